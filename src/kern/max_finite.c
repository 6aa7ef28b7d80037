/* SPDX-License-Identifier: MIT */
#include "kern/max_finite.h"

#include "core/half.h"

/* Ordered as unsigned integers, floats go from 0 to Inf, then follow NaN, then
 * all with a sign. */
uint32_t ibl_max_finite_c(const float *src, size_t count)
{
    uint32_t most = 0;
    for (size_t i = 0; i < count; i++) {
        const uint32_t bits = ibl_bits_of(src[i]);
        most = bits > most ? bits : most;
    }
    return most;
}

IBL_KERNEL(ibl_max_finite, ibl_max_finite_c)

ibl_max_finite_fn *ibl_max_finite(ibl_isa isa)
{
    ibl_max_finite_dsp dsp;
    ibl_max_finite_dsp_init(&dsp, isa);
    return dsp.look;
}
