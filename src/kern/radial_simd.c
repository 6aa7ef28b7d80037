/* SPDX-License-Identifier: MIT */
/* In vectors of any width. */
#include <string.h>

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

/* Squared distance of VF points from a light. */
static inline vf distance(const vf p[6], const ibl_radial_light *s)
{
    const vf x = (p[0] - vf_all(s->at[0])) + (p[3] - vf_all(s->rest[0]));
    const vf y = (p[1] - vf_all(s->at[1])) + (p[4] - vf_all(s->rest[1]));
    const vf z = (p[2] - vf_all(s->at[2])) + (p[5] - vf_all(s->rest[2]));
    return vf_fma(x, x, vf_fma(y, y, z * z));
}

static inline vf rational(const ibl_radial *lobe, vf q)
{
    const vf level = vf_fma(q, vf_all(-0.5f), vf_all(1));
    const vf t = vf_fma(q, vf_all(lobe->slope), vf_all(1));
    return vf_max(level, vf_all(0)) * vf_all(lobe->peak) / (t * t);
}

static inline vf tabulated(const ibl_radial *lobe, vf q)
{
    const int shift = 23 - lobe->bits;
    const vi far = q > vf_all(1);
    /* 2 - q is less than q exactly when q > 1. */
    const vf other = vf_all(2) - q;
    const vf v = vf_max(vf_either(far, other, q), vf_all(0));
    const vf start =
        vf_either(far, vf_all(lobe->start[1]), vf_all(lobe->start[0]));
    const vi base = (lobe->base[1] & far) | (lobe->base[0] & ~far);
    const vi word = (vi)(v + start);
    const vi at = ((word >> shift) - base) << 2;
    const vf x = __builtin_convertvector(word & ((1 << shift) - 1), vf) *
                 (1 / (float)(1 << shift));
    int piece[VF];
    memcpy(piece, &at, sizeof piece);
    /* Transposes four coefficients per texel to one vector per coefficient. */
    vf c[4];
#pragma GCC unroll 4
    for (int i = 0; i < 4; i++) {
        const float *from[VF / 4];
#pragma GCC unroll 4
        for (int k = 0; k < VF / 4; k++)
            from[k] = lobe->coef + piece[4 * k + i];
        c[i] = vf_load_quads(from);
    }
    vf_transpose(c);
    return vf_fma(vf_fma(vf_fma(c[3], x, c[2]), x, c[1]), x, c[0]);
}

/* Adds to AT_ONCE vectors of texels; table: the lobe is one. */
static inline void add_texels(const ibl_radial *lobe, bool table,
                              const ibl_radial_light *lights, int count,
                              const float *point, int stride, float *rgba)
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
        vf q[AT_ONCE];
        vi above[AT_ONCE], any = {0};
#pragma GCC unroll 2
        for (int n = 0; n < AT_ONCE; n++) {
            q[n] = distance(p[n], s);
            above[n] = q[n] < vf_all(2);
            any |= above[n];
        }
        if (!vi_any(any))
            continue;
#pragma GCC unroll 2
        for (int n = 0; n < AT_ONCE; n++) {
            const vf k = table ? (vf)(above[n] & (vi)tabulated(lobe, q[n]))
                               : rational(lobe, q[n]);
#pragma GCC unroll 3
            for (int c = 0; c < 3; c++)
                sum[n][c] = vf_fma(k, vf_all(s->rgb[c]), sum[n][c]);
        }
    }
#pragma GCC unroll 2
    for (int n = 0; n < AT_ONCE; n++)
        add_rgb(rgba + 4 * n * VF, sum[n][0], sum[n][1], sum[n][2]);
}

static void add(const ibl_radial *lobe, const ibl_radial_light *lights,
                int count, const float *point, int stride, float *rgba)
{
    const bool table = lobe->coef;
    for (int i = 0; i < stride; i += AT_ONCE * VF)
        if (table)
            add_texels(lobe, true, lights, count, point + i, stride,
                       rgba + 4 * i);
        else
            add_texels(lobe, false, lights, count, point + i, stride,
                       rgba + 4 * i);
}

IBL_VECTOR_KERNEL(ibl_radial, points, add)
