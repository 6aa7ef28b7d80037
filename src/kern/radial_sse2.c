/* SPDX-License-Identifier: MIT */
#include "kern/radial_lanes.h"

static void points(double v, int size, int first, int stride, float *point)
{
    lanes_points(v, size, first, stride, point);
}

static void add(const ibl_radial *lobe, const ibl_radial_light *lights,
                int count, const float *point, int stride, float *rgba)
{
    lanes_add(lobe, lights, count, point, stride, rgba);
}

void ibl_radial_init_sse2(ibl_radial_dsp *dsp)
{
    *dsp = (ibl_radial_dsp){points, add};
}
