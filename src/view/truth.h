/* SPDX-License-Identifier: MIT */
/*
 * The integral that the split sum stands for: for each pixel the whole BRDF
 * (GGX, height-correlated Smith or what the table has, Schlick's Fresnel, and
 * the diffuse part) against level 0, with N, V and R as they are, by importance
 * sampling, a few samples a frame, added up. A frame that looks the same as the
 * one before goes on where that ended.
 */
#ifndef VIEW_TRUTH_H
#define VIEW_TRUTH_H

#include "view/frame.h"
#include "view/gl.h"

typedef struct view_truth view_truth;

#define VIEW_TRUTH_SAMPLES 4096 /* a pixel; then it rests */

view_truth *view_truth_create(void); /* NULL, with a message */
void view_truth_free(view_truth *t); /* NULL is fine */
/* Adds samples (as many as budget allows for a frame) to the picture of width x
 * height; begins anew if anything in frame differs from the call before but
 * what is of display alone. instances: the renderer's vertex array of spheres,
 * count of them, to be drawn as sphere.vert wants it. sky: program of the sky
 * pass. Textures of the set are bound. The result is in view_truth_texture as
 * RGBA32F: RGB averaged over samples by the pass itself. */
bool view_truth_draw(view_truth *t, const view_frame *frame, GLuint instances,
                     int count, int width, int height, int budget);
void view_truth_restart(view_truth *t); /* another set was loaded */
GLuint view_truth_texture(const view_truth *t);
int view_truth_samples(const view_truth *t); /* a pixel has by now */

#endif
