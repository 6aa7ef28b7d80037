/* SPDX-License-Identifier: MIT */
/*
 * Blocks of sixteen rows, row r in lane r, as kern/fft.h takes them: rows of a
 * map to lanes, lanes to rows of texels, and rows of any length to a ring of
 * samples.
 */
#ifndef IBL_KERN_ROW_BLOCK_H
#define IBL_KERN_ROW_BLOCK_H

#include <stddef.h>
#include <stdint.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_ROW_BLOCK_LANES = 16,
    IBL_ROW_BLOCK_TAPS = 9 /* samples that one pixel is spread over */
};

/* How pixels are spread: pixel i = k period + p adds its value times tap t of p
 * to sample k step + first[p] + t. */
typedef struct ibl_row_block_spread {
    int period;
    int step;
    int32_t *first; /* first[0] is 0; never falls, also between periods */
    float *taps;    /* IBL_ROW_BLOCK_TAPS for each p */
} ibl_row_block_spread;

typedef struct ibl_row_block_dsp {
    /*
     * Loads count pixels of sixteen rows of interleaved RGB into lanes:
     *     lanes[c * channel + i * 16 + r] = scale rows[r][3 i + c].
     *   rows   no alignment; nothing beyond 3 count floats is read
     *   scale  a power of two
     *   lanes  64-byte aligned; channel, in floats, a multiple of 16
     */
    void (*load)(const float *const rows[IBL_ROW_BLOCK_LANES], int count,
                 float scale, float *lanes, size_t channel);
    /*
     * Stores count texels of each of the first `used` rows:
     *     rows[r][4 i + c] = lanes[c * channel + i * 16 + r],
     *     rows[r][4 i + 3] = 0.
     */
    void (*store)(const float *lanes, size_t channel, int count,
                  float *const rows[IBL_ROW_BLOCK_LANES], int used);
    /*
     * Spreads pixels start .. start + count - 1 of one channel; calls must be
     * in order from 0 on. With s the first sample of pixel start + count - 1,
     * samples below s are then complete, the IBL_ROW_BLOCK_TAPS from s on are
     * partial sums, and later ones are undefined.
     *   pixels   16 floats for each, that of start first; 64-byte aligned
     *   samples  16 floats for each, 64-byte aligned
     */
    void (*spread)(const ibl_row_block_spread *spread, const float *pixels,
                   int start, int count, float *samples);
} ibl_row_block_dsp;

IBL_DECLARE_KERNEL(ibl_row_block);

/* The first sample that pixel i adds to. */
static inline int64_t ibl_row_block_first(const ibl_row_block_spread *spread,
                                          int i)
{
    return (int64_t)(i / spread->period) * spread->step +
           spread->first[i % spread->period];
}

#endif
