/* SPDX-License-Identifier: MIT */
/* Places of the local probes of --mode scene. */
#ifndef VIEW_SCENE_LOCALS_H
#define VIEW_SCENE_LOCALS_H

#include "ibl/probes.h"

/* Places 1..VIEW_MAX_LOCALS probes in a nearly square grid at eye level,
 * outside pillars and mirror. Influence: the cell, from below the floor to
 * above the ceiling; proxy: the walls. Influences of neighbours overlap by a
 * blend width and sum to at least 1. Sorted by ibl_probes_order; layers 0 to
 * count - 1. */
void view_scene_place(ibl_probe *probes, int count);

#endif
