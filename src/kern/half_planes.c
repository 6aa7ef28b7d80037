/* SPDX-License-Identifier: MIT */
#include "kern/half_planes.h"

#include "core/half.h"

unsigned char ibl_unzip_sum_c(const unsigned char *src, size_t count)
{
    unsigned sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += src[i];
    return (unsigned char)sum;
}

void ibl_unzip_c(const unsigned char *even, const unsigned char *odd,
                 size_t count, unsigned char last[2], unsigned char *dst)
{
    for (size_t i = 0; i < count; i++) {
        last[0] = (unsigned char)(last[0] + even[i] + 128);
        last[1] = (unsigned char)(last[1] + odd[i] + 128);
        dst[2 * i] = last[0];
        dst[2 * i + 1] = last[1];
    }
}

/* The first byte is stored as it is: `last` cancels the 128 that unzip adds. */
void ibl_unzip_begin(const ibl_half_planes_dsp *dsp, const unsigned char *src,
                     size_t count, unsigned char last[2])
{
    last[0] = 128;
    last[1] = (unsigned char)(128 + dsp->sum(src, count) + 128 * count);
}

void ibl_half_planes_c(const unsigned char *const plane[3], int count,
                       float *dst)
{
    for (int i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) {
            const unsigned char *p = plane[c] + 2 * i;
            *dst++ = ibl_half_to_float((uint16_t)(p[0] | p[1] << 8));
        }
    }
}

IBL_KERNEL(ibl_half_planes, ibl_unzip_sum_c, ibl_unzip_c, ibl_half_planes_c)
