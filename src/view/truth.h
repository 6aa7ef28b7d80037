/* SPDX-License-Identifier: MIT */
/*
 * The integral that the split sum stands for: for each pixel the whole BRDF
 * (GGX with the geometry of the table, Schlick's Fresnel, and the diffuse
 * part) against level 0, with N, V and R as they are, by importance sampling,
 * some samples a frame, added up. A frame that looks the same as the one
 * before goes on where that ended; N samples are the first N of one sequence,
 * however they were divided into frames.
 */
#ifndef VIEW_TRUTH_H
#define VIEW_TRUTH_H

#include <stdbool.h>

#include "view/baked_set.h"
#include "view/frame.h"
#include "view/gl.h"

typedef struct view_truth view_truth;

#define VIEW_TRUTH_SAMPLES 4096 /* a pixel; then it rests */

view_truth *view_truth_create(void); /* NULL, with a message */
void view_truth_free(view_truth *t); /* NULL is fine */
/* The set whose textures are bound to the units of view_unit from now on: makes
 * the table of its lights (aim.h) and begins anew. False, with a message. */
bool view_truth_load(view_truth *t, const baked_set *set);
/* Begins anew: the spheres in the vertex array were changed. */
void view_truth_restart(view_truth *t);
/*
 * Adds samples to the picture of width x height; begins anew if anything in
 * frame differs from the call before but what is of display alone.
 *   frame      what uniform block "Frame" (binding 0) holds
 *   instances  vertex array of the spheres, as sphere.vert takes them, in the
 *              order that the split sum draws them in; count of them
 *   samples    for each pixel; 0: as many as leave a frame responsive, by the
 *              clock, so not the same number in every run
 * The program, the vertex array and the framebuffer that are bound are others
 * afterwards; blending is off, the viewport is the picture's. False, with a
 * message.
 */
bool view_truth_draw(view_truth *t, const view_frame *frame, GLuint instances,
                     int count, int width, int height, int samples);
/* RGBA32F: the mean over all samples, composed with the sky as the split sum's
 * picture is. 0 before the first draw. */
GLuint view_truth_texture(const view_truth *t);
int view_truth_samples(const view_truth *t); /* a pixel has by now */

#endif
