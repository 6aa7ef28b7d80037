/* SPDX-License-Identifier: MIT */
/* Sample sets: directions around +Z, their weights and mip levels. A set is
 * made once for all texels of a level and turned to each texel's frame. */
#ifndef IBL_BAKE_SAMPLES_H
#define IBL_BAKE_SAMPLES_H

#include <stdbool.h>

#include "brdf/lobe.h"
#include "ibl/ibl.h"
#include "kern/gather.h"

typedef struct ibl_samples {
    ibl_gather_samples set; /* weights sum to 1 */
    int count;              /* of all groups */
    float *memory;
    ibl_gather_group *groups;
} ibl_samples;

typedef struct ibl_sampling {
    ibl_lobe_shape shape;
    int count;  /* Hammersley points */
    int edge;   /* of the pyramid's level 0 */
    int levels; /* of the pyramid */
    double lod_bias;
    bool pdf_mip;     /* choose the mip level by pdf; else level 0 */
    double footprint; /* variance of a source pixel in level 0 along one axis,
                         in square radians */
} ibl_sampling;

/* Hammersley points with the density of the lobe's D above the horizon,
 * N = V = R, weights N.L. */
ibl_status ibl_samples_specular(ibl_ctx *ctx, const ibl_sampling *sampling,
                                ibl_samples *samples);

/* A grid over the hemisphere in theta and phi: midpoints, at most step radians
 * apart, weights cos(theta) sin(theta), level 0. */
ibl_status ibl_samples_hemisphere(ibl_ctx *ctx, double step,
                                  ibl_samples *samples);

void ibl_samples_free(ibl_samples *samples); /* zeroed is fine */

#endif
