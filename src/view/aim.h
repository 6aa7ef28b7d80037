/* SPDX-License-Identifier: MIT */
/*
 * A table to draw directions from, where an environment outshines its mean.
 *
 * Samples of a rough lobe rarely meet a small sun, and then count too much. So
 * some are drawn from the environment and both kinds are weighed together:
 * multiple importance sampling (Veach and Guibas 1995), with the mean taken off
 * the environment before (Karlik et al. 2019, "MIS Compensation").
 *
 * The faces are divided into cells, each with a chance in proportion to its
 * light above the mean. A direction is a random place near the middle of a
 * random cell, by a tent a cell wide, reflected at the edges of the face. So
 * the density is the chances interpolated bilinearly, as the environment is
 * between texels.
 *
 * Chances are multiples of 1 / VIEW_AIM_TOKENS. A random token names a cell:
 * drawing is one lookup and the chance is exact. Neighbouring tokens are of
 * neighbouring cells, so an even sequence of numbers gives even directions.
 */
#ifndef VIEW_AIM_H
#define VIEW_AIM_H

#include <stdbool.h>

#include "ibl/io.h"

#define VIEW_AIM_ROW 512 /* tokens as a square picture */
#define VIEW_AIM_TOKENS (VIEW_AIM_ROW * VIEW_AIM_ROW)
#define VIEW_AIM_EDGE 512 /* cells along a face's edge, at most */

typedef struct view_aim {
    int edge; /* along a face's edge; 0: too little outshines the mean, there is
                 no table */
    float *chance; /* of each cell, faces and rows as in a cube's level */
    float *tokens; /* index of the cell of each */
} view_aim;

/* From level 0 of a cube. False, with a message, and *aim zeroed, if there is
 * no memory. */
bool view_aim_make(const ibl_texture *cube, view_aim *aim);
void view_aim_free(view_aim *aim); /* zeroed is fine */

#endif
