/* SPDX-License-Identifier: MIT */
/*
 * From samples on rings of a sphere to the texels of a cube: positions of
 * texels among rings and columns, the weights of 8 x 8 samples around them, and
 * the weighted sums. The caller handles directions and mirror images
 * (bake/spectral/resample.c).
 */
#ifndef IBL_KERN_INTERP_H
#define IBL_KERN_INTERP_H

#include <stddef.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_TAPS = 8,       /* samples that interpolate a position */
    IBL_TAPS_FIRST = 3, /* samples before the whole part of the position */
    IBL_TAPS_DEGREE = 9
};

/* The weight of tap k at whole + t, 0 <= t < 1, is a polynomial in t - 1/2 with
 * coefficients coef[0..degree][k], constant first. Weights sum to 1 for every
 * t; tap 7 - k is tap k mirrored. */
typedef struct ibl_interp_weights {
    double coef[IBL_TAPS_DEGREE + 1][IBL_TAPS];
} ibl_interp_weights;

/*
 * A row of texels to interpolate. With r = i ring_step and c = i column_step,
 * texel i is the sum over j and k = 0..7 of
 *     ring_weight[8 r + j] column_weight[8 c + k]
 * times the sample of 4 floats at
 *     grid + (ring[r] + j) stride + 4 (column[c] + k).
 * A negative stride mirrors the rings.
 */
typedef struct ibl_interp_row {
    const float *grid;
    ptrdiff_t stride; /* floats from ring to ring */
    const int *ring, *column;
    const float *ring_weight, *column_weight;
    int ring_step, column_step; /* 1 or -1 */
    int count;                  /* texels, 0 or more */
    float *rgba;                /* output: 4 count floats */
} ibl_interp_row;

/* Gain, offset and limits of colours, see ibl_interp_finish. */
typedef struct ibl_interp_range {
    float gain;
    float offset[4], low[4], high[4]; /* R, G, B, unused */
} ibl_interp_range;

typedef struct ibl_interp_dsp {
    /*
     * Latitudes of the first `count` texels of a row of a side face of `size`,
     * atan(v / sqrt(1 + u_i^2)), u_i = (2 i + 1) / size - 1, -1 <= v <= 1,
     * within 1e-11. Writes up to the next multiple of 8.
     */
    void (*latitudes)(double v, int size, int count, double *angle);
    /*
     * The same for the top face: the angle from the pole, atan(hypot(u, v)),
     * and the azimuth in the first quadrant, atan(|v| / |u|), which is any
     * value where both are 0.
     */
    void (*polar)(double v, int size, int count, double *angle,
                  double *azimuth);
    /*
     * Weights at the positions shift + scale angle[i]. first[i] is the lowest
     * tap's index, weight[8 i ..] are the weights of this tap and the next
     * seven. Their sum is 1 within the rounding of the largest one.
     */
    void (*weights)(const ibl_interp_weights *taps, double shift, double scale,
                    const double *angle, int count, int *first, float *weight);
    void (*row)(const ibl_interp_row *row);
} ibl_interp_dsp;

IBL_DECLARE_KERNEL(ibl_interp);

/* rgb[3 i + c] = rgba[4 i + c] gain + offset[c], limited to low[c]..high[c];
 * NaN becomes low[c]. rgb is the output, 3 count floats. */
void ibl_interp_finish(const float *rgba, const ibl_interp_range *range,
                       int count, float *rgb);

#endif
