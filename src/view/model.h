/* SPDX-License-Identifier: MIT */
/* A scene of glTF in OpenGL, drawn by the set: metallic-roughness with
 * specular, clearcoat, sheen and unlit; anisotropy and transmission are left
 * out. */
#ifndef VIEW_MODEL_H
#define VIEW_MODEL_H

#include <stdbool.h>

#include "scene/scene.h"
#include "view/gl.h"
#include "view/settings.h"
#include "view/upload.h"

typedef struct view_model view_model;

/* Uploads what is drawn of a scene, with its images, which are decoded for it.
 * The model is moved and scaled: the middle of its box is the origin, and its
 * farthest vertex is at a distance of 1. name: for messages. NULL, with a
 * message. */
view_model *view_model_create(ibl_ctx *ctx, ibl_scene *scene, const char *name);
void view_model_free(view_model *m); /* NULL is fine */

/* A sphere with a normal map around its middle. NULL, with a message. */
view_model *view_model_ball(void);
/* Gives it the material of the settings: the upper end of metallic, the middle
 * of roughness. False: it had that already. */
bool view_model_paint(view_model *ball, const view_settings *s);

/* What colours it: lookups of one view_reflection, or samples of the reference
 * (truth.h). */
typedef struct view_model_light {
    int reflection; /* VIEW_REFERENCE: by samples */
    bool sheen;     /* the set has it */
    bool harmonics; /* diffuse light is by them */
} view_model_light;

/* What a picture of materials shows, over the sky. */
typedef struct view_subject {
    GLuint sky;       /* program */
    GLuint instances; /* vertex array of count spheres, from back to front */
    int count;
    view_model *model; /* in place of the spheres, or NULL */
    int width, height;
    const float *eye; /* of the camera, for the order of what is blended */
    GLuint frame;     /* the buffer of the block "Frame" */
    const view_mean *mean;
} view_subject;

/* Draws it into a picture of its size; the viewport is set.
 *   spheres  their program
 *   canvas, samples  for a model, see view_canvas_begin
 * Pixels of a model's opaque material have alpha 2 + its index, blended ones
 * leave alpha as it is. Changes program, vertex array and units from
 * VIEW_MODEL_UNITS; leaves blending off. False, with a message. */
bool view_subject_draw(const view_subject *s, const view_model_light *light,
                       GLuint spheres, const view_image *picture,
                       view_canvas *canvas, int samples);

/* Names of materials, for reports: "" if the file has none. */
int view_model_materials(const view_model *m);
const char *view_model_material(const view_model *m, int i);

#endif
