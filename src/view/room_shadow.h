/* SPDX-License-Identifier: MIT */
/* Shadows of the room's sun: its depth map of the whole room, and the uniform
 * block of shaders/sun.glsl. */
#ifndef VIEW_ROOM_SHADOW_H
#define VIEW_ROOM_SHADOW_H

#include "view/room.h"

typedef struct view_room_shadow {
    GLuint program, depth, framebuffer, buffer;
    bool made;     /* depth holds the scene of key */
    double key[5]; /* moving objects drawn, time; direction to the sun */
} view_room_shadow;

/* *s must be zeroed. False, with a message. */
bool view_room_shadow_make(view_room_shadow *s);
void view_room_shadow_free(view_room_shadow *s); /* zeroed is fine */

/* Uploads the sun of a draw. If its shadows must be rendered again: binds their
 * framebuffer, sets viewport, depth test and culling, and returns the program
 * that draws all casters, front faces counter-clockwise. Else returns 0. */
GLuint view_room_shadow_use(view_room_shadow *s, const view_room_draw *d);

#endif
