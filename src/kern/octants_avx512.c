/* SPDX-License-Identifier: MIT */
#include "kern/octants_lanes.h"

void ibl_octants_collect_avx512(const float *row, const int *offset, int count,
                                double *pixels)
{
    collect(row, offset, count, pixels);
}

void ibl_octants_blend_avx512(const ibl_octant_blend *row, const int *column,
                              int count, int lanes, double *pixels)
{
    blend(row, column, count, lanes, pixels);
}

void ibl_octants_add_avx512(const ibl_octant_span *spans, int count,
                            const double *pixels, double *sums)
{
    add_spans(spans, count, pixels, sums);
}

void ibl_octants_write_avx512(const double *sums, const double *weights,
                              int count, float *const out[IBL_OCTANTS],
                              const ptrdiff_t step[IBL_OCTANTS])
{
    write_sums(sums, weights, count, out, step);
}
