/* SPDX-License-Identifier: MIT */
#include "kern/max_finite.h"

#include "core/half.h"
#include "kern/lanes.h"

/* The maximum as signed integers; separately checks for a sign. The rest are
 * compared as unsigned ones: floats go from 0 to Inf, then follow NaN, then all
 * with a sign. */
static uint32_t most(const float *src, size_t count)
{
    vi high[4] = {{0}}, all = {0};
    size_t i = 0;

    for (; i + 4 * VF <= count; i += 4 * VF)
#pragma GCC unroll 4
        for (int k = 0; k < 4; k++) {
            const vi v = (vi)vf_load(src + i + k * VF);
            high[k] = vi_max(v, high[k]);
            all |= v;
        }
    high[0] = vi_max(vi_max(high[0], high[1]), vi_max(high[2], high[3]));
    uint32_t result = 0;
    for (; i < count; i++) {
        const uint32_t bits = ibl_bits_of(src[i]);
        result = bits > result ? bits : result;
    }
    for (int k = 0; k < VF; k++) {
        if (all[k] < 0)
            return 0x80000000u;
        if ((uint32_t)high[0][k] > result)
            result = (uint32_t)high[0][k];
    }
    return result;
}

IBL_VECTOR_KERNEL(ibl_max_finite, most)
