/* SPDX-License-Identifier: MIT */
/*
 * The numbers of an ASTC block: bits, bounded integer sequences, and what the
 * integers of a range stand for. Khronos Data Format Specification 1.3,
 * sections 23.9, 23.12, 23.13 and 23.17.
 */
#ifndef IBL_KERN_ASTC_ISE_H
#define IBL_KERN_ASTC_ISE_H

#include <stdint.h>

/* A block, bit 0 first; low is its first 8 bytes, little endian. */
typedef struct ibl_bits128 {
    uint64_t low, high;
} ibl_bits128;

ibl_bits128 ibl_bits128_load(const unsigned char block[16]);
void ibl_bits128_store(ibl_bits128 bits, unsigned char block[16]);
/* The same bits, the last first. */
ibl_bits128 ibl_bits128_reversed(ibl_bits128 bits);
/* n bits, 0 to 32, from bit `at` on; bits beyond the last are 0. */
unsigned ibl_bits128_get(ibl_bits128 bits, int at, int n);
/* Sets n bits that are 0. */
void ibl_bits128_put(ibl_bits128 *bits, int at, int n, unsigned value);

/* The ranges 0 .. levels - 1 of integers, in ASTC's order. */
enum {
    IBL_ISE_2,
    IBL_ISE_3,
    IBL_ISE_4,
    IBL_ISE_5,
    IBL_ISE_6,
    IBL_ISE_8,
    IBL_ISE_10,
    IBL_ISE_12,
    IBL_ISE_16,
    IBL_ISE_20,
    IBL_ISE_24,
    IBL_ISE_32,
    IBL_ISE_40,
    IBL_ISE_48,
    IBL_ISE_64,
    IBL_ISE_80,
    IBL_ISE_96,
    IBL_ISE_128,
    IBL_ISE_160,
    IBL_ISE_192,
    IBL_ISE_256,
    IBL_ISE_RANGES
};
int ibl_ise_levels(int range);

/* How many bits a sequence takes. */
int ibl_ise_bits(int range, int count);

/* Reads count integers, at most 64, from bit `at` on; and writes them. */
void ibl_ise_get(ibl_bits128 bits, int at, int range, int count,
                 unsigned char *values);
void ibl_ise_put(ibl_bits128 *bits, int at, int range, int count,
                 const unsigned char *values);

/* What an integer stands for: an endpoint's 0 to 255, for ranges from IBL_ISE_6
 * on, and a weight's 0 to 64, for ranges up to IBL_ISE_32. */
int ibl_ise_endpoint(int range, int value);
int ibl_ise_weight(int range, int value);

#endif
