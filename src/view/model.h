/* SPDX-License-Identifier: MIT */
/* A scene of glTF in OpenGL, drawn by the set: metallic-roughness with
 * specular, clearcoat and unlit; anisotropy, transmission and sheen are left
 * out. */
#ifndef VIEW_MODEL_H
#define VIEW_MODEL_H

#include <stdbool.h>

#include "scene/scene.h"
#include "view/frame.h"
#include "view/gl.h"
#include "view/settings.h"

typedef struct view_model view_model;

/* Uploads what is drawn of a scene, with its images, which are decoded for it.
 * The model is moved and scaled: the middle of its box is the origin, and its
 * farthest vertex is at a distance of 1. name: for messages. NULL, with a
 * message. */
view_model *view_model_create(ibl_ctx *ctx, ibl_scene *scene, const char *name);
void view_model_free(view_model *m); /* NULL is fine */

/* Moves a model: its middle and radius, or NULL: as it is in its file. */
void view_model_place(view_model *m, const double at[3], double radius);
/* Moves a draw of a scene, by its index. */
void view_model_move(view_model *m, int draw, const double at[3], double scale);

/* Draws it with depth into the bound framebuffer, which has cleared depth. eye:
 * of the camera. Changes program, vertex array and units from VIEW_MODEL_UNITS;
 * leaves blending and depth test off. False, with a message. */
bool view_model_draw(view_model *m, const view_lighting *light,
                     const float eye[3]);

/* What a picture of materials shows, over the sky. */
typedef struct view_subject {
    const view_frame *frame;
    view_model *model; /* or NULL: the spheres */
    view_lighting light;
} view_subject;

/* Draws it into a picture of its size. Colours are times alpha, what covers the
 * pixel. Of VIEW_PARTS_COUNT R is 1 + the index of the sphere or the opaque
 * material, over nothing. Changes program, vertex array, framebuffer and units
 * from VIEW_MODEL_UNITS; leaves blending off. False, with a message. */
bool view_subject_draw(const view_subject *s, view_image *picture);

/* A camera of the file; NULL: it has no such one. */
const view_pose *view_model_camera(const view_model *m, int i);
/* Height of its lowest point below its middle, at radius 1. */
double view_model_floor(const view_model *m);
/* Draws the depth of what is opaque by the block "Frame" into the bound
 * framebuffer, which has cleared depth. False, with a message. */
bool view_model_depth(view_model *m);

/* Names of materials, for reports: "" if the file has none; NULL: there are
 * fewer. */
const char *view_model_material(const view_model *m, int i);

#endif
