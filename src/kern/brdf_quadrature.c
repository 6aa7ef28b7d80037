/* SPDX-License-Identifier: MIT */
#include "kern/brdf_quadrature.h"

/* The tail beyond y has e^-2y of the lobe: 3e-7 in the inner part, where the
 * integrand is bounded; in the outer part it may grow like 1 / N.H. */
static const double inner_end = 7.5, outer_end = 30.0;

/* Newton's method on the Legendre polynomial. */
void ibl_gauss_points(int n, double *at, double *weight)
{
    for (int i = 0; i < n; i++) {
        double x = cos(IBL_PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
        for (int step = 0; step < 8; step++) {
            double p = 1.0, before = 0.0;
            for (int k = 1; k <= n; k++) {
                const double next =
                    ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k;
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        at[i] = 0.5 * (1.0 - x);
        weight[i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
}

void ibl_brdf_rule_init(ibl_brdf_rule *rule)
{
    ibl_gauss_points(IBL_BRDF_INNER, rule->inner_at, rule->inner_weight);
    ibl_gauss_points(IBL_BRDF_OUTER, rule->outer_at, rule->outer_weight);
    ibl_gauss_points(IBL_BRDF_ANGLES, rule->arc_at, rule->arc_weight);
    for (int k = 0; k < IBL_BRDF_ANGLES; k++)
        rule->ring[k] = cos(IBL_PI * (k + 0.5) / IBL_BRDF_ANGLES);
}

ibl_brdf_limits ibl_brdf_limits_of(const ibl_split_view *v)
{
    const double t1 = v->cosine / (1.0 + v->sine);
    const double inner = fmin(asinh(t1 / v->alpha), inner_end);
    const double outer = fmin(asinh(1.0 / (t1 * v->alpha)), outer_end);

    return (ibl_brdf_limits){inner, fmax(inner, outer)};
}
