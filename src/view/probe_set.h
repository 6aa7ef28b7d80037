/* SPDX-License-Identifier: MIT */
/* Probes baked by `iblbake probes`, as cube arrays of OpenGL. */
#ifndef VIEW_PROBE_SET_H
#define VIEW_PROBE_SET_H

#include <stdbool.h>

#include "view/room.h"

typedef struct view_probe_set view_probe_set;

/* Reads an index (iblbake-probes(1)) and its arrays, and turns spherical
 * harmonics of irradiance into cubes; ignores the global environment. ctx must
 * log through view_log. NULL, with a message: a file is missing or wrong. */
view_probe_set *view_probe_set_load(ibl_ctx *ctx, const char *index);
void view_probe_set_free(view_probe_set *set); /* NULL is fine */

/* Maps to draw the room with; owned by set. */
const view_probe_maps *view_probe_set_locals(const view_probe_set *set);

/* Whether the index or an array was replaced, and has not changed for settle
 * seconds. False while the index is missing. */
bool view_probe_set_changed(const view_probe_set *set, double settle);
/* Takes the present files as seen: changed() reports only later changes. */
void view_probe_set_seen(view_probe_set *set);

#endif
