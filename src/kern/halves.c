/* SPDX-License-Identifier: MIT */
#include "kern/halves.h"

#include "core/cpu.h"
#include "core/half.h"

void ibl_halves_c(const unsigned char *const plane[3], int count, float *dst)
{
    for (int i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) {
            const unsigned char *p = plane[c] + 2 * i;
            *dst++ = ibl_half_to_float((uint16_t)(p[0] | p[1] << 8));
        }
    }
}

ibl_halves_fn *ibl_halves(ibl_isa isa)
{
#if IBL_X86
    if (isa >= IBL_ISA_AVX2)
        return ibl_halves_avx2;
#endif
    (void)isa;
    return ibl_halves_c;
}
