/* SPDX-License-Identifier: MIT */
#ifndef IBL_BRDF_HAMMERSLEY_H
#define IBL_BRDF_HAMMERSLEY_H

#include <stdint.h>

/* The bits of i in reverse order: Van der Corput's radical inverse in base 2,
 * as a fraction of 2^32. */
static inline uint32_t ibl_reverse_bits(uint32_t i)
{
    i = (i << 16) | (i >> 16);
    i = ((i & 0x00ff00ffu) << 8) | ((i & 0xff00ff00u) >> 8);
    i = ((i & 0x0f0f0f0fu) << 4) | ((i & 0xf0f0f0f0u) >> 4);
    i = ((i & 0x33333333u) << 2) | ((i & 0xccccccccu) >> 2);
    i = ((i & 0x55555555u) << 1) | ((i & 0xaaaaaaaau) >> 1);
    return i;
}

/* Radical inverse in base 2, in [0, 1), exact. */
static inline double ibl_radical_inverse(uint32_t i)
{
    return (double)ibl_reverse_bits(i) * 0x1p-32;
}

/*
 * Point i of n. u1 is the middle of interval i of n, so never 0 or 1. It sets
 * the angle from the axis: the density of the samples is monotone in i. u2, in
 * [0, 1), sets the azimuth.
 */
static inline void ibl_hammersley(uint32_t i, uint32_t n, double *u1,
                                  double *u2)
{
    *u1 = ((double)i + 0.5) / (double)n;
    *u2 = ibl_radical_inverse(i);
}

#endif
