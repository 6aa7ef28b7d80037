/* SPDX-License-Identifier: MIT */
/* Volumes of probes as wires: edges of boxes, three circles of spheres. */
#ifndef VIEW_VOLUMES_H
#define VIEW_VOLUMES_H

#include "view/room.h"

typedef struct view_volumes {
    GLuint program, array, buffer; /* 0 until they are first drawn */
} view_volumes;

void view_volumes_free(view_volumes *v); /* zeroed is fine */

/* Scene-linear, at an exposure of 0. */
extern const float view_volumes_influence[3], view_volumes_proxy[3];

/* Draws a volume into the bound framebuffer as d drew the room, where nothing
 * in its depth buffer is nearer; wires on a surface are before it. Keeps the
 * depth. ev: that the picture is shown at, wires look alike at any. Changes
 * program and vertex array; depth test and blending are off. False, with a
 * message. */
bool view_volumes_render(view_volumes *v, const view_room_draw *d, double ev,
                         const ibl_volume *volume, const float colour[3]);

#endif
