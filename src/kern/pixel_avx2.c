/* SPDX-License-Identifier: MIT */
/* Halves by F16C, after the clamp that the instruction does not do. */
#include <immintrin.h>

#include "kern/pixel.h"

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

size_t ibl_encode_rgba16f_avx2(const float *src, size_t count, void *dst)
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

size_t ibl_encode_rg16f_avx2(const float *src, size_t count, void *dst)
{
    unsigned char *out = dst;
    size_t beyond = 0, i = 0;
    for (; i + 4 <= count; i += 4, src += 8, out += 16)
        _mm_storeu_si128((__m128i *)(void *)out,
                         encode8(_mm256_loadu_ps(src), &beyond));
    return beyond + ibl_encode_rg16f_c(src, count - i, out);
}
