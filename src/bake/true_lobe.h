/* SPDX-License-Identifier: MIT */
/*
 * The lobe that a surface reflects: f(V, L) N.L with GGX, height-correlated
 * Smith and Schlick's Fresnel, as points with weights.
 *
 * Axes: N is +Z, the mirror direction R of V is (sin, 0, cos) of the angle
 * between N and V. The lobe is symmetric in y, and only its half y > 0 has
 * points.
 *
 * The points are those of kern/brdf_quadrature.h, which end on the horizon,
 * with fewer radii: moments of the lobe are right to 1e-3 at N.V = .02, to 1e-4
 * from .1 on.
 */
#ifndef IBL_BAKE_TRUE_LOBE_H
#define IBL_BAKE_TRUE_LOBE_H

enum {
    IBL_TRUE_LOBE_RADII = 10, /* of full rings, and of arcs */
    IBL_TRUE_LOBE_ANGLES = 8, /* on half a ring or arc */
    IBL_TRUE_LOBE_POINTS = 2 * IBL_TRUE_LOBE_RADII * IBL_TRUE_LOBE_ANGLES
};

/* Points and weights on 0..1. */
typedef struct ibl_true_lobe_rule {
    double at[IBL_TRUE_LOBE_RADII], weight[IBL_TRUE_LOBE_RADII];
    double arc[IBL_TRUE_LOBE_ANGLES], arc_weight[IBL_TRUE_LOBE_ANGLES];
} ibl_true_lobe_rule;

/* Unit directions L, and their shares of the lobe for F0 = 1 and for F0 = .04:
 * each sums to 1. */
typedef struct ibl_true_lobe {
    int count; /* IBL_TRUE_LOBE_POINTS, or half of them */
    float x[IBL_TRUE_LOBE_POINTS], y[IBL_TRUE_LOBE_POINTS];
    float z[IBL_TRUE_LOBE_POINTS];
    float share[2][IBL_TRUE_LOBE_POINTS];
} ibl_true_lobe;

void ibl_true_lobe_rule_init(ibl_true_lobe_rule *rule);

/* n_dot_v in (0, 1), alpha in (0, 1]. */
void ibl_true_lobe_make(const ibl_true_lobe_rule *rule, double n_dot_v,
                        double alpha, ibl_true_lobe *lobe);

#endif
