/* SPDX-License-Identifier: MIT */
/* IEEE 754 binary16, one value at a time: the reference for the rest. */
#ifndef IBL_CORE_HALF_H
#define IBL_CORE_HALF_H

#include <stdint.h>
#include <string.h>

/* Rounds to nearest even; overflow gives +-Inf, NaN stays NaN, denormals are
 * kept. */
uint16_t ibl_half_from_float(float f);

/* Exact. The exponent is rebiased by 112, twice that for Inf and NaN, and
 * denormals are normalised by a subtraction. */
static inline float ibl_half_to_float(uint16_t h)
{
    const uint32_t sign = (uint32_t)(h & 0x8000) << 16;
    const uint32_t exponent = h & 0x7C00;
    uint32_t bits = ((uint32_t)(h & 0x7FFF) << 13) + (112u << 23);
    float f;

    if (exponent == 0x7C00)
        bits += 112u << 23;
    if (!exponent) {
        bits += 1u << 23;
        memcpy(&f, &bits, sizeof f);
        f -= 0x1p-14f;
        memcpy(&bits, &f, sizeof bits);
    }
    bits |= sign;
    memcpy(&f, &bits, sizeof f);
    return f;
}

#endif
