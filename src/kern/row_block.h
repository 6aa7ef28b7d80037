/* SPDX-License-Identifier: MIT */
/*
 * A strip is sixteen rows at once, row r in lane r, as kern/fft.h takes
 * them: rows of a map into lanes, lanes into rows of texels, and rows of any
 * length onto a ring of samples.
 */
#ifndef IBL_KERN_ROW_BLOCK_H
#define IBL_KERN_ROW_BLOCK_H

#include <stddef.h>
#include <stdint.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_ROW_BLOCK_LANES = 16,
    IBL_ROW_BLOCK_TAPS = 9 /* samples that a pixel is spread to */
};

/* What pixels are before they are transformed: (value - subtract) scale. */
typedef struct ibl_row_block_change {
    float subtract[3]; /* of each channel */
    float scale;       /* a power of two */
} ibl_row_block_change;

/* How pixels are spread: pixel i = k period + p adds tap t of p times its
 * value to sample k step + first[p] + t. */
typedef struct ibl_row_block_spread {
    int period;
    int step;
    int32_t *first; /* first[0] is 0; never falls, nor from period to period */
    float *taps;    /* IBL_ROW_BLOCK_TAPS of each p */
} ibl_row_block_spread;

typedef struct ibl_row_block_dsp {
    /*
     * Takes count pixels of sixteen rows of interleaved RGB into lanes:
     *     lanes[c * channel + i * 16 + r] = rows[r][3 i + c], changed.
     *   rows   no alignment; nothing beyond 3 count floats is read
     *   lanes  64-byte aligned; channel, in floats, a multiple of 16
     */
    void (*load)(const float *const rows[IBL_ROW_BLOCK_LANES], int count,
                 const ibl_row_block_change *change, float *lanes,
                 size_t channel);
    /*
     * The way back, count texels of each of the first `used` rows:
     *     rows[r][4 i + c] = lanes[c * channel + i * 16 + r],
     *     rows[r][4 i + 3] = 0.
     */
    void (*store)(const float *lanes, size_t channel, int count,
                  float *const rows[IBL_ROW_BLOCK_LANES], int used);
    /*
     * Spreads pixels start .. start + count - 1 of one channel, in order from 0
     * on. Samples below the first that pixel start + count - 1 adds to are
     * done, its IBL_ROW_BLOCK_TAPS are under way, those beyond undefined.
     *   pixels   16 floats for each, that of start first; 64-byte aligned
     *   samples  16 floats for each, 64-byte aligned
     */
    void (*spread)(const ibl_row_block_spread *spread, const float *pixels,
                   int start, int count, float *samples);
} ibl_row_block_dsp;

IBL_DECLARE_KERNEL(ibl_row_block);

/* The plain versions, for what the vectors leave at the end of rows. */
void ibl_row_block_load_c(const float *const rows[IBL_ROW_BLOCK_LANES],
                          int count, const ibl_row_block_change *change,
                          float *lanes, size_t channel);
void ibl_row_block_store_c(const float *lanes, size_t channel, int count,
                           float *const rows[IBL_ROW_BLOCK_LANES], int used);

/* The sample that pixel i adds to first. */
static inline int64_t ibl_row_block_first(const ibl_row_block_spread *spread,
                                          int i)
{
    return (int64_t)(i / spread->period) * spread->step +
           spread->first[i % spread->period];
}

#endif
