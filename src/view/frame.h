/* SPDX-License-Identifier: MIT */
/* Uniform block "Frame", std140; shaders/frame.glsl has the same members. */
#ifndef VIEW_FRAME_H
#define VIEW_FRAME_H

#include <stddef.h>

#include "view/baked_set.h"
#include "view/sphere_grid.h"

/* What is behind everything. */
enum view_backdrop {
    VIEW_BACKDROP_NONE,
    VIEW_BACKDROP_CUBE, /* the skybox or level 0 */
    VIEW_BACKDROP_MAP   /* the map of the set, which the renderer finds */
};

typedef struct view_frame {
    float clip[16]; /* world to clip space, column-major */
    float eye[4];
    float right[4], up[4], forward[4]; /* of view_camera */
    float viewport[4];                 /* width, height, 1/width, 1/height */
    float turn[4];    /* cosine and sine of settings.turn, view_widening,
                         width of a place in pixels */
    float lod[4];     /* scale, offset, last level, mapping (baked_set) */
    float diffuse[4]; /* scale of the irradiance map, geometry of the table
                         (ibl_geometry), yaw of the map in turns,
                         settings.blur */
    float sh[25][4];  /* RGB of each (l, m), E/pi; zeros beyond sh_degree */
    float disc_direction[IBL_MAX_LIGHTS][4]; /* of the set's lights, in the
                                                environment; their radius */
    float disc_irradiance[IBL_MAX_LIGHTS][4];
    float light_position[4][4];  /* world, 1 */
    float light_intensity[4][4]; /* RGB, 0 */
    int shading[4]; /* multiscatter, lights, view_backdrop, 1 if the sky texture
                       has filterable levels, else 0 */
    int choice[4];  /* mode, diffuse, layout, level */
    int reflection[4];   /* view_reflection; that of the other picture; number
                            of discs; number that the sky lacks */
    float inspect_at[4]; /* zoom, pan x, pan y, rows of the grid */
    float display[4];    /* 2^ev, split, gain, 1 if the reference has
                            the map's texture, else 0 */
    int show[4];         /* tone, below 0: linear values; false_colour;
                            compare; columns of the grid, 0: no grid is split */
    int sampling[4];     /* of the reference (truth.h): first sample, number;
                            cells of view_aim along an edge, 0: no table; discs
                            that its environment lacks */
} view_frame;

/* Number of leading bytes that the reference depends on, and the linear
 * picture. */
enum {
    VIEW_FRAME_REFERENCE = offsetof(view_frame, choice),
    VIEW_FRAME_LINEAR = offsetof(view_frame, display)
};

void view_frame_fill(view_frame *f, const view_settings *s,
                     const baked_set *set, int width, int height);

#endif
