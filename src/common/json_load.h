/* SPDX-License-Identifier: MIT */
/* JSON files as a whole: all that the programs read come through here. */
#ifndef COMMON_JSON_LOAD_H
#define COMMON_JSON_LOAD_H

#include <jansson.h>
#include <stdbool.h>

#include "common/stderr_line.h"

enum {
    /* A sidecar with harmonics of the highest degree has 115 MB. */
    IBL_JSON_BYTES = 1 << 28
};

/* Why a file cannot be used. */
typedef struct ibl_json_why {
    bool damaged;              /* what is in the file is at fault */
    char line[IBL_LINE_BYTES]; /* "PATH: is a directory: ..." */
} ibl_json_why;

/* Reads a regular file, with jansson's flags; for json_decref, NULL: why says.
 * Pipes, devices and what is larger than IBL_JSON_BYTES are refused. */
json_t *ibl_json_load(const char *path, size_t flags, ibl_json_why *why);

/* What a sidecar says in "names" where its names of files are not UTF-8: they
 * have bytes, and '%', as %XX. */
#define IBL_NAMES_ENCODED "percent-encoded"

/* ibl_json_load of a sidecar, with the names of files decoded: then they are
 * any bytes. */
json_t *ibl_sidecar_load(const char *path, ibl_json_why *why);

#endif
