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
    /* Receives each error, one line. */
    void (*fail)(void *cookie, const char *text);
    void *cookie;
    json_t *root;
} ibl_json_file;

enum {
    IBL_JSON_PATH_BYTES = 256
};

/* A place in a file. */
typedef struct ibl_json_at {
    const ibl_json_file *file;
    const json_t *value; /* NULL: there is none */
    bool optional;
    char path[IBL_JSON_PATH_BYTES]; /* "probes[3].influence.box" */
} ibl_json_at;

/* Reads file->name by ibl_json_load; file->root is to be freed with
 * json_decref. False after a failure. */
bool ibl_json_open(ibl_json_file *file);

ibl_json_at ibl_json_root(const ibl_json_file *file);
/* at is an object; the value is NULL where it has no such member. */
ibl_json_at ibl_json_member(const ibl_json_at *at, const char *key);
/* The same of a member that may be absent: the checks below return true then,
 * and leave the value as it is. */
ibl_json_at ibl_json_optional(const ibl_json_at *at, const char *key);
/* at is an array, index in it. */
ibl_json_at ibl_json_element(const ibl_json_at *at, size_t index);

/* Reports that at is not what was expected, and what it is. False; true without
 * a report where at is optional and absent. */
bool ibl_json_wrong(ibl_json_at at, const char *expected, ...)
    __attribute__((format(printf, 2, 3)));
/* Reports something else of it: "FILE: PATH: ...". False. */
bool ibl_json_complain(ibl_json_at at, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));

/* These check what at is, and return ibl_json_wrong if it is not. */

/* An object without other members than the keys, ended by NULL. */
bool ibl_json_object(ibl_json_at at, const char *const *keys);
bool ibl_json_array(ibl_json_at at, size_t least, size_t most);
bool ibl_json_text_at(ibl_json_at at, const char **text);
/* From low, or above it where open, to high. */
bool ibl_json_real(ibl_json_at at, double low, double high, bool open,
                   double *value);
bool ibl_json_int(ibl_json_at at, int low, int high, int *value);
/* One of the names, ended by NULL; its number, into an int or enumeration. */
bool ibl_json_choice(ibl_json_at at, const char *const *names, void *value);
/* Three numbers as ibl_json_real takes them. */
bool ibl_json_triple(ibl_json_at at, double low, double high, bool open,
                     double value[3]);

/* Volumes of probes, which sets, grids and indices have alike. */

/* Lengths and places are in any unit; up to this, volumes and their ratios are
 * well inside of a double. */
#define IBL_JSON_FARTHEST 1e12

/* Checks and takes the three coordinates of a place. */
bool ibl_json_place(ibl_json_at at, double place[3]);
/* Checks and takes {"box": {"centre", "half"}} or {"sphere": {"centre",
 * "radius"}}. */
bool ibl_json_volume(ibl_json_at at, ibl_volume *volume);

#endif
