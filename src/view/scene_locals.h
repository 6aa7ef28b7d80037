/* SPDX-License-Identifier: MIT */
/* The places of the local probes of --mode scene. */
#ifndef VIEW_SCENE_LOCALS_H
#define VIEW_SCENE_LOCALS_H

#include "ibl/probes.h"

/* Places 1..VIEW_MAX_LOCALS probes in a nearly square grid at eye level, moved
 * out of pillars and mirror. Influence: the cell, from beneath the floor to
 * above the ceiling; proxy: the walls. Neighbours share a blend width across
 * their border, where they sum to at least 1. In the order of ibl_probes_order,
 * layers 0, 1, ... */
void view_scene_place(ibl_probe *probes, int count);

#endif
