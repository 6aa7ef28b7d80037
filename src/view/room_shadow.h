/* SPDX-License-Identifier: MIT */
/* The shadows of the room's sun: its depth map over the whole room, and the
 * uniform block of shaders/sun.glsl. */
#ifndef VIEW_ROOM_SHADOW_H
#define VIEW_ROOM_SHADOW_H

#include "view/room.h"

typedef struct view_room_shadow {
    GLuint program, depth, framebuffer, buffer;
    bool made;     /* depths, of what the key says */
    double key[5]; /* what moves is drawn, its seconds; the sun's direction */
} view_room_shadow;

/* Makes a zeroed one. False, with a message. */
bool view_room_shadow_make(view_room_shadow *s);
void view_room_shadow_free(view_room_shadow *s); /* zeroed is fine */

/* Tells shaders of the sun of a draw. If its shadows have to be made anew,
 * binds their framebuffer, sets the viewport, depth test and culling, and
 * returns the program that draws all casters, front faces counter-clockwise.
 * Else 0. */
GLuint view_room_shadow_use(view_room_shadow *s, const view_room_draw *d);

#endif
