/* SPDX-License-Identifier: MIT */
/* Halves in SSE2 integers: the arithmetic of small_float in pixel.c, four at
 * once. */
#include <emmintrin.h>
#include <string.h>

#include "kern/pixel.h"

/* Encodes 4 floats to 4 halves in the low 16 bits of each lane, the sign bit
 * extended upward (as _mm_packs_epi32 wants it); adds -1 to a lane of *beyond
 * where a value was. */
static __m128i encode4(__m128 v, __m128i *beyond)
{
    const __m128 sign_bit = _mm_set1_ps(-0.0f);
    const __m128 limit = _mm_set1_ps(IBL_HALF_MAX);

    v = _mm_and_ps(v, _mm_cmpord_ps(v, v));
    const __m128 sign = _mm_and_ps(v, sign_bit);
    __m128 mag = _mm_andnot_ps(sign_bit, v);
    *beyond =
        _mm_add_epi32(*beyond, _mm_castps_si128(_mm_cmpgt_ps(mag, limit)));
    mag = _mm_min_ps(mag, limit);

    const __m128i bits = _mm_castps_si128(mag);
    const __m128i odd =
        _mm_and_si128(_mm_srli_epi32(bits, 13), _mm_set1_epi32(1));
    __m128i normal = _mm_add_epi32(_mm_add_epi32(bits, odd),
                                   _mm_set1_epi32(0xFFF - (112 << 23)));
    normal = _mm_srli_epi32(normal, 13);

    /* 0.5's last bit is 2^-24, the unit of the denormal halves. */
    const __m128 half = _mm_set1_ps(0.5f);
    const __m128i denormal = _mm_sub_epi32(
        _mm_castps_si128(_mm_add_ps(mag, half)), _mm_castps_si128(half));
    const __m128i small = _mm_cmplt_epi32(bits, _mm_set1_epi32(0x38800000));
    const __m128i magnitude = _mm_or_si128(_mm_and_si128(small, denormal),
                                           _mm_andnot_si128(small, normal));
    return _mm_or_si128(magnitude, _mm_srai_epi32(_mm_castps_si128(sign), 16));
}

static size_t sum_beyond(__m128i beyond)
{
    int lanes[4];
    memcpy(lanes, &beyond, sizeof lanes);
    return (size_t)(-(lanes[0] + lanes[1] + lanes[2] + lanes[3]));
}

enum {
    BLOCK = 1 << 24 /* texels for which the 32-bit counts cannot overflow */
};

static size_t rgba_block(const float *src, size_t count, unsigned char *dst)
{
    const __m128 rgb_mask = _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0));
    const __m128 alpha = _mm_setr_ps(0, 0, 0, 1);
    __m128i beyond = _mm_setzero_si128();
    size_t i = 0;
    /* A load takes the next texel's red along: the last texel has none. */
    for (; i + 1 < count; i++, src += 3, dst += 8) {
        const __m128 rgb = _mm_and_ps(_mm_loadu_ps(src), rgb_mask);
        const __m128i texel = encode4(_mm_or_ps(rgb, alpha), &beyond);
        _mm_storel_epi64((__m128i *)(void *)dst, _mm_packs_epi32(texel, texel));
    }
    return sum_beyond(beyond) + ibl_encode_rgba16f_c(src, count - i, dst);
}

size_t ibl_encode_rgba16f_sse2(const float *src, size_t count, void *dst)
{
    unsigned char *out = dst;
    size_t beyond = 0;
    for (size_t i = 0; i < count; i += BLOCK) {
        const size_t n = count - i < BLOCK ? count - i : BLOCK;
        beyond += rgba_block(src + 3 * i, n, out + 8 * i);
    }
    return beyond;
}

static size_t rg_block(const float *src, size_t count, unsigned char *dst)
{
    __m128i beyond = _mm_setzero_si128();
    size_t i = 0;
    for (; i + 4 <= count; i += 4, src += 8, dst += 16) {
        const __m128i low = encode4(_mm_loadu_ps(src), &beyond);
        const __m128i high = encode4(_mm_loadu_ps(src + 4), &beyond);
        _mm_storeu_si128((__m128i *)(void *)dst, _mm_packs_epi32(low, high));
    }
    return sum_beyond(beyond) + ibl_encode_rg16f_c(src, count - i, dst);
}

size_t ibl_encode_rg16f_sse2(const float *src, size_t count, void *dst)
{
    unsigned char *out = dst;
    size_t beyond = 0;
    for (size_t i = 0; i < count; i += BLOCK) {
        const size_t n = count - i < BLOCK ? count - i : BLOCK;
        beyond += rg_block(src + 2 * i, n, out + 4 * i);
    }
    return beyond;
}
