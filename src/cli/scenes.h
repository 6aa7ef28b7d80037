/* SPDX-License-Identifier: MIT */
/* The scenes of --scene: what their materials need of a bake. */
#ifndef CLI_SCENES_H
#define CLI_SCENES_H

#include "cli/choice.h"
#include "cli/rendered.h"
#include "scene/survey.h"

enum {
    IBL_MAX_SCENES = 64
};

/* The files of --scene. */
typedef struct ibl_scene_list {
    int count;
    const char *path[IBL_MAX_SCENES];
} ibl_scene_list;

/* Scenes that were read. Of their contents the survey is left. */
typedef struct ibl_scenes {
    ibl_scene_survey survey;
    char **files; /* all that were read */
    int file_count;
} ibl_scenes;

/* Reads scenes, strict as in ibl_scene_read, and surveys them. ibl_scenes_free
 * is needed also after a failure. */
bool ibl_scenes_read(ibl_ctx *ctx, const ibl_scene_list *list, bool strict,
                     ibl_scenes *out);
void ibl_scenes_free(ibl_scenes *s); /* NULL is fine */

/* For the choice: the materials that reflect. False: none does. */
bool ibl_scenes_materials(const ibl_scenes *s, ibl_materials *materials);
/* Adds rows of what was found. */
void ibl_scenes_tell(const ibl_scenes *s, ibl_choice *choice);
json_t *ibl_scenes_json(const ibl_scenes *s); /* NULL: no memory */

#endif
