/* SPDX-License-Identifier: MIT */
/*
 * The kernels of kern/row_block.h with vectors.
 *
 * Rows become lanes four floats at a time. A vector is made of the same four
 * floats of rows r, r + 4, ... Four such vectors are transposed as 4 x 4 in
 * each 128-bit part; then lane r is row r.
 */
#include "kern/lanes.h"
#include "kern/row_block.h"

/* ---- for the rest of rows after whole vectors -------------------------- */

static void load_rest(const float *const rows[IBL_ROW_BLOCK_LANES], int count,
                      float scale, float *lanes, size_t channel)
{
    for (size_t i = 0; i < (size_t)count; i++)
        for (size_t c = 0; c < 3; c++)
            for (size_t r = 0; r < IBL_ROW_BLOCK_LANES; r++)
                lanes[c * channel + i * IBL_ROW_BLOCK_LANES + r] =
                    rows[r][3 * i + c] * scale;
}

static void store_rest(const float *lanes, size_t channel, int count,
                       float *const rows[IBL_ROW_BLOCK_LANES], int used)
{
    for (size_t i = 0; i < (size_t)count; i++)
        for (size_t r = 0; r < (size_t)used; r++) {
            const float *from = lanes + i * IBL_ROW_BLOCK_LANES + r;
            rows[r][4 * i] = from[0];
            rows[r][4 * i + 1] = from[channel];
            rows[r][4 * i + 2] = from[2 * channel];
            rows[r][4 * i + 3] = 0;
        }
}

/* ---- vectors ------------------------------------------------------------ */

/* Four floats of every fourth row, beginning with rows[0]. */
static inline vf quads(const float *const *rows, size_t at)
{
    const float *p[VF / 4];
#pragma GCC unroll 4
    for (size_t k = 0; k < VF / 4; k++)
        p[k] = rows[4 * k] + at;
    return vf_load_quads(p);
}

/* Loads four pixels of VF rows, four floats at a time. */
static inline void load_four(const float *const *rows, size_t i, float scale,
                             float *to, size_t channel)
{
#pragma GCC unroll 3
    for (size_t at = 0; at < 12; at += 4) {
        vf v[4];
#pragma GCC unroll 4
        for (size_t k = 0; k < 4; k++)
            v[k] = quads(rows + k, 3 * i + at);
        vf_transpose(v);
#pragma GCC unroll 4
        for (size_t k = 0; k < 4; k++) {
            const size_t c = (at + k) % 3, pixel = (at + k) / 3;
            vf_store(to + c * channel + pixel * IBL_ROW_BLOCK_LANES,
                     v[k] * vf_all(scale));
        }
    }
}

static void load(const float *const rows[IBL_ROW_BLOCK_LANES], int count,
                 float scale, float *lanes, size_t channel)
{
    const float *ends[IBL_ROW_BLOCK_LANES];
    const int whole = count - count % 4;
    for (size_t l = 0; l < IBL_ROW_BLOCK_LANES; l += VF)
        for (size_t i = 0; i < (size_t)whole; i += 4)
            load_four(rows + l, i, scale, lanes + i * IBL_ROW_BLOCK_LANES + l,
                      channel);
    for (int r = 0; r < IBL_ROW_BLOCK_LANES; r++)
        ends[r] = rows[r] + 3 * (size_t)whole;
    load_rest(ends, count - whole, scale,
              lanes + (size_t)whole * IBL_ROW_BLOCK_LANES, channel);
}

/* Stores texel i of VF rows. */
static inline void store_texel(const float *from, size_t channel, size_t i,
                               float *const *rows)
{
    vf v[4] = {vf_load(from), vf_load(from + channel),
               vf_load(from + 2 * channel), vf_all(0)};
    vf_transpose(v);
#pragma GCC unroll 8
    for (size_t r = 0; r < VF; r++)
        vq_store(rows[r] + 4 * i, vf_quad(v[r % 4], r / 4));
}

static void store(const float *lanes, size_t channel, int count,
                  float *const rows[IBL_ROW_BLOCK_LANES], int used)
{
    if (used < IBL_ROW_BLOCK_LANES) {
        store_rest(lanes, channel, count, rows, used);
        return;
    }
    for (size_t l = 0; l < IBL_ROW_BLOCK_LANES; l += VF)
        for (size_t i = 0; i < (size_t)count; i++)
            store_texel(lanes + i * IBL_ROW_BLOCK_LANES + l, channel, i,
                        rows + l);
}

/* Keeps the partial sums of samples in registers, the oldest first. */
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
        /* Pixels with the same first sample. */
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
