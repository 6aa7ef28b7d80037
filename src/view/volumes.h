/* SPDX-License-Identifier: MIT */
/* Volumes of probes as wires over a scene: of boxes the edges, of spheres three
 * circles about the axes. */
#ifndef VIEW_VOLUMES_H
#define VIEW_VOLUMES_H

#include "ibl/probes.h"
#include "view/gl.h"

typedef struct view_volumes view_volumes;

view_volumes *view_volumes_create(void); /* NULL, with a message */
void view_volumes_free(view_volumes *v); /* NULL is fine */

/* Scene-linear, at an exposure of 0. */
extern const float view_volumes_influence[3], view_volumes_proxy[3];

typedef struct view_volumes_draw {
    double clip[16]; /* world to clip space, column-major, by which the scene
                        was drawn, */
    double eye[3];   /* and from where */
    double ev;       /* that the picture is shown at: wires look alike at any */
    int count;
    const ibl_probe *probe;
} view_volumes_draw;

/*
 * Draws the influence of each probe, and its proxy if it has one, in another
 * colour, into the bound framebuffer, where nothing in its depth buffer is
 * nearer; wires on a surface are before it. That depth stays. Program and
 * vertex array are others afterwards, depth test and blending off.
 */
void view_volumes_render(view_volumes *v, const view_volumes_draw *d);

#endif
