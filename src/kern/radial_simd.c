/* SPDX-License-Identifier: MIT */
/* The functions of radial.c for vectors of any width. */
#include <string.h>

#include "kern/lanes.h"
#include "kern/radial.h"

/* What lanes.h lacks: zero where a lane is not less, whether any is, every
 * fourth lane's piece of a table (in fewer steps than a gather takes), and
 * adding three vectors to VF texels of four floats. */
#if VF == 16
static inline vf keep_less(vf value, vf a, vf b)
{
    return _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(a, b, _CMP_LT_OQ), value);
}

static inline int any_less(vf a, vf b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ) != 0;
}

/* Pieces at[0], at[4], at[8] and at[12]. */
static inline vf load_pieces(const float *coef, const int *at)
{
    const __m256 low =
        _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(coef + at[0])),
                             _mm_load_ps(coef + at[4]), 1);
    const __m256 high =
        _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(coef + at[8])),
                             _mm_load_ps(coef + at[12]), 1);
    return _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
}

static inline void add_rgb(float *rgba, vf r, vf g, vf b)
{
    vf t[4] = {r, g, b, vf_all(0)};
    vf_transpose(t); /* texels 0 4 8 12, 1 5 9 13, ... */
    const vf a0 = _mm512_shuffle_f32x4(t[0], t[1], 0x44);
    const vf a1 = _mm512_shuffle_f32x4(t[2], t[3], 0x44);
    const vf a2 = _mm512_shuffle_f32x4(t[0], t[1], 0xEE);
    const vf a3 = _mm512_shuffle_f32x4(t[2], t[3], 0xEE);
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

/* Pieces at[0] and at[4]. */
static inline vf load_pieces(const float *coef, const int *at)
{
    return _mm256_insertf128_ps(
        _mm256_castps128_ps256(_mm_load_ps(coef + at[0])),
        _mm_load_ps(coef + at[4]), 1);
}

static inline void add_rgb(float *rgba, vf r, vf g, vf b)
{
    vf t[4] = {r, g, b, vf_all(0)};
    vf_transpose(t); /* texels 0 4, 1 5, 2 6, 3 7 */
    for (int k = 0; k < 2; k++) {
        float *to = rgba + 8 * k;
        const vf first = _mm256_permute2f128_ps(t[2 * k], t[2 * k + 1], 0x20);
        const vf second = _mm256_permute2f128_ps(t[2 * k], t[2 * k + 1], 0x31);
        vf_store(to, vf_load(to) + first);
        vf_store(to + 16, vf_load(to + 16) + second);
    }
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

static inline vf load_pieces(const float *coef, const int *at)
{
    return _mm_load_ps(coef + at[0]);
}

static inline void add_rgb(float *rgba, vf r, vf g, vf b)
{
    vf t[4] = {r, g, b, vf_all(0)};
    vf_transpose(t);
    for (int k = 0; k < 4; k++)
        vf_store(rgba + 4 * k, vf_load(rgba + 4 * k) + t[k]);
}
#endif

static inline void store_split(float *point, int rest, vd x)
{
    vd_store_floats(point, x);
    vd_store_floats(point + rest, x - vd_load_floats(point));
}

static void lanes_points(double v, int size, int first, int stride,
                         float *point)
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
    /* 2 - q is less than q just where q > 1. */
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
    /* From four coefficients of each texel to vectors of each coefficient. */
    vf c[4];
    for (int i = 0; i < 4; i++)
        c[i] = load_pieces(lobe->coef, piece + i);
    vf_transpose(c);
    return vf_fma(vf_fma(vf_fma(c[3], x, c[2]), x, c[1]), x, c[0]);
}

static void lanes_add(const ibl_radial *lobe, const ibl_radial_light *lights,
                      int count, const float *point, int stride, float *rgba)
{
    const vf horizon = vf_all(2);
    for (int i = 0; i < stride; i += VF) {
        vf p[6], r = vf_all(0), g = r, b = r;
        for (int k = 0; k < 6; k++)
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

void IBL_FOR_ISA(ibl_radial_init)(ibl_radial_dsp *dsp)
{
    *dsp = (ibl_radial_dsp){lanes_points, lanes_add};
}
