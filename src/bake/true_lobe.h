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
 * with fewer radii, shared by rings and arcs in proportion to their lengths.
 * Lobes of half the width to twice that are seen right to 1e-3 from r = .3 on,
 * and to 2e-2 at r = .1 and grazing angles.
 */
#ifndef IBL_BAKE_TRUE_LOBE_H
#define IBL_BAKE_TRUE_LOBE_H

#define IBL_DIELECTRIC_F0 0.04

enum {
    IBL_TRUE_LOBE_RADII = 20,
    IBL_TRUE_LOBE_LEAST = 4, /* radii of full rings, and of arcs, at least */
    IBL_TRUE_LOBE_MOST = IBL_TRUE_LOBE_RADII - IBL_TRUE_LOBE_LEAST,
    IBL_TRUE_LOBE_ANGLES = 8, /* on half a ring or arc */
    IBL_TRUE_LOBE_POINTS = IBL_TRUE_LOBE_RADII * IBL_TRUE_LOBE_ANGLES
};

/* Points and weights on 0..1: rule n has n points. */
typedef struct ibl_true_lobe_rule {
    double at[IBL_TRUE_LOBE_MOST + 1][IBL_TRUE_LOBE_MOST];
    double weight[IBL_TRUE_LOBE_MOST + 1][IBL_TRUE_LOBE_MOST];
    double cosine[IBL_TRUE_LOBE_ANGLES]; /* of the points on half a ring */
    double sine[IBL_TRUE_LOBE_ANGLES];
} ibl_true_lobe_rule;

/* Unit directions L, and their shares of the lobe for F0 = 1 and for F0 = .04:
 * each sums to 1. */
typedef struct ibl_true_lobe {
    int count;
    float x[IBL_TRUE_LOBE_POINTS], y[IBL_TRUE_LOBE_POINTS];
    float z[IBL_TRUE_LOBE_POINTS];
    float share[2][IBL_TRUE_LOBE_POINTS];
} ibl_true_lobe;

void ibl_true_lobe_rule_init(ibl_true_lobe_rule *rule);

/* n_dot_v in (0, 1), alpha in (0, 1]. */
void ibl_true_lobe_make(const ibl_true_lobe_rule *rule, double n_dot_v,
                        double alpha, ibl_true_lobe *lobe);

#endif
