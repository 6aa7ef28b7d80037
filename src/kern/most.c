/* SPDX-License-Identifier: MIT */
#include "kern/most.h"

#include <string.h>

#include "core/cpu.h"

/* As unsigned integers, floats are in order from 0 to Inf, then come NaN,
 * then all that have a sign. */
uint32_t ibl_most_c(const float *src, size_t count)
{
    uint32_t most = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, src + i, sizeof bits);
        most = bits > most ? bits : most;
    }
    return most;
}

ibl_most_fn *ibl_most(ibl_isa isa)
{
    ibl_most_dsp dsp = {ibl_most_c};
    IBL_INIT(ibl_most, &dsp, isa);
    return dsp.most;
}
