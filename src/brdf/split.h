/* SPDX-License-Identifier: MIT */
/*
 * The integrand of the split-sum table (Karis 2013, "Real Shading in Unreal
 * Engine 4"). Over half vectors, dL = 4 V.H dH, and D N.H dH is the measure
 * du dphi / 2pi of ibl_ggx_sample_half, so both integrals are
 *     integral of 4 vis N.L V.H / N.H (1 - Fc or Fc) du dphi / 2pi
 * with vis = G / (4 N.L N.V).
 */
#ifndef IBL_BRDF_SPLIT_H
#define IBL_BRDF_SPLIT_H

#include "brdf/ggx.h"
#include "ibl/ibl.h"

typedef struct ibl_split_view {
    double sine, cosine; /* of the angle between N and V */
    double alpha;
    ibl_geometry geometry;
} ibl_split_view;

static inline ibl_split_view ibl_split_view_of(double n_dot_v, double alpha,
                                               ibl_geometry geometry)
{
    return (ibl_split_view){sqrt((1.0 - n_dot_v) * (1.0 + n_dot_v)), n_dot_v,
                            alpha, geometry};
}

/* Adds weight times the integrand (scale and bias) at a half vector. */
static inline void ibl_split_add(const ibl_split_view *v, double sin_h,
                                 double cos_h, double cos_phi, double weight,
                                 double sum[2])
{
    double v_dot_h = v->sine * sin_h * cos_phi + v->cosine * cos_h;
    const double n_dot_l = 2.0 * v_dot_h * cos_h - v->cosine;

    if (!(n_dot_l > 0.0))
        return;
    if (v_dot_h > 1.0)
        v_dot_h = 1.0;
    const double vis =
        v->geometry == IBL_GEOMETRY_SCHLICK_IBL
            ? ibl_schlick_visibility(n_dot_l, v->cosine, v->alpha)
            : ibl_smith_visibility(n_dot_l, v->cosine, v->alpha);
    const double g = weight * 4.0 * vis * n_dot_l * v_dot_h / cos_h;
    const double f = ibl_fresnel_weight(v_dot_h);
    sum[0] += g * (1.0 - f);
    sum[1] += g * f;
}

#endif
