/* SPDX-License-Identifier: MIT */
#include <float.h>
#include <math.h>

#include "ibl/ibl.h"

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double ibl_relative_error(const double rgb[3], const double truth[3],
                          const double mean[3])
{
    const double d[3] = {rgb[0] - truth[0], rgb[1] - truth[1],
                         rgb[2] - truth[2]};
    const double floor = IBL_RELATIVE_FLOOR * length(mean);
    const double scale = fmax(length(truth), floor);
    /* So that a black map has finite errors. */
    return length(d) / fmax(scale, (double)FLT_MIN);
}
