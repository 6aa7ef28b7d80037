/* SPDX-License-Identifier: MIT */
/* JSON files as a whole: all that the programs read come through here. */
#ifndef COMMON_JSON_LOAD_H
#define COMMON_JSON_LOAD_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "common/stderr_line.h"

enum {
    /* A sidecar with harmonics of the highest degree has 115 MB. */
    IBL_JSON_BYTES = 1 << 28
};

/* Why there is nothing. */
typedef struct ibl_json_why {
    bool damaged;              /* what is in the file is at fault */
    char line[IBL_LINE_BYTES]; /* "PATH: is a directory: ..." */
} ibl_json_why;

/* All of a regular file, ended by a NUL beyond *size, for free(); NULL: why
 * says. Pipes, devices and what is larger than IBL_JSON_BYTES are refused. */
char *ibl_json_bytes(const char *path, size_t *size, ibl_json_why *why);
/* JSON of such bytes, with jansson's flags, for json_decref; NULL: why says. */
json_t *ibl_json_parse(const char *path, const char *bytes, size_t size,
                       size_t flags, ibl_json_why *why);
/* Both. */
json_t *ibl_json_load(const char *path, size_t flags, ibl_json_why *why);

/* What a sidecar says in "names" where its names of files are not UTF-8: they
 * have bytes, and '%', as %XX. */
#define IBL_NAMES_ENCODED "percent-encoded"

/* ibl_json_load of a sidecar, with the names of files decoded: then they are
 * any bytes. */
json_t *ibl_sidecar_load(const char *path, ibl_json_why *why);

#endif
