/* SPDX-License-Identifier: MIT */
/* As pixel_avx2.c, sixteen at once; masked loads and stores end the rows. */
#include <immintrin.h>

#include "kern/pixel.h"

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

size_t ibl_encode_rgba16f_avx512(const float *src, size_t count, void *dst)
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

size_t ibl_encode_rg16f_avx512(const float *src, size_t count, void *dst)
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
