/* SPDX-License-Identifier: MIT */
/* A captured cube as what the bakes take: an equirectangular map. */
#ifndef CLI_CUBE_MAP_H
#define CLI_CUBE_MAP_H

#include <stdbool.h>

#include <ibl/ibl.h>

/* Width of the map of a cube with faces of size n; it is half as high. */
int ibl_cube_map_width(int n);

/*
 * Fills map (allocated, any size) from level 0 of cube: each pixel is the mean
 * over its solid angle of the texels as constant patches, so that the map is
 * the same light: a constant stays that, nothing leaves the range of the cube,
 * and a texel's energy arrives. Meridians are integrated exactly in the sine of
 * the latitude, and lie between the edges of pixels and of the columns of
 * texels of the four upright faces, SUBDIVISIONS in each interval. False: no
 * memory.
 */
bool ibl_cube_map_fill(const ibl_cube *cube, ibl_image *map);

#endif
