/* SPDX-License-Identifier: MIT */
/*
 * Sums of pixels for eight images at once. Eight parts of a map with the same
 * geometry share their weights: a value is a vector of eight, one lane for each
 * image. A pixel or a sum is three values: R, G and B. All versions give the
 * same bytes: they add in the same order, without fusing or reassociating.
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

/* A weight for a run of pixels that is added to one sum. */
typedef struct ibl_octant_span {
    float weight;
    int slot;              /* index of the sum */
    uint16_t pixel, count; /* the first pixel, and how many: >= 1 */
} ibl_octant_span;

/* A pixel between two pixels of a source row: their offsets in floats, and the
 * weight of the second. */
typedef struct ibl_octant_tap {
    int at[2];
    double weight;
} ibl_octant_tap;

/* A row of pixels between two rows of a source. */
typedef struct ibl_octant_blend {
    const float *source[2];
    double weight[2];
    int turn[2]; /* columns to shift each by, 0..columns - 1 */
    int columns;
    const ibl_octant_tap *taps; /* one for each column */
} ibl_octant_blend;

typedef struct ibl_octants_dsp {
    /*
     * Gathers pixels of a row: lane m of pixel i is the RGB at
     * row + offset[i * IBL_OCTANTS + m].
     *   pixels  count of IBL_OCTANT_RGB doubles, 64-byte aligned
     */
    void (*collect)(const float *row, const int *offset, int count,
                    double *pixels);
    /*
     * The same for an interpolated row: lane m of pixel i is that at
     * column[i * IBL_OCTANTS + m].
     *   lanes   number of lanes to write; the rest stays unchanged
     */
    void (*blend)(const ibl_octant_blend *row, const int *column, int count,
                  int lanes, double *pixels);
    /*
     * sums[slot] += weight * (sum of the run's pixels, from first to last) and
     * weights[slot] += weight * count, span after span.
     *   pixels, sums  arrays of IBL_OCTANT_RGB doubles, 64-byte aligned
     */
    void (*add)(const ibl_octant_span *spans, int count, const double *pixels,
                double *sums, double *weights);
    /*
     * Writes sums * (1 / weight) as floats, and clears both: lane m of sum i
     * becomes the RGB at out[m] + i * step[m]. Unused lanes may share a dummy
     * place.
     *   sums  count of IBL_OCTANT_RGB doubles, 64-byte aligned
     */
    void (*write)(double *sums, double *weights, int count,
                  float *const out[IBL_OCTANTS],
                  const ptrdiff_t step[IBL_OCTANTS]);
} ibl_octants_dsp;

IBL_DECLARE_KERNEL(ibl_octants);

#endif
