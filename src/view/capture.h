/* SPDX-License-Identifier: MIT */
/*
 * Cubes that are captured and filtered here, on the GPU: six faces (or two
 * paraboloids) of something that draws, then the levels of roughness and the
 * irradiance by the formulas of the bake (ibl/ibl.h: GGX with N = V = R,
 * Hammersley points, mip by pdf), a face at a time if it is to be spread over
 * frames. Or filtered by the library on the CPU from what is read back.
 */
#ifndef VIEW_CAPTURE_H
#define VIEW_CAPTURE_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "view/gl.h"

typedef struct view_capture view_capture;

typedef enum view_capture_kind {
    VIEW_CAPTURE_FACES,
    VIEW_CAPTURE_PARABOLOIDS
} view_capture_kind;

/* Draws into the bound framebuffer of size x size pixels with depth, linear
 * RGBA, world to clip space by clip (column-major), from eye. For paraboloids
 * side is 0 (towards +Z) or 1, and clip takes world to the space of the
 * paraboloid before its projection; else side is -1. */
typedef void view_capture_scene(void *cookie, const double clip[16],
                                const double eye[3], int size, int side);

typedef struct view_capture_options {
    view_capture_kind kind;
    int size;    /* of faces, 16..1024; default 256 */
    int levels;  /* ibl_default_levels(size) */
    int samples; /* of each texel of a filtered level, default 64 */
    double near, far;
} view_capture_options;

view_capture_options view_capture_options_default(void);

/* NULL, with a message. */
view_capture *view_capture_create(const view_capture_options *options);
void view_capture_free(view_capture *c); /* NULL is fine */

/* Everything at once, from position. False, with a message. */
bool view_capture_update(view_capture *c, const double position[3],
                         view_capture_scene *scene, void *cookie);
/* The next `steps` of an update, of view_capture_steps(c); what is shown stays
 * the last whole one until the last step has been done. True once it has. */
bool view_capture_advance(view_capture *c, const double position[3],
                          view_capture_scene *scene, void *cookie, int steps);
int view_capture_steps(const view_capture *c);

/* Filters on the CPU by the library what the faces hold, in place of the GPU's
 * levels and irradiance. */
bool view_capture_filter_cpu(view_capture *c, ibl_ctx *ctx);

/* The last whole update: cubes, RGBA16F. */
GLuint view_capture_specular(const view_capture *c);
GLuint view_capture_irradiance(const view_capture *c); /* E / pi */
/* Level of the captured or filtered chain, 3 floats a texel. */
bool view_capture_read(const view_capture *c, ibl_cube *cube);
bool view_capture_read_irradiance(const view_capture *c, ibl_cube *cube);
/* Milliseconds of the last update's parts: drawing, levels, irradiance. */
void view_capture_times(const view_capture *c, double ms[3]);

#endif
