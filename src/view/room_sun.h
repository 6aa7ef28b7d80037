/* SPDX-License-Identifier: MIT */
/* The sun of an environment: so bright and small that it lights from one
 * direction and casts shadows. Its light is removed from the
 * environment: within a cone, radiance keeps its colour and at most a luminance
 * of `limit`. */
#ifndef VIEW_ROOM_SUN_H
#define VIEW_ROOM_SUN_H

#include <stdbool.h>

#include "ibl/io.h"

typedef struct view_room_sun {
    double direction[3];  /* to the sun, unit, in the environment's frame */
    double irradiance[3]; /* linear RGB; zeros: no sun */
    bool apart;           /* it is no part of the maps: nothing is removed */
    double radius;        /* of its disc if it is apart, rad */
    double limit;         /* luminance */
    double cosine;        /* of the cone's half angle */
} view_room_sun;

/* Finds the sun around the brightest texel of level 0. The limit is a multiple
 * of the mean luminance outside the cone. No sun (all zeros) if the light above
 * it is weak, or spread as from soft boxes and windows. Texels that are not
 * finite count as 0. False, with a message: no memory. */
bool view_room_sun_find(const ibl_texture *sky, view_room_sun *sun);

bool view_room_sun_shines(const view_room_sun *sun);

#endif
