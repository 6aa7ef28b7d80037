/* SPDX-License-Identifier: MIT */
/* The local probes of --mode scene: where in the room they are, and their
 * captures, each a layer of cube arrays. Part of view/scene_captures.h, used
 * there alone. */
#ifndef VIEW_SCENE_LOCALS_H
#define VIEW_SCENE_LOCALS_H

#include "view/capture.h"
#include "view/room.h"

/*
 * Places 1..VIEW_MAX_LOCALS probes in a grid of rows that is as square as can
 * be, at eye level, beside pillars and mirror where they would be in them. Each
 * has its cell of the room as influence, from beneath the floor to above the
 * ceiling, and the walls as proxy. Neighbours share a blend width half on
 * either side of their border, where they sum to 1 at least. Writes them in the
 * order of ibl_probes_order, with layers 0, 1, ...
 */
void view_scene_place(ibl_probe *probes, int count);

typedef struct view_scene_locals view_scene_locals;

/* Black. All are captured by one capture of those options, in turn, so that
 * there is memory for one of them and the arrays. NULL, with a message. */
view_scene_locals *view_scene_locals_create(const view_capture_options *options,
                                            int count);
void view_scene_locals_free(view_scene_locals *l); /* NULL is fine */

/* The i-th, as far as `far`. Leaves a framebuffer of its own bound, and else
 * what captures do. False, with a message. */
bool view_scene_locals_capture(view_scene_locals *l, int i, double far,
                               view_capture_scene *scene, void *cookie);
/* A face of a probe's last capture, for probe_save.h: 4 halves a pixel. False,
 * with a message. */
bool view_scene_locals_face(void *l, int probe, int face, uint16_t *rgba);
/* As a draw has them; valid until they are freed. */
view_room_locals view_scene_locals_drawn(const view_scene_locals *l);

#endif
