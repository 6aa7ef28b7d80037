/* SPDX-License-Identifier: MIT */
/* Probes that `iblbake probes` baked, as cube arrays of OpenGL. */
#ifndef VIEW_PROBE_SET_H
#define VIEW_PROBE_SET_H

#include <stdbool.h>

#include "view/room.h"

typedef struct view_probe_set view_probe_set;

/* Reads an index (iblbake-probes(1)) and the arrays that it names; irradiance
 * as spherical harmonics becomes cubes. Leaves out the global environment. ctx
 * logs through view_log. NULL, with a message, if anything is missing, does not
 * fit, or is no finite number. */
view_probe_set *view_probe_set_load(ibl_ctx *ctx, const char *index);
void view_probe_set_free(view_probe_set *set); /* NULL is fine */

/* What the room is drawn with; owned by set. */
const view_probe_maps *view_probe_set_locals(const view_probe_set *set);
/* The index, as it was given. */
const char *view_probe_set_path(const view_probe_set *set);

/* Whether the index or an array is another file than the one that was read, and
 * left alone for settle seconds; never without the index. */
bool view_probe_set_changed(const view_probe_set *set, double settle);
/* Looks no more at what the files are now, until they change again. */
void view_probe_set_seen(view_probe_set *set);

#endif
