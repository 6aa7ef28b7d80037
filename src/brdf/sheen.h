/* SPDX-License-Identifier: MIT */
/*
 * The visibility terms V = G / (4 N.L N.V) of sheen, whose distribution of
 * normals is Charlie's: D = (2 + 1/alpha) sin(theta_h)^(1/alpha) / 2pi.
 *
 * Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF";
 * Neubelt and Pettineo 2013, "Crafting a Next-gen Material Pipeline for The
 * Order: 1886" (after Ashikhmin).
 */
#ifndef IBL_BRDF_SHEEN_H
#define IBL_BRDF_SHEEN_H

#include <math.h>

/* Ashikhmin's, simplified; the same for every alpha. */
static inline double ibl_ashikhmin_visibility(double n_dot_l, double n_dot_v)
{
    return 0.25 / (n_dot_l + n_dot_v - n_dot_l * n_dot_v);
}

/* Fitted to Smith's integral for cosines of 0..0.5 (Estevez and Kulla, table
 * 1), between the values at alpha = 1 and alpha = 0. */
static inline double ibl_charlie_fit(double cosine, double alpha)
{
    const double t = (1.0 - alpha) * (1.0 - alpha);
    const double a = 21.5473 + t * (25.3245 - 21.5473);
    const double b = 3.82987 + t * (3.32435 - 3.82987);
    const double c = 0.19823 + t * (0.16801 - 0.19823);
    const double d = -1.97760 + t * (-1.27393 + 1.97760);
    const double e = -4.32054 + t * (-4.85967 + 4.32054);

    return a / (1.0 + b * pow(cosine, c)) + d * cosine + e;
}

/* Smith's Lambda of Charlie's distribution. */
static inline double ibl_charlie_lambda(double cosine, double alpha)
{
    return exp(cosine < 0.5 ? ibl_charlie_fit(cosine, alpha)
                            : 2.0 * ibl_charlie_fit(0.5, alpha) -
                                  ibl_charlie_fit(1.0 - cosine, alpha));
}

#endif
