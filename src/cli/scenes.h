/* SPDX-License-Identifier: MIT */
/* The scenes of --scene: what their materials need of a bake. */
#ifndef CLI_SCENES_H
#define CLI_SCENES_H

#include "cli/choose.h"
#include "scene/survey.h"

/* Scenes that were read. Of their contents the survey is left. */
typedef struct ibl_scenes {
    ibl_scene_survey survey;
    char **files; /* all that were read */
    int file_count;
} ibl_scenes;

/* Reads the scenes of o and surveys them. ibl_scenes_free is needed also after
 * a failure. */
bool ibl_scenes_read(ibl_ctx *ctx, const ibl_opts *o, ibl_scenes *out);
void ibl_scenes_free(ibl_scenes *s); /* NULL is fine */

/* For the choice: the materials that reflect. False: none does. */
bool ibl_scenes_materials(const ibl_scenes *s, ibl_materials *materials);
/* Adds rows of what was found. */
void ibl_scenes_tell(const ibl_scenes *s, ibl_choice *choice);

/* Leaves out of o what a scene in which nothing reflects does not need. */
void ibl_scenes_drop(const ibl_scenes *s, ibl_opts *o, ibl_choice *choice);
/* Whether sheen needs a set of its own beside o; sets its options, which are
 * those of o, chosen or not, for Charlie's lobe. */
bool ibl_scenes_sheen(const ibl_scenes *s, const ibl_opts *o, ibl_opts *sheen,
                      ibl_choice *choice);
/* Adds rows of what is left to the user. */
void ibl_scenes_advise(const ibl_scenes *s, const ibl_opts *o,
                       ibl_choice *choice);

json_t *ibl_scenes_json(const ibl_scenes *s); /* NULL: no memory */

#endif
