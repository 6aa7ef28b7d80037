/* SPDX-License-Identifier: MIT */
/*
 * The split-sum integrals (brdf/split.h) by quadrature.
 *
 * With t the tangent of the half vector's angle, N.L = 2 V.H N.H - N.V is
 * above the horizon where
 *     cos(phi) > c0(t) = N.V (t^2 - 1) / (2 sin_v t),
 * which is everywhere for t <= t1 = tan((90 degrees - view angle) / 2) and
 * nowhere for t >= 1 / t1. The sums end on these limits and never cross them:
 * an inner part over full rings, an outer part over arcs |phi| < acos(c0).
 *
 * The radius is t = alpha sinh(y), so u = tanh(y)^2: of unit scale at the
 * peak of the lobe and logarithmic along its tail, which makes the integrand
 * smooth on the scale of y for every alpha and view. Gauss-Legendre points in
 * y and on the arcs, equal steps on the rings.
 */
#ifndef IBL_KERN_BRDF_QUADRATURE_H
#define IBL_KERN_BRDF_QUADRATURE_H

#include <stddef.h>

#include "brdf/split.h"
#include "kern/isa.h"

enum {
    IBL_BRDF_INNER = 14, /* radii of full rings */
    IBL_BRDF_OUTER = 20, /* radii of arcs */
    IBL_BRDF_ANGLES = 10 /* points on half a ring or arc */
};

/* Points and weights on [0, 1]; for rings cos(phi). */
typedef struct ibl_brdf_rule {
    double inner_at[IBL_BRDF_INNER], inner_weight[IBL_BRDF_INNER];
    double outer_at[IBL_BRDF_OUTER], outer_weight[IBL_BRDF_OUTER];
    double arc_at[IBL_BRDF_ANGLES], arc_weight[IBL_BRDF_ANGLES];
    double ring[IBL_BRDF_ANGLES];
} ibl_brdf_rule;

/* Gauss-Legendre on [0, 1]: n points and their weights. */
void ibl_gauss_points(int n, double *at, double *weight);

void ibl_brdf_rule_init(ibl_brdf_rule *rule);

/* The y where the outer part begins, and where it ends. */
typedef struct ibl_brdf_limits {
    double inner, outer;
} ibl_brdf_limits;

ibl_brdf_limits ibl_brdf_limits_of(const ibl_split_view *view);

typedef struct ibl_brdf_dsp {
    /*
     * The integrals for count views of one alpha: sum[2 i] is the scale and
     * sum[2 i + 1] the bias for n_dot_v[i] in (0, 1). alpha in (0, 1].
     */
    void (*sums)(const ibl_brdf_rule *rule, ibl_geometry geometry, double alpha,
                 const double *n_dot_v, int count, float *sum);
    /*
     * out[i] = sum over k < terms of table[k stride + i] pair[2 k + i % 2], for
     * i < count. count is even.
     */
    void (*mix)(const float *table, size_t stride, const float *pair, int terms,
                int count, float *out);
} ibl_brdf_dsp;

IBL_DECLARE_KERNEL(ibl_brdf);

#endif
