/* SPDX-License-Identifier: MIT */
/* How levels are made, and the degree of the analysis that they need. */
#ifndef IBL_BAKE_SPECTRAL_PLAN_H
#define IBL_BAKE_SPECTRAL_PLAN_H

#include <stdbool.h>

#include "brdf/lobe.h"
#include "ibl/ibl.h"

/* Where the parts of a level come from. */
typedef struct ibl_spectral_parts {
    bool spectral; /* the far part, or all, from harmonics */
    bool near;     /* the near part, or all, from the pixels in reach */
} ibl_spectral_parts;

typedef struct ibl_spectral_plan {
    ibl_method level[IBL_MAX_LEVELS];         /* AUTO: the environment itself */
    ibl_spectral_parts parts[IBL_MAX_LEVELS]; /* of SPECTRAL levels */
    ibl_lobe_shape shape[IBL_MAX_LEVELS];     /* with the split, if any */
    ibl_method irradiance;                    /* SAMPLED: the classic grid */
    int degree;                               /* of the analysis; -1: none */
    bool whole;                               /* the whole map has to be kept */
} ibl_spectral_plan;

/*
 * From the size of the map and what is asked for. A level is spectral unless
 * IBL_METHOD_SAMPLED or samples of its own say otherwise. Where the degree that
 * a lobe needs would cost more than the pixels in its reach, these are summed
 * up instead (near.h).
 *   layout   of the specular chain, if one is wanted
 */
ibl_status ibl_spectral_plan_make(ibl_ctx *ctx, int width, int height,
                                  const ibl_bake_options *opts,
                                  const ibl_specular_layout *layout,
                                  ibl_spectral_plan *plan);

#endif
