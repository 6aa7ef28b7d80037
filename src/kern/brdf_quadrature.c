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

/* cos_h and sin_h of the half vector at y; returns du / dy. */
static double radius(double alpha, double y, double *sin_h, double *cos_h)
{
    const double e = exp(-2.0 * y), tanh_y = (1.0 - e) / (1.0 + e);
    const double t = alpha * sinh(y);

    *cos_h = 1.0 / sqrt(1.0 + t * t);
    *sin_h = t * *cos_h;
    /* 2 tanh / cosh^2 */
    return 8.0 * tanh_y * e / ((1.0 + e) * (1.0 + e));
}

/* Adds full rings up to y = end. */
static void add_inner(const ibl_brdf_rule *r, const ibl_split_view *v,
                      double end, double sum[2])
{
    for (int i = 0; i < IBL_BRDF_INNER; i++) {
        double sin_h, cos_h;
        const double w = end * r->inner_weight[i] / IBL_BRDF_ANGLES *
                         radius(v->alpha, end * r->inner_at[i], &sin_h, &cos_h);
        for (int k = 0; k < IBL_BRDF_ANGLES; k++)
            ibl_split_add(v, sin_h, cos_h, r->ring[k], w, sum);
    }
}

/* Adds arcs from y.inner to y.outer. */
static void add_outer(const ibl_brdf_rule *r, const ibl_split_view *v,
                      ibl_brdf_limits y, double sum[2])
{
    const double length = y.outer - y.inner;
    for (int i = 0; i < IBL_BRDF_OUTER; i++) {
        double sin_h, cos_h;
        const double du =
            radius(v->alpha, y.inner + length * r->outer_at[i], &sin_h, &cos_h);
        const double t = sin_h / cos_h;
        const double c0 = v->cosine * (t * t - 1.0) / (2.0 * v->sine * t);
        const double half = acos(fmax(-1.0, fmin(c0, 1.0)));
        const double w = length * r->outer_weight[i] * du * half / IBL_PI;
        for (int k = 0; k < IBL_BRDF_ANGLES; k++)
            ibl_split_add(v, sin_h, cos_h, cos(half * r->arc_at[k]),
                          w * r->arc_weight[k], sum);
    }
}

static void split_sums(const ibl_brdf_rule *rule, ibl_geometry geometry,
                       double alpha, const double *n_dot_v, int count,
                       float *sum)
{
    for (int i = 0; i < count; i++) {
        const ibl_split_view v = ibl_split_view_of(n_dot_v[i], alpha, geometry);
        const ibl_brdf_limits y = ibl_brdf_limits_of(&v);
        double both[2] = {0.0, 0.0};
        add_inner(rule, &v, y.inner, both);
        if (y.outer > y.inner)
            add_outer(rule, &v, y, both);
        sum[2 * i] = (float)both[0];
        sum[2 * i + 1] = (float)both[1];
    }
}

void ibl_brdf_mix_c(const float *table, size_t stride, const float *pair,
                    int terms, int count, float *out)
{
    for (int i = 0; i < count; i++) {
        float sum = 0;
        for (int k = 0; k < terms; k++)
            sum += table[(size_t)k * stride + (size_t)i] * pair[2 * k + i % 2];
        out[i] = sum;
    }
}

IBL_KERNEL(ibl_brdf, split_sums, ibl_brdf_mix_c)
