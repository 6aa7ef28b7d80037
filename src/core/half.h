/* SPDX-License-Identifier: MIT */
/* IEEE 754 binary16, one value at a time; the vector versions must agree. */
#ifndef IBL_CORE_HALF_H
#define IBL_CORE_HALF_H

#include <stdint.h>
#include <string.h>

static inline uint32_t ibl_bits_of(float f)
{
    uint32_t u;
    memcpy(&u, &f, sizeof u);
    return u;
}

static inline float ibl_float_of(uint32_t bits)
{
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

/* Encodes f with 5 exponent bits (bias 15), `mantissa` bits, at most 10, and no
 * sign. f must be >= 0 and at most the largest finite value. Rounds to even. */
static inline uint32_t ibl_small_float(float f, int mantissa)
{
    const uint32_t bits = ibl_bits_of(f);
    const int drop = 23 - mantissa;

    if (bits < 0x38800000) {
        /* Denormals, below 2^-14, have the unit 2^(-14 - mantissa). Adding the
         * power of two whose last bit is this unit rounds f to even and leaves
         * its count of units in the sum's low bits. */
        const float magic = ibl_float_of((uint32_t)(drop - 14 + 127) << 23);
        return ibl_bits_of(f + magic) - ibl_bits_of(magic);
    }
    /* Add half a unit less one, plus the lowest kept bit; drop the rest. */
    const uint32_t half = (1u << (drop - 1)) - 1;
    return (bits + half + (bits >> drop & 1) - (112u << 23)) >> drop;
}

/* Rounds to nearest even. Overflow gives +-Inf, NaN stays NaN, denormals are
 * kept. */
static inline uint16_t ibl_half_from_float(float f)
{
    const uint32_t bits = ibl_bits_of(f), mag = bits & 0x7FFFFFFF;
    const uint16_t sign = (uint16_t)(bits >> 16 & 0x8000);

    if (mag > 0x7F800000) /* NaN */
        return sign | 0x7E00;
    if (mag >= 0x477FF000) /* 65520 and up round to 2^16, which is Inf */
        return sign | 0x7C00;
    return sign | (uint16_t)ibl_small_float(ibl_float_of(mag), 10);
}

/* Exact. The exponent is rebiased by 112, for Inf and NaN by twice that. A
 * subtraction normalises denormals. */
static inline float ibl_half_to_float(uint16_t h)
{
    const uint32_t sign = (uint32_t)(h & 0x8000) << 16;
    const uint32_t exponent = h & 0x7C00;
    uint32_t bits = ((uint32_t)(h & 0x7FFF) << 13) + (112u << 23);

    if (exponent == 0x7C00)
        bits += 112u << 23;
    if (!exponent)
        bits = ibl_bits_of(ibl_float_of(bits + (1u << 23)) - 0x1p-14f);
    return ibl_float_of(bits | sign);
}

#endif
