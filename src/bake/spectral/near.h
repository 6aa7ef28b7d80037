/* SPDX-License-Identifier: MIT */
/*
 * The near part of a narrow lobe (brdf/lobe.h), or a whole lobe if it is
 * narrow: integrals over the map's pixels in its reach, as constant patches.
 *
 * By Stokes' theorem the integral over a patch is one along its edges. With
 *     H(psi) = integral of K sin(psi') from psi on,
 * and gamma the angle around R, it is
 *     2 pi H(0), if R is inside,  - closed integral of H d gamma.
 * Where two pixels meet, only their difference f counts. So a texel gets 2 pi
 * H(0) times the pixel that it is in, plus the sum over the edges in reach of f
 * times int H d gamma.
 */
#ifndef IBL_BAKE_SPECTRAL_NEAR_H
#define IBL_BAKE_SPECTRAL_NEAR_H

#include "brdf/lobe.h"
#include "ibl/ibl.h"

typedef struct ibl_near ibl_near;

typedef struct ibl_near_map {
    int width, height;
    double yaw; /* radians */
} ibl_near_map;

/*
 * For the texels of a level. shape: of the lobe, its near part if split > 0,
 * else the whole lobe; GGX or Phong. Borrows ctx.
 */
ibl_status ibl_near_create(ibl_ctx *ctx, const ibl_near_map *map,
                           const ibl_lobe_shape *shape,
                           const ibl_level_shape *level, ibl_near **out);
void ibl_near_free(ibl_near *near); /* NULL is fine */

/* Adds the next rows from the zenith, RGB. Starts jobs on the context's pool,
 * as ibl_level0_add does. */
void ibl_near_add(ibl_near *near, int rows, const float *rgb);

/* Reach from R, in radians. */
double ibl_near_reach(const ibl_near *near);
/* Integral of the part over the sphere: the result for a map of 1. */
double ibl_near_whole(const ibl_near *near);
/* Sums of every texel, 3 numbers each in the order of the level, after all rows
 * were added. Valid until ibl_near_free. */
const double *ibl_near_sums(const ibl_near *near);

#endif
