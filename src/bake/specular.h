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
 * environment. levels: the samples that were asked for; what they became.
 */
ibl_status ibl_specular_sample(ibl_specular_bake *b,
                               ibl_specular_level levels[IBL_MAX_LEVELS]);

enum {
    IBL_LOOKUP_CHEAP_EDGE = 128 /* a cube of this is always worth making */
};

/* The largest edge of a cube for lookups that is of any use: texels of half a
 * pixel of the source. A power of two. */
int ibl_lookup_limit(const ibl_image *env);
/* Whether level 0 is the environment, in a size that serves for lookups. */
bool ibl_lookup_has_level0(const ibl_specular_bake *b);
/* What making a cube for lookups costs, in lookups. */
double ibl_lookup_cost(int edge);
/* Makes a cube for lookups of an edge that is a power of two. The one of
 * level 0's edge is made from level 0, if that is the environment. */
ibl_status ibl_lookup_make(const ibl_specular_bake *b, int edge,
                           ibl_pyramid *pyramid);

/* The samples of a level, for lookups in pyramid. */
ibl_status ibl_specular_samples(const ibl_specular_bake *b,
                                const ibl_pyramid *pyramid, int level,
                                int count, ibl_samples *samples);

#endif
