/* SPDX-License-Identifier: MIT */
/*
 * A table to draw directions from, where an environment outshines its mean.
 *
 * Samples of a rough lobe rarely meet a small sun, and then count for too much.
 * So some are drawn from the environment itself and the two are weighed
 * together: multiple importance sampling (Veach and Guibas 1995), with the mean
 * taken off the environment before (Karlik et al. 2019, "MIS Compensation"), as
 * what the lobe samples well need not be drawn again.
 *
 * The faces are divided into cells, with a chance of each in proportion to what
 * it shines above the mean. A direction is drawn by drawing a cell, and moving
 * from its middle by up to a cell with a tent for density, back from the edges
 * of the face: so the density is the chances interpolated bilinearly, as the
 * environment is between its texels.
 *
 * Chances are multiples of 1 / VIEW_AIM_TOKENS: a token drawn with equal
 * chances names a cell, so drawing is one lookup, the chance is known exactly,
 * and tokens that follow each other lie near each other, so that an even
 * sequence of numbers is an even set of directions.
 */
#ifndef VIEW_AIM_H
#define VIEW_AIM_H

#include <stdbool.h>

#include "ibl/io.h"

#define VIEW_AIM_ROW 512 /* tokens as a square picture */
#define VIEW_AIM_TOKENS (VIEW_AIM_ROW * VIEW_AIM_ROW)
#define VIEW_AIM_EDGE 512 /* cells along a face's edge, at most */

typedef struct view_aim {
    int edge;      /* cells along a face's edge; 0: nothing outshines the mean
                      by what is worth a sample, and there is no table */
    float *chance; /* of each cell, faces and rows as in a cube's level */
    float *tokens; /* index of the cell of each */
} view_aim;

/* Of level 0 of a cube, as it is between texels when filtered. False, with a
 * message, and *aim zeroed, if there is no memory. */
bool view_aim_make(const ibl_texture *cube, view_aim *aim);
void view_aim_free(view_aim *aim); /* zeroed is fine */

#endif
