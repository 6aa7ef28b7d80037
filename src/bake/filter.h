/* SPDX-License-Identifier: MIT */
/* A level of a prefiltered cube: every texel the weighted sum of lookups in a
 * pyramid, by one set of samples. */
#ifndef IBL_BAKE_FILTER_H
#define IBL_BAKE_FILTER_H

#include <stdbool.h>

#include "bake/samples.h"
#include "ibl/ibl.h"
#include "image/pyramid.h"

/*
 * Fills a level of out on the context's pool, reporting under stage.
 *   jitter  turn the set by a hash of level and texel, about the normal
 */
ibl_status ibl_filter_level(ibl_ctx *ctx, const char *stage,
                            const ibl_pyramid *pyramid,
                            const ibl_samples *samples, bool jitter,
                            ibl_cube *out, int level);

#endif
