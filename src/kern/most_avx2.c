/* SPDX-License-Identifier: MIT */
#include <immintrin.h>

#include "kern/most.h"

static __m256i load(const float *p)
{
    return _mm256_loadu_si256((const __m256i *)p);
}

uint32_t ibl_most_avx2(const float *src, size_t count)
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
