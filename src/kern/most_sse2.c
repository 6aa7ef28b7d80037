/* SPDX-License-Identifier: MIT */
#include <emmintrin.h>

#include "kern/most.h"

static __m128i larger(__m128i a, __m128i b)
{
    const __m128i is_a = _mm_cmpgt_epi32(a, b);
    return _mm_or_si128(_mm_and_si128(is_a, a), _mm_andnot_si128(is_a, b));
}

/* The maximum of signed integers, and beside it whether one has a sign. */
uint32_t ibl_most_sse2(const float *src, size_t count)
{
    __m128i most[2] = {_mm_setzero_si128(), _mm_setzero_si128()};
    __m128i all = _mm_setzero_si128();
    uint32_t lane[4], result;
    size_t i = 0;

    for (; i + 8 <= count; i += 8) {
        const __m128i *p = (const __m128i *)(src + i);
        const __m128i a = _mm_loadu_si128(p), b = _mm_loadu_si128(p + 1);
        most[0] = larger(a, most[0]);
        most[1] = larger(b, most[1]);
        all = _mm_or_si128(all, _mm_or_si128(a, b));
    }
    result = ibl_most_c(src + i, count - i);
    if (_mm_movemask_ps(_mm_castsi128_ps(all)))
        return 0x80000000u;
    _mm_storeu_si128((__m128i *)lane, larger(most[0], most[1]));
    for (int k = 0; k < 4; k++)
        result = lane[k] > result ? lane[k] : result;
    return result;
}
