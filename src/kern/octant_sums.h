/* SPDX-License-Identifier: MIT */
/*
 * Sums of pixels for eight images at once. Where eight parts of a map have
 * the same geometry, a weight counts for all of them: a value is a vector of
 * eight, one lane for each image, and a pixel or a sum is three of them, R, G
 * and B. All versions give the same bytes: they add in the same order, and
 * neither fuse nor reassociate.
 */
#ifndef IBL_KERN_OCTANT_SUMS_H
#define IBL_KERN_OCTANT_SUMS_H

#include <stddef.h>
#include <stdint.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_OCTANTS = 8,                  /* lanes */
    IBL_OCTANT_RGB = 3 * IBL_OCTANTS, /* doubles of a pixel or a sum */
};

/* A weight for a run of pixels, to be added to one sum. */
typedef struct ibl_octant_span {
    double weight;
    int slot;              /* of the sum */
    uint16_t pixel, count; /* the first one, and how many: >= 1 */
} ibl_octant_span;

/* Where a pixel lies between two of a source's row: their offsets in floats and
 * the weight of the second. */
typedef struct ibl_octant_tap {
    int at[2];
    double weight;
} ibl_octant_tap;

/* A row of pixels between those of two rows of a source. */
typedef struct ibl_octant_blend {
    const float *source[2];
    double weight[2];
    int turn[2]; /* columns to go on by in each, 0..columns - 1 */
    int columns;
    const ibl_octant_tap *taps; /* of each column */
} ibl_octant_blend;

typedef struct ibl_octants_dsp {
    /*
     * Brings pixels of a row side by side: lane m of pixel i is the RGB at
     * row + offset[i * IBL_OCTANTS + m].
     *   pixels  count of IBL_OCTANT_RGB doubles, 64-byte aligned
     */
    void (*collect)(const float *row, const int *offset, int count,
                    double *pixels);
    /*
     * The same from a row between two: lane m of pixel i is that at
     * column[i * IBL_OCTANTS + m].
     *   lanes   how many of them to write; what others hold stays
     */
    void (*blend)(const ibl_octant_blend *row, const int *column, int count,
                  int lanes, double *pixels);
    /*
     * sums[slot] += weight * (sum of the run's pixels, from first to last),
     * span after span.
     *   pixels, sums  arrays of IBL_OCTANT_RGB doubles, 64-byte aligned
     */
    void (*add)(const ibl_octant_span *spans, int count, const double *pixels,
                double *sums);
    /*
     * Writes sums * (1 / weight) as floats: lane m of sum i becomes the RGB at
     * out[m] + i * step[m]. Lanes may share a place where nothing of use is.
     *   sums  count of IBL_OCTANT_RGB doubles, 64-byte aligned
     */
    void (*write)(const double *sums, const double *weights, int count,
                  float *const out[IBL_OCTANTS],
                  const ptrdiff_t step[IBL_OCTANTS]);
} ibl_octants_dsp;

IBL_DECLARE_KERNEL(ibl_octants);

#endif
