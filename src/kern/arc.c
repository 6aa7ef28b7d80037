/* SPDX-License-Identifier: MIT */
#include "kern/arc.h"

#include "core/cpu.h"

void ibl_arc_prefix_c(const float *rgb, int width, const double *turn,
                      double level, double rise, double *sums)
{
    for (int k = 0; k < IBL_ARC_LANES; k++)
        sums[k] = 0.0;
    for (int i = 0; i < width; i++) {
        const double l[4] = {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 1.0};
        const double x = level * turn[2 * i], z = level * turn[2 * i + 1];
        const double *from = sums + (size_t)i * IBL_ARC_LANES;
        double *to = sums + (size_t)(i + 1) * IBL_ARC_LANES;
        for (int k = 0; k < 4; k++) {
            to[k] = from[k] + x * l[k];
            to[4 + k] = from[4 + k] + z * l[k];
            to[8 + k] = from[8 + k] + rise * l[k];
        }
    }
}

static void add_row(const double *row, int width, double centre, double half,
                    double sum[IBL_ARC_LANES])
{
    const double *whole = row + (size_t)width * IBL_ARC_LANES;

    if (half > width) {
        for (int k = 0; k < IBL_ARC_LANES; k++)
            sum[k] += whole[k];
        return;
    }
    /* Column i is in if centre - half < i + .5 < centre + half. Casts round
     * towards zero, so the left end is moved up by width for it. */
    int first = (int)(centre - half + 0.5 + width) - width;
    int end = (int)(centre + half + 0.5);
    double around = 0.0;
    if (first < 0) {
        first += width;
        around = 1.0;
    }
    if (end > width) {
        end -= width;
        around = 1.0;
    }
    const double *a = row + (size_t)first * IBL_ARC_LANES;
    const double *b = row + (size_t)end * IBL_ARC_LANES;
    for (int k = 0; k < IBL_ARC_LANES; k++)
        sum[k] += (b[k] - a[k]) + around * whole[k];
}

void ibl_arc_add_c(const ibl_arc_rows *rows, double centre, const double *half,
                   double sum[IBL_ARC_LANES])
{
    const size_t stride = ((size_t)rows->width + 1) * IBL_ARC_LANES;

    for (int r = 0; r < rows->rows; r++) {
        if (half[r] > 0.0)
            add_row(rows->sums + (size_t)r * stride, rows->width, centre,
                    half[r], sum);
    }
}

void ibl_arc_dsp_init(ibl_arc_dsp *dsp, ibl_isa isa)
{
    dsp->prefix = ibl_arc_prefix_c;
    dsp->add = ibl_arc_add_c;
#if IBL_X86
    if (isa >= IBL_ISA_AVX2) {
        dsp->prefix = ibl_arc_prefix_avx2;
        dsp->add = ibl_arc_add_avx2;
    }
#else
    (void)isa;
#endif
}
