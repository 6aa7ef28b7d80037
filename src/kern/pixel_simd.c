/* SPDX-License-Identifier: MIT */
#include "kern/pixel.h"

#include <immintrin.h>
#include <string.h>

#if defined(__AVX512F__)

/* As AVX2 below, sixteen at once; masked loads and stores end the rows. */

static __m256i encode16(__m512 v, size_t *beyond)
{
    const __m512 sign_bit = _mm512_set1_ps(-0.0f);
    const __m512 limit = _mm512_set1_ps(IBL_HALF_MAX);

    v = _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(v, v, _CMP_ORD_Q), v);
    const __m512 sign = _mm512_and_ps(v, sign_bit);
    const __m512 mag = _mm512_andnot_ps(sign_bit, v);
    const __mmask16 over = _mm512_cmp_ps_mask(mag, limit, _CMP_GT_OQ);
    *beyond += (size_t)__builtin_popcount(over);
    return _mm512_cvtps_ph(_mm512_or_ps(_mm512_min_ps(mag, limit), sign),
                           _MM_FROUND_TO_NEAREST_INT);
}

static size_t encode_rgba16f_simd(const float *src, size_t count, void *dst)
{
    const __m512i spread =
        _mm512_setr_epi32(0, 1, 2, 0, 3, 4, 5, 0, 6, 7, 8, 0, 9, 10, 11, 0);
    const __m512 one = _mm512_set1_ps(1);
    unsigned char *out = dst;
    size_t beyond = 0;
    for (size_t i = 0; i < count; i += 4, src += 12, out += 32) {
        const size_t n = count - i < 4 ? count - i : 4;
        const __mmask16 in = (__mmask16)((1u << (3 * n)) - 1);
        const __m512 rgb =
            _mm512_permutexvar_ps(spread, _mm512_maskz_loadu_ps(in, src));
        const __m256i texels =
            encode16(_mm512_mask_mov_ps(rgb, 0x8888, one), &beyond);
        _mm256_mask_storeu_epi64(out, (__mmask8)((1u << n) - 1), texels);
    }
    return beyond;
}

static size_t encode_rg16f_simd(const float *src, size_t count, void *dst)
{
    unsigned char *out = dst;
    size_t beyond = 0;
    for (size_t i = 0; i < count; i += 8, src += 16, out += 32) {
        const size_t n = count - i < 8 ? count - i : 8;
        const __mmask16 in = (__mmask16)((1u << (2 * n)) - 1);
        const __m512 rg = _mm512_maskz_loadu_ps(in, src);
        _mm256_mask_storeu_epi32(out, (__mmask8)((1u << n) - 1),
                                 encode16(rg, &beyond));
    }
    return beyond;
}

#elif defined(__AVX2__)

/* Halves by F16C, after the clamp that the instruction does not do. */

/* Encodes 8 floats; *beyond grows by how many were. */
static __m128i encode8(__m256 v, size_t *beyond)
{
    const __m256 sign_bit = _mm256_set1_ps(-0.0f);
    const __m256 limit = _mm256_set1_ps(IBL_HALF_MAX);

    v = _mm256_and_ps(v, _mm256_cmp_ps(v, v, _CMP_ORD_Q));
    const __m256 sign = _mm256_and_ps(v, sign_bit);
    const __m256 mag = _mm256_andnot_ps(sign_bit, v);
    const int over = _mm256_movemask_ps(_mm256_cmp_ps(mag, limit, _CMP_GT_OQ));
    *beyond += (size_t)__builtin_popcount((unsigned)over);
    return _mm256_cvtps_ph(_mm256_or_ps(_mm256_min_ps(mag, limit), sign),
                           _MM_FROUND_TO_NEAREST_INT);
}

static size_t encode_rgba16f_simd(const float *src, size_t count, void *dst)
{
    const __m256 one = _mm256_set1_ps(1);
    unsigned char *out = dst;
    size_t beyond = 0, i = 0;
    /* A load takes the next texel's red along: the last texel has none. */
    for (; i + 2 < count; i += 2, src += 6, out += 16) {
        const __m256 two =
            _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(src)),
                                 _mm_loadu_ps(src + 3), 1);
        const __m128i texels =
            encode8(_mm256_blend_ps(two, one, 0x88), &beyond);
        _mm_storeu_si128((__m128i *)(void *)out, texels);
    }
    return beyond + ibl_encode_rgba16f_c(src, count - i, out);
}

static size_t encode_rg16f_simd(const float *src, size_t count, void *dst)
{
    unsigned char *out = dst;
    size_t beyond = 0, i = 0;
    for (; i + 4 <= count; i += 4, src += 8, out += 16)
        _mm_storeu_si128((__m128i *)(void *)out,
                         encode8(_mm256_loadu_ps(src), &beyond));
    return beyond + ibl_encode_rg16f_c(src, count - i, out);
}

#else /* SSE2 */

/* Halves in SSE2 integers: the arithmetic of small_float in pixel.c, four at
 * once. */

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

static size_t encode_rgba16f_simd(const float *src, size_t count, void *dst)
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

static size_t encode_rg16f_simd(const float *src, size_t count, void *dst)
{
    unsigned char *out = dst;
    size_t beyond = 0;
    for (size_t i = 0; i < count; i += BLOCK) {
        const size_t n = count - i < BLOCK ? count - i : BLOCK;
        beyond += rg_block(src + 2 * i, n, out + 4 * i);
    }
    return beyond;
}

#endif

void IBL_FOR_ISA(ibl_pixel_init)(ibl_pixel_dsp *dsp)
{
    dsp->encode[IBL_PIXEL_RGBA16F] = encode_rgba16f_simd;
    dsp->encode[IBL_PIXEL_RG16F] = encode_rg16f_simd;
}
