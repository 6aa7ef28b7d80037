/* SPDX-License-Identifier: MIT */
#include "kern/fft_lanes.h"

void ibl_fft_forward_avx512(const ibl_fft *fft, float *z)
{
    forward((const float *const *)fft->passes, z, fft->size);
}

void ibl_fft_inverse_avx512(const ibl_fft *fft, float *z)
{
    inverse((const float *const *)fft->passes, z, fft->size);
}

void ibl_fft_split_avx512(const float *z, const ibl_fft_pair *pairs, int count,
                          const ibl_fft_spectrum *out)
{
    split(z, pairs, count, out);
}

void ibl_fft_merge_avx512(const ibl_fft_spectrum *in, const ibl_fft_pair *pairs,
                          int count, float *z)
{
    merge(in, pairs, count, z);
}
