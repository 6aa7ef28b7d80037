/* SPDX-License-Identifier: MIT */
/* Checks that floats are finite and not negative, in one pass. */
#ifndef IBL_KERN_MAX_FINITE_H
#define IBL_KERN_MAX_FINITE_H

#include <stddef.h>
#include <stdint.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

/* The bits of +Inf. */
#define IBL_INFINITE_BITS 0x7f800000u

typedef struct ibl_max_finite_dsp {
    /*
     * The bits of the largest of count floats. The result is below
     * IBL_INFINITE_BITS exactly when all of them are finite and none has a
     * sign; then all versions agree. 0 for no floats. No alignment is needed.
     */
    uint32_t (*look)(const float *src, size_t count);
} ibl_max_finite_dsp;

IBL_DECLARE_KERNEL(ibl_max_finite);

#endif
