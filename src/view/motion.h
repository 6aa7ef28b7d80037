/* SPDX-License-Identifier: MIT */
/* Moving about: what arrows, mouse and wheel share. */
#ifndef VIEW_MOTION_H
#define VIEW_MOTION_H

#include "view/baked_set.h"
#include "view/settings.h"

/* A place in a picture: pixels from its upper left. */
typedef struct view_place {
    int width, height; /* of the picture */
    double x, y;
} view_place;

/* A drag by pixels: turns the camera, the height of the picture being half a
 * turn, or moves the map that is shown. */
void view_drag(view_settings *s, const baked_set *set, int width, int height,
               double dx, double dy);
/* Nearer by steps of a tenth; a map stays where it is at a place. */
void view_approach(view_settings *s, const baked_set *set, view_place at,
                   double steps);
/* Turns the environment by degrees. */
void view_spin(view_settings *s, double degrees);

#endif
