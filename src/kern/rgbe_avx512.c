/* SPDX-License-Identifier: MIT */
#include "kern/rgbe.h"

#include <immintrin.h>
#include <string.h>

/* As the SSE2 version, but 64 bytes at once; its comments hold here. */
const unsigned char *ibl_rgbe_expand_avx512(const unsigned char *src, int count,
                                            unsigned char *dst)
{
    while (count > 0) {
        const int code = src[0];
        const int is_run = -(code > 128);
        const int n = code - (is_run & 128);
        const __mmask64 mask = _cvtu64_mask64((unsigned long long)is_run);
        const __m512i copy = _mm512_loadu_si512(src + 1);

        _mm512_storeu_si512(dst,
                            _mm512_mask_set1_epi8(copy, mask, (char)src[1]));
        if (n > 64) {
            if (is_run)
                memset(dst + 64, src[1], (size_t)(n - 64));
            else
                memcpy(dst + 64, src + 65, (size_t)(n - 64));
        }
        dst += n;
        count -= n;
        src += is_run ? 2 : n + 1;
    }
    return src;
}

static __m512i widen(const unsigned char *src)
{
    return _mm512_cvtepu8_epi32(_mm_loadu_si128((const __m128i *)src));
}

static __m512 scale_by(__m512i m, __m512 unit, __m512 scale)
{
    const __m512 base = _mm512_set1_ps(32768.0f);
    const __m512 f = _mm512_sub_ps(
        _mm512_castsi512_ps(_mm512_or_si512(m, _mm512_castps_si512(base))),
        base);
    return _mm512_mul_ps(_mm512_mul_ps(f, unit), scale);
}

static __m512 unit_of(__m512i e)
{
    const __m512i normal =
        _mm512_sub_epi32(_mm512_slli_epi32(e, 23), _mm512_set1_epi32(1 << 23));
    return _mm512_castsi512_ps(
        _mm512_max_epi32(normal, _mm512_slli_epi32(e, 22)));
}

/* Sixteen R, G, B each to 48 floats: R and G by one permutation (G is 16 and
 * up), then B put in between. */
static void store_rgb(float *dst, __m512 r, __m512 g, __m512 b)
{
    const __m512i rg0 =
        _mm512_setr_epi32(0, 16, 0, 1, 17, 0, 2, 18, 0, 3, 19, 0, 4, 20, 0, 5);
    const __m512i rg1 = _mm512_setr_epi32(21, 0, 6, 22, 0, 7, 23, 0, 8, 24, 0,
                                          9, 25, 0, 10, 26);
    const __m512i rg2 = _mm512_setr_epi32(0, 11, 27, 0, 12, 28, 0, 13, 29, 0,
                                          14, 30, 0, 15, 31, 0);
    const __m512i b0 =
        _mm512_setr_epi32(0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0);
    const __m512i b1 =
        _mm512_setr_epi32(0, 5, 0, 0, 6, 0, 0, 7, 0, 0, 8, 0, 0, 9, 0, 0);
    const __m512i b2 =
        _mm512_setr_epi32(10, 0, 0, 11, 0, 0, 12, 0, 0, 13, 0, 0, 14, 0, 0, 15);

    _mm512_storeu_ps(
        dst, _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(r, rg0, g),
                                        0x4924, b0, b));
    _mm512_storeu_ps(
        dst + 16, _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(r, rg1, g),
                                             0x2492, b1, b));
    _mm512_storeu_ps(
        dst + 32, _mm512_mask_permutexvar_ps(_mm512_permutex2var_ps(r, rg2, g),
                                             0x9249, b2, b));
}

void ibl_rgbe_to_rgb_avx512(const unsigned char *src, size_t plane_bytes,
                            int count, const float scale[3], float *dst)
{
    const __m512 sr = _mm512_set1_ps(scale[0]);
    const __m512 sg = _mm512_set1_ps(scale[1]);
    const __m512 sb = _mm512_set1_ps(scale[2]);
    int i = 0;

    for (; i + 16 <= count; i += 16) {
        const unsigned char *p = src + i;
        const __m512 unit = unit_of(widen(p + 3 * plane_bytes));
        store_rgb(dst + 3 * i, scale_by(widen(p), unit, sr),
                  scale_by(widen(p + plane_bytes), unit, sg),
                  scale_by(widen(p + 2 * plane_bytes), unit, sb));
    }
    ibl_rgbe_to_rgb_c(src + i, plane_bytes, count - i, scale, dst + 3 * i);
}
