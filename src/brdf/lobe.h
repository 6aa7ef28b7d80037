/* SPDX-License-Identifier: MIT */
/*
 * The lobes of ibl_lobe as functions of
 *     q = sin^2(psi / 2),
 * psi the angle from R. Near the peak of a narrow lobe the cosine loses its
 * digits, q does not. With N = V = R the half vector is at psi / 2, so
 * N.H^2 = 1 - q, sin^2(theta_h) = q, N.L = 1 - 2 q; and dO = 4 pi dq.
 *
 * A lobe is K = scale D N.L with an integral of 1 over the sphere:
 *   GGX      D = D_ggx (brdf/ggx.h)
 *   Charlie  D = (2 q)^s, s = 1 / (2 alpha): sin(theta_h)^(1 / alpha) up to a
 *            constant (Estevez and Kulla 2017, "Production Friendly
 *            Microfacet Sheen BRDF")
 *   Phong    D = (1 - 2 q)^n, n = (1 / alpha^2 - 1) / 2
 *
 * In v = 2 q, dO = 2 pi dv over 0..1, the integrals are
 *   Charlie  2 pi int v^s (1 - v) dv = 2 pi / ((s + 1) (s + 2))
 *   Phong    2 pi int (1 - v)^(n + 1) dv = 2 pi / (n + 2)
 */
#ifndef IBL_BRDF_LOBE_H
#define IBL_BRDF_LOBE_H

#include <math.h>

#include "brdf/ggx.h"
#include "ibl/ibl.h"

/* Shape of K around its peak. It decides how a narrow lobe is baked. */
typedef enum ibl_lobe_kind {
    IBL_LOBE_TAILED, /* smooth within alpha, then a power of 1 / psi */
    IBL_LOBE_RING,   /* 0 at the peak, not smooth there */
    IBL_LOBE_COMPACT /* smooth, negligible a few widths away */
} ibl_lobe_kind;

typedef struct ibl_lobe_shape {
    ibl_lobe lobe;
    double alpha;
    double power; /* Charlie's s, Phong's n */
    double scale;
    ibl_lobe_kind kind;
    double end; /* K falls as this power of N.L on the horizon */
} ibl_lobe_shape;

/* Returns IBL_ERR_ARGUMENT if there is no such lobe. */
ibl_status ibl_lobe_check(ibl_ctx *ctx, ibl_lobe lobe);

/* alpha in (0, 1]. Values below 1e-75 count as 1e-75, to avoid underflow. */
ibl_lobe_shape ibl_lobe_shape_of(ibl_lobe lobe, double alpha);

/* D. q in 0..1/2; cosine = 1 - 2 q > 0. Both are passed for their digits: q has
 * them at the peak of GGX and Phong, the cosine on the horizon. */
static inline double ibl_lobe_d(const ibl_lobe_shape *s, double q,
                                double cosine)
{
    const double a2 = s->alpha * s->alpha;
    double log_d = 0;

    switch (s->lobe) {
    case IBL_LOBE_GGX:
        return ibl_ggx_d(q + a2 * (1 - q), s->alpha);
    case IBL_LOBE_CHARLIE:
        log_d = cosine < 0.5 ? log1p(-cosine) : log(2 * q);
        break;
    case IBL_LOBE_PHONG:
        log_d = q < 0.25 ? log1p(-2 * q) : log(cosine);
        break;
    }
    return exp(s->power * log_d);
}

/* K, per steradian; 0 below the horizon. */
static inline double ibl_lobe_value(const ibl_lobe_shape *s, double q,
                                    double cosine)
{
    return cosine > 0 ? s->scale * ibl_lobe_d(s, q, cosine) * cosine : 0;
}

/* Derivative of ln D with respect to q. Charlie's has no limit at q = 0. */
static inline double ibl_lobe_slope(const ibl_lobe_shape *s, double q,
                                    double cosine)
{
    const double a2 = s->alpha * s->alpha;

    switch (s->lobe) {
    case IBL_LOBE_GGX:
        break;
    case IBL_LOBE_CHARLIE:
        return s->power / q;
    case IBL_LOBE_PHONG:
        return -2 * s->power / cosine;
    }
    return -2 * (1 - a2) / (q + a2 * (1 - q));
}

/* A direction drawn with density D over the hemisphere. */
typedef struct ibl_lobe_sample {
    double sin_h, cos_h; /* of the half vector's angle */
    double cosine;       /* N.L */
    double pdf;          /* per steradian */
} ibl_lobe_sample;

/* L is above the horizon if the half vector is within 45 degrees: u below
 * 1 / (1 + alpha^2) in Walter's formula. pdf = D N.H / (4 V.H), and V = N. */
static inline ibl_lobe_sample ibl_lobe_draw_ggx(double alpha, double u)
{
    const double part = 1 / (1 + alpha * alpha);
    ibl_lobe_sample r;

    ibl_ggx_sample_half(u * part, alpha, &r.sin_h, &r.cos_h);
    r.cosine = (r.cos_h - r.sin_h) * (r.cos_h + r.sin_h);
    const double c = alpha * r.cos_h;
    r.pdf = ibl_ggx_d(r.sin_h * r.sin_h + c * c, alpha) / (4 * part);
    return r;
}

/* v = 2 q and cosine = N.L = 1 - v. One of the two is x = exp(log_x). */
static inline ibl_lobe_sample ibl_lobe_draw_power(double power, double log_x,
                                                  double v, double cosine)
{
    return (ibl_lobe_sample){sqrt(v / 2), sqrt((1 + cosine) / 2), cosine,
                             (power + 1) / (2 * IBL_PI) * exp(power * log_x)};
}

/* u in (0, 1); the density falls as u grows. Power p of x in 0..1, where x is v
 * or 1 - v, is drawn as x = (1 - u)^(1 / (p + 1)). */
static inline ibl_lobe_sample ibl_lobe_draw(const ibl_lobe_shape *s, double u)
{
    const double log_x = log1p(-u) / (s->power + 1);

    switch (s->lobe) {
    case IBL_LOBE_GGX:
        break;
    case IBL_LOBE_CHARLIE:
        return ibl_lobe_draw_power(s->power, log_x, exp(log_x), -expm1(log_x));
    case IBL_LOBE_PHONG:
        return ibl_lobe_draw_power(s->power, log_x, -expm1(log_x), exp(log_x));
    }
    return ibl_lobe_draw_ggx(s->alpha, u);
}

/* The largest pdf, within a factor of two. */
static inline double ibl_lobe_peak(const ibl_lobe_shape *s)
{
    switch (s->lobe) {
    case IBL_LOBE_GGX:
        break;
    case IBL_LOBE_CHARLIE:
    case IBL_LOBE_PHONG:
        return (s->power + 1) / (2 * IBL_PI);
    }
    return 1 / (4 * IBL_PI * s->alpha * s->alpha);
}

#endif
