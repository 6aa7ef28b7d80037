/* SPDX-License-Identifier: MIT */
/* The cube convention of ibl/ibl.h, as data: it stands nowhere else. */
#ifndef IBL_IMAGE_CUBE_H
#define IBL_IMAGE_CUBE_H

#include "ibl/ibl.h"

/* A point (u, v) of a face, both in -1..1, looks along
 * forward + u right + v down. Every component is -1, 0 or 1. */
typedef struct ibl_face_axes {
    signed char forward[3], right[3], down[3];
} ibl_face_axes;

extern const ibl_face_axes ibl_face[IBL_FACES];

/* Component of d along one of them. */
static inline double ibl_face_along(const signed char axis[3],
                                    const double d[3])
{
    return axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2];
}

/* Solid angle of the rectangle from the face's centre to (u, v), with the sign
 * of u v: four of them give that of any rectangle. */
double ibl_face_angle(double u, double v);

/* Levels of a whole chain, down to 1x1: floor(log2(size)) + 1; 1 for sizes
 * below. */
int ibl_cube_most_levels(int size);

/* Whether there is a context and a cube that a caller filled in, with data, a
 * size and levels in range: IBL_ERR_ARGUMENT. */
ibl_status ibl_check_cube(ibl_ctx *ctx, const ibl_cube *cube);

#endif
