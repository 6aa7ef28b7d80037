/* SPDX-License-Identifier: MIT */
/* Chooses how levels are made, and the degree of the analysis they need. */
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

/* Of the levels of a chain. */
typedef struct ibl_chain_plan {
    ibl_method level[IBL_MAX_LEVELS];         /* AUTO: the environment itself */
    ibl_spectral_parts parts[IBL_MAX_LEVELS]; /* of SPECTRAL levels */
    ibl_lobe_shape shape[IBL_MAX_LEVELS];     /* with the split, if any */
} ibl_chain_plan;

/* Of a whole bake. */
typedef struct ibl_spectral_plan {
    ibl_method irradiance; /* SAMPLED: the classic grid */
    int degree;            /* of the analysis; -1: none */
    int single;            /* degree from which floats do, in all levels */
    bool whole;            /* the whole map must be kept */
} ibl_spectral_plan;

/* Plans all but the chains, from the size of the map and the options. */
ibl_status ibl_spectral_plan_make(ibl_ctx *ctx, int width, int height,
                                  const ibl_bake_options *opts,
                                  ibl_spectral_plan *plan);

/*
 * Plans a chain and adds what it needs to the plan. A level is spectral unless
 * the method is IBL_METHOD_SAMPLED, or AUTO with level_samples for it. If the
 * degree that a lobe needs costs more than the pixels in its reach, these are
 * summed instead (near.h).
 */
ibl_status ibl_spectral_plan_chain(ibl_ctx *ctx, int width, int height,
                                   const ibl_specular_options *opts,
                                   const ibl_specular_layout *layout,
                                   ibl_chain_plan *chain,
                                   ibl_spectral_plan *plan);

#endif
