/* SPDX-License-Identifier: MIT */
/* The scenes of --scene: what their materials need of a bake. What was found
 * and chosen for them and --rendered-error, as a table. */
#ifndef CLI_SCENES_H
#define CLI_SCENES_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

#include "cli/rendered.h"
#include "scene/survey.h"

enum {
    IBL_MAX_SCENES = 64
};

/* What was found and chosen, and the figures beside those of the defaults. */
typedef struct ibl_choice {
    char *table;  /* what was found and chosen, a line each; to be freed */
    int rows[2];  /* of it: found, chosen */
    double asked; /* error; NAN: there is no choice */
    bool reached;
    double error, standard_error, usual_error; /* as measured */
    size_t bytes, usual_bytes; /* of texels, without containers */
} ibl_choice;

/* Adds a row: a value, then perhaps a tab and why. What was found comes first.
 * Long texts are cut. */
void ibl_choice_add(ibl_choice *c, bool chosen, const char *name,
                    const char *fmt, ...) __attribute__((format(printf, 4, 5)));
void ibl_choice_print(const ibl_choice *c, FILE *to);
json_t *ibl_choice_json(const ibl_choice *c);

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
void ibl_scenes_free(ibl_scenes *s);

/* For the choice: the materials that reflect. False: none does. */
bool ibl_scenes_materials(const ibl_scenes *s, ibl_materials *materials);
/* Adds rows of what was found. */
void ibl_scenes_tell(const ibl_scenes *s, ibl_choice *choice);
json_t *ibl_scenes_json(const ibl_scenes *s);

#endif
