/* SPDX-License-Identifier: MIT */
#ifndef IBL_JSON_BUILD_H
#define IBL_JSON_BUILD_H

#include <jansson.h>

/* Building JSON without checks after each call: a failed call sets the object
 * or array to NULL, and so the container it is put into. All calls take
 * ownership of value; a NULL value is a failure. */
static inline void drop_if(int failed, json_t **container)
{
    if (failed) {
        json_decref(*container);
        *container = NULL;
    }
}

static inline void put(json_t **object, const char *key, json_t *value)
{
    drop_if(json_object_set_new(*object, key, value), object);
}

static inline void put_all(json_t **object, json_t *members)
{
    drop_if(json_object_update_new(*object, members), object);
}

static inline void append(json_t **array, json_t *value)
{
    drop_if(json_array_append_new(*array, value), array);
}

#endif
