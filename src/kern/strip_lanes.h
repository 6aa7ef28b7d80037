/* SPDX-License-Identifier: MIT */
/*
 * The kernels of kern/strip.h over vectors, for the files that are compiled
 * for one instruction set each.
 *
 * Rows and lanes change places four floats at a time: a vector is made of
 * the same four floats of rows r, r + 4, ..., so that after a transposition
 * of 4 x 4 inside the 128-bit parts of four of them lane r is row r.
 */
#ifndef IBL_KERN_STRIP_LANES_H
#define IBL_KERN_STRIP_LANES_H

#include "kern/lanes.h"
#include "kern/strip.h"

#if VF == 16
/* Four floats of every fourth row, from rows[0] on. */
static inline vf quads(const float *const *rows, size_t at)
{
    const __m512 a = _mm512_castps128_ps512(_mm_loadu_ps(rows[0] + at));
    const __m512 b = _mm512_insertf32x4(a, _mm_loadu_ps(rows[4] + at), 1);
    const __m512 c = _mm512_insertf32x4(b, _mm_loadu_ps(rows[8] + at), 2);
    return _mm512_insertf32x4(c, _mm_loadu_ps(rows[12] + at), 3);
}

static inline __m128 quad_of(vf v, size_t row)
{
    switch (row / 4) {
    case 0:
        return _mm512_castps512_ps128(v);
    case 1:
        return _mm512_extractf32x4_ps(v, 1);
    case 2:
        return _mm512_extractf32x4_ps(v, 2);
    default:
        return _mm512_extractf32x4_ps(v, 3);
    }
}

static inline void transpose(vf v[4])
{
    const vf a = _mm512_unpacklo_ps(v[0], v[1]);
    const vf b = _mm512_unpackhi_ps(v[0], v[1]);
    const vf c = _mm512_unpacklo_ps(v[2], v[3]);
    const vf d = _mm512_unpackhi_ps(v[2], v[3]);
    v[0] = _mm512_shuffle_ps(a, c, 0x44);
    v[1] = _mm512_shuffle_ps(a, c, 0xEE);
    v[2] = _mm512_shuffle_ps(b, d, 0x44);
    v[3] = _mm512_shuffle_ps(b, d, 0xEE);
}
#elif VF == 8
static inline vf quads(const float *const *rows, size_t at)
{
    const __m256 a = _mm256_castps128_ps256(_mm_loadu_ps(rows[0] + at));
    return _mm256_insertf128_ps(a, _mm_loadu_ps(rows[4] + at), 1);
}

static inline __m128 quad_of(vf v, size_t row)
{
    return row < 4 ? _mm256_castps256_ps128(v) : _mm256_extractf128_ps(v, 1);
}

static inline void transpose(vf v[4])
{
    const vf a = _mm256_unpacklo_ps(v[0], v[1]);
    const vf b = _mm256_unpackhi_ps(v[0], v[1]);
    const vf c = _mm256_unpacklo_ps(v[2], v[3]);
    const vf d = _mm256_unpackhi_ps(v[2], v[3]);
    v[0] = _mm256_shuffle_ps(a, c, 0x44);
    v[1] = _mm256_shuffle_ps(a, c, 0xEE);
    v[2] = _mm256_shuffle_ps(b, d, 0x44);
    v[3] = _mm256_shuffle_ps(b, d, 0xEE);
}
#else
static inline vf quads(const float *const *rows, size_t at)
{
    return _mm_loadu_ps(rows[0] + at);
}

static inline __m128 quad_of(vf v, size_t row)
{
    (void)row;
    return v;
}

static inline void transpose(vf v[4])
{
    _MM_TRANSPOSE4_PS(v[0], v[1], v[2], v[3]);
}
#endif

/* Floats at .. at + 3 of VF rows, into four vectors of lanes. */
static inline void load4(const float *const *rows, size_t at, vf v[4])
{
    for (size_t k = 0; k < 4; k++)
        v[k] = quads(rows + k, at);
    transpose(v);
}

static inline void load(const float *const rows[IBL_STRIP_LANES], int count,
                        const float subtract[3], float *lanes, size_t channel)
{
    const float *ends[IBL_STRIP_LANES];
    const int whole = count & ~3;
    for (size_t l = 0; l < IBL_STRIP_LANES; l += VF) {
        for (size_t i = 0; i < (size_t)whole; i += 4) {
            float *to = lanes + i * IBL_STRIP_LANES + l;
            vf v[12];
            for (size_t k = 0; k < 12; k += 4)
                load4(rows + l, 3 * i + k, v + k);
            for (size_t k = 0; k < 12; k++)
                vf_store(to + k % 3 * channel + k / 3 * IBL_STRIP_LANES,
                         v[k] - vf_all(subtract[k % 3]));
        }
    }
    for (int r = 0; r < IBL_STRIP_LANES; r++)
        ends[r] = rows[r] + 3 * (size_t)whole;
    ibl_strip_load_c(ends, count - whole, subtract,
                     lanes + (size_t)whole * IBL_STRIP_LANES, channel);
}

static inline void store(const float *lanes, size_t channel, int count,
                         float *const rows[IBL_STRIP_LANES], int used)
{
    if (used < IBL_STRIP_LANES) {
        ibl_strip_store_c(lanes, channel, count, rows, used);
        return;
    }
    for (size_t l = 0; l < IBL_STRIP_LANES; l += VF)
        for (size_t i = 0; i < (size_t)count; i++) {
            const float *from = lanes + i * IBL_STRIP_LANES + l;
            vf v[4] = {vf_load(from), vf_load(from + channel),
                       vf_load(from + 2 * channel), vf_all(0)};
            transpose(v);
            for (size_t r = 0; r < VF; r++)
                _mm_storeu_ps(rows[l + r] + 4 * i, quad_of(v[r % 4], r));
        }
}

/* The samples under way are in registers, the oldest first. */
static inline void spread_lanes(const ibl_strip_spread *spread,
                                const float *pixels, int start, int count,
                                float *samples)
{
    int64_t at = start ? ibl_strip_first(spread, start - 1) : 0;
    int64_t base = (int64_t)(start / spread->period) * spread->step;
    int p = start % spread->period;
    float *to = samples + at * IBL_STRIP_LANES;
    vf sum[IBL_STRIP_TAPS];
    for (int t = 0; t < IBL_STRIP_TAPS; t++)
        sum[t] = start ? vf_load(to + t * IBL_STRIP_LANES) : vf_all(0);
    for (int i = 0; i < count; i++) {
        const float *taps = spread->taps + (size_t)p * IBL_STRIP_TAPS;
        const int64_t first = base + spread->first[p];
        const vf v = vf_load(pixels + (size_t)i * IBL_STRIP_LANES);
        for (; at < first; at++, to += IBL_STRIP_LANES) {
            vf_store(to, sum[0]);
            for (int t = 1; t < IBL_STRIP_TAPS; t++)
                sum[t - 1] = sum[t];
            sum[IBL_STRIP_TAPS - 1] = vf_all(0);
        }
        for (int t = 0; t < IBL_STRIP_TAPS; t++)
            sum[t] = vf_fma(v, vf_all(taps[t]), sum[t]);
        if (++p == spread->period) {
            p = 0;
            base += spread->step;
        }
    }
    for (int t = 0; t < IBL_STRIP_TAPS; t++)
        vf_store(to + t * IBL_STRIP_LANES, sum[t]);
}

static inline void spread_all(const ibl_strip_spread *spread,
                              const float *pixels, int start, int count,
                              float *samples)
{
    for (size_t l = 0; l < IBL_STRIP_LANES; l += VF)
        spread_lanes(spread, pixels + l, start, count, samples + l);
}

#endif
