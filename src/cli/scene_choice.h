/* SPDX-License-Identifier: MIT */
/* What follows from the materials of scenes alone. */
#ifndef CLI_SCENE_CHOICE_H
#define CLI_SCENE_CHOICE_H

#include "cli/choose.h"

/* Leaves out of o what a scene in which nothing reflects does not need. */
void ibl_scenes_drop(const ibl_scenes *s, ibl_opts *o, ibl_choice *choice);
/* Whether sheen needs a set of its own beside o; sets its options, which are
 * those of o, chosen or not, for Charlie's lobe. */
bool ibl_scenes_sheen(const ibl_scenes *s, const ibl_opts *o, ibl_opts *sheen,
                      ibl_choice *choice);
/* Adds rows of what is left to the user. */
void ibl_scenes_advise(const ibl_scenes *s, const ibl_opts *o,
                       ibl_choice *choice);

#endif
