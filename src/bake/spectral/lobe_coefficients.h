/* SPDX-License-Identifier: MIT */
/*
 * Lobes as factors of spherical harmonics: convolving with a lobe K, a function
 * of only the angle whose integral over the sphere is 1, multiplies every
 * coefficient of degree l by
 *     k_l = 2 pi int_-1^1 K(c) P_l(c) dc,
 * P_l Legendre's polynomials; k_0 = 1 (Funk and Hecke's theorem). The response
 * to a point light, K itself, has sum (2 l + 1) k_l^2 = 4 pi int K^2 dO.
 */
#ifndef IBL_BAKE_SPECTRAL_LOBE_COEFFICIENTS_H
#define IBL_BAKE_SPECTRAL_LOBE_COEFFICIENTS_H

#include "brdf/lobe.h"

/*
 * Computes k[0..degree] of a lobe, to about 1e-14; 0 < alpha <= 1. The
 * quadrature has about 0.9 degree + 64 points. Takes some tens of microseconds
 * at degree 512, and grows as the square.
 */
ibl_status ibl_lobe_coefficients(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                                 int degree, double *k);

/*
 * Finds the smallest degree, or limit if that is less, with
 *     sqrt(sum over l > *degree of (2 l + 1) k_l^2 / the whole sum) < tail,
 * the relative rms error of truncating the response to a point light. Most
 * lobes have a corner on the horizon, and k_l becomes a power of l, l^(-5/2)
 * where the slope jumps. Once it does, the degree is extrapolated, within a few
 * percent.
 *   tail   1e-12..1
 */
ibl_status ibl_lobe_degree(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                           double tail, int limit, int *degree);

#endif
