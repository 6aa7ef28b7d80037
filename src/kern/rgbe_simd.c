/* SPDX-License-Identifier: MIT */
#include "kern/rgbe.h"

#include <string.h>

#include "kern/lanes.h"

enum {
    BLOCK = VF == 16 ? 64 : 32 /* bytes that are expanded at once */
};

/* A vector of bytes anywhere. */
typedef int bytes
    __attribute__((vector_size(sizeof(vi)), aligned(1), may_alias));

/*
 * Runs and literals alternate without a pattern that a branch predictor could
 * learn, and most are short: both are made, one is kept by a mask, a block of
 * bytes at once, and only what is longer branches.
 */
static const unsigned char *expand(const unsigned char *src, int count,
                                   unsigned char *dst)
{
    while (count > 0) {
        const int code = src[0];
        const int is_run = -(code > 128);
        const int n = code - (is_run & 128);
        const vi run = (vi){0} + ((int)(src[1] * 0x01010101u) & is_run);
        for (size_t k = 0; k < BLOCK; k += sizeof(vi))
            *(bytes *)(dst + k) =
                run | (*(const bytes *)(src + 1 + k) & ~is_run);
        if (n > BLOCK) {
            if (is_run)
                memset(dst + BLOCK, src[1], (size_t)(n - BLOCK));
            else
                memcpy(dst + BLOCK, src + 1 + BLOCK, (size_t)(n - BLOCK));
        }
        dst += n;
        count -= n;
        src += is_run ? 2 : n + 1;
    }
    return src;
}

/* VF bytes; and VF R, G and B each to floats R G B R G B ... */
#if VF == 16
static vi widen(const unsigned char *src)
{
    return (vi)_mm512_cvtepu8_epi32(_mm_loadu_si128((const __m128i *)src));
}

/* Sixteen R, G, B each to 48 floats: R and G by one permutation (G is 16 and
 * up), then B put in between. */
static void store_rgb(float *dst, __m512 r, __m512 g, __m512 b)
{
    const __m512i rg0 =
        _mm512_setr_epi32(0, 16, 0, 1, 17, 0, 2, 18, 0, 3, 19, 0, 4, 20, 0, 5);
    const __m512i rg1 = _mm512_setr_epi32(21, 0, 6, 22, 0, 7, 23, 0, 8, 24, 0,
                                          9, 25, 0, 10, 26);
    const __m512i rg2 = _mm512_setr_epi32(0, 11, 27, 0, 12, 28, 0, 13, 29, 0,
                                          14, 30, 0, 15, 31, 0);
    const __m512i b0 =
        _mm512_setr_epi32(0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0);
    const __m512i b1 =
        _mm512_setr_epi32(0, 5, 0, 0, 6, 0, 0, 7, 0, 0, 8, 0, 0, 9, 0, 0);
    const __m512i b2 =
        _mm512_setr_epi32(10, 0, 0, 11, 0, 0, 12, 0, 0, 13, 0, 0, 14, 0, 0, 15);

    _mm512_storeu_ps(
        dst, _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(r, rg0, g),
                                        0x4924, b0, b));
    _mm512_storeu_ps(
        dst + 16, _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(r, rg1, g),
                                             0x2492, b1, b));
    _mm512_storeu_ps(
        dst + 32, _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(r, rg2, g),
                                             0x9249, b2, b));
}
#elif VF == 8
static vi widen(const unsigned char *src)
{
    return (vi)_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)src));
}

/* Eight R, G, B each to 24 floats: every lane of each is put where it goes,
 * then blended. */
static void store_rgb(float *dst, __m256 r, __m256 g, __m256 b)
{
    const __m256i at_r = _mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5);
    const __m256i at_g = _mm256_setr_epi32(5, 0, 3, 6, 1, 4, 7, 2);
    const __m256i at_b = _mm256_setr_epi32(2, 5, 0, 3, 6, 1, 4, 7);

    r = _mm256_permutevar8x32_ps(r, at_r); /* r0 r3 r6 r1 r4 r7 r2 r5 */
    g = _mm256_permutevar8x32_ps(g, at_g);
    b = _mm256_permutevar8x32_ps(b, at_b);
    _mm256_storeu_ps(dst,
                     _mm256_blend_ps(_mm256_blend_ps(r, g, 0x92), b, 0x24));
    _mm256_storeu_ps(dst + 8,
                     _mm256_blend_ps(_mm256_blend_ps(r, g, 0x24), b, 0x49));
    _mm256_storeu_ps(dst + 16,
                     _mm256_blend_ps(_mm256_blend_ps(r, g, 0x49), b, 0x92));
}
#else
static vi widen(const unsigned char *src)
{
    const __m128i zero = _mm_setzero_si128();
    int four;

    memcpy(&four, src, sizeof four);
    return (vi)_mm_unpacklo_epi16(
        _mm_unpacklo_epi8(_mm_cvtsi32_si128(four), zero), zero);
}

/* Four R, G, B each to twelve floats R G B R G B ... */
static void store_rgb(float *dst, __m128 r, __m128 g, __m128 b)
{
    const __m128 rg_lo = _mm_unpacklo_ps(r, g);          /* r0 g0 r1 g1 */
    const __m128 rg_hi = _mm_unpackhi_ps(r, g);          /* r2 g2 r3 g3 */
    const __m128 b0_r1 = _mm_shuffle_ps(b, rg_lo, 0x20); /* b0 b0 r1 r1' */
    const __m128 b1_g1 = _mm_shuffle_ps(rg_lo, b, 0x13); /* g1 r0 b1 b0 */
    const __m128 b2_r3 = _mm_shuffle_ps(b, rg_hi, 0x22); /* b2 b0 r3 r2 */
    const __m128 g3_b3 = _mm_shuffle_ps(rg_hi, b, 0x33); /* g3 r2 b3 b0 */

    _mm_storeu_ps(dst, _mm_shuffle_ps(rg_lo, b0_r1, 0x84));
    _mm_storeu_ps(dst + 4, _mm_shuffle_ps(b1_g1, rg_hi, 0x48));
    _mm_storeu_ps(dst + 8, _mm_shuffle_ps(b2_r3, g3_b3, 0x88));
}
#endif

/*
 * m / 256 without a conversion: m under the exponent of 2^15 is 2^15 + m / 256.
 * Then times 2^(e - 128), which is a float for every e.
 */
static vf scale_by(vi m, vf unit, vf scale)
{
    const vf base = vf_all(32768);
    return ((vf)(m | (vi)base) - base) * unit * scale;
}

/* 2^(e - 128): the larger of the normal float's bits, negative for e = 0,
 * and those of the denormal that e = 1 needs. */
static vf unit_of(vi e)
{
    const vi normal = (e << 23) - (1 << 23), denormal = e << 22;
    return (vf)vi_max(normal, denormal);
}

static void to_rgb(const unsigned char *src, size_t plane_bytes, int count,
                   const float scale[3], float *dst)
{
    const vf r = vf_all(scale[0]), g = vf_all(scale[1]), b = vf_all(scale[2]);
    int i = 0;

    for (; i + VF <= count; i += VF) {
        const unsigned char *p = src + i;
        const vf unit = unit_of(widen(p + 3 * plane_bytes));
        store_rgb(dst + 3 * i, scale_by(widen(p), unit, r),
                  scale_by(widen(p + plane_bytes), unit, g),
                  scale_by(widen(p + 2 * plane_bytes), unit, b));
    }
    ibl_rgbe_to_rgb_c(src + i, plane_bytes, count - i, scale, dst + 3 * i);
}

void IBL_FOR_ISA(ibl_rgbe_init)(ibl_rgbe_dsp *dsp)
{
    *dsp = (ibl_rgbe_dsp){expand, to_rgb};
}
