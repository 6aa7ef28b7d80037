/* SPDX-License-Identifier: MIT */
/* The sun of an environment: so bright and small that it lights as from one
 * direction and casts shadows. Its light is taken off the environment: within a
 * cone, radiance keeps its colour and at most a luminance of `limit`. */
#ifndef VIEW_ROOM_SUN_H
#define VIEW_ROOM_SUN_H

#include <stdbool.h>

#include "ibl/io.h"

typedef struct view_room_sun {
    double direction[3];  /* to it, unit, in the environment's own frame */
    double irradiance[3]; /* linear RGB; zeros: no sun */
    double limit;         /* luminance */
    double cosine;        /* of the cone's half angle */
} view_room_sun;

/* Finds the sun around the brightest texel of level 0. The limit is a multiple
 * of the mean luminance outside the cone. There is none (all zeros) if the
 * light above the limit is spread, as of soft boxes and windows, or weak.
 * Texels that are not finite count as 0. False, with a message: no memory. */
bool view_room_sun_find(const ibl_texture *sky, view_room_sun *sun);

bool view_room_sun_shines(const view_room_sun *sun);

#endif
