/* SPDX-License-Identifier: MIT */
#include "kern/most.h"

#include <immintrin.h>

#if defined(__AVX512F__)

static uint32_t most_simd(const float *src, size_t count)
{
    __m512i a = _mm512_setzero_si512(), b = a, c = a, d = a;
    uint32_t most, rest;
    size_t i = 0;

    for (; i + 64 <= count; i += 64) {
        a = _mm512_max_epu32(a, _mm512_loadu_si512(src + i));
        b = _mm512_max_epu32(b, _mm512_loadu_si512(src + i + 16));
        c = _mm512_max_epu32(c, _mm512_loadu_si512(src + i + 32));
        d = _mm512_max_epu32(d, _mm512_loadu_si512(src + i + 48));
    }
    a = _mm512_max_epu32(_mm512_max_epu32(a, b), _mm512_max_epu32(c, d));
    most = _mm512_reduce_max_epu32(a);
    rest = ibl_most_c(src + i, count - i);
    return rest > most ? rest : most;
}

#elif defined(__AVX2__)

static __m256i load(const float *p)
{
    return _mm256_loadu_si256((const __m256i *)p);
}

static uint32_t most_simd(const float *src, size_t count)
{
    __m256i a = _mm256_setzero_si256(), b = a, c = a, d = a;
    uint32_t lane[8], most;
    size_t i = 0;

    for (; i + 32 <= count; i += 32) {
        a = _mm256_max_epu32(a, load(src + i));
        b = _mm256_max_epu32(b, load(src + i + 8));
        c = _mm256_max_epu32(c, load(src + i + 16));
        d = _mm256_max_epu32(d, load(src + i + 24));
    }
    a = _mm256_max_epu32(_mm256_max_epu32(a, b), _mm256_max_epu32(c, d));
    _mm256_storeu_si256((__m256i *)lane, a);
    most = ibl_most_c(src + i, count - i);
    for (int k = 0; k < 8; k++)
        most = lane[k] > most ? lane[k] : most;
    return most;
}

#else /* SSE2 */

static __m128i larger(__m128i a, __m128i b)
{
    const __m128i is_a = _mm_cmpgt_epi32(a, b);
    return _mm_or_si128(_mm_and_si128(is_a, a), _mm_andnot_si128(is_a, b));
}

/* The maximum of signed integers, and beside it whether one has a sign. */
static uint32_t most_simd(const float *src, size_t count)
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

#endif

void IBL_FOR_ISA(ibl_most_init)(ibl_most_dsp *dsp)
{
    dsp->most = most_simd;
}
