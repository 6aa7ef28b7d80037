/* SPDX-License-Identifier: MIT */
/* In vectors of any width. */
#include "kern/lanes.h"
#include "kern/radial.h"

enum {
    /* Vectors of texels that share a light's numbers, with their points and
     * sums in registers: nine for each. */
    AT_ONCE = REGISTERS / 16
};
_Static_assert(IBL_RADIAL_BLOCK % (AT_ONCE * VF) == 0, "whole blocks");

/* Adds to VF texels of four floats; their fourth float is unchanged. */
static inline void add_rgb(float *rgba, vf r, vf g, vf b)
{
    vf t[4] = {r, g, b, vf_all(0)};
    vf_transpose(t); /* texels 0 4, 1 5, ... */
#pragma GCC unroll 8
    for (size_t i = 0; i < VF; i++) {
        float *to = rgba + 4 * i;
        vq_store(to, vq_load(to) + vf_quad(t[i % 4], i / 4));
    }
}

static inline void store_split(float *point, int rest, vd x)
{
    vd_store_floats(point, x);
    vd_store_floats(point + rest, x - vd_load_floats(point));
}

static void points(double v, int size, int first, int stride, float *point)
{
    static const double odd[8] = {1, 3, 5, 7, 9, 11, 13, 15};
    for (int i = 0; i < stride; i += VD) {
        const vd u = (vd_load(odd) + 2.0 * (first + i)) / (double)size - 1.0;
        const vd scale = 1.0 / vd_sqrt(1.0 + u * u + v * v);
        store_split(point + i, 3 * stride, scale);
        store_split(point + stride + i, 3 * stride, u * scale);
        store_split(point + 2 * stride + i, 3 * stride, v * scale);
    }
}

/* Squared distance of VF points from a light, which may be far. */
static inline vf distance(const vf p[6], const ibl_radial_light *s, bool far)
{
    vf d[3];

#pragma GCC unroll 3
    for (int k = 0; k < 3; k++) {
        d[k] = p[k] - vf_all(s->at[k]);
        if (!far)
            d[k] += p[k + 3] - vf_all(s->rest[k]);
    }
    return vf_fma(d[0], d[0], vf_fma(d[1], d[1], d[2] * d[2]));
}

/* Of x > 0, to 1e-7 of the value: 2 atanh((m - 1) / (m + 1)) for m in
 * sqrt(1/2)..sqrt(2). */
static inline vf log2_of(vf x)
{
    const vi bits = (vi)x, exponent = (bits - 0x3f3504f3) >> 23;
    const vf m = (vf)(bits - (exponent << 23));
    const vf s = (m - 1.0f) / (m + 1.0f), z = s * s;
    vf p = vf_fma(z, vf_all(1 / 9.0f), vf_all(1 / 7.0f));
    p = vf_fma(z, p, vf_all(1 / 5.0f));
    p = vf_fma(z, p, vf_all(1 / 3.0f));
    p = vf_fma(z, p, vf_all(1));
    return vf_fma(s * p, vf_all(2.885390082f),
                  __builtin_convertvector(exponent, vf));
}

/* Of t <= 1, to 2e-7; below -126 that of -126. */
static inline vf exp2_of(vf t)
{
    static const float c[] = {1.5403530e-4f,
                              1.3333558e-3f,
                              9.6181291e-3f,
                              5.5504109e-2f,
                              2.4022651e-1f,
                              6.9314718e-1f,
                              1};
    const vf shifted = vf_max(t, vf_all(-126)) + 0x1.8p23f;
    const vf f = vf_max(t, vf_all(-126)) - (shifted - 0x1.8p23f);
    vf p = vf_all(c[0]);
    for (int i = 1; i < 7; i++)
        p = vf_fma(p, f, vf_all(c[i]));
    return (vf)((vi)p + ((vi)shifted << 23));
}

/* D times the scale. */
static inline vf density(const ibl_radial *lobe, ibl_lobe kind, vf q)
{
    const vf z = 0.5f * q, y = vf_max(1.0f - z, vf_all(1e-30f));
    const vf t = vf_fma(q, vf_all(lobe->slope), vf_all(1));

    switch (kind) {
    case IBL_LOBE_GGX:
        return vf_all(lobe->scale) / (t * t);
    case IBL_LOBE_CHARLIE:
        return lobe->scale *
               exp2_of(lobe->power * log2_of(vf_max(z, vf_all(1e-30f))));
    case IBL_LOBE_PHONG:
        break;
    }
    /* 1 - z is rounded; log(1 - z) / z hardly depends on that. */
    const vi rounded = y < vf_all(1);
    const vf slope =
        vf_either(rounded, log2_of(y) / (1.0f - y), vf_all(-1.442695041f));
    return lobe->scale *
           exp2_of(lobe->power * vf_max(slope * z, vf_all(-1e4f)));
}

/* N.L changes by up to that over the sides of a rectangle. */
static inline void changes(const vf p[6], const ibl_radial_light *s, vf side[2])
{
#pragma GCC unroll 2
    for (int k = 0; k < 2; k++)
        side[k] = vf_fma(
            p[0], vf_all(s->side[k][0]),
            vf_fma(p[1], vf_all(s->side[k][1]), p[2] * vf_all(s->side[k][2])));
}

/* The mean of q: q + c v, c = N.L, v a third of the sum of the sides' squares.
 */
static inline vf mean_of(const ibl_radial_light *s, vf q)
{
    return vf_fma(vf_fma(q, vf_all(-0.5f), vf_all(1)), vf_all(s->rgb[3]), q);
}

/*
 * The mean of GGX over a rectangle, from that of q. Its variance is
 * 4 (a^2 + b^2) / 3, with a and b the changes of N.L. With t = 1 + slope q, the
 * second derivative of (1 - q/2) / t^2 is (6 c slope^2 / t^2 + 2 slope / t) /
 * t^2.
 */
static inline vf far_value(const ibl_radial *lobe, const vf p[6],
                           const ibl_radial_light *s, vf mean)
{
    const vf slope = vf_all(lobe->slope), zero = vf_all(0);
    const vf c = vf_max(vf_fma(mean, vf_all(-0.5f), vf_all(1)), zero);
    const vf inverse = 1.0f / vf_fma(mean, slope, vf_all(1));
    const vf steep = slope * inverse;
    vf side[2];

    changes(p, s, side);
    const vf half = (side[0] * side[0] + side[1] * side[1]) * (4 / 3.0f);
    const vf bend = vf_fma(c * steep, vf_all(3), vf_all(1)) * steep;
    return lobe->scale * inverse * inverse * vf_fma(half, bend, c);
}

/*
 * With h = N.L of a point of a rectangle, c in its middle and changing by up to
 * a and b along its sides, the mean of max(h, 0)^n is
 *     sum over the corners of +-max(c +- a +- b, 0)^(n+2)
 *         2 n! / (n + 2)! / (8 a b) 2,
 * plus for the corners with two equal signs. Returns that of n = 1 and replaces
 * q by where K / N.L is taken: at h of the mean of h max(h, 0) over that of
 * max(h, 0). Of a whole rectangle these are c and q; half is then half the
 * variance of h, else 0.
 */
static inline vf cut(const vf p[6], const ibl_radial_light *s, vf *q, vf *half)
{
    const vf c = vf_fma(*q, vf_all(-0.5f), vf_all(1)), zero = vf_all(0);
    vf side[2];

    changes(p, s, side);
    for (int k = 0; k < 2; k++)
        side[k] = vf_max(side[k], zero - side[k]);
    /* A side that is nearly on the horizon would cancel in the sum. */
    const vf a = vf_max(vf_max(side[0], side[1]), vf_all(1e-12f));
    const vf b = vf_max(vf_min(side[0], side[1]), 0.03f * a);
    const vf h[4] = {vf_max(c + a + b, zero), vf_max(c + a - b, zero),
                     vf_max(c - a + b, zero), vf_max(c - a - b, zero)};
    vf third = zero, fourth = zero;
#pragma GCC unroll 4
    for (int i = 0; i < 4; i++) {
        const vf cube = h[i] * h[i] * h[i];
        third = i % 3 ? third - cube : third + cube;
        fourth = i % 3 ? vf_fma(zero - cube, h[i], fourth)
                       : vf_fma(cube, h[i], fourth);
    }
    const vi whole = c > a + b;
    *half = vf_either(whole, (a * a + b * b) * (1 / 6.0f), zero);
    const vf part = vf_max(third / (24.0f * a * b), zero);
    const vf at = 0.5f * fourth / vf_max(third, vf_all(1e-30f));
    *q = vf_either(whole, *q, vf_max(2.0f - 2.0f * at, zero));
    return vf_either(whole, c, part);
}

/* The second derivative of h (1 - h)^power or, Phong, h h^power in parts of the
 * value. */
static inline vf bend_of(const ibl_radial *lobe, ibl_lobe kind, vf q)
{
    const vf least = vf_all(1e-6f), z = vf_max(0.5f * q, least);
    const vf h = vf_max(1.0f - z, least);
    const float n = lobe->power;

    if (kind == IBL_LOBE_PHONG)
        return n * (n + 1) / (h * h);
    return (n * (n - 1) / z - 2 * n / h) / z;
}

enum form {
    POINT,
    SPREAD,
    CUT
};

/* Adds to AT_ONCE vectors of texels. */
static inline void add_texels(const ibl_radial *lobe, ibl_lobe kind,
                              enum form form, const ibl_radial_light *lights,
                              int count, const float *point, int stride,
                              float *rgba)
{
    const vf zero = vf_all(0);
    vf p[AT_ONCE][6], sum[AT_ONCE][3];

#pragma GCC unroll 2
    for (int n = 0; n < AT_ONCE; n++) {
#pragma GCC unroll 6
        for (int k = 0; k < 6; k++)
            p[n][k] = vf_load(point + k * stride + n * VF);
        sum[n][0] = sum[n][1] = sum[n][2] = zero;
    }
    for (const ibl_radial_light *s = lights; s < lights + count; s++) {
        vf q[AT_ONCE], c[AT_ONCE], half[AT_ONCE];
        vi any = {0};
#pragma GCC unroll 2
        for (int n = 0; n < AT_ONCE; n++) {
            q[n] = distance(p[n], s, form == SPREAD);
            if (form != POINT)
                q[n] = mean_of(s, q[n]);
            half[n] = zero;
            c[n] = form == CUT
                       ? cut(p[n], s, &q[n], &half[n])
                       : vf_max(vf_fma(q[n], vf_all(-0.5f), vf_all(1)), zero);
            any |= c[n] > zero;
        }
        if (form != SPREAD && !vi_any(any))
            continue;
#pragma GCC unroll 2
        for (int n = 0; n < AT_ONCE; n++) {
            vf k = zero;
            if (form != SPREAD)
                k = density(lobe, kind, q[n]) * c[n];
            if (form == SPREAD)
                k = far_value(lobe, p[n], s, q[n]);
            else if (form == CUT && kind == IBL_LOBE_GGX)
                k = vf_either(half[n] > zero, far_value(lobe, p[n], s, q[n]),
                              k);
            else if (form == CUT)
                k *= vf_fma(half[n], bend_of(lobe, kind, q[n]), vf_all(1));
#pragma GCC unroll 3
            for (int i = 0; i < 3; i++)
                sum[n][i] = vf_fma(k, vf_all(s->rgb[i]), sum[n][i]);
        }
    }
#pragma GCC unroll 2
    for (int n = 0; n < AT_ONCE; n++)
        add_rgb(rgba + 4 * n * VF, sum[n][0], sum[n][1], sum[n][2]);
}

static inline void add_lights(const ibl_radial *lobe, enum form form,
                              const ibl_radial_light *lights, int count,
                              const float *point, int stride, float *rgba)
{
    for (int i = 0; i < IBL_RADIAL_BLOCK; i += AT_ONCE * VF)
        switch (lobe->lobe) {
        case IBL_LOBE_GGX:
            add_texels(lobe, IBL_LOBE_GGX, form, lights, count, point + i,
                       stride, rgba + 4 * i);
            break;
        case IBL_LOBE_CHARLIE:
            add_texels(lobe, IBL_LOBE_CHARLIE, form == CUT ? CUT : POINT,
                       lights, count, point + i, stride, rgba + 4 * i);
            break;
        case IBL_LOBE_PHONG:
            add_texels(lobe, IBL_LOBE_PHONG, form == CUT ? CUT : POINT, lights,
                       count, point + i, stride, rgba + 4 * i);
            break;
        }
}

static void add(const ibl_radial *lobe, const ibl_radial_light *lights,
                int count, const float *point, int stride, float *rgba)
{
    add_lights(lobe, POINT, lights, count, point, stride, rgba);
}

static void add_far(const ibl_radial *lobe, const ibl_radial_light *lights,
                    int count, const float *point, int stride, float *rgba)
{
    add_lights(lobe, SPREAD, lights, count, point, stride, rgba);
}

static void add_cut(const ibl_radial *lobe, const ibl_radial_light *lights,
                    int count, const float *point, int stride, float *rgba)
{
    add_lights(lobe, CUT, lights, count, point, stride, rgba);
}

IBL_VECTOR_KERNEL(ibl_radial, points, add, add_far, add_cut)
