/* SPDX-License-Identifier: MIT */
/* Reading a JSON file that a program wrote: every error names the file, the
 * path in it, what was expected and what was found. */
#ifndef VIEW_JSON_AT_H
#define VIEW_JSON_AT_H

#include <jansson.h>
#include <stdbool.h>

/* A place in a file: "probes[3].influence.box". It lives on the stack of who
 * reads it, and what is above it outlives it. */
typedef struct view_json_at {
    const char *file;    /* for messages */
    const json_t *value; /* NULL: there is none */
    const struct view_json_at *above;
    const char *key; /* NULL: an element */
    size_t index;
} view_json_at;

/* NULL, with a message; else to be freed with json_decref. */
json_t *view_json_open(const char *file);

view_json_at view_json_root(const char *file, const json_t *root);
/* The value is NULL where at is no object or has no such member. */
view_json_at view_json_member(const view_json_at *at, const char *key);
view_json_at view_json_element(const view_json_at *at, size_t index);

/* Says that at is not what was expected, and what it is. False. */
bool view_json_wrong(const view_json_at *at, const char *expected, ...)
    __attribute__((format(printf, 2, 3)));

/* These check what at is, and return false after view_json_wrong. */

bool view_json_array(const view_json_at *at, size_t least, size_t most);
bool view_json_text(const view_json_at *at, const char **text);
/* From low to high; above 0 where low is 0 and open. */
bool view_json_real(const view_json_at *at, double low, double high, bool open,
                    double *value);
bool view_json_int(const view_json_at *at, int low, int high, int *value);
/* One of the names, ended by NULL; its number. */
bool view_json_choice(const view_json_at *at, const char *const *names,
                      int *value);
/* Three numbers as view_json_real takes them. */
bool view_json_triple(const view_json_at *at, double low, double high,
                      bool open, double value[3]);

#endif
