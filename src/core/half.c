/* SPDX-License-Identifier: MIT */
#include "core/half.h"

#include <math.h>
#include <string.h>

static uint32_t bits_of(float f)
{
    uint32_t u;
    memcpy(&u, &f, sizeof u);
    return u;
}

static float float_of(uint32_t u)
{
    float f;
    memcpy(&f, &u, sizeof f);
    return f;
}

uint16_t ibl_half_from_float(float f)
{
    const uint32_t bits = bits_of(f);
    const uint16_t sign = (uint16_t)(bits >> 16 & 0x8000);
    const uint32_t mag = bits & 0x7FFFFFFF;

    if (mag > 0x7F800000) /* NaN */
        return sign | 0x7E00;
    if (mag >= 0x477FF000) /* 65520 and above round to 2^16, which is Inf */
        return sign | 0x7C00;
    if (mag < 0x38800000) {
        /* Below 2^-14 a half counts in units of 2^-24; rintf rounds ties to
         * even, and 2^-14 itself comes out as the first normal. */
        return sign | (uint16_t)rintf(float_of(mag) * 0x1p24f);
    }
    /* Drop 13 bits, rounding: add half less one, plus the bit that stays. */
    const uint32_t rounded = mag + 0xFFF + (mag >> 13 & 1);
    return sign | (uint16_t)((rounded - (112u << 23)) >> 13);
}
