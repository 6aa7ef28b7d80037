/* SPDX-License-Identifier: MIT */
#include <immintrin.h>

#include "kern/halves.h"

static __m256 widen(const unsigned char *src)
{
    return _mm256_cvtph_ps(_mm_loadu_si128((const __m128i *)src));
}

void ibl_halves_avx2(const unsigned char *const plane[3], int count, float *dst)
{
    /* Every lane goes where it belongs in one of three vectors. */
    const __m256i at_r = _mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5);
    const __m256i at_g = _mm256_setr_epi32(5, 0, 3, 6, 1, 4, 7, 2);
    const __m256i at_b = _mm256_setr_epi32(2, 5, 0, 3, 6, 1, 4, 7);
    int i = 0;

    for (; i + 8 <= count; i += 8, dst += 24) {
        const __m256 r =
            _mm256_permutevar8x32_ps(widen(plane[0] + 2 * i), at_r);
        const __m256 g =
            _mm256_permutevar8x32_ps(widen(plane[1] + 2 * i), at_g);
        const __m256 b =
            _mm256_permutevar8x32_ps(widen(plane[2] + 2 * i), at_b);
        _mm256_storeu_ps(dst,
                         _mm256_blend_ps(_mm256_blend_ps(r, g, 0x92), b, 0x24));
        _mm256_storeu_ps(dst + 8,
                         _mm256_blend_ps(_mm256_blend_ps(r, g, 0x24), b, 0x49));
        _mm256_storeu_ps(dst + 16,
                         _mm256_blend_ps(_mm256_blend_ps(r, g, 0x49), b, 0x92));
    }
    const unsigned char *const rest[3] = {plane[0] + 2 * i, plane[1] + 2 * i,
                                          plane[2] + 2 * i};
    ibl_halves_c(rest, count - i, dst);
}
