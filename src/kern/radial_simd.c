/* SPDX-License-Identifier: MIT */
/* The functions of radial.c for vectors of any width. */
#include <string.h>

#include "kern/lanes.h"
#include "kern/radial.h"

typedef int vi __attribute__((vector_size(sizeof(vf))));

/* What lanes.h lacks: zero where a lane is not less, whether any is, every
 * fourth lane's piece of a table (in fewer steps than a gather takes),
 * shuffles, and adding three vectors to VF texels of four floats. */
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

static inline vf low_pairs(vf a, vf b)
{
    return _mm512_unpacklo_ps(a, b);
}

static inline vf high_pairs(vf a, vf b)
{
    return _mm512_unpackhi_ps(a, b);
}

static inline vf low_halves(vf a, vf b)
{
    return _mm512_shuffle_ps(a, b, 0x44);
}

static inline vf high_halves(vf a, vf b)
{
    return _mm512_shuffle_ps(a, b, 0xEE);
}

static inline void add_rgb(float *rgba, vf r, vf g, vf b)
{
    const vf zero = vf_all(0);
    const vf rg0 = low_pairs(r, g), rg1 = high_pairs(r, g);
    const vf b0 = low_pairs(b, zero), b1 = high_pairs(b, zero);
    /* Texels 0 4 8 12, 1 5 9 13, ... */
    const vf t0 = low_halves(rg0, b0);
    const vf t1 = high_halves(rg0, b0);
    const vf t2 = low_halves(rg1, b1);
    const vf t3 = high_halves(rg1, b1);
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

/* Pieces at[0] and at[4]. */
static inline vf load_pieces(const float *coef, const int *at)
{
    return _mm256_insertf128_ps(
        _mm256_castps128_ps256(_mm_load_ps(coef + at[0])),
        _mm_load_ps(coef + at[4]), 1);
}

static inline vf low_pairs(vf a, vf b)
{
    return _mm256_unpacklo_ps(a, b);
}

static inline vf high_pairs(vf a, vf b)
{
    return _mm256_unpackhi_ps(a, b);
}

static inline vf low_halves(vf a, vf b)
{
    return _mm256_shuffle_ps(a, b, 0x44);
}

static inline vf high_halves(vf a, vf b)
{
    return _mm256_shuffle_ps(a, b, 0xEE);
}

static inline void add_rgb(float *rgba, vf r, vf g, vf b)
{
    const vf zero = vf_all(0);
    const vf rg0 = low_pairs(r, g), rg1 = high_pairs(r, g);
    const vf b0 = low_pairs(b, zero), b1 = high_pairs(b, zero);
    /* Texels 0 4, 1 5, 2 6, 3 7. */
    const vf t0 = low_halves(rg0, b0);
    const vf t1 = high_halves(rg0, b0);
    const vf t2 = low_halves(rg1, b1);
    const vf t3 = high_halves(rg1, b1);
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

static inline vf load_pieces(const float *coef, const int *at)
{
    return _mm_load_ps(coef + at[0]);
}

static inline vf low_pairs(vf a, vf b)
{
    return _mm_unpacklo_ps(a, b);
}

static inline vf high_pairs(vf a, vf b)
{
    return _mm_unpackhi_ps(a, b);
}

static inline vf low_halves(vf a, vf b)
{
    return _mm_shuffle_ps(a, b, 0x44);
}

static inline vf high_halves(vf a, vf b)
{
    return _mm_shuffle_ps(a, b, 0xEE);
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
    const vf v = vf_max((vf)(((vi)other & far) | ((vi)q & ~far)), vf_all(0));
    const vf start = (vf)(((vi)vf_all(lobe->start[1]) & far) |
                          ((vi)vf_all(lobe->start[0]) & ~far));
    const vi base = (lobe->base[1] & far) | (lobe->base[0] & ~far);
    const vi word = (vi)(v + start);
    const vi at = ((word >> shift) - base) << 2;
    const vf x = __builtin_convertvector(word & ((1 << shift) - 1), vf) *
                 (1 / (float)(1 << shift));
    int piece[VF];
    memcpy(piece, &at, sizeof piece);
    const vf p0 = load_pieces(lobe->coef, piece);
    const vf p1 = load_pieces(lobe->coef, piece + 1);
    const vf p2 = load_pieces(lobe->coef, piece + 2);
    const vf p3 = load_pieces(lobe->coef, piece + 3);
    /* From four coefficients of each texel to vectors of each coefficient. */
    const vf a = low_pairs(p0, p1), b = low_pairs(p2, p3);
    const vf c = high_pairs(p0, p1), d = high_pairs(p2, p3);
    vf k = vf_fma(high_halves(c, d), x, low_halves(c, d));
    k = vf_fma(k, x, high_halves(a, b));
    return vf_fma(k, x, low_halves(a, b));
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
