/* SPDX-License-Identifier: MIT */
/*
 * The near part of a narrow lobe (brdf/lobe.h), or a lobe that is narrow as a
 * whole: integrals over the map's pixels in its reach, each a constant patch.
 *
 * By Stokes' theorem the integral over a patch is one along its edges: with
 *     H(psi) = integral of K sin(psi') from psi on,
 * and gamma the angle around R, it is
 *     2 pi H(0), if R is inside,  - closed integral of H d gamma,
 * and where two pixels meet only their difference f counts. What a texel gets
 * is so 2 pi H(0) times the pixel that it is in, plus the sum over the edges in
 * reach of their f times int H d gamma.
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
 * For one level, faces of n x n texels. shape: with a split its near part,
 * else the whole lobe; GGX or Phong. Borrows ctx.
 */
ibl_status ibl_near_create(ibl_ctx *ctx, const ibl_near_map *map,
                           const ibl_lobe_shape *shape, int n, ibl_near **out);
void ibl_near_free(ibl_near *near); /* NULL is fine */

/* The next rows from the zenith, RGB. Begins jobs of the context's pool, as
 * ibl_level0_add does. */
void ibl_near_add(ibl_near *near, int rows, const float *rgb);

/* How far from R it reaches, in radians. */
double ibl_near_reach(const ibl_near *near);
/* Integral of the part over the sphere: what a map of 1 gives. */
double ibl_near_whole(const ibl_near *near);
/* What was taken from every pixel, R, G, B. */
const float *ibl_near_base(const ibl_near *near);
/* All rows have been added: the sums of every texel, 3 numbers in the order of
 * the level. Until ibl_near_free. */
const double *ibl_near_sums(const ibl_near *near);

#endif
