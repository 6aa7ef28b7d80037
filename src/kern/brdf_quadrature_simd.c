/* SPDX-License-Identifier: MIT */
/*
 * The sums in vectors of floats, one view per lane. The points
 * differ between views only by their scale. Values that would lose digits
 * (sines, limits) are prepared in double.
 */
#include <stdbool.h>
#include <string.h>

#include "kern/brdf_quadrature.h"
#include "kern/lanes.h"

typedef struct views {
    vf cosine, sine, inner, outer; /* inner, outer: limits of y */
    vf a2, rest;                   /* alpha^2, 1 - alpha^2; Schlick: k, 1 - k */
    vf of_view;                    /* the part of the visibility without N.L */
    vf alpha;
    bool schlick;
} views;

/* exp(y), 0 <= y < 80, within 2e-7: 2^n times the Taylor series of exp(f). */
static inline vf vf_exp(vf y)
{
    /* 1.5 2^23: adding it leaves the nearest integer in the low bits. */
    const vf magic = vf_all(12582912.0f);
    const vf n = vf_fma(y, vf_all(1.44269504f), magic);
    const vf whole = n - magic;
    /* f = y - n ln 2, with ln 2 split in two. */
    const vf f = vf_fma(whole, vf_all(2.12194440e-4f),
                        vf_fma(whole, vf_all(-0.693359375f), y));
    vf p = vf_all(1.0f / 5040);
    p = vf_fma(p, f, vf_all(1.0f / 720));
    p = vf_fma(p, f, vf_all(1.0f / 120));
    p = vf_fma(p, f, vf_all(1.0f / 24));
    p = vf_fma(p, f, vf_all(1.0f / 6));
    p = vf_fma(p, f, vf_all(0.5f));
    p = vf_fma(p, f, vf_all(1));
    p = vf_fma(p, f, vf_all(1));
    const vi scale = ((vi)n << 23) + 0x3F800000;
    return p * (vf)scale;
}

/* acos(x), -1 <= x <= 1, within 1e-7 plus rounding (Abramowitz and Stegun
 * 4.4.46). */
static inline vf vf_acos(vf x)
{
    const vf size = vf_max(x, -x);
    vf p = vf_all(-0.0012624911f);
    p = vf_fma(p, size, vf_all(0.0066700901f));
    p = vf_fma(p, size, vf_all(-0.0170881256f));
    p = vf_fma(p, size, vf_all(0.0308918810f));
    p = vf_fma(p, size, vf_all(-0.0501743046f));
    p = vf_fma(p, size, vf_all(0.0889789874f));
    p = vf_fma(p, size, vf_all(-0.2145988016f));
    p = vf_fma(p, size, vf_all(1.5707963050f));
    const vf acute = vf_sqrt(vf_all(1) - size) * p;
    return vf_either(x < vf_all(0), vf_all(3.14159265f) - acute, acute);
}

/* cos(a), 0 <= a <= pi, within 1.2e-7: 1 - 2 sin^2(a / 2), with the sine's
 * series to the eleventh power. */
static inline vf vf_cos(vf a)
{
    const vf x = vf_all(0.5f) * a, q = x * x;
    vf p = vf_all(-1.0f / 39916800);
    p = vf_fma(p, q, vf_all(1.0f / 362880));
    p = vf_fma(p, q, vf_all(-1.0f / 5040));
    p = vf_fma(p, q, vf_all(1.0f / 120));
    p = vf_fma(p, q, vf_all(-1.0f / 6));
    p = vf_fma(p, q, vf_all(1));
    const vf s = x * p;
    return vf_fma(vf_all(-2) * s, s, vf_all(1));
}

/* t, 1 / cos_h = sqrt(1 + t^2), du / dy. */
typedef struct radius {
    vf t, root, du;
} radius;

static inline radius radius_at(const views *v, vf y)
{
    const vf one = vf_all(1);
    const vf up = vf_exp(y), down = one / up, e = down * down;
    const vf t = v->alpha * vf_all(0.5f) * (up - down);
    const vf plus = one + e;
    return (radius){t, vf_sqrt(vf_fma(t, t, one)),
                    vf_all(8) * (one - e) * e / (plus * plus * plus)};
}

/* Adds the integrand at a half vector, times weight. V.H = a cos(phi) + b. */
static inline void add_point(const views *v, vf a, vf b, vf cos_h, vf root,
                             vf cos_phi, vf weight, vf sum[2])
{
    vf v_dot_h = vf_fma(a, cos_phi, b);
    const vf n_dot_l = vf_fma(vf_all(2) * v_dot_h, cos_h, -v->cosine);
    const vi above = n_dot_l > vf_all(0);
    vf vis; /* 4 times the visibility */

    v_dot_h = vf_min(v_dot_h, vf_all(1));
    if (v->schlick)
        vis = vf_all(1) / (vf_fma(n_dot_l, v->rest, v->a2) * v->of_view);
    else
        vis = vf_all(2) /
              vf_fma(v->cosine,
                     vf_sqrt(vf_fma(n_dot_l * n_dot_l, v->rest, v->a2)),
                     n_dot_l * v->of_view);
    const vf g = (vf)(above & (vi)(vis * n_dot_l * v_dot_h * root * weight));
    const vf far = vf_all(1) - v_dot_h, square = far * far;
    const vf bias = g * (square * square * far);
    sum[0] += g - bias;
    sum[1] += bias;
}

/* Adds w times the points of a ring or, if half is not NULL, of an arc of this
 * half angle. */
static inline void add_radius(const ibl_brdf_rule *r, const views *v,
                              const radius *at, const vf *half, vf w, vf sum[2])
{
    const vf one = vf_all(1), cos_h = one / at->root;
    const vf a = v->sine * at->t * cos_h, b = v->cosine * cos_h;
    vf part[2] = {vf_all(0), vf_all(0)};

    for (int k = 0; k < IBL_BRDF_ANGLES; k++)
        add_point(v, a, b, cos_h, at->root,
                  half ? vf_cos(*half * vf_all((float)r->arc_at[k]))
                       : vf_all((float)r->ring[k]),
                  half ? vf_all((float)r->arc_weight[k]) : one, part);
    sum[0] = vf_fma(w, part[0], sum[0]);
    sum[1] = vf_fma(w, part[1], sum[1]);
}

static inline void add_inner(const ibl_brdf_rule *r, const views *v, vf sum[2])
{
    for (int i = 0; i < IBL_BRDF_INNER; i++) {
        const vf y = v->inner * vf_all((float)r->inner_at[i]);
        const radius at = radius_at(v, y);
        const vf w = v->inner * at.du *
                     vf_all((float)(r->inner_weight[i] / IBL_BRDF_ANGLES));
        add_radius(r, v, &at, NULL, w, sum);
    }
}

static inline void add_outer(const ibl_brdf_rule *r, const views *v, vf sum[2])
{
    const vf length = v->outer - v->inner, one = vf_all(1);

    for (int i = 0; i < IBL_BRDF_OUTER; i++) {
        const vf y = vf_fma(length, vf_all((float)r->outer_at[i]), v->inner);
        const radius at = radius_at(v, y);
        const vf c0 =
            v->cosine * vf_fma(at.t, at.t, -one) / (vf_all(2) * v->sine * at.t);
        const vf half = vf_acos(vf_max(vf_min(c0, one), -one));
        const vf w = length * at.du * half *
                     vf_all((float)(r->outer_weight[i] / IBL_PI));
        add_radius(r, v, &at, &half, w, sum);
    }
}

/* Lanes from count on repeat the last view. */
static inline views views_of(ibl_geometry geometry, double alpha,
                             const double *n_dot_v, int count)
{
    float cosine[VF], sine[VF], inner[VF], outer[VF];
    views l;

    for (int i = 0; i < VF; i++) {
        const ibl_split_view v = ibl_split_view_of(
            n_dot_v[i < count ? i : count - 1], alpha, geometry);
        const ibl_brdf_limits y = ibl_brdf_limits_of(&v);
        cosine[i] = (float)v.cosine;
        sine[i] = (float)v.sine;
        inner[i] = (float)y.inner;
        outer[i] = (float)y.outer;
    }
    l.cosine = vf_load(cosine);
    l.sine = vf_load(sine);
    l.inner = vf_load(inner);
    l.outer = vf_load(outer);
    l.alpha = vf_all((float)alpha);
    l.schlick = geometry == IBL_GEOMETRY_SCHLICK_IBL;
    const double part = l.schlick ? 0.5 * alpha : alpha * alpha;
    l.a2 = vf_all((float)part);
    l.rest = vf_all((float)(1 - part));
    l.of_view = l.schlick ? vf_fma(l.cosine, l.rest, l.a2)
                          : vf_sqrt(vf_fma(l.cosine * l.cosine, l.rest, l.a2));
    return l;
}

static void split_sums(const ibl_brdf_rule *rule, ibl_geometry geometry,
                       double alpha, const double *n_dot_v, int count,
                       float *sum)
{
    for (int i = 0; i < count; i += VF) {
        const int n = count - i < VF ? count - i : VF;
        const views v = views_of(geometry, alpha, n_dot_v + i, n);
        vf both[2] = {vf_all(0), vf_all(0)};
        float scale[VF], bias[VF];
        add_inner(rule, &v, both);
        add_outer(rule, &v, both);
        vf_store(scale, both[0]);
        vf_store(bias, both[1]);
        for (int k = 0; k < n; k++) {
            sum[2 * (i + k)] = scale[k];
            sum[2 * (i + k) + 1] = bias[k];
        }
    }
}

/* A vector that alternates the two floats of a pair. */
static inline vf both_of(const float *pair)
{
    double both;
    memcpy(&both, pair, sizeof both);
    return (vf)vd_all(both);
}

static void split_mix(const float *table, size_t stride, const float *pair,
                      int terms, int count, float *out)
{
    int i = 0;

    /* Four sums at once hide the latency of the multiply-add. */
    for (; i + 4 * VF <= count; i += 4 * VF) {
        vf sum[4] = {vf_all(0), vf_all(0), vf_all(0), vf_all(0)};
        for (int k = 0; k < terms; k++) {
            const float *from = table + (size_t)k * stride + (size_t)i;
            const vf both = both_of(pair + 2 * k);
            sum[0] = vf_fma(vf_load(from), both, sum[0]);
            sum[1] = vf_fma(vf_load(from + VF), both, sum[1]);
            sum[2] = vf_fma(vf_load(from + 2 * VF), both, sum[2]);
            sum[3] = vf_fma(vf_load(from + 3 * VF), both, sum[3]);
        }
        for (int j = 0; j < 4; j++)
            vf_store(out + i + j * VF, sum[j]);
    }
    for (; i < count; i += 2) {
        vf sum = vf_all(0);
        for (int k = 0; k < terms; k++)
            sum = vf_fma(both_of(table + (size_t)k * stride + (size_t)i),
                         both_of(pair + 2 * k), sum);
        out[i] = sum[0];
        out[i + 1] = sum[1];
    }
}

IBL_VECTOR_KERNEL(ibl_brdf, split_sums, split_mix)
