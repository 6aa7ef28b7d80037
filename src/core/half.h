/* SPDX-License-Identifier: MIT */
/* IEEE 754 binary16, one value at a time: the reference for the rest. */
#ifndef IBL_CORE_HALF_H
#define IBL_CORE_HALF_H

#include <stdint.h>

/* Rounds to nearest even; overflow gives +-Inf, NaN stays NaN, denormals are
 * kept. */
uint16_t ibl_half_from_float(float f);
float ibl_half_to_float(uint16_t h);

#endif
