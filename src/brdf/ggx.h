/* SPDX-License-Identifier: MIT */
/*
 * The GGX microfacet terms, each formula once. Cosines are taken as given in
 * [0, 1]; alpha is the GGX width, roughness squared.
 *
 * Walter et al. 2007, "Microfacet Models for Refraction through Rough
 * Surfaces"; Heitz 2014, "Understanding the Masking-Shadowing Function";
 * Karis 2013, "Real Shading in Unreal Engine 4".
 */
#ifndef IBL_BRDF_GGX_H
#define IBL_BRDF_GGX_H

#include <math.h>

#include "core/pi.h"

/* Distribution of normals (Walter eq. 33). t = sin^2 + alpha^2 cos^2 of the
 * half vector's angle: 1 - cos^2 loses its digits near the peak of a narrow
 * lobe. */
static inline double ibl_ggx_d(double t, double alpha)
{
    /* alpha / t first: alpha^2 may underflow. */
    return (alpha / t) * (alpha / t) / IBL_PI;
}

/*
 * Visibility G / (4 N.L N.V), Smith's G, height-correlated (Heitz eq. 99).
 * Finite unless alpha = 0 and a cosine is 0.
 */
static inline double ibl_smith_visibility(double n_dot_l, double n_dot_v,
                                          double alpha)
{
    double a2 = alpha * alpha;
    double l = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    double v = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);

    return 0.5 / (l + v);
}

/* Visibility with Schlick's G for image-based light, k = roughness^2 / 2
 * (Karis). Finite unless alpha = 0 and a cosine is 0. */
static inline double ibl_schlick_visibility(double n_dot_l, double n_dot_v,
                                            double alpha)
{
    double k = 0.5 * alpha;
    double l = n_dot_l * (1.0 - k) + k;
    double v = n_dot_v * (1.0 - k) + k;

    return 0.25 / (l * v);
}

/* Schlick's Fresnel weight (1 - V.H)^5: F = F0 + (1 - F0) weight. */
static inline double ibl_fresnel_weight(double v_dot_h)
{
    double f = 1.0 - v_dot_h;

    return f * f * (f * f) * f;
}

/*
 * Sine and cosine of the angle of a half vector drawn with density D cos_h
 * (Walter eq. 35). u in [0, 1]: the density falls as u grows, u = 1 is the
 * horizon. No cancellation at either end. alpha = 0: the normal.
 */
static inline void ibl_ggx_sample_half(double u, double alpha, double *sin_h,
                                       double *cos_h)
{
    double s2 = alpha * alpha * u;
    double c2 = 1.0 - u;

    if (s2 <= 0.0) {
        *sin_h = 0.0;
        *cos_h = 1.0;
        return;
    }
    *sin_h = sqrt(s2 / (s2 + c2));
    *cos_h = sqrt(c2 / (s2 + c2));
}

#endif
