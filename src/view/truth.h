/* SPDX-License-Identifier: MIT */
/* The integral that the split sum approximates: for each pixel the whole BRDF
 * (GGX with the geometry of the table, Schlick's Fresnel, and the diffuse part)
 * against the map, or level 0 where that is not at hand, by importance
 * sampling, accumulated over frames. N samples are the first N of one sequence,
 * however divided into frames. */
#ifndef VIEW_TRUTH_H
#define VIEW_TRUTH_H

#include <stdbool.h>

#include "view/baked_set.h"
#include "view/frame.h"
#include "view/gl.h"
#include "view/model.h"

typedef struct view_truth view_truth;

#define VIEW_TRUTH_SAMPLES 4096 /* most samples of a pixel */

/* Makes the table of lights (aim.h) of a set, whose textures must be bound from
 * now on. NULL, with a message. */
view_truth *view_truth_create(const baked_set *set);
void view_truth_free(view_truth *t); /* NULL is fine */
/* What it integrates, as "level 0". */
const char *view_truth_environment(const view_truth *t);
/* Discards all samples; call it when the spheres have changed. */
void view_truth_restart(view_truth *t);
/*
 * Adds samples to the picture of what is seen; begins anew if frame differs in
 * more than its display, or the subject in size or model.
 *   frame      the uniform block "Frame" at binding 0, but for the place in the
 *              pixels, which may change
 *   samples    for each pixel; 0: as many as keep a frame quick, by the clock
 * Changes program, vertex array and framebuffer; blending is off, the viewport
 * is the picture's. False, with a message.
 */
bool view_truth_draw(view_truth *t, const view_frame *frame,
                     const view_subject *seen, int samples);
/* RGBA32F: the mean of all samples, composed with the sky as the split sum is.
 * 0 before the first draw. */
GLuint view_truth_texture(const view_truth *t);
int view_truth_samples(const view_truth *t); /* samples of each pixel so far */

#endif
