/* SPDX-License-Identifier: MIT */
/* Loads JSON files, for all programs. */
#ifndef COMMON_JSON_LOAD_H
#define COMMON_JSON_LOAD_H

#include <jansson.h>
#include <stdbool.h>

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

/* What a sidecar says was done to the colours of its source. Leaves alone what
 * it does not say, or not in such words. */
void ibl_sidecar_colour(const json_t *sidecar, ibl_read_options *read);

#endif
