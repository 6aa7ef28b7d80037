/* SPDX-License-Identifier: MIT */
/* A specular chain in the making. */
#ifndef IBL_BAKE_SPECULAR_H
#define IBL_BAKE_SPECULAR_H

#include <stdbool.h>

#include "bake/samples.h"
#include "ibl/ibl.h"
#include "image/pyramid.h"

typedef struct ibl_specular_bake {
    ibl_ctx *ctx;
    const ibl_image *env;
    const ibl_specular_options *opts; /* in range */
    ibl_specular_layout layout;
    bool sampled[IBL_MAX_LEVELS]; /* which levels are */
    ibl_cube cube;                /* of that layout */
    ibl_pyramid pyramid;          /* that is looked up */
} ibl_specular_bake;

/* Whether the options are in range, in words if not. */
ibl_status ibl_specular_check(ibl_ctx *ctx, const ibl_specular_options *opts);

/*
 * Bakes the levels that are sampled. Level 0 of the cube is done if it is the
 * environment.
 *   levels  with the samples of each
 */
ibl_status ibl_specular_sample(ibl_specular_bake *b,
                               const ibl_specular_level *levels);

#endif
