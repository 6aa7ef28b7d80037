/* SPDX-License-Identifier: MIT */
#include "kern/rgbe.h"

#include <emmintrin.h>
#include <string.h>

/*
 * Runs and literals alternate without a pattern that a branch predictor could
 * learn, and most are short: both are made, one is kept by a mask, 32 bytes
 * at once, and only what is longer branches.
 */
const unsigned char *ibl_rgbe_expand_sse2(const unsigned char *src, int count,
                                          unsigned char *dst)
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

void ibl_rgbe_to_rgb_sse2(const unsigned char *src, size_t plane_bytes,
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
