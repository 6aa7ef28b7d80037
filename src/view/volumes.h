/* SPDX-License-Identifier: MIT */
/* Draws volumes of probes as wires: box edges or three circles of a sphere. */
#ifndef VIEW_VOLUMES_H
#define VIEW_VOLUMES_H

#include "view/room.h"

typedef struct view_volumes {
    GLuint program, array, buffer; /* 0 until the first draw */
} view_volumes;

void view_volumes_free(view_volumes *v); /* zeroed is fine */

/* Scene-linear, at an exposure of 0. */
extern const float view_volumes_influence[3], view_volumes_proxy[3];

/* Draws a volume into the bound framebuffer with the camera of d. The depth
 * buffer hides wires behind surfaces but not on them, and does not change. ev:
 * the exposure of the picture; wires look the same at any. Changes program and
 * vertex array; turns depth test and blending off. False, with a message. */
bool view_volumes_render(view_volumes *v, const view_room_draw *d, double ev,
                         const ibl_volume *volume, const float colour[3]);

#endif
