/* SPDX-License-Identifier: MIT */
/* Loads, builds and writes JSON. */
#ifndef IBL_JSON_LOAD_H
#define IBL_JSON_LOAD_H

#include <jansson.h>
#include <stdbool.h>

#include <ibl/probes.h>

#include "json/text.h"

/* Why a file cannot be used. */
typedef struct ibl_json_why {
    ibl_status status;         /* IBL_ERR_IO, IBL_ERR_MEMORY, or, for contents
                                  that are wrong or too large, IBL_ERR_FORMAT */
    char line[IBL_LINE_BYTES]; /* "PATH: is a directory: ..." */
} ibl_json_why;

/* Reads a regular file, with jansson's flags. The caller must json_decref the
 * result; NULL: see why. Where memory runs out, jansson's lexer reads beyond
 * what it has: programs have jansson's allocator end them before. */
json_t *ibl_json_load(const char *path, size_t flags, ibl_json_why *why);
/* The same of a text, which why calls name. */
json_t *ibl_json_parse(const char *name, const void *text, size_t size,
                       size_t flags, ibl_json_why *why);

/* Reads count numbers; false if they are not that, or not finite. */
bool ibl_json_numbers(const json_t *list, double *to, int count);

/* JSON for people and programs: indented, arrays of plain values on one line,
 * numbers of 15 digits. The text ends with a newline. The caller must free it;
 * NULL: no memory, or root is NULL. */
char *ibl_json_text(const json_t *root);

/* The members that ibl_json_probe reads. NULL: no memory. */
json_t *ibl_json_probe_of(const ibl_probe *p);

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
