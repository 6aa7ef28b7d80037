/* SPDX-License-Identifier: MIT */
/* Loads and writes JSON, for all programs. */
#ifndef COMMON_JSON_LOAD_H
#define COMMON_JSON_LOAD_H

#include <jansson.h>
#include <stdbool.h>

#include <ibl/probes.h>

#include <ibl/io.h>

#include "common/stderr_line.h"

enum {
    /* A sidecar with spherical harmonics of the highest degree has 115 MB. */
    IBL_JSON_BYTES = 1 << 28
};

/* Why a file cannot be used. */
typedef struct ibl_json_why {
    bool damaged;              /* the contents are wrong or too large */
    char line[IBL_LINE_BYTES]; /* "PATH: is a directory: ..." */
} ibl_json_why;

/* Reads a regular file of at most IBL_JSON_BYTES, with jansson's flags. The
 * caller must json_decref the result; NULL: see why. */
json_t *ibl_json_load(const char *path, size_t flags, ibl_json_why *why);

/* The value of "names" in a sidecar if one of its file names is not UTF-8. All
 * of them then have %XX for '%' and for bytes that are not UTF-8. */
#define IBL_NAMES_ENCODED "percent-encoded"

/* ibl_json_load of a sidecar; decodes its file names, to any bytes. */
json_t *ibl_sidecar_load(const char *path, ibl_json_why *why);

/* The entry of the output whose member has that value; NULL: none. */
json_t *ibl_sidecar_output(const json_t *sidecar, const char *member,
                           const char *value);

/* Reads count numbers; false if they are not that, or not finite. */
bool ibl_json_numbers(const json_t *list, double *to, int count);

/* Reads the lights that were taken out of the map, and returns their number;
 * -1: they are damaged. */
int ibl_sidecar_lights(const json_t *sidecar, ibl_light light[IBL_MAX_LIGHTS]);

/* What a sidecar says was done to the colours of its source. Leaves alone what
 * it does not say, or not in such words. */
void ibl_sidecar_colour(const json_t *sidecar, ibl_read_options *read);

/*
 * JSON for people and programs: indented, arrays of plain values on one line,
 * each number with the fewest digits that read back as the same double. The
 * text ends with a newline. The caller must free it; NULL: no memory, or root
 * is NULL.
 */
char *ibl_json_text(const json_t *root);

/* [x, y, z], and the members that ibl_json_probe reads. NULL: no memory. */
json_t *ibl_json_triple_of(const double v[3]);
json_t *ibl_json_probe_of(const ibl_probe *p);

#endif
