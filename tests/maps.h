/* SPDX-License-Identifier: MIT */
/* Maps for the tests of hard cases and properties, and what cubes of them are
 * compared by. Everything that cannot go on exits. Maps and cubes are freed
 * after the running test. */
#ifndef MAPS_H
#define MAPS_H

#include "test.h"

/* A map of one value. */
ibl_image map_constant(ibl_ctx *ctx, int width, int height, float value);
/* Sets R G B of a pixel. */
void map_set(const ibl_image *map, int x, int y, float r, float g, float b);
float *map_pixel(const ibl_image *map, int x, int y);
/* Random values in 0..1, most of them small. */
void map_fill(const ibl_image *map, uint64_t seed);
/* Pixel x is the old x + columns (wrapped), or, mirrored, width - 1 - x. */
ibl_image map_turned(ibl_ctx *ctx, const ibl_image *map, int columns);
ibl_image map_mirrored(ibl_ctx *ctx, const ibl_image *map);
/* Every value times factor. */
ibl_image map_scaled(ibl_ctx *ctx, const ibl_image *map, float factor);
size_t map_floats(const ibl_image *map);
/* To the bit; not if one has no pixels. */
bool map_same(const ibl_image *a, const ibl_image *b);
/* Smallest and largest value of a channel. */
void map_range(const ibl_image *map, int channel, double *low, double *high);

/* Kinds of random maps. */
typedef enum map_kind {
    MAP_NOISE,        /* uniform in 0..1 */
    MAP_DECADES,      /* log-uniform over 16 decades */
    MAP_SUNS,         /* up to 4 pixels of up to 1e6 on black */
    MAP_SUNNY,        /* the same on a sky of noise */
    MAP_SMOOTH,       /* a few broad lobes */
    MAP_BLACK_ROWS,   /* noise with rows and columns of 0 */
    MAP_DENORMAL,     /* denormal floats */
    MAP_CHECKERBOARD, /* 0 and 1 by pixel */
    MAP_DENORMAL_HALVES,
    MAP_KINDS
} map_kind;

ibl_image map_of_kind(ibl_ctx *ctx, test_random *r, map_kind kind, int width,
                      int height);

/* Not initialized. */
ibl_cube cube_alloc(ibl_ctx *ctx, int n, int levels);
/* The bakes. */
ibl_cube cube_level0(ibl_ctx *ctx, const ibl_image *map, double yaw, int n);
ibl_bake_result map_bake(ibl_ctx *ctx, const ibl_image *map,
                         const ibl_bake_options *options);

/* Mean of a level's channel by the texels' exact solid angles. */
double cube_mean(const ibl_cube *cube, int level, int channel);
size_t cube_floats(const ibl_cube *cube);

/* sqrt(sum |a - b|^2 / sum b^2) over all channels of the texels of a level. */
double cube_nrmse(const ibl_cube *a, const ibl_cube *b, int level);

#endif
