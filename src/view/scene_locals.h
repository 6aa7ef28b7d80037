/* SPDX-License-Identifier: MIT */
/* The local probes of --mode scene: their places in the room, and their
 * captures, each a layer of cube arrays. */
#ifndef VIEW_SCENE_LOCALS_H
#define VIEW_SCENE_LOCALS_H

#include "view/capture.h"
#include "view/room.h"

/* Places 1..VIEW_MAX_LOCALS probes in a nearly square grid at eye level, moved
 * out of pillars and mirror. Influence: the cell, from beneath the floor to
 * above the ceiling; proxy: the walls. Neighbours share a blend width across
 * their border, where they sum to at least 1. In the order of ibl_probes_order,
 * layers 0, 1, ... */
void view_scene_place(ibl_probe *probes, int count);

typedef struct view_scene_locals view_scene_locals;

/* Black at first. One capture of those options makes all of them in turn. NULL,
 * with a message. */
view_scene_locals *view_scene_locals_create(const view_capture_options *options,
                                            int count);
void view_scene_locals_free(view_scene_locals *l); /* NULL is fine */

/* Captures the i-th, as far as `far`. Leaves its framebuffer bound, else the
 * state of captures. False, with a message. */
bool view_scene_locals_capture(view_scene_locals *l, int i, double far,
                               view_capture_scene *scene, void *cookie);
/* A face of a probe's last capture, for probe_save.h: 4 halves a pixel. False,
 * with a message. */
bool view_scene_locals_face(void *l, int probe, int face, uint16_t *rgba);
/* As a draw has them; valid until they are freed. */
view_room_locals view_scene_locals_drawn(const view_scene_locals *l);

#endif
