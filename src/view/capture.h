/* SPDX-License-Identifier: MIT */
/*
 * Cubes that are captured and filtered here, on the GPU: six faces (or two
 * paraboloids) of something that draws, then the levels of roughness and the
 * irradiance (ibl/ibl.h: GGX with N = V = R), a face at a time if it is to be
 * spread over frames. Or filtered by the library on the CPU from what is read
 * back. From that, with 64 samples, the GPU's levels and irradiance of cubes of
 * 64 texels and more differ by an nRMSE of 0.2 % in an evenly lit room, of 1.5
 * % at most with a light that is 50 times as bright as the room and 2 % with
 * one of 200 times, wherever it is and whatever its size; small ones that are
 * 1000 times as bright leave up to 2.2 % (tests/check_view_capture.c).
 *
 * Alpha is how much of a texel has been seen: 0 where nothing was drawn. It is
 * filtered as the colours are, which are thus premultiplied by it: what fills
 * in has 1 - alpha.
 *
 * All of this leaves the framebuffer and the viewport as they were, depth test
 * and blending off, and no program in use; texture units 12 and 13, the vertex
 * array and the colour to clear with are others afterwards.
 */
#ifndef VIEW_CAPTURE_H
#define VIEW_CAPTURE_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "view/gl.h"
#include "view/settings.h"

typedef struct view_capture view_capture;

/*
 * Draws into the bound framebuffer of size x size pixels with depth, linear
 * RGBA, world to clip space by clip (column-major), from eye. The framebuffer
 * has been cleared to zeros, depth test is on and blending off. What is beyond
 * a half float is cut later.
 *   side   of paraboloids 0 (towards +Z) or 1 (-Z), and clip is what
 *          shaders/paraboloid.glsl wants; else -1
 * Front faces are counter-clockwise as everywhere. Up in the world may be down
 * in the framebuffer: a cube's rows begin at its top.
 */
typedef void view_capture_scene(void *cookie, const double clip[16],
                                const double eye[3], int size, int side);

typedef struct view_capture_options {
    view_probe_capture kind;
    int size;    /* of faces, a power of two, 16..1024; default 256. Pictures
                    of paraboloids have twice the edge, so about as many
                    pixels to an angle: a third more than six faces have. They
                    pay where what is drawn costs more than pixels do. */
    int levels;  /* 0: ibl_default_levels(size) */
    int samples; /* of each texel of a filtered level, 1..1024, default 64. Of
                    16 the error is three times as large, of 256 half as large;
                    with 1024 view_capture_create takes a second or two. */
    double near, far; /* default 0.05 and 100 */
    ibl_ctx *cpu; /* not NULL: filtered by the library in this context, as one
                     step, not on the GPU; default NULL */
    bool timed;   /* each step waits for its end, for view_capture_times;
                     default false */
} view_capture_options;

#define VIEW_CAPTURE_IRRADIANCE 32 /* edge of that cube */

view_capture_options view_capture_options_default(void);

/* NULL, with a message. */
view_capture *view_capture_create(const view_capture_options *options);
void view_capture_free(view_capture *c); /* NULL is fine */

/* Everything at once, from position, leaving off what had been begun. False,
 * with a message. */
bool view_capture_update(view_capture *c, const double position[3],
                         view_capture_scene *scene, void *cookie);
/*
 * The next `steps` of an update, of view_capture_steps(c), but none beyond its
 * end; what is shown stays the last whole one until the last step has been
 * done. True once it has. position counts at an update's first step. False
 * with a message if the library could not filter: the next is a first step.
 *
 * Steps are: six faces or two sides drawn; the levels for lookups; each face of
 * each level from 1 on; each face of the irradiance. With options.cpu, after
 * those drawn, one.
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

/* Filters on the CPU by the library what the faces of the last whole update
 * hold, in place of the GPU's levels and irradiance. False, with a message,
 * and nothing has changed. Leaves off what had been begun. */
bool view_capture_filter_cpu(view_capture *c, ibl_ctx *ctx);

/* The last whole update: cubes, RGBA16F, filtered linearly. Other ones after
 * each update: ask every time. Black before the first. */
GLuint view_capture_specular(const view_capture *c);
GLuint view_capture_irradiance(const view_capture *c); /* E / pi */
int view_capture_size(const view_capture *c);
int view_capture_levels(const view_capture *c);
/* The captured and filtered chain, RGB. cube is allocated, of that size and at
 * most as many levels; irradiance of VIEW_CAPTURE_IRRADIANCE and one level.
 * False, with a message. */
bool view_capture_read(const view_capture *c, ibl_cube *cube);
bool view_capture_read_irradiance(const view_capture *c, ibl_cube *cube);
/* Milliseconds of the last whole update's parts: drawing, levels, irradiance
 * (0 if the library made it with the levels). Without options.timed what it
 * took to ask for them. */
void view_capture_times(const view_capture *c, double ms[3]);

#endif
