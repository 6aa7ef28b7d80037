/* SPDX-License-Identifier: MIT */
/* Chooses how levels are made, and the degree of the analysis they need. */
#ifndef IBL_BAKE_SPECTRAL_PLAN_H
#define IBL_BAKE_SPECTRAL_PLAN_H

#include <stdbool.h>

#include "brdf/lobe.h"
#include "ibl/ibl.h"

/* How the tolerance is divided, in units of it. */
static const struct ibl_error_parts {
    double degrees;   /* what degrees leave out where it is measured, */
    double elsewhere; /* and how many times as much there is elsewhere */
    double lights;    /* by their points */
    double tail;      /* share of a point light beyond the analysis: maps are
                         smoother, and the brightest pixels are taken out */
    /* In units of the default, whatever is asked: */
    double taps;     /* of the interpolation between rings */
    double rounding; /* of floats */
} ibl_error_parts = {0.25, 2, 0.1, 1, 0.35, 0.05};

/* Of a whole bake. */
typedef struct ibl_spectral_plan {
    ibl_method irradiance; /* SAMPLED: the classic grid */
    int irradiance_degree; /* the most */
    int degree;            /* of the analysis; -1: none */
    int single;            /* degree from which floats do, in all levels */
    bool whole;            /* the whole map must be kept */
} ibl_spectral_plan;

/* Plans all but the chains. */
ibl_status ibl_spectral_plan_make(ibl_ctx *ctx, const ibl_bake_options *opts,
                                  ibl_spectral_plan *plan);

/* Adds what a chain needs to the plan; degree: the most of each spectral level.
 */
ibl_status ibl_spectral_plan_chain(ibl_ctx *ctx,
                                   const ibl_specular_options *opts,
                                   const ibl_specular_layout *layout,
                                   int degree[IBL_MAX_LEVELS],
                                   ibl_spectral_plan *plan);

#endif
