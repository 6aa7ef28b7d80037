/* SPDX-License-Identifier: MIT */
#include "kern/half_planes.h"
#include "kern/lanes.h"

#if VF == 4
void IBL_FOR_ISA(ibl_half_planes_init)(ibl_half_planes_dsp *dsp)
{
    (void)dsp; /* keeps the plain versions */
}
#else

static unsigned char sum(const unsigned char *src, size_t count)
{
    __m256i sums = _mm256_setzero_si256(); /* each of 8 bytes */
    size_t i = 0;

    for (; i + 32 <= count; i += 32) {
        const __m256i v = _mm256_loadu_si256((const __m256i *)(src + i));
        sums =
            _mm256_add_epi64(sums, _mm256_sad_epu8(v, _mm256_setzero_si256()));
    }
    const __m128i two = _mm_add_epi64(_mm256_castsi256_si128(sums),
                                      _mm256_extracti128_si256(sums, 1));
    return (unsigned char)(_mm_cvtsi128_si32(two) + _mm_extract_epi16(two, 4) +
                           ibl_unzip_sum_c(src + i, count - i));
}

/* Decodes the next 32 bytes from their differences. *last is the previous byte
 * in every lane, and becomes the last of these. Adds up 2, 4, 8, 16 differences
 * first; only the addition of *last depends on earlier bytes. */
static __m256i add_up(const unsigned char *src, __m256i *last)
{
    const __m256i ends = _mm256_set1_epi8(15);
    __m256i v = _mm256_loadu_si256((const __m256i *)src);

    v = _mm256_xor_si256(v, _mm256_set1_epi8(-128));
    v = _mm256_add_epi8(v, _mm256_slli_si256(v, 1));
    v = _mm256_add_epi8(v, _mm256_slli_si256(v, 2));
    v = _mm256_add_epi8(v, _mm256_slli_si256(v, 4));
    v = _mm256_add_epi8(v, _mm256_slli_si256(v, 8));
    const __m256i low = _mm256_permute2x128_si256(v, v, 0x08);
    v = _mm256_add_epi8(v, _mm256_shuffle_epi8(low, ends));
    const __m256i high = _mm256_permute2x128_si256(v, v, 0x11);
    const __m256i bytes = _mm256_add_epi8(v, *last);
    *last = _mm256_add_epi8(*last, _mm256_shuffle_epi8(high, ends));
    return bytes;
}

static void unzip(const unsigned char *even, const unsigned char *odd,
                  size_t count, unsigned char last[2], unsigned char *dst)
{
    __m256i last_even = _mm256_set1_epi8((char)last[0]);
    __m256i last_odd = _mm256_set1_epi8((char)last[1]);
    size_t i = 0;

    for (; i + 32 <= count; i += 32) {
        const __m256i a = add_up(even + i, &last_even);
        const __m256i b = add_up(odd + i, &last_odd);
        const __m256i low = _mm256_unpacklo_epi8(a, b);
        const __m256i high = _mm256_unpackhi_epi8(a, b);
        _mm256_storeu_si256((__m256i *)(dst + 2 * i),
                            _mm256_permute2x128_si256(low, high, 0x20));
        _mm256_storeu_si256((__m256i *)(dst + 2 * i + 32),
                            _mm256_permute2x128_si256(low, high, 0x31));
    }
    last[0] = (unsigned char)_mm256_extract_epi8(last_even, 0);
    last[1] = (unsigned char)_mm256_extract_epi8(last_odd, 0);
    ibl_unzip_c(even + i, odd + i, count - i, last, dst + 2 * i);
}

/* VF halves as floats. */
static vf widen(const unsigned char *src)
{
    return _mm256_cvtph_ps(_mm_loadu_si128((const __m128i *)src));
}

static void to_rgb(const unsigned char *const plane[3], int count, float *dst)
{
    int i = 0;

    for (; i + VF < count; i += VF, dst += 3 * VF)
        vf_store_rgb(dst, widen(plane[0] + 2 * i), widen(plane[1] + 2 * i),
                     widen(plane[2] + 2 * i));
    const unsigned char *const rest[3] = {plane[0] + 2 * i, plane[1] + 2 * i,
                                          plane[2] + 2 * i};
    ibl_half_planes_c(rest, count - i, dst);
}

IBL_VECTOR_KERNEL(ibl_half_planes, sum, unzip, to_rgb)
#endif
