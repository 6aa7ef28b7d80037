/* SPDX-License-Identifier: MIT */
/* Camera and map movement by arrows, mouse and wheel. */
#ifndef VIEW_MOTION_H
#define VIEW_MOTION_H

#include "view/baked_set.h"
#include "view/settings.h"

/* A pixel of a picture, from its upper left. */
typedef struct view_place {
    int width, height; /* of the picture */
    double x, y;
} view_place;

/* Drags by pixels: turns the camera, by half a turn for the height of the
 * picture, or moves the map. */
void view_drag(view_settings *s, const baked_set *set, int width, int height,
               double dx, double dy);
/* Moves the camera nearer, or enlarges the map around a pixel, by a factor 1.1
 * per step. */
void view_approach(view_settings *s, const baked_set *set, view_place at,
                   double steps);
/* Moves a model by pixels, with what is in the middle of its distance. */
void view_pan(view_settings *s, int width, int height, double dx, double dy);
/* Turns the environment by degrees. */
void view_spin(view_settings *s, double degrees);
/* Moves the first light about the origin at its distance: around +Y and up, by
 * degrees. Makes one if there is none. */
void view_move_light(view_settings *s, double around, double up);

#endif
