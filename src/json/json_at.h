/* SPDX-License-Identifier: MIT */
/* Reads and checks a JSON file. Every error names the file, the path in it,
 * what was expected and what was found. */
#ifndef IBL_JSON_AT_H
#define IBL_JSON_AT_H

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
    const json_t *value;            /* NULL: absent */
    bool optional;                  /* absence is no error */
    char path[IBL_JSON_PATH_BYTES]; /* "probes[3].influence.box" */
} ibl_json_at;

/* Reads file->name; the caller must json_decref file->root. False: reported. */
bool ibl_json_open(ibl_json_file *file);

ibl_json_at ibl_json_root(const ibl_json_file *file);
/* A member of an object. */
ibl_json_at ibl_json_member(const ibl_json_at *at, const char *key);
/* The same for a member that may be absent: then the checks below return true
 * and leave their output unchanged. */
ibl_json_at ibl_json_optional(const ibl_json_at *at, const char *key);
/* An element of an array; index must be in range. */
ibl_json_at ibl_json_element(const ibl_json_at *at, size_t index);

/* Reports what was expected and what was found; returns false. If at is
 * optional and absent, returns true without a report. */
bool ibl_json_wrong(ibl_json_at at, const char *expected, ...)
    __attribute__((format(printf, 2, 3)));
/* Reports another error, as "FILE: PATH: ..."; returns false. */
bool ibl_json_complain(ibl_json_at at, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));

/* These check the value; if it is wrong, they return ibl_json_wrong. */

/* An object whose members are all in keys, ended by NULL. */
bool ibl_json_object(ibl_json_at at, const char *const *keys);
bool ibl_json_array(ibl_json_at at, size_t least, size_t most);
bool ibl_json_text_at(ibl_json_at at, const char **text);
/* A number from low to high; with open, above low. */
bool ibl_json_real(ibl_json_at at, double low, double high, bool open,
                   double *value);
bool ibl_json_int(ibl_json_at at, int low, int high, int *value);
/* One of names, ended by NULL. *value, an int or enumeration, is its index. */
bool ibl_json_choice(ibl_json_at at, const char *const *names, void *value);
/* An array of three numbers as in ibl_json_real. */
bool ibl_json_triple(ibl_json_at at, double low, double high, bool open,
                     double value[3]);

/* Volumes of probes, the same in sets, grids and indices. */

/* Largest length and coordinate, in any unit. Volumes and their ratios then
 * stay far from the limits of a double. */
#define IBL_JSON_FARTHEST 1e12

/* Three coordinates. */
bool ibl_json_place(ibl_json_at at, double place[3]);
/* {"box": {"centre", "half"}} or {"sphere": {"centre", "radius"}}. */
bool ibl_json_volume(ibl_json_at at, ibl_volume *volume);

/* Priorities are -IBL_JSON_PRIORITY..IBL_JSON_PRIORITY. */
#define IBL_JSON_PRIORITY 1000000

/* A probe without its layer: position and influence; without blend, priority
 * and proxy these stay as they are. */
bool ibl_json_probe(ibl_json_at at, ibl_probe *probe);

#endif
