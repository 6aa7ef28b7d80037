/* SPDX-License-Identifier: MIT */
/* The roughnesses of a chain, fitted to the power of a map: the ladder of
 * IBL_ROUGHNESS_BEST. */
#ifndef IBL_BAKE_LADDER_H
#define IBL_BAKE_LADDER_H

#include "ibl/ibl.h"

/*
 * Replaces the roughnesses of the levels 1..levels - 2 of a layout, whose
 * roughnesses are Filament's. Sought is the least sum of the nRMSE of what
 * surfaces reflect, over roughnesses .1 to 1 and F0 1 and .04, each the mean
 * over views (as of ibl_expectation_of). Levels are chosen among roughnesses in
 * equal steps of r (2 - r), Filament's included, by dynamic programming: for
 * the tangents to the sum at the last choice, no other choice is better. So no
 * step from Filament's makes the sum larger. None is below the present
 * roughness of level 1.
 *   power, degree  as of ibl_lobe_kernels_make
 */
ibl_status ibl_ladder_fit(ibl_ctx *ctx, const double *power, int degree,
                          ibl_specular_layout *layout);

#endif
