/* SPDX-License-Identifier: MIT */
/* Inverse of ibl_cube_direction. */
#ifndef VIEW_CUBE_H
#define VIEW_CUBE_H

/* Face, and texel of edge x edge, that a direction of any length points to. */
void view_cube_texel(const double d[3], int edge, int *face, int *x, int *y);

#endif
