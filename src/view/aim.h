/* SPDX-License-Identifier: MIT */
/*
 * A table to draw directions from, where an environment is brighter than its
 * mean.
 *
 * Samples of a rough lobe rarely hit a small sun, and then count too much. So
 * some directions are drawn from the environment, and both kinds are combined
 * by multiple importance sampling (Veach and Guibas 1995), with the mean
 * subtracted from the environment before (Karlik et al. 2019, "MIS
 * Compensation").
 *
 * Each face is divided into cells whose chances are proportional to their light
 * above the mean. A direction is a random place near the centre of a random
 * cell, from a tent one cell wide, reflected at the edges of the face. The
 * density is therefore the chances interpolated bilinearly, as the environment
 * is between texels.
 *
 * Chances are multiples of 1 / VIEW_AIM_TOKENS. A random token names a cell:
 * drawing is one lookup and the chance is exact. Neighbouring tokens belong to
 * neighbouring cells, so an even sequence of numbers gives even directions.
 */
#ifndef VIEW_AIM_H
#define VIEW_AIM_H

#include <stdbool.h>

#include "ibl/io.h"

#define VIEW_AIM_ROW 512 /* edge of the square texture of tokens */
#define VIEW_AIM_TOKENS (VIEW_AIM_ROW * VIEW_AIM_ROW)
#define VIEW_AIM_EDGE 512 /* cells along a face's edge, at most */

typedef struct view_aim {
    int edge; /* cells along a face's edge; 0: too little light is above the
                 mean and there is no table */
    float *chance; /* of each cell; faces and rows as in a cube's level */
    float *tokens; /* index of each token's cell */
} view_aim;

/* Makes the table from level 0 of a cube. */
void view_aim_make(const ibl_texture *cube, view_aim *aim);
void view_aim_free(view_aim *aim); /* zeroed is fine */

#endif
