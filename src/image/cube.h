/* SPDX-License-Identifier: MIT */
/* The cube convention of ibl/ibl.h, as data: it stands nowhere else. */
#ifndef IBL_IMAGE_CUBE_H
#define IBL_IMAGE_CUBE_H

#include <stddef.h>

#include "ibl/ibl.h"

/* A point (u, v) of a face, both in -1..1, looks along
 * forward + u right + v down. Every component is -1, 0 or 1. */
typedef struct ibl_face_axes {
    signed char forward[3], right[3], down[3];
} ibl_face_axes;

extern const ibl_face_axes ibl_face[IBL_FACES];

/* Solid angle of the rectangle from the face's centre to (u, v), with the sign
 * of u v: four of them give that of any rectangle. */
double ibl_face_angle(double u, double v);

/* Texels are numbered (face n + y) n + x. That beside a face, of (x, y), one of
 * which is -1 or n. */
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
 * its edge: the even ones begin at +X, +Z, -X and -Z and go on towards the next
 * of them, odd ones go backwards to where these end. Lines count from the pole
 * on top and bottom, on the side from its upper edge; z from the middle.
 */
ibl_octant_place ibl_octant_place_of(const ibl_cube *cube, int k,
                                     ibl_octant_face face);

/* Levels of a whole chain, down to 1x1: floor(log2(size)) + 1; 1 for sizes
 * below. */
int ibl_cube_most_levels(int size);

/* Whether there is a context and a cube that a caller filled in, with data, a
 * size and levels in range: IBL_ERR_ARGUMENT. */
ibl_status ibl_check_cube(ibl_ctx *ctx, const ibl_cube *cube);

#endif
