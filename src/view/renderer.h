/* SPDX-License-Identifier: MIT */
/*
 * Makes the picture. Passes, each into what the next one reads:
 *   1. linear   sky and spheres by the split sum, what is inspected, or the
 *               scene (stage.h), as scene-linear RGB floats; while the truth
 * goes on, that of the frame before
 *   2. truth    the same spheres by the integral itself (truth.h), while
 *               settings.compare asks for it
 *   3. display  exposure, tone curve, sRGB, and comparing; into framebuffer 0
 *   4. overlay  text (overlay.h)
 * State that never changes is set when the renderer is made, textures are
 * uploaded when a set is loaded, and a frame allocates nothing.
 *
 * Spheres are ray-traced on a quad each that covers them: normals are exact,
 * edges are smoothed by coverage, and spheres are drawn from back to front.
 */
#ifndef VIEW_RENDERER_H
#define VIEW_RENDERER_H

#include "view/baked_set.h"
#include "view/gl.h"
#include "view/probe_set.h"
#include "view/scene_captures.h"
#include "view/sphere_grid.h"

typedef struct view_renderer view_renderer;

/* Needs a current context. NULL, with a message. */
view_renderer *view_renderer_create(void);
void view_renderer_free(view_renderer *r); /* NULL is fine */

/* Uploads a set's textures; what was loaded before goes. set stays the
 * caller's and must stay until the next load. False, with a message. */
bool view_renderer_load(view_renderer *r, const baked_set *set);

/* Local probes of the scene from now on, in place of captured ones; NULL: none.
 * They stay the caller's, and until others are given. */
void view_renderer_probes(view_renderer *r, const view_probe_set *probes);

/* Draws into framebuffer 0, width x height pixels. False, with a message. */
bool view_renderer_draw(view_renderer *r, const view_settings *s, int width,
                        int height);

/* Of the last draw: linear RGB, width * height * 3 floats, rows from the top;
 * truth: that of the reference. */
bool view_renderer_read(const view_renderer *r, bool truth, float *rgb);

/* Of the last draw: what it showed, as view_picture_read has it, but drawn once
 * more into a framebuffer of its own: the pixels of a window are undefined
 * where others cover it. NULL, with a message. */
unsigned char *view_renderer_picture(const view_renderer *r);

/* The scene, once it has been drawn; else NULL. */
view_scene *view_renderer_stage(const view_renderer *r);

/* Samples of the truth for each pixel and draw; 0 (default): as many as leave a
 * frame responsive, by the clock, so not the same in every run. */
void view_renderer_pace(view_renderer *r, int samples);
/* Samples for each pixel that the truth has by now, of VIEW_TRUTH_SAMPLES; 0:
 * the last draw did not ask for it. */
int view_renderer_samples(const view_renderer *r);
/* The truth begins anew, as if nothing had been drawn. */
void view_renderer_restart(view_renderer *r);
/* Relative RMSE of the split sum against the truth for each sphere, as
 * view_errors has it: room for the grid; returns how many. 0: no truth is
 * there. */
int view_renderer_errors(const view_renderer *r, double *rmse);

#endif
