/* SPDX-License-Identifier: MIT */
#include "kern/brdf_quadrature.h"

#include <math.h>

#include "brdf/sheen.h"
#include "core/pi.h"
#include "kern/sheen_quadrature.h"

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

/* ---- sheen -------------------------------------------------------------- */

typedef struct view {
    double alpha, cosine, sine; /* of the angle between N and V */
    double lambda;
} view;

void ibl_sheen_rule_init(ibl_sheen_rule *r)
{
    ibl_gauss_points(IBL_SHEEN_INNER, r->inner_at, r->inner_weight);
    ibl_gauss_points(IBL_SHEEN_OUTER, r->outer_at, r->outer_weight);
    ibl_gauss_points(IBL_SHEEN_ANGLES, r->arc_at, r->arc_weight);
    for (int k = 0; k < IBL_SHEEN_OUTER; k++) {
        const double angle = IBL_PI * r->outer_at[k];
        r->outer_at[k] = 0.5 - 0.5 * cos(angle);
        r->outer_weight[k] *= 0.5 * IBL_PI * sin(angle);
    }
    for (int k = 0; k < IBL_SHEEN_ANGLES; k++) {
        const double angle = 0.5 * IBL_PI * r->arc_at[k];
        r->arc_at[k] = sin(angle);
        r->arc_weight[k] *= 0.5 * IBL_PI * cos(angle);
    }
}

/* Adds the ring or arc |phi| < half at theta_h, which stands for a width of
 * weight. */
static void add_arc(const ibl_sheen_rule *r, const view *v, double theta,
                    double half, double weight, double sum[2])
{
    const double sin_h = sin(theta), cos_h = cos(theta);
    const double d =
        (2.0 + 1.0 / v->alpha) / (2.0 * IBL_PI) * pow(sin_h, 1.0 / v->alpha);
    const double w = weight * 2.0 * half * d * sin_h;

    for (int k = 0; k < IBL_SHEEN_ANGLES; k++) {
        const double v_dot_h =
            v->cosine * cos_h + v->sine * sin_h * cos(half * r->arc_at[k]);
        const double n_dot_l = 2.0 * v_dot_h * cos_h - v->cosine;
        const double g = 4.0 * w * r->arc_weight[k] * v_dot_h;
        if (!(n_dot_l > 0.0))
            continue;
        const double lambda = ibl_charlie_lambda(fmin(n_dot_l, 1.0), v->alpha);
        sum[0] += g * n_dot_l * ibl_ashikhmin_visibility(n_dot_l, v->cosine);
        sum[1] += g * 0.25 / (v->cosine * (1.0 + v->lambda + lambda));
    }
}

/* Adds full rings of theta_h from low to high. */
static void add_inner(const ibl_sheen_rule *r, const view *v, double low,
                      double high, double sum[2])
{
    for (int k = 0; k < IBL_SHEEN_INNER; k++)
        add_arc(r, v, low + (high - low) * r->inner_at[k], IBL_PI,
                (high - low) * r->inner_weight[k], sum);
}

/* Adds arcs of theta_h from low to high. */
static void add_outer(const ibl_sheen_rule *r, const view *v, double low,
                      double high, double sum[2])
{
    for (int k = 0; k < IBL_SHEEN_OUTER; k++) {
        const double theta = low + (high - low) * r->outer_at[k];
        /* N.L > 0 where cos(phi) > c0 */
        const double c0 =
            -v->cosine * cos(2 * theta) / (v->sine * sin(2 * theta));
        add_arc(r, v, theta, acos(fmax(-1.0, fmin(c0, 1.0))),
                (high - low) * r->outer_weight[k], sum);
    }
}

void ibl_sheen_sums(const ibl_sheen_rule *rule, double alpha,
                    const double *n_dot_v, int count, float *sum)
{
    /* Below it D is less than 1e-9 of its maximum. */
    const double from = asin(exp(-20.0 * alpha));

    for (int i = 0; i < count; i++) {
        const double c = n_dot_v[i], half = 0.5 * acos(c);
        const double low = fmax(from, IBL_PI / 4 - half);
        const view v = {alpha, c, sqrt((1.0 - c) * (1.0 + c)),
                        ibl_charlie_lambda(c, alpha)};
        double both[2] = {0.0, 0.0};
        if (from < IBL_PI / 4 - half)
            add_inner(rule, &v, from, IBL_PI / 4 - half, both);
        if (low < IBL_PI / 4 + half)
            add_outer(rule, &v, low, IBL_PI / 4 + half, both);
        sum[2 * i] = (float)both[0];
        sum[2 * i + 1] = (float)both[1];
    }
}
