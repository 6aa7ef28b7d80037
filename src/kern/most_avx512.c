/* SPDX-License-Identifier: MIT */
#include <immintrin.h>

#include "kern/most.h"

uint32_t ibl_most_avx512(const float *src, size_t count)
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
