/* SPDX-License-Identifier: MIT */
#include "kern/rgbe.h"

#include <immintrin.h>
#include <string.h>

#if defined(__AVX512F__)

/* As SSE2 below, 64 bytes at once; its comments hold here. */
static const unsigned char *rgbe_expand_simd(const unsigned char *src,
                                             int count, unsigned char *dst)
{
    while (count > 0) {
        const int code = src[0];
        const int is_run = -(code > 128);
        const int n = code - (is_run & 128);
        const __mmask64 mask = _cvtu64_mask64((unsigned long long)is_run);
        const __m512i copy = _mm512_loadu_si512(src + 1);

        _mm512_storeu_si512(dst,
                            _mm512_mask_set1_epi8(copy, mask, (char)src[1]));
        if (n > 64) {
            if (is_run)
                memset(dst + 64, src[1], (size_t)(n - 64));
            else
                memcpy(dst + 64, src + 65, (size_t)(n - 64));
        }
        dst += n;
        count -= n;
        src += is_run ? 2 : n + 1;
    }
    return src;
}

static __m512i widen(const unsigned char *src)
{
    return _mm512_cvtepu8_epi32(_mm_loadu_si128((const __m128i *)src));
}

static __m512 scale_by(__m512i m, __m512 unit, __m512 scale)
{
    const __m512 base = _mm512_set1_ps(32768.0f);
    const __m512 f = _mm512_sub_ps(
        _mm512_castsi512_ps(_mm512_or_si512(m, _mm512_castps_si512(base))),
        base);
    return _mm512_mul_ps(_mm512_mul_ps(f, unit), scale);
}

static __m512 unit_of(__m512i e)
{
    const __m512i normal =
        _mm512_sub_epi32(_mm512_slli_epi32(e, 23), _mm512_set1_epi32(1 << 23));
    return _mm512_castsi512_ps(
        _mm512_max_epi32(normal, _mm512_slli_epi32(e, 22)));
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

static void rgbe_to_rgb_simd(const unsigned char *src, size_t plane_bytes,
                             int count, const float scale[3], float *dst)
{
    const __m512 sr = _mm512_set1_ps(scale[0]);
    const __m512 sg = _mm512_set1_ps(scale[1]);
    const __m512 sb = _mm512_set1_ps(scale[2]);
    int i = 0;

    for (; i + 16 <= count; i += 16) {
        const unsigned char *p = src + i;
        const __m512 unit = unit_of(widen(p + 3 * plane_bytes));
        store_rgb(dst + 3 * i, scale_by(widen(p), unit, sr),
                  scale_by(widen(p + plane_bytes), unit, sg),
                  scale_by(widen(p + 2 * plane_bytes), unit, sb));
    }
    ibl_rgbe_to_rgb_c(src + i, plane_bytes, count - i, scale, dst + 3 * i);
}

#elif defined(__AVX2__)

/* As SSE2 below; its comments hold here. */
static const unsigned char *rgbe_expand_simd(const unsigned char *src,
                                             int count, unsigned char *dst)
{
    while (count > 0) {
        const int code = src[0];
        const int is_run = -(code > 128);
        const int n = code - (is_run & 128);
        const __m256i run = _mm256_set1_epi8((char)src[1]);
        const __m256i copy = _mm256_loadu_si256((const __m256i *)(src + 1));

        _mm256_storeu_si256(
            (__m256i *)dst,
            _mm256_blendv_epi8(copy, run, _mm256_set1_epi32(is_run)));
        if (n > 32) {
            if (is_run)
                memset(dst + 32, src[1], (size_t)(n - 32));
            else
                memcpy(dst + 32, src + 33, (size_t)(n - 32));
        }
        dst += n;
        count -= n;
        src += is_run ? 2 : n + 1;
    }
    return src;
}

static __m256i widen(const unsigned char *src)
{
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)src));
}

static __m256 scale_by(__m256i m, __m256 unit, __m256 scale)
{
    const __m256 base = _mm256_set1_ps(32768.0f);
    const __m256 f = _mm256_sub_ps(
        _mm256_castsi256_ps(_mm256_or_si256(m, _mm256_castps_si256(base))),
        base);
    return _mm256_mul_ps(_mm256_mul_ps(f, unit), scale);
}

/* 2^(e - 128): the larger of the normal float's bits, negative for e = 0,
 * and those of the denormal that e = 1 needs. */
static __m256 unit_of(__m256i e)
{
    const __m256i normal =
        _mm256_sub_epi32(_mm256_slli_epi32(e, 23), _mm256_set1_epi32(1 << 23));
    return _mm256_castsi256_ps(
        _mm256_max_epi32(normal, _mm256_slli_epi32(e, 22)));
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

static void rgbe_to_rgb_simd(const unsigned char *src, size_t plane_bytes,
                             int count, const float scale[3], float *dst)
{
    const __m256 sr = _mm256_set1_ps(scale[0]);
    const __m256 sg = _mm256_set1_ps(scale[1]);
    const __m256 sb = _mm256_set1_ps(scale[2]);
    int i = 0;

    for (; i + 8 <= count; i += 8) {
        const unsigned char *p = src + i;
        const __m256 unit = unit_of(widen(p + 3 * plane_bytes));
        store_rgb(dst + 3 * i, scale_by(widen(p), unit, sr),
                  scale_by(widen(p + plane_bytes), unit, sg),
                  scale_by(widen(p + 2 * plane_bytes), unit, sb));
    }
    ibl_rgbe_to_rgb_c(src + i, plane_bytes, count - i, scale, dst + 3 * i);
}

#else /* SSE2 */

/*
 * Runs and literals alternate without a pattern that a branch predictor could
 * learn, and most are short: both are made, one is kept by a mask, 32 bytes
 * at once, and only what is longer branches.
 */
static const unsigned char *rgbe_expand_simd(const unsigned char *src,
                                             int count, unsigned char *dst)
{
    while (count > 0) {
        const int code = src[0];
        const int is_run = -(code > 128);
        const int n = code - (is_run & 128);
        const __m128i mask = _mm_set1_epi32(is_run);
        const __m128i run = _mm_and_si128(mask, _mm_set1_epi8((char)src[1]));
        const __m128i a = _mm_loadu_si128((const __m128i *)(src + 1));
        const __m128i b = _mm_loadu_si128((const __m128i *)(src + 17));

        _mm_storeu_si128((__m128i *)dst,
                         _mm_or_si128(run, _mm_andnot_si128(mask, a)));
        _mm_storeu_si128((__m128i *)(dst + 16),
                         _mm_or_si128(run, _mm_andnot_si128(mask, b)));
        if (n > 32) {
            if (is_run)
                memset(dst + 32, src[1], (size_t)(n - 32));
            else
                memcpy(dst + 32, src + 33, (size_t)(n - 32));
        }
        dst += n;
        count -= n;
        src += is_run ? 2 : n + 1;
    }
    return src;
}

/*
 * m / 256 without a conversion: m under the exponent of 2^15 is 2^15 + m / 256.
 * Then times 2^(e - 128), which is a float for every e.
 */
static __m128 scale_by(__m128i m_hi, __m128 unit, __m128 scale)
{
    const __m128 m = _mm_sub_ps(_mm_castsi128_ps(m_hi), _mm_set1_ps(32768.0f));
    return _mm_mul_ps(_mm_mul_ps(m, unit), scale);
}

/* 2^(e - 128), 0 for e = 0; e = 1 is the denormal 2^-127. */
static __m128 unit_of(__m128i e)
{
    const __m128i one = _mm_set1_epi32(1);
    const __m128i above = _mm_cmpgt_epi32(e, one);
    const __m128i normal = _mm_slli_epi32(_mm_sub_epi32(e, one), 23);
    const __m128i low = _mm_slli_epi32(e, 22);
    return _mm_castsi128_ps(_mm_or_si128(_mm_and_si128(above, normal),
                                         _mm_andnot_si128(above, low)));
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

static void rgbe_to_rgb_simd(const unsigned char *src, size_t plane_bytes,
                             int count, const float scale[3], float *dst)
{
    const __m128i zero = _mm_setzero_si128();
    const __m128i top = _mm_set1_epi16(0x4700); /* of 2^15 */
    __m128 s[3];
    int i = 0;

    for (int c = 0; c < 3; c++)
        s[c] = _mm_set1_ps(scale[c]);
    for (; i + 8 <= count; i += 8) {
        __m128i bytes[4];
        for (int c = 0; c < 4; c++)
            bytes[c] = _mm_unpacklo_epi8(
                _mm_loadl_epi64((const __m128i *)(src + c * plane_bytes + i)),
                zero);
        __m128 unit = unit_of(_mm_unpacklo_epi16(bytes[3], zero));
        store_rgb(dst + 3 * i,
                  scale_by(_mm_unpacklo_epi16(bytes[0], top), unit, s[0]),
                  scale_by(_mm_unpacklo_epi16(bytes[1], top), unit, s[1]),
                  scale_by(_mm_unpacklo_epi16(bytes[2], top), unit, s[2]));
        unit = unit_of(_mm_unpackhi_epi16(bytes[3], zero));
        store_rgb(dst + 3 * i + 12,
                  scale_by(_mm_unpackhi_epi16(bytes[0], top), unit, s[0]),
                  scale_by(_mm_unpackhi_epi16(bytes[1], top), unit, s[1]),
                  scale_by(_mm_unpackhi_epi16(bytes[2], top), unit, s[2]));
    }
    ibl_rgbe_to_rgb_c(src + i, plane_bytes, count - i, scale, dst + 3 * i);
}

#endif

void IBL_FOR_ISA(ibl_rgbe_init)(ibl_rgbe_dsp *dsp)
{
    *dsp = (ibl_rgbe_dsp){rgbe_expand_simd, rgbe_to_rgb_simd};
}
