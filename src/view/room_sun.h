/* SPDX-License-Identifier: MIT */
/*
 * The sun of an environment: what is so bright and so small that it lights as
 * from one direction, and casts shadows. What it gives is taken off the
 * environment, so that nothing is counted twice: within a cone about it,
 * radiance keeps its colour and no more than a luminance of `limit`.
 */
#ifndef VIEW_ROOM_SUN_H
#define VIEW_ROOM_SUN_H

#include <stdbool.h>

#include "ibl/io.h"

typedef struct view_room_sun {
    double direction[3];  /* to it, unit, in the environment's own frame */
    double irradiance[3]; /* linear RGB: the integral of what is taken over
                             solid angle; zeros: there is no sun */
    double limit;         /* luminance */
    double cosine;        /* of the cone's half angle */
} view_room_sun;

/*
 * The sun in level 0 of a cube, about its brightest texel. The limit is some
 * times the mean luminance of what is not in the cone. There is none (all is
 * zeroed) where what is beyond the limit spreads, as soft boxes and windows do,
 * or gives little beside the rest: then shadows would be wrong or nothing.
 * Texels that are not finite count as 0. False, with a message, if there is no
 * memory.
 */
bool view_room_sun_find(const ibl_texture *sky, view_room_sun *sun);

bool view_room_sun_shines(const view_room_sun *sun);
/* What is left of a texel in a direction (unit, of the environment). */
void view_room_sun_cut(const view_room_sun *sun, const double direction[3],
                       double rgb[3]);

#endif
