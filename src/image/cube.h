/* SPDX-License-Identifier: MIT */
/* The cube convention of ibl/ibl.h as data; defined only here. */
#ifndef IBL_IMAGE_CUBE_H
#define IBL_IMAGE_CUBE_H

#include <stddef.h>

#include "ibl/ibl.h"

/* Point (u, v) of a face, both in -1..1, has the direction forward + u right +
 * v down. Every component is -1, 0 or 1. */
typedef struct ibl_face_axes {
    signed char forward[3], right[3], down[3];
} ibl_face_axes;

extern const ibl_face_axes ibl_face[IBL_FACES];

/* Solid angle of the rectangle from the face's centre to (u, v), with the sign
 * of u v. Four of them with signs give any rectangle. */
double ibl_face_angle(double u, double v);

/* The texel with its centre at d, in half texels from the cube's middle: one
 * component is n or -n, the others are smaller. Numbered as below. */
size_t ibl_cube_texel_at(int n, const int d[3]);

/* The texel beyond an edge of a face, at (x, y), where one of x and y is -1 or
 * n. Texels are numbered (face n + y) n + x. */
size_t ibl_cube_neighbour(int n, int face, int x, int y);

typedef enum ibl_octant_face {
    IBL_OCTANT_TOP,
    IBL_OCTANT_SIDE,
    IBL_OCTANT_BOTTOM
} ibl_octant_face;

/* Texel z of a line i is at base + i * line + z * step. */
typedef struct ibl_octant_place {
    float *base;
    ptrdiff_t line, step;
} ibl_octant_place;

/*
 * Level 0 in octant k = 0..7 of the horizon, from the middle of a side face to
 * its edge. Even octants begin at +X, +Z, -X and -Z and run towards the next of
 * these. The odd octant after each begins at that next axis and runs back to
 * the same edge. Lines count from the pole on top and bottom, from the upper
 * edge on the side; z counts from the middle.
 */
ibl_octant_place ibl_octant_place_of(const ibl_cube *cube, int k,
                                     ibl_octant_face face);

/* Levels of a full chain down to 1x1: floor(log2(size)) + 1; 1 for size < 1. */
int ibl_cube_most_levels(int size);

/* Checks that there is a context and a valid cube, with data, and size and
 * levels in range. Else IBL_ERR_ARGUMENT. */
ibl_status ibl_check_cube(ibl_ctx *ctx, const ibl_cube *cube);
/* The same for any projection. */
ibl_status ibl_check_map(ibl_ctx *ctx, const ibl_cube *map);

/* Texels of a level, and of the first levels of a map. */
static inline size_t ibl_level_texels(const ibl_level_shape *s)
{
    return (size_t)s->faces * (size_t)s->width * (size_t)s->height;
}
size_t ibl_map_texels(ibl_projection projection, int size, int levels);

/* Shape of a level of a map. */
static inline ibl_level_shape ibl_map_shape(const ibl_cube *map, int level)
{
    return ibl_level_shape_of(map->projection, ibl_cube_edge(map->size, level));
}

/* A flat level's texel beyond an edge, at (x, y), each -1 or within or one too
 * large: the one that meets there on the sphere, as y width + x. */
size_t ibl_flat_neighbour(const ibl_level_shape *shape, int x, int y);

#endif
