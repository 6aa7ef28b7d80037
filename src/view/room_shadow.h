/* SPDX-License-Identifier: MIT */
/* The shadows of the room's sun: its depth map over the whole room, and the
 * uniform block of shaders/sun.glsl. */
#ifndef VIEW_ROOM_SHADOW_H
#define VIEW_ROOM_SHADOW_H

#include "view/room.h"

typedef struct view_room_shadow view_room_shadow;

view_room_shadow *view_room_shadow_create(void); /* NULL, with a message */
void view_room_shadow_free(view_room_shadow *s); /* NULL is fine */

/* Tells shaders of the sun of a draw. If its shadows have to be made anew,
 * returns the program that draws all casters, front faces counter-clockwise;
 * end follows. Else 0. */
GLuint view_room_shadow_begin(view_room_shadow *s, const view_room_draw *d);
void view_room_shadow_end(view_room_shadow *s);

/* Edge of a texel across the light, in units of the room. Shadows are blurred
 * by one and a half of them each way. */
double view_room_shadow_texel(const view_room_sun *sun, double turn);

#endif
