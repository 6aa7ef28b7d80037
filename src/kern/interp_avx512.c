/* SPDX-License-Identifier: MIT */
#include "kern/interp_lanes.h"

static void latitudes(double v, int size, int count, double *angle)
{
    lanes_latitudes(v, size, count, angle);
}

static void polar(double v, int size, int count, double *angle, double *azimuth)
{
    lanes_polar(v, size, count, angle, azimuth);
}

static void weights(const ibl_taps *taps, double shift, double scale,
                    const double *angle, int count, int *first, float *weight)
{
    lanes_weights(taps, shift, scale, angle, count, first, weight);
}

static void row(const ibl_interp_row *a)
{
    lanes_row(a);
}

static void finish(const float *rgba, const ibl_interp_range *range, int count,
                   float *rgb)
{
    lanes_finish(rgba, range, count, rgb);
}

void ibl_interp_init_avx512(ibl_interp_dsp *dsp)
{
    *dsp = (ibl_interp_dsp){latitudes, polar, weights, row, finish};
}
