/* SPDX-License-Identifier: MIT */
/* What is made spectrally and what is sampled. */
#ifndef IBL_BAKE_SPECTRAL_PLAN_H
#define IBL_BAKE_SPECTRAL_PLAN_H

#include <stdbool.h>

#include "ibl/ibl.h"

typedef struct ibl_spectral_plan {
    ibl_method level[IBL_MAX_LEVELS]; /* AUTO: the environment itself */
    ibl_method irradiance;            /* SAMPLED: summed over the pixels */
    ibl_method sh;                    /* SAMPLED: summed over the pixels */
    int degree;                       /* of the analysis; -1: none */
    double tolerance;                 /* of a level's relative error */
    bool whole;                       /* the whole map has to be kept */
} ibl_spectral_plan;

/*
 * From the size of the map and what is asked for. A level is spectral
 * unless
 *   - its lobe is so narrow that a pixel of the map is no longer a point, see
 *     ibl_spectral_shortfall;
 *   - its degree would be above IBL_SPECTRAL_MAX_DEGREE;
 *   - with IBL_METHOD_AUTO, it costs many times what sampling it does, even
 *     where it leaves as much.
 * Tells by ibl_info which levels IBL_METHOD_SPECTRAL could not have so.
 *   layout   of the specular chain, if one is wanted
 */
ibl_status ibl_spectral_plan_make(ibl_ctx *ctx, int width, int height,
                                  const ibl_bake_options *opts,
                                  const ibl_specular_layout *layout,
                                  ibl_spectral_plan *plan);

#define IBL_SPECTRAL_MAX_DEGREE 4096

/*
 * Relative error, at most, of taking pixels for points where a lobe is so
 * narrow that the sums of ibl/reference.h begin to spread those near its peak:
 * below an alpha of 4 pixels of the map (GGX; Phong 2, Charlie 1). Measured for
 * GGX at 3.3 pixels: a twentieth of it. The others end there: 1.
 */
double ibl_spectral_shortfall(int width, int height, ibl_lobe lobe,
                              double alpha);
/* How much of it is accepted where no tolerance was asked for: three pixels.
 * Samples leave more. */
#define IBL_SPECTRAL_SHORTFALL 0.01

/* The relative error that is aimed at without a tolerance: a fifth of what
 * rounding to a half float leaves, 2.8e-4. */
#define IBL_SPECTRAL_TOLERANCE 5e-5

#endif
