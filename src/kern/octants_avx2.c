/* SPDX-License-Identifier: MIT */
#include "kern/octants_lanes.h"

void ibl_octants_collect_avx2(const float *row, const int *offset, int count,
                              double *pixels)
{
    collect(row, offset, count, pixels);
}

void ibl_octants_add_avx2(const ibl_octant_span *spans, int count,
                          const double *pixels, double *sums)
{
    add_spans(spans, count, pixels, sums);
}
