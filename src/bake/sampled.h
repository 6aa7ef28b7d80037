/* SPDX-License-Identifier: MIT */
/* Baking by samples: every texel is a weighted sum of lookups in a pyramid. One
 * set of samples serves a whole level. */
#ifndef IBL_BAKE_SAMPLED_H
#define IBL_BAKE_SAMPLED_H

#include <stdbool.h>

#include "bake/samples.h"
#include "ibl/ibl.h"
#include "image/pyramid.h"

/*
 * Tangent, bitangent and normal of texel (x, y) of a face of edge n: the
 * tangent follows the face's rows, so symmetric texels have symmetric frames.
 * turn rotates tangent and bitangent about the normal, in radians.
 */
void ibl_texel_frame(int n, int face, int x, int y, double turn,
                     float frame[9]);

/*
 * Fills a level of out on the context's pool; progress is reported under stage.
 *   jitter  turn the set about the normal, by a hash of level and texel
 */
ibl_status ibl_filter_level(ibl_ctx *ctx, const char *stage,
                            const ibl_pyramid *pyramid,
                            const ibl_samples *samples, bool jitter,
                            const ibl_cube *out, int level);

/*
 * Bakes the levels of cube. A level 0 of roughness 0 must be done already.
 *   opts    in range; the angle counts in place of theirs
 *   report  with the layout; the rest is written
 */
ibl_status ibl_sample_levels(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                             const ibl_specular_options *opts,
                             const ibl_cube *cube, ibl_specular_report *report);

/* Irradiance with opts->step > 0, by the classic grid over the hemisphere. out
 * must be allocated, with opts->size and one level; opts must be in range. */
ibl_status ibl_irradiance_grid(ibl_ctx *ctx, const ibl_image *env,
                               const ibl_irradiance_options *opts,
                               const ibl_cube *out);

#endif
