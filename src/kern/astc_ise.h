/* SPDX-License-Identifier: MIT */
/*
 * The numbers of an ASTC block: bounded integer sequences, and what the
 * integers of a range stand for. Khronos Data Format Specification 1.3,
 * sections 23.9, 23.12, 23.13 and 23.17.
 */
#ifndef IBL_KERN_ASTC_ISE_H
#define IBL_KERN_ASTC_ISE_H

#include "kern/blocks.h"

/* The ranges 0 .. levels - 1 of integers that blocks of UASTC HDR have: of
 * weights up to IBL_ISE_16, of endpoints from IBL_ISE_40 on. */
enum {
    IBL_ISE_3,
    IBL_ISE_4,
    IBL_ISE_5,
    IBL_ISE_6,
    IBL_ISE_8,
    IBL_ISE_10,
    IBL_ISE_12,
    IBL_ISE_16,
    IBL_ISE_40,
    IBL_ISE_64,
    IBL_ISE_80,
    IBL_ISE_128,
    IBL_ISE_192,
    IBL_ISE_256,
    IBL_ISE_RANGES
};
int ibl_ise_levels(int range);

/* How many bits a sequence takes. */
int ibl_ise_bits(int range, int count);

/* Reads count integers, at most 16, from bit `at` on; and writes them. */
void ibl_ise_get(ibl_bits128 bits, int at, int range, int count,
                 unsigned char *values);
void ibl_ise_put(ibl_bits128 *bits, int at, int range, int count,
                 const unsigned char *values);

/* What an integer stands for: an endpoint's 0 to 255, and a weight's 0 to 64.
 */
int ibl_ise_endpoint(int range, int value);
int ibl_ise_weight(int range, int value);

#endif
