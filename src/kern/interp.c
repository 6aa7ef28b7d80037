/* SPDX-License-Identifier: MIT */
#include "kern/interp.h"

void ibl_interp_finish(const float *rgba, const ibl_interp_range *range,
                       int count, float *rgb)
{
    const ibl_interp_range a = *range; /* a copy, which rgb cannot alias */
    for (int i = 0; i < count; i++, rgba += 4, rgb += 3)
#pragma GCC unroll 3
        for (int c = 0; c < 3; c++) {
            const float x = rgba[c] * a.gain + a.offset[c];
            const float y = x > a.low[c] ? x : a.low[c];
            rgb[c] = y < a.high[c] ? y : a.high[c];
        }
}
