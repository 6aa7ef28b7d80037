/* SPDX-License-Identifier: MIT */
/*
 * The directional albedo of sheen, the integral of D V N.L dL with Charlie's D
 * and the two V of brdf/sheen.h, by quadrature over half vectors
 * (dL = 4 V.H dH).
 *
 * N.L is above the horizon everywhere on rings of theta_h below
 * 45 degrees - theta_v / 2, nowhere above 45 degrees + theta_v / 2, and between
 * them on arcs (kern/brdf_quadrature.h). D is negligible below an angle that
 * depends on alpha. Points lie denser at the ends of the arcs and of their
 * range of theta_h, where the integrand has roots.
 */
#ifndef IBL_KERN_SHEEN_QUADRATURE_H
#define IBL_KERN_SHEEN_QUADRATURE_H

enum {
    IBL_SHEEN_INNER = 16, /* angles of full rings */
    IBL_SHEEN_OUTER = 28, /* angles of arcs */
    IBL_SHEEN_ANGLES = 16 /* points on half a ring or arc */
};

/* Points and weights on [0, 1]; outer and arc: after the change of variable. */
typedef struct ibl_sheen_rule {
    double inner_at[IBL_SHEEN_INNER], inner_weight[IBL_SHEEN_INNER];
    double outer_at[IBL_SHEEN_OUTER], outer_weight[IBL_SHEEN_OUTER];
    double arc_at[IBL_SHEEN_ANGLES], arc_weight[IBL_SHEEN_ANGLES];
} ibl_sheen_rule;

void ibl_sheen_rule_init(ibl_sheen_rule *rule);

/* The integrals for count views of one alpha: sum[2 i] with Ashikhmin's V,
 * sum[2 i + 1] with Charlie's, for n_dot_v[i] in (0, 1). alpha in (0, 1]. */
void ibl_sheen_sums(const ibl_sheen_rule *rule, double alpha,
                    const double *n_dot_v, int count, float *sum);

#endif
