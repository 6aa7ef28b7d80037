/* SPDX-License-Identifier: MIT */
/* One look at floats that are to be finite and not negative. */
#ifndef IBL_KERN_MOST_H
#define IBL_KERN_MOST_H

#include <stddef.h>
#include <stdint.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

/* The bits of +Inf. */
#define IBL_MOST_INFINITE 0x7f800000u

/*
 * The bits of the largest of count floats. The result is below
 * IBL_MOST_INFINITE exactly when all of them are finite and none has a sign;
 * then every version returns the same. 0 for no floats. No alignment is needed.
 */
typedef uint32_t ibl_most_fn(const float *src, size_t count);

typedef struct ibl_most_dsp {
    ibl_most_fn *most;
} ibl_most_dsp;

/* The version for an instruction set. */
ibl_most_fn *ibl_most(ibl_isa isa);
IBL_DECLARE_INIT(ibl_most);

uint32_t ibl_most_c(const float *src, size_t count);

#endif
