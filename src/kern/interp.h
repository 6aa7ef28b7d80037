/* SPDX-License-Identifier: MIT */
/*
 * From samples on rings of a sphere to texels: positions of directions among
 * rings and columns, the weights of 8 x 8 samples around them, and the weighted
 * sums.
 */
#ifndef IBL_KERN_INTERP_H
#define IBL_KERN_INTERP_H

#include <stddef.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_TAPS = 8,      /* samples that interpolate a position */
    IBL_TAPS_FIRST = 3 /* samples before the whole part of the position */
};

/*
 * Texels to interpolate. Texel i is the sum over j and k = 0..7 of
 *     ring_weight[8 i + j] column_weight[8 i + k]
 * times the sample of 4 floats at
 *     grid + (ring[i] + j) stride + 4 (column[i] + k).
 */
typedef struct ibl_interp_row {
    const float *grid;
    ptrdiff_t stride; /* floats from ring to ring */
    const int *ring, *column;
    const float *ring_weight, *column_weight;
    int count;   /* texels, 0 or more */
    float *rgba; /* output: 4 count floats */
} ibl_interp_row;

/* Gain, offset and limits of colours. */
typedef struct ibl_interp_range {
    float gain;
    float offset[4], low[4], high[4]; /* R, G, B, unused */
} ibl_interp_range;

typedef struct ibl_interp_dsp {
    /*
     * Angles of `count` directions, a multiple of 8, within 1e-11: theta from
     * +Y in 0..pi, and phi = atan2(z, x), any value at the poles. point is as
     * from ibl_radial_dsp's points() with that stride.
     */
    void (*angles)(const float *point, int stride, int count, double *theta,
                   double *phi);
    /*
     * Weights at the positions shift + scale angle[i], above -64. first[i] is
     * the lowest tap's index, weight[8 i ..] are the weights of this tap and
     * the next seven. Their sum is 1 within 2e-7.
     */
    void (*weights)(double shift, double scale, const double *angle, int count,
                    int *first, float *weight);
    void (*row)(const ibl_interp_row *row);
} ibl_interp_dsp;

IBL_DECLARE_KERNEL(ibl_interp);

#endif
