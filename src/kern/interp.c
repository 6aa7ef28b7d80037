/* SPDX-License-Identifier: MIT */
#include "kern/interp.h"

#include <math.h>

static double coordinate(int i, int size)
{
    return (2 * i + 1) / (double)size - 1;
}

static void latitudes(double v, int size, int count, double *angle)
{
    for (int i = 0; i < count; i++) {
        const double u = coordinate(i, size);
        angle[i] = atan(v / sqrt(1 + u * u));
    }
}

static void polar(double v, int size, int count, double *angle, double *azimuth)
{
    for (int i = 0; i < count; i++) {
        const double u = coordinate(i, size);
        angle[i] = atan(sqrt(u * u + v * v));
        azimuth[i] = atan2(fabs(v), fabs(u));
    }
}

/* Weight of one tap by Horner's rule. */
static double weight_of(const ibl_interp_weights *taps, int tap, double t)
{
    double w = taps->coef[IBL_TAPS_DEGREE][tap];
    for (int d = IBL_TAPS_DEGREE - 1; d >= 0; d--)
        w = w * t + taps->coef[d][tap];
    return w;
}

static void weights(const ibl_interp_weights *taps, double shift, double scale,
                    const double *angle, int count, int *first, float *weight)
{
    for (int i = 0; i < count; i++) {
        const double position = shift + scale * angle[i];
        const double whole = floor(position);
        const double t = position - whole - 0.5;
        float *w = weight + (size_t)i * IBL_TAPS;
        double rest = 0;
        for (int k = 0; k < IBL_TAPS; k++) {
            const double exact = weight_of(taps, k, t);
            w[k] = (float)exact;
            rest += exact - (double)w[k];
        }
        /* Add the rounding errors to the largest weight: the sum stays 1. */
        w[t < 0 ? IBL_TAPS_FIRST : IBL_TAPS_FIRST + 1] += (float)rest;
        first[i] = (int)whole - IBL_TAPS_FIRST;
    }
}

static void row(const ibl_interp_row *a)
{
    for (int i = 0; i < a->count; i++) {
        const ptrdiff_t r = i * a->ring_step, c = i * a->column_step;
        const float *grid =
            a->grid + a->ring[r] * a->stride + 4 * (ptrdiff_t)a->column[c];
        const float *ring = a->ring_weight + r * IBL_TAPS;
        const float *column = a->column_weight + c * IBL_TAPS;
        float sum[4] = {0};
        for (int k = 0; k < IBL_TAPS; k++) {
            float along[4] = {0};
            for (int j = 0; j < IBL_TAPS; j++)
                for (int n = 0; n < 4; n++)
                    along[n] += ring[j] * grid[j * a->stride + 4 * k + n];
            for (int n = 0; n < 4; n++)
                sum[n] += column[k] * along[n];
        }
        for (int n = 0; n < 4; n++)
            a->rgba[4 * i + n] = sum[n];
    }
}

void ibl_interp_finish(const float *rgba, const ibl_interp_range *range,
                       int count, float *rgb)
{
    const ibl_interp_range a = *range; /* a copy, which rgb cannot alias */
    for (int i = 0; i < count; i++, rgba += 4, rgb += 3)
#pragma GCC unroll 3
        for (int c = 0; c < 3; c++) {
            const float x = rgba[c] * a.gain + a.offset[c];
            const float y = x > a.low[c] ? x : a.low[c];
            rgb[c] = y < a.high[c] ? y : a.high[c];
        }
}

IBL_KERNEL(ibl_interp, latitudes, polar, weights, row)
