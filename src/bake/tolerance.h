/* SPDX-License-Identifier: MIT */
/* The fewest samples that keep a level's error below a tolerance. */
#ifndef IBL_BAKE_TOLERANCE_H
#define IBL_BAKE_TOLERANCE_H

#include "bake/specular.h"

/*
 * Chooses b->pyramid and the samples of every level that is sampled, with the
 * estimates that ibl_bake_specular_report describes, and warns of levels that
 * miss the tolerance. level 0 of b->cube is done if it is the environment.
 * Reports as stage "estimate".
 */
ibl_status ibl_tolerance_choose(ibl_specular_bake *b,
                                ibl_specular_level levels[IBL_MAX_LEVELS]);

/* Which of the errors of `count` texels, 0 the largest, is taken: with a chance
 * of 99 % it is no less than the 95th percentile of all texels' errors. */
int ibl_tolerance_rank(int count);

#endif
