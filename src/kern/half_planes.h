/* SPDX-License-Identifier: MIT */
/* Decoding of EXR data: undoes the preparation of bytes for ZIP, and converts
 * planes of halves to pixels of floats. */
#ifndef IBL_KERN_HALF_PLANES_H
#define IBL_KERN_HALF_PLANES_H

#include <stddef.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

/*
 * Before compression by ZIP, a block's bytes at even places are put before
 * those at odd places. Then all but the first byte are replaced by their
 * difference to the previous one, plus 128. Nothing needs an alignment.
 */
typedef struct ibl_half_planes_dsp {
    /* The sum of count bytes, modulo 256. */
    unsigned char (*sum)(const unsigned char *src, size_t count);
    /*
     * Writes the next 2 count bytes from count differences of each half.
     *   last  the previous byte at even and at odd places; becomes the last
     *         ones of these
     */
    void (*unzip)(const unsigned char *even, const unsigned char *odd,
                  size_t count, unsigned char last[2], unsigned char *dst);
    /*
     * Converts count pixels from three planes of halves, little endian, to
     * tightly packed floats; planes may coincide. Exact, except that a NaN may
     * become any NaN.
     */
    void (*to_rgb)(const unsigned char *const plane[3], int count, float *dst);
} ibl_half_planes_dsp;

IBL_DECLARE_KERNEL(ibl_half_planes);

/* Sets last for the start of a block; src are its even differences. */
void ibl_unzip_begin(const ibl_half_planes_dsp *dsp, const unsigned char *src,
                     size_t count, unsigned char last[2]);

/* The plain versions, for the rest after whole vectors. */
unsigned char ibl_unzip_sum_c(const unsigned char *src, size_t count);
void ibl_unzip_c(const unsigned char *even, const unsigned char *odd,
                 size_t count, unsigned char last[2], unsigned char *dst);
void ibl_half_planes_c(const unsigned char *const plane[3], int count,
                       float *dst);

#endif
