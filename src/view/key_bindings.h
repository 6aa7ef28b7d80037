/* SPDX-License-Identifier: MIT */
/* What keys and the mouse do. */
#ifndef VIEW_KEY_BINDINGS_H
#define VIEW_KEY_BINDINGS_H

struct view_app;

/* Does what a key does, and says what it changed; unknown keys do nothing. */
void view_keys_press(struct view_app *app, int key);

/* Drags the picture by pixels: turns the camera, by half a turn for the height
 * of the picture, or moves the map. */
void view_drag(struct view_app *app, double dx, double dy);
/* Moves the camera nearer, or enlarges the map around a pixel, by a factor 1.1
 * per step. */
void view_approach(struct view_app *app, double x, double y, double steps);
/* Moves a model by pixels, with what is in the middle of its distance. */
void view_pan(struct view_app *app, double dx, double dy);
/* Turns the environment by degrees. */
void view_spin(struct view_app *app, double degrees);

#endif
