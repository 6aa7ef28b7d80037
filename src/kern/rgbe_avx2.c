/* SPDX-License-Identifier: MIT */
#include "kern/rgbe.h"

#include <immintrin.h>
#include <string.h>

/* As the SSE2 version; its comments hold here. */
const unsigned char *ibl_rgbe_expand_avx2(const unsigned char *src, int count,
                                          unsigned char *dst)
{
    while (count > 0) {
        const int code = src[0];
        const int is_run = -(code > 128);
        const int n = code - (is_run & 128);
        const __m256i run = _mm256_set1_epi8((char)src[1]);
        const __m256i copy = _mm256_loadu_si256((const __m256i *)(src + 1));

        _mm256_storeu_si256(
            (__m256i *)dst,
            _mm256_blendv_epi8(copy, run, _mm256_set1_epi32(is_run)));
        if (n > 32) {
            if (is_run)
                memset(dst + 32, src[1], (size_t)(n - 32));
            else
                memcpy(dst + 32, src + 33, (size_t)(n - 32));
        }
        dst += n;
        count -= n;
        src += is_run ? 2 : n + 1;
    }
    return src;
}

static __m256i widen(const unsigned char *src)
{
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)src));
}

static __m256 scale_by(__m256i m, __m256 unit, __m256 scale)
{
    const __m256 base = _mm256_set1_ps(32768.0f);
    const __m256 f = _mm256_sub_ps(
        _mm256_castsi256_ps(_mm256_or_si256(m, _mm256_castps_si256(base))),
        base);
    return _mm256_mul_ps(_mm256_mul_ps(f, unit), scale);
}

/* 2^(e - 128): the larger of the normal float's bits, negative for e = 0,
 * and those of the denormal that e = 1 needs. */
static __m256 unit_of(__m256i e)
{
    const __m256i normal =
        _mm256_sub_epi32(_mm256_slli_epi32(e, 23), _mm256_set1_epi32(1 << 23));
    return _mm256_castsi256_ps(
        _mm256_max_epi32(normal, _mm256_slli_epi32(e, 22)));
}

/* Eight R, G, B each to 24 floats: every lane of each is put where it goes,
 * then blended. */
static void store_rgb(float *dst, __m256 r, __m256 g, __m256 b)
{
    const __m256i at_r = _mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5);
    const __m256i at_g = _mm256_setr_epi32(5, 0, 3, 6, 1, 4, 7, 2);
    const __m256i at_b = _mm256_setr_epi32(2, 5, 0, 3, 6, 1, 4, 7);

    r = _mm256_permutevar8x32_ps(r, at_r); /* r0 r3 r6 r1 r4 r7 r2 r5 */
    g = _mm256_permutevar8x32_ps(g, at_g);
    b = _mm256_permutevar8x32_ps(b, at_b);
    _mm256_storeu_ps(dst,
                     _mm256_blend_ps(_mm256_blend_ps(r, g, 0x92), b, 0x24));
    _mm256_storeu_ps(dst + 8,
                     _mm256_blend_ps(_mm256_blend_ps(r, g, 0x24), b, 0x49));
    _mm256_storeu_ps(dst + 16,
                     _mm256_blend_ps(_mm256_blend_ps(r, g, 0x49), b, 0x92));
}

void ibl_rgbe_to_rgb_avx2(const unsigned char *src, size_t plane_bytes,
                          int count, const float scale[3], float *dst)
{
    const __m256 sr = _mm256_set1_ps(scale[0]);
    const __m256 sg = _mm256_set1_ps(scale[1]);
    const __m256 sb = _mm256_set1_ps(scale[2]);
    int i = 0;

    for (; i + 8 <= count; i += 8) {
        const unsigned char *p = src + i;
        const __m256 unit = unit_of(widen(p + 3 * plane_bytes));
        store_rgb(dst + 3 * i, scale_by(widen(p), unit, sr),
                  scale_by(widen(p + plane_bytes), unit, sg),
                  scale_by(widen(p + 2 * plane_bytes), unit, sb));
    }
    ibl_rgbe_to_rgb_c(src + i, plane_bytes, count - i, scale, dst + 3 * i);
}
