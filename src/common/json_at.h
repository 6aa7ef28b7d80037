/* SPDX-License-Identifier: MIT */
/* Reading a JSON file: every error names the file, the path in it, what was
 * expected and what was found. */
#ifndef COMMON_JSON_AT_H
#define COMMON_JSON_AT_H

#include <jansson.h>
#include <stdbool.h>

#include <ibl/probes.h>

typedef struct ibl_json_file {
    const char *name; /* for messages */
    /* Is told what is wrong, one line each time. */
    void (*fail)(void *cookie, const char *text);
    void *cookie;
    json_t *root;
} ibl_json_file;

/* A place in a file: "probes[3].influence.box". It lives on the stack of who
 * reads it, and what is above it outlives it. */
typedef struct ibl_json_at {
    const ibl_json_file *file;
    const json_t *value; /* NULL: there is none */
    const struct ibl_json_at *above;
    const char *key; /* NULL: an element */
    size_t index;
} ibl_json_at;

/* Reads file->name by ibl_json_load; file->root is to be freed with
 * json_decref. False after a failure. */
bool ibl_json_open(ibl_json_file *file);

ibl_json_at ibl_json_root(const ibl_json_file *file);
/* at is an object; the value is NULL where it has no such member. */
ibl_json_at ibl_json_member(const ibl_json_at *at, const char *key);
/* at is an array, index in it. */
ibl_json_at ibl_json_element(const ibl_json_at *at, size_t index);

/* Says that at is not what was expected, and what it is. False. */
bool ibl_json_wrong(const ibl_json_at *at, const char *expected, ...)
    __attribute__((format(printf, 2, 3)));
/* Says something else of it: "FILE: PATH: ..."; false, as these are after a
 * failure. */
bool ibl_json_complain(const ibl_json_at *at, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
/* The path of at: "probes[3].name". */
void ibl_json_path(const ibl_json_at *at, char *text, size_t size);

/* These check what at is, and return false after ibl_json_wrong. */

/* An object without other members than the keys, ended by NULL. */
bool ibl_json_object(const ibl_json_at *at, const char *const *keys);
bool ibl_json_array(const ibl_json_at *at, size_t least, size_t most);
bool ibl_json_text_at(const ibl_json_at *at, const char **text);
/* From low, or above it where open, to high. */
bool ibl_json_real(const ibl_json_at *at, double low, double high, bool open,
                   double *value);
bool ibl_json_int(const ibl_json_at *at, int low, int high, int *value);
/* One of the names, ended by NULL; its number. */
bool ibl_json_choice(const ibl_json_at *at, const char *const *names,
                     int *value);
/* Three numbers as ibl_json_real takes them. */
bool ibl_json_triple(const ibl_json_at *at, double low, double high, bool open,
                     double value[3]);

/* Volumes of probes, which sets, grids and indices have alike. */

/* Lengths and places are in any unit; up to this, volumes and their ratios are
 * well inside of a double. */
#define IBL_JSON_FARTHEST 1e12

/* Checks and takes {"box": {"centre", "half"}} or {"sphere": {"centre",
 * "radius"}}. False after ibl_json_wrong. */
bool ibl_json_volume(const ibl_json_at *at, ibl_volume *volume);

#endif
