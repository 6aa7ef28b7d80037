/* SPDX-License-Identifier: MIT */
#include "core/half.h"

uint16_t ibl_half_from_float(float f)
{
    const uint32_t bits = ibl_bits_of(f), mag = bits & 0x7FFFFFFF;
    const uint16_t sign = (uint16_t)(bits >> 16 & 0x8000);

    if (mag > 0x7F800000) /* NaN */
        return sign | 0x7E00;
    if (mag >= 0x477FF000) /* 65520 and up round to 2^16, which is Inf */
        return sign | 0x7C00;
    return sign | (uint16_t)ibl_small_float(ibl_float_of(mag), 10);
}
