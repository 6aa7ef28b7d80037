/* SPDX-License-Identifier: MIT */
/* The functions of radial.c for vectors of any width; included by one file
 * for each instruction set. */
#ifndef IBL_KERN_RADIAL_LANES_H
#define IBL_KERN_RADIAL_LANES_H

#include <stddef.h>

#include "kern/lanes.h"
#include "kern/radial.h"

typedef int vi __attribute__((vector_size(sizeof(vf))));

/* What lanes.h lacks: the greater of two, zero where a mask is not set,
 * whether any lane is less, gathering, roots, and adding three vectors to VF
 * texels of four floats. */
#if VF == 16
static inline vf keep_less(vf value, vf a, vf b)
{
    return _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(a, b, _CMP_LT_OQ), value);
}

static inline int any_less(vf a, vf b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ) != 0;
}

static inline vf gather(const float *from, vi at)
{
    return _mm512_i32gather_ps((__m512i)at, from, 4);
}

static inline vd vd_sqrt(vd x)
{
    return _mm512_sqrt_pd(x);
}

static inline void add_rgb(float *rgba, vf r, vf g, vf b)
{
    const vf zero = vf_all(0);
    const vf rg0 = _mm512_unpacklo_ps(r, g), rg1 = _mm512_unpackhi_ps(r, g);
    const vf b0 = _mm512_unpacklo_ps(b, zero);
    const vf b1 = _mm512_unpackhi_ps(b, zero);
    /* Texels 0 4 8 12, 1 5 9 13, ... */
    const vf t0 = _mm512_shuffle_ps(rg0, b0, 0x44);
    const vf t1 = _mm512_shuffle_ps(rg0, b0, 0xEE);
    const vf t2 = _mm512_shuffle_ps(rg1, b1, 0x44);
    const vf t3 = _mm512_shuffle_ps(rg1, b1, 0xEE);
    const vf a0 = _mm512_shuffle_f32x4(t0, t1, 0x44);
    const vf a1 = _mm512_shuffle_f32x4(t2, t3, 0x44);
    const vf a2 = _mm512_shuffle_f32x4(t0, t1, 0xEE);
    const vf a3 = _mm512_shuffle_f32x4(t2, t3, 0xEE);
    vf_store(rgba, vf_load(rgba) + _mm512_shuffle_f32x4(a0, a1, 0x88));
    vf_store(rgba + 16,
             vf_load(rgba + 16) + _mm512_shuffle_f32x4(a0, a1, 0xDD));
    vf_store(rgba + 32,
             vf_load(rgba + 32) + _mm512_shuffle_f32x4(a2, a3, 0x88));
    vf_store(rgba + 48,
             vf_load(rgba + 48) + _mm512_shuffle_f32x4(a2, a3, 0xDD));
}
#elif VF == 8
static inline vf keep_less(vf value, vf a, vf b)
{
    return _mm256_and_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ), value);
}

static inline int any_less(vf a, vf b)
{
    return _mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ)) != 0;
}

static inline vf gather(const float *from, vi at)
{
    return _mm256_i32gather_ps(from, (__m256i)at, 4);
}

static inline vd vd_sqrt(vd x)
{
    return _mm256_sqrt_pd(x);
}

static inline void add_rgb(float *rgba, vf r, vf g, vf b)
{
    const vf zero = vf_all(0);
    const vf rg0 = _mm256_unpacklo_ps(r, g), rg1 = _mm256_unpackhi_ps(r, g);
    const vf b0 = _mm256_unpacklo_ps(b, zero);
    const vf b1 = _mm256_unpackhi_ps(b, zero);
    /* Texels 0 4, 1 5, 2 6, 3 7. */
    const vf t0 = _mm256_shuffle_ps(rg0, b0, 0x44);
    const vf t1 = _mm256_shuffle_ps(rg0, b0, 0xEE);
    const vf t2 = _mm256_shuffle_ps(rg1, b1, 0x44);
    const vf t3 = _mm256_shuffle_ps(rg1, b1, 0xEE);
    vf_store(rgba, vf_load(rgba) + _mm256_permute2f128_ps(t0, t1, 0x20));
    vf_store(rgba + 8,
             vf_load(rgba + 8) + _mm256_permute2f128_ps(t2, t3, 0x20));
    vf_store(rgba + 16,
             vf_load(rgba + 16) + _mm256_permute2f128_ps(t0, t1, 0x31));
    vf_store(rgba + 24,
             vf_load(rgba + 24) + _mm256_permute2f128_ps(t2, t3, 0x31));
}
#else
static inline vf keep_less(vf value, vf a, vf b)
{
    return _mm_and_ps(_mm_cmplt_ps(a, b), value);
}

static inline int any_less(vf a, vf b)
{
    return _mm_movemask_ps(_mm_cmplt_ps(a, b)) != 0;
}

static inline vf gather(const float *from, vi at)
{
    return _mm_setr_ps(from[at[0]], from[at[1]], from[at[2]], from[at[3]]);
}

static inline vd vd_sqrt(vd x)
{
    return _mm_sqrt_pd(x);
}

static inline void add_rgb(float *rgba, vf r, vf g, vf b)
{
    vf a = vf_all(0);
    _MM_TRANSPOSE4_PS(r, g, b, a);
    vf_store(rgba, vf_load(rgba) + r);
    vf_store(rgba + 4, vf_load(rgba + 4) + g);
    vf_store(rgba + 8, vf_load(rgba + 8) + b);
    vf_store(rgba + 12, vf_load(rgba + 12) + a);
}
#endif

static inline size_t stride_of(int size)
{
    return ((size_t)size + IBL_RADIAL_BLOCK - 1) / IBL_RADIAL_BLOCK *
           IBL_RADIAL_BLOCK;
}

static inline void store_split(float *point, size_t rest, vd x)
{
    vd_store_floats(point, x);
    vd_store_floats(point + rest, x - vd_load_floats(point));
}

static inline void lanes_points(double v, int size, float *point)
{
    static const double odd[8] = {1, 3, 5, 7, 9, 11, 13, 15};
    const size_t stride = stride_of(size);
    for (size_t i = 0; i < stride; i += VD) {
        const vd u = (vd_load(odd) + 2.0 * (double)i) / (double)size - 1.0;
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
    /* 2 - q is less than q just where q > 1. */
    const vf other = vf_all(2) - q;
    const vf v = vf_max((vf)(((vi)other & far) | ((vi)q & ~far)), vf_all(0));
    const vf start = (vf)(((vi)vf_all(lobe->start[1]) & far) |
                          ((vi)vf_all(lobe->start[0]) & ~far));
    const vi base = (lobe->base[1] & far) | (lobe->base[0] & ~far);
    const vi word = (vi)(v + start);
    const vi at = ((word >> shift) - base) << 2;
    const vf x = __builtin_convertvector(word & ((1 << shift) - 1), vf) *
                 (1 / (float)(1 << shift));
    vf k = vf_fma(gather(lobe->coef + 3, at), x, gather(lobe->coef + 2, at));
    k = vf_fma(k, x, gather(lobe->coef + 1, at));
    return vf_fma(k, x, gather(lobe->coef, at));
}

static inline void lanes_add(const ibl_radial *lobe,
                             const ibl_radial_light *lights, int count,
                             const float *point, int size, float *rgba)
{
    const size_t stride = stride_of(size);
    const vf horizon = vf_all(2);
    for (size_t i = 0; i < stride; i += VF) {
        vf p[6], r = vf_all(0), g = r, b = r;
        for (size_t k = 0; k < 6; k++)
            p[k] = vf_load(point + k * stride + i);
        for (int l = 0; l < count; l++) {
            const ibl_radial_light *s = &lights[l];
            const vf q = distance(p, s);
            if (!any_less(q, horizon))
                continue;
            const vf k = lobe->coef ? keep_less(tabulated(lobe, q), q, horizon)
                                    : rational(lobe, q);
            r = vf_fma(k, vf_all(s->rgb[0]), r);
            g = vf_fma(k, vf_all(s->rgb[1]), g);
            b = vf_fma(k, vf_all(s->rgb[2]), b);
        }
        add_rgb(rgba + 4 * i, r, g, b);
    }
}

#endif
