/* SPDX-License-Identifier: MIT */
#include "kern/octants.h"

#include "core/cpu.h"

void ibl_octants_collect_c(const float *row, const int *offset, int count,
                           double *pixels)
{
    for (int i = 0; i < count; i++) {
        for (int m = 0; m < IBL_OCTANTS; m++) {
            for (int c = 0; c < 3; c++)
                pixels[c * IBL_OCTANTS + m] = (double)row[offset[m] + c];
        }
        offset += IBL_OCTANTS;
        pixels += IBL_OCTANT_RGB;
    }
}

void ibl_octants_add_c(const ibl_octant_span *spans, int count,
                       const double *pixels, double *sums)
{
    for (const ibl_octant_span *s = spans; s < spans + count; s++) {
        const double *first = pixels + IBL_OCTANT_RGB * (size_t)s->pixel;
        double *sum = sums + IBL_OCTANT_RGB * (size_t)s->slot;
        for (int k = 0; k < IBL_OCTANT_RGB; k++) {
            double run = first[k];
            for (int i = 1; i < s->count; i++)
                run += first[IBL_OCTANT_RGB * i + k];
            sum[k] += s->weight * run;
        }
    }
}

void ibl_octants_write_c(const double *sums, const double *weights, int count,
                         float *const out[IBL_OCTANTS],
                         const ptrdiff_t step[IBL_OCTANTS])
{
    for (int i = 0; i < count; i++) {
        const double scale = 1 / weights[i];
        for (int m = 0; m < IBL_OCTANTS; m++) {
            for (int c = 0; c < 3; c++)
                out[m][i * step[m] + c] =
                    (float)(sums[c * IBL_OCTANTS + m] * scale);
        }
        sums += IBL_OCTANT_RGB;
    }
}

void ibl_octants_dsp_init(ibl_octants_dsp *dsp, ibl_isa isa)
{
    *dsp = (ibl_octants_dsp){ibl_octants_collect_c, ibl_octants_add_c,
                             ibl_octants_write_c};
#if IBL_X86
    if (isa >= IBL_ISA_SSE2)
        *dsp = (ibl_octants_dsp){ibl_octants_collect_sse2, ibl_octants_add_sse2,
                                 ibl_octants_write_sse2};
    if (isa >= IBL_ISA_AVX2)
        *dsp = (ibl_octants_dsp){ibl_octants_collect_avx2, ibl_octants_add_avx2,
                                 ibl_octants_write_avx2};
    if (isa >= IBL_ISA_AVX512)
        *dsp =
            (ibl_octants_dsp){ibl_octants_collect_avx512,
                              ibl_octants_add_avx512, ibl_octants_write_avx512};
#else
    (void)isa;
#endif
}
