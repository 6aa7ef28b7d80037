/* SPDX-License-Identifier: MIT */
/* Building JSON as a list of calls: what fails makes the object or array NULL,
 * and so in turn what that was to be put into. */
#ifndef CLI_JSON_PUT_H
#define CLI_JSON_PUT_H

#include <jansson.h>

/* Both take value over; NULL is a failure. */
static inline void put(json_t **object, const char *key, json_t *value)
{
    if (json_object_set_new(*object, key, value)) {
        json_decref(*object);
        *object = NULL;
    }
}

static inline void append(json_t **array, json_t *value)
{
    if (json_array_append_new(*array, value)) {
        json_decref(*array);
        *array = NULL;
    }
}

#endif
