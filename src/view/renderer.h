/* SPDX-License-Identifier: MIT */
/*
 * Makes the picture in passes, each into what the next one reads, for one state
 * or for two that are compared:
 *   1. linear   scene-linear RGBA floats: sky and spheres, a model, a map, or
 *               the scene; the mean of several draws, each at another place in
 *               all pixels
 *   2. truth    the same spheres or model by the integral itself (truth.h)
 *   3. display  exposure, tone curve, sRGB, comparison; into framebuffer 0
 * A frame allocates nothing.
 *
 * Spheres are ray-traced on a quad each: normals are exact, and edges are
 * smoothed by coverage, from back to front.
 */
#ifndef VIEW_RENDERER_H
#define VIEW_RENDERER_H

#include "view/baked_set.h"
#include "view/gl.h"
#include "view/model.h"
#include "view/room.h"
#include "view/sphere_grid.h"
#include "view/truth.h"

typedef struct view_renderer view_renderer;

/* Where a picture is in a framebuffer, in pixels from the lower left. */
typedef struct view_area {
    int x, y, width, height;
} view_area;

/* Needs a current context. NULL, with a message. */
view_renderer *view_renderer_create(void);
/* NULL is fine. OpenGL's objects end with their context. */
void view_renderer_free(view_renderer *r);

/* Uploads the textures of a set and frees the previous ones; set must stay
 * valid until the next load. False, with a message. */
bool view_renderer_load(view_renderer *r, const baked_set *set);
/* Sets what the second state is drawn by, in place of the set; set must stay
 * valid until the next call. The reference stays that of the first set. False,
 * with a message. */
bool view_renderer_against(view_renderer *r, const baked_set *set);
/* Sets local probes of the scene, instead of captured ones; NULL: none. The
 * caller keeps them unchanged until the next call. */
void view_renderer_probes(view_renderer *r, const view_probe_set *probes);
/* Sets the model of VIEW_MODEL and of the scene; NULL: none. The caller keeps
 * it until the next call. */
void view_renderer_model(view_renderer *r, view_model *model);

/* Where pictures are shown: framebuffer 0 at first. */
void view_renderer_target(view_renderer *r, GLuint framebuffer);
/* Draws the next place of view_places in each pixel, and shows the mean of
 * those since the picture changed. side: the state and, if its compare says so,
 * the second one. False, with a message. */
bool view_renderer_draw(view_renderer *r, const view_settings side[2],
                        const view_area *area);
/* Shows the last draw at another exposure. */
void view_renderer_show(view_renderer *r, double ev);
/* Whether the last draw was that of the last place in the pixels, with all
 * samples. */
bool view_renderer_complete(const view_renderer *r);

/* Reads the linear picture of a side: RGB, width * height * 3 floats, rows from
 * the top. False, with a message. */
bool view_renderer_read(const view_renderer *r, int side, float *rgb);
/* The last picture in linear light, without exposure, tone curve or gain; else
 * as it is shown. The same shape. False, with a message. */
bool view_renderer_linear(const view_renderer *r, float *rgb);
/* What of a map is at a pixel of the last picture, counted from the lower left:
 * its face, or -1, level, column and row; the direction of its centre in
 * the environment's frame, of the table N.V and roughness; its value. False:
 * nothing. */
bool view_renderer_texel(view_renderer *r, int x, int y, float told[3][4]);
/* The scene of the first side; NULL before it was drawn. */
view_scene *view_renderer_stage(const view_renderer *r);

/* Sets the samples of the reference per pixel and draw; 0 (default): as many as
 * keep a frame quick, which varies. */
void view_renderer_pace(view_renderer *r, int samples);
/* The reference that the last draw had, or NULL, and its samples per pixel. */
const view_truth *view_renderer_truth(const view_renderer *r);
int view_renderer_samples(const view_renderer *r);
/* Restarts the picture and the reference. */
void view_renderer_restart(view_renderer *r);
/* Errors of each sphere, or material of the model, of the first side against
 * the second, and their sum behind them; of other pictures one. Returns an
 * array to be freed, and their number; NULL: nothing is compared. */
view_error *view_renderer_errors(view_renderer *r, int *number);

#endif
