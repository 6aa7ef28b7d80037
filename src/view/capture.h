/* SPDX-License-Identifier: MIT */
/*
 * Captures of a scene as cubes, filtered to levels of roughness (ibl/ibl.h: GGX
 * with N = V = R) and irradiance: on the GPU, a face at a time, or by the
 * library. The GPU's levels of cubes of 64 texels and more, with 64 samples,
 * differ from the library's by an nRMSE of 0.2 % in an evenly lit room, of up
 * to 1.5 % with a light 50 times as bright, 2 % with 200 times and 2.2 % with
 * 1000 times (tests/check_view_capture.c).
 *
 * Alpha is how much of a texel has been seen: 0 where nothing was drawn. It is
 * filtered like the colours, which are premultiplied by it.
 *
 * All calls keep the framebuffer and the viewport, and leave depth test and
 * blending off and no program in use. The units VIEW_CAPTURE_UNIT and _MORE,
 * the vertex array and the clear colour change.
 */
#ifndef VIEW_CAPTURE_H
#define VIEW_CAPTURE_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "view/gl.h"
#include "view/settings.h"

typedef struct view_capture view_capture;

/*
 * Draws into the bound framebuffer of size x size pixels, cleared to zeros,
 * with depth test on and blending off: linear RGBA, world to clip space by clip
 * (column-major), from eye. Values beyond a half float are cut later. Front
 * faces are counter-clockwise; up in the world may be down in the picture.
 *   side   -1, or the paraboloid: 0 (towards +Z), 1 (-Z); clip is then
 *          for shaders/paraboloid.glsl
 */
typedef void view_capture_scene(void *cookie, const double clip[16],
                                const double eye[3], int size, int side);

typedef struct view_capture_options {
    view_probe_capture kind;
    int size;    /* of faces, a power of two, 16..1024; default 256. Pictures
                    of paraboloids have twice the edge: a third more pixels than
                    six faces. They pay where the scene costs more. */
    int levels;  /* 0: ibl_default_levels(size) */
    int samples; /* of each texel of a level, 1..1024, default 64. 16 make three
                    times the error, 256 half; with 1024 view_capture_create
                    takes a second or two. */
    double near, far; /* default 0.05 and 100 */
    ibl_ctx *cpu; /* not NULL: the library filters, in one step; default NULL */
    bool timed;   /* wait for the end of each step; default false */
} view_capture_options;

#define VIEW_CAPTURE_IRRADIANCE 32 /* edge of that cube */

view_capture_options view_capture_options_default(void);

/* NULL, with a message. */
view_capture *view_capture_create(const view_capture_options *options);
void view_capture_free(view_capture *c); /* NULL is fine */

/* A whole update from position; drops one that was begun. False, with a
 * message. */
bool view_capture_update(view_capture *c, const double position[3],
                         view_capture_scene *scene, void *cookie);
/*
 * Does the next `steps` of an update, at most to its end. The last whole update
 * stays shown until then. True at the end. position counts at the first step.
 * False with a message if the library could not filter: the next is a first
 * step.
 *
 * Steps are: six faces or two sides drawn; the lookups; each face of each level
 * from 1 on; each face of the irradiance. With options.cpu one step follows the
 * drawn ones.
 */
bool view_capture_advance(view_capture *c, const double position[3],
                          view_capture_scene *scene, void *cookie, int steps);
/* Whether the last call of it did fail. */
bool view_capture_failed(const view_capture *c);
int view_capture_steps(const view_capture *c);
/* Of them, those that call the scene, which are the first. */
int view_capture_draws(const view_capture *c);
/* In place of options.far, from the next draw on. */
void view_capture_set_far(view_capture *c, double far);
/* What had been begun is left off: the next step is an update's first. */
void view_capture_restart(view_capture *c);

/* Filters the shown level 0 by the library, in place of the shown levels and
 * irradiance; drops an update that was begun. False, with a message, and
 * nothing has changed. */
bool view_capture_filter_cpu(view_capture *c, ibl_ctx *ctx);

/* The last whole update: cubes, RGBA16F, filtered linearly. Their names change
 * with each update. Black before the first. */
GLuint view_capture_specular(const view_capture *c);
GLuint view_capture_irradiance(const view_capture *c); /* E / pi */
int view_capture_size(const view_capture *c);
int view_capture_levels(const view_capture *c);
/* Reads the shown chain, RGB, into an allocated cube of that size and at most
 * as many levels; irradiance: of VIEW_CAPTURE_IRRADIANCE and one level. False,
 * with a message. */
bool view_capture_read(const view_capture *c, ibl_cube *cube);
bool view_capture_read_irradiance(const view_capture *c, ibl_cube *cube);
/* Milliseconds of the last whole update: drawing, levels, irradiance (0 if the
 * library made it with the levels). Without options.timed, the time to ask for
 * them. */
void view_capture_times(const view_capture *c, double ms[3]);

#endif
