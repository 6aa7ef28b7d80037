/* SPDX-License-Identifier: MIT */
/* Planes of halves, as EXR files have them, to pixels of floats. */
#ifndef IBL_KERN_HALVES_H
#define IBL_KERN_HALVES_H

#include "ibl/ibl.h"

/*
 * count pixels from three planes of halves, little endian, to tightly packed
 * floats; they may be the same plane. Exact, but that NaN may be any NaN. No
 * alignment is needed.
 */
typedef void ibl_halves_fn(const unsigned char *const plane[3], int count,
                           float *dst);

/* The version for an instruction set. */
ibl_halves_fn *ibl_halves(ibl_isa isa);

void ibl_halves_c(const unsigned char *const plane[3], int count, float *dst);
void ibl_halves_avx2(const unsigned char *const plane[3], int count,
                     float *dst);

#endif
