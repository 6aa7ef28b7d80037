/* SPDX-License-Identifier: MIT */
/*
 * The kernels of kern/row_block.h over vectors, for the files that are compiled
 * for one instruction set each.
 *
 * Rows and lanes change places four floats at a time: a vector is made of
 * the same four floats of rows r, r + 4, ..., so that after a transposition
 * of 4 x 4 inside the 128-bit parts of four of them lane r is row r.
 */
#include "kern/lanes.h"
#include "kern/row_block.h"

/* Four floats of every fourth row, from rows[0] on. */
static inline vf quads(const float *const *rows, size_t at)
{
    const float *p[4];
#pragma GCC unroll 4
    for (size_t k = 0; k < VF / 4; k++)
        p[k] = rows[4 * k] + at;
    return vf_load_quads(p);
}

/*
 * Floats at .. at + 4 GROUPS - 1 of VF rows, into as many vectors of lanes.
 * Rows that are a power of two apart share a few sets of the cache, so what a
 * line holds of a row is taken at once: 16 floats, where registers allow.
 */
#define GROUPS (VF == 16 ? 4 : 1)
static inline void take(const float *const *rows, size_t at, vf *v)
{
#pragma GCC unroll 4
    for (size_t k = 0; k < 4; k++)
#pragma GCC unroll 4
        for (size_t g = 0; g < GROUPS; g++)
            v[4 * g + k] = quads(rows + k, at + 4 * g);
#pragma GCC unroll 4
    for (size_t g = 0; g < GROUPS; g++)
        vf_transpose(v + 4 * g);
}

/* 4 GROUPS pixels of VF rows, in three takes. */
static inline void load_some(const float *const *rows, size_t i,
                             const ibl_row_block_change *change, float *to,
                             size_t channel)
{
#pragma GCC unroll 3
    for (size_t part = 0; part < 3; part++) {
        const size_t at = part * 4 * GROUPS;
        vf v[4 * GROUPS];
        take(rows, 3 * i + at, v);
#pragma GCC unroll 16
        for (size_t k = 0; k < 4 * GROUPS; k++) {
            const size_t c = (at + k) % 3, pixel = (at + k) / 3;
            vf_store(to + c * channel + pixel * IBL_ROW_BLOCK_LANES,
                     (v[k] - vf_all(change->subtract[c])) *
                         vf_all(change->scale));
        }
    }
}

static void load(const float *const rows[IBL_ROW_BLOCK_LANES], int count,
                 const ibl_row_block_change *change, float *lanes,
                 size_t channel)
{
    const float *ends[IBL_ROW_BLOCK_LANES];
    const int whole = count - count % (4 * GROUPS);
    for (size_t l = 0; l < IBL_ROW_BLOCK_LANES; l += VF)
        for (size_t i = 0; i < (size_t)whole; i += 4 * GROUPS)
            load_some(rows + l, i, change, lanes + i * IBL_ROW_BLOCK_LANES + l,
                      channel);
    for (int r = 0; r < IBL_ROW_BLOCK_LANES; r++)
        ends[r] = rows[r] + 3 * (size_t)whole;
    ibl_row_block_load_c(ends, count - whole, change,
                         lanes + (size_t)whole * IBL_ROW_BLOCK_LANES, channel);
}

/*
 * TEXELS texels of AT_ONCE rows, which are half of them at most: rows that
 * are a power of two apart share a few sets of the cache, and the sets do not
 * hold a line of each of sixteen.
 */
#if VF == 16
#define TEXELS 4
#define AT_ONCE 8

/* One channel of two texels of eight rows. */
static inline vf two_texels(const float *from)
{
    const __m512 a = _mm512_castps256_ps512(_mm256_loadu_ps(from));
    return _mm512_insertf32x8(a, _mm256_loadu_ps(from + IBL_ROW_BLOCK_LANES),
                              1);
}

static inline void store_some(const float *from, size_t channel, size_t i,
                              float *const *rows)
{
    vf v[2][4];
#pragma GCC unroll 2
    for (size_t k = 0; k < 2; k++) {
        const float *at = from + 2 * k * IBL_ROW_BLOCK_LANES;
        v[k][0] = two_texels(at);
        v[k][1] = two_texels(at + channel);
        v[k][2] = two_texels(at + 2 * channel);
        v[k][3] = vf_all(0);
        vf_transpose(v[k]);
    }
    /* In v[k][j]: rows j and j + 4 of one texel, then of the next. */
#pragma GCC unroll 4
    for (size_t j = 0; j < 4; j++) {
        vf_store(rows[j] + 4 * i, _mm512_shuffle_f32x4(v[0][j], v[1][j], 0x88));
        vf_store(rows[j + 4] + 4 * i,
                 _mm512_shuffle_f32x4(v[0][j], v[1][j], 0xDD));
    }
}
#else
#define TEXELS 1
#define AT_ONCE VF

static inline void store_some(const float *from, size_t channel, size_t i,
                              float *const *rows)
{
    vf v[4] = {vf_load(from), vf_load(from + channel),
               vf_load(from + 2 * channel), vf_all(0)};
    vf_transpose(v);
#pragma GCC unroll 8
    for (size_t r = 0; r < AT_ONCE; r++)
        _mm_storeu_ps(rows[r] + 4 * i, vf_quad(v[r % 4], r / 4));
}
#endif

static void store(const float *lanes, size_t channel, int count,
                  float *const rows[IBL_ROW_BLOCK_LANES], int used)
{
    float *ends[IBL_ROW_BLOCK_LANES];
    const int whole = used < IBL_ROW_BLOCK_LANES ? 0 : count - count % TEXELS;
    for (size_t l = 0; l < IBL_ROW_BLOCK_LANES; l += AT_ONCE)
        for (size_t i = 0; i < (size_t)whole; i += TEXELS)
            store_some(lanes + i * IBL_ROW_BLOCK_LANES + l, channel, i,
                       rows + l);
    for (int r = 0; r < used; r++)
        ends[r] = rows[r] + 4 * (size_t)whole;
    ibl_row_block_store_c(lanes + (size_t)whole * IBL_ROW_BLOCK_LANES, channel,
                          count - whole, ends, used);
}

/* The samples under way are in registers, the oldest first. */
static inline void spread_lanes(const ibl_row_block_spread *spread,
                                const float *pixels, int start, int count,
                                float *samples)
{
    int64_t at = start ? ibl_row_block_first(spread, start - 1) : 0;
    int64_t base = (int64_t)(start / spread->period) * spread->step;
    int p = start % spread->period;
    float *to = samples + at * IBL_ROW_BLOCK_LANES;
    vf sum[IBL_ROW_BLOCK_TAPS];
#pragma GCC unroll 16
    for (int t = 0; t < IBL_ROW_BLOCK_TAPS; t++)
        sum[t] = start ? vf_load(to + t * IBL_ROW_BLOCK_LANES) : vf_all(0);
    for (int i = 0; i < count;) {
        const int64_t first = base + spread->first[p];
        for (; at < first; at++, to += IBL_ROW_BLOCK_LANES) {
            vf_store(to, sum[0]);
#pragma GCC unroll 16
            for (int t = 1; t < IBL_ROW_BLOCK_TAPS; t++)
                sum[t - 1] = sum[t];
            sum[IBL_ROW_BLOCK_TAPS - 1] = vf_all(0);
        }
        /* Pixels that begin at one sample. */
        do {
            const float *taps = spread->taps + (size_t)p * IBL_ROW_BLOCK_TAPS;
            const vf v = vf_load(pixels + (size_t)i * IBL_ROW_BLOCK_LANES);
#pragma GCC unroll 16
            for (int t = 0; t < IBL_ROW_BLOCK_TAPS; t++)
                sum[t] = vf_fma(v, vf_all(taps[t]), sum[t]);
            i++;
            p++;
        } while (i < count && p < spread->period &&
                 base + spread->first[p] == at);
        if (p == spread->period) {
            p = 0;
            base += spread->step;
        }
    }
#pragma GCC unroll 16
    for (int t = 0; t < IBL_ROW_BLOCK_TAPS; t++)
        vf_store(to + t * IBL_ROW_BLOCK_LANES, sum[t]);
}

static void spread_all(const ibl_row_block_spread *spread, const float *pixels,
                       int start, int count, float *samples)
{
    for (size_t l = 0; l < IBL_ROW_BLOCK_LANES; l += VF)
        spread_lanes(spread, pixels + l, start, count, samples + l);
}

IBL_VECTOR_KERNEL(ibl_row_block, load, store, spread_all)
