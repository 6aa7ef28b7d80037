/* SPDX-License-Identifier: MIT */
#ifndef COMMON_SIDECAR_LOAD_H
#define COMMON_SIDECAR_LOAD_H

#include "common/json_load.h"

/* What a sidecar says in "names" where its names of files are not UTF-8: they
 * have bytes, and '%', as %XX. */
#define IBL_NAMES_ENCODED "percent-encoded"

/* ibl_json_load of a sidecar, with the names of files decoded: then they are
 * any bytes. */
json_t *ibl_sidecar_load(const char *path, ibl_json_why *why);

#endif
