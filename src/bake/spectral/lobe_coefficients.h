/* SPDX-License-Identifier: MIT */
/*
 * Lobes as factors of spherical harmonics: convolving with a lobe K, a
 * function of the angle alone whose integral over the sphere is 1, multiplies
 * every coefficient of degree l by
 *     k_l = 2 pi int_-1^1 K(c) P_l(c) dc,
 * P_l Legendre's polynomials; k_0 = 1 (Funk and Hecke's theorem). A point
 * light's response, K itself, has sum (2 l + 1) k_l^2 = 4 pi int K^2 dO.
 */
#ifndef IBL_BAKE_SPECTRAL_LOBE_COEFFICIENTS_H
#define IBL_BAKE_SPECTRAL_LOBE_COEFFICIENTS_H

#include "brdf/lobe.h"

/*
 * k[0..degree] of a lobe, or of its far part (brdf/lobe.h), 0 < alpha <= 1, to
 * about 1e-14, by quadrature at about 0.9 degree + 64 points: some tens of
 * microseconds at degree 512, and as the square.
 */
ibl_status ibl_lobe_coefficients(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                                 int degree, double *k);

/*
 * The smallest degree that keeps all but `tail` of a point light's response:
 * sqrt(sum over l > *degree of (2 l + 1) k_l^2 / the whole sum) < tail, the
 * relative rms error of what is cut off; limit, if that is less.
 * The corner that most lobes have on the horizon leaves k_l a power of l,
 * l^(-5/2) where the slope jumps; once that is seen the degree is worked out,
 * within some percent, not searched for.
 *   tail   1e-12..1
 */
ibl_status ibl_lobe_degree(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                           double tail, int limit, int *degree);

#endif
