/* SPDX-License-Identifier: MIT */
/* The faces of a cube: directions of texels, and the unfolded cube. */
#ifndef CLI_FACES_H
#define CLI_FACES_H

#include <stdbool.h>

#include <ibl/ibl.h>
#include <ibl/reference.h>

/* Direction of point (u, v) of a face, not normalised. u and v are -1..1 on the
 * face and may lie beyond its edges. */
void ibl_face_direction(int face, double u, double v, double dir[3]);

/* The face that a direction hits, and where on it: u and v are -1..1. */
int ibl_face_point(const double dir[3], double *u, double *v);

/* The texel that a direction hits in a cube with faces of `size` texels. */
ibl_texel ibl_face_texel(int size, const double dir[3]);

/* The texel at an offset of dx, dy, also across edges. False: none exists. */
bool ibl_face_neighbour(int size, ibl_texel at, int dx, int dy, ibl_texel *to);

/* The same three of a level of any shape. */
ibl_texel ibl_level_hit(const ibl_level_shape *shape, const double dir[3]);
bool ibl_level_neighbour(const ibl_level_shape *shape, ibl_texel at, int dx,
                         int dy, ibl_texel *to);
static inline float *ibl_level_at(float *texels, const ibl_level_shape *shape,
                                  ibl_texel at)
{
    const size_t line = (size_t)at.face * (size_t)shape->height + (size_t)at.y;
    return texels + 3 * (line * (size_t)shape->width + (size_t)at.x);
}

/* A texel of a level whose faces of `size` are stored one after the other. */
static inline float *ibl_face_at(float *faces, int size, ibl_texel at)
{
    const size_t n = (size_t)size;
    return faces +
           3 * (((size_t)at.face * n + (size_t)at.y) * n + (size_t)at.x);
}

/* The mean of pixels x0..x1 - 1 by y0..y1 - 1, at least one, of an RGB image or
 * a face. */
void ibl_mean_rgb(const float *image, int width, int x0, int x1, int y0, int y1,
                  double rgb[3]);

/*
 * An unfolded cube is a cross of 4 by 3 faces, +Y on top, -X +Z +X -Z in the
 * middle row, -Y below, so that neighbours in the cross are neighbours on the
 * cube. These are the column and row of each face.
 */
enum {
    IBL_CROSS_COLUMNS = 4,
    IBL_CROSS_ROWS = 3
};
extern const int ibl_cross_place[IBL_FACES][2];

#endif
