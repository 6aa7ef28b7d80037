/* SPDX-License-Identifier: MIT */
/* The shadows of the room's sun: how far it sees, in a square of texels that is
 * as large as the room is from there, and what shaders are told of it
 * (shaders/sun.glsl). Part of view/room.h, used there alone. */
#ifndef VIEW_ROOM_SHADOW_H
#define VIEW_ROOM_SHADOW_H

#include "view/room.h"

typedef struct view_room_shadow view_room_shadow;

view_room_shadow *view_room_shadow_create(void); /* NULL, with a message */
void view_room_shadow_free(view_room_shadow *s); /* NULL is fine */

/*
 * Tells shaders of the sun of a draw. If its shadows are wanted and have to be
 * made anew, returns the program to draw everything with that casts any, front
 * faces counter-clockwise; then end is to be called. Else 0.
 */
GLuint view_room_shadow_begin(view_room_shadow *s, const view_room_draw *d);
void view_room_shadow_end(view_room_shadow *s);

/* Edge of a texel across the light, in units of the room: shadows are blurred
 * by one and a half of them each way. */
double view_room_shadow_texel(const view_room_sun *sun, double turn);

#endif
