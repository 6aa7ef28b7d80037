/* SPDX-License-Identifier: MIT */
/* What EXR files have: bytes made ready to be deflated, and planes of halves
 * that become pixels of floats. */
#ifndef IBL_KERN_HALF_PLANES_H
#define IBL_KERN_HALF_PLANES_H

#include <stddef.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

/*
 * Before ZIP deflates the bytes of a block it puts those at even places before
 * those at odd ones, and in place of all but the first their difference to the
 * one before, plus 128. Nothing needs an alignment.
 */
typedef struct ibl_half_planes_dsp {
    /* The sum of count bytes, modulo 256. */
    unsigned char (*sum)(const unsigned char *src, size_t count);
    /*
     * The next 2 count bytes from count differences of each half.
     *   last  the bytes before them at even and at odd places; becomes the
     *         last of these
     */
    void (*unzip)(const unsigned char *even, const unsigned char *odd,
                  size_t count, unsigned char last[2], unsigned char *dst);
    /*
     * count pixels from three planes of halves, little endian, to tightly
     * packed floats; they may be the same plane. Exact, but that NaN may be any
     * NaN.
     */
    void (*to_rgb)(const unsigned char *const plane[3], int count, float *dst);
} ibl_half_planes_dsp;

IBL_DECLARE_KERNEL(ibl_half_planes);

/* Sets last for the first bytes of a block, of which src are the evens. */
void ibl_unzip_begin(const ibl_half_planes_dsp *dsp, const unsigned char *src,
                     size_t count, unsigned char last[2]);

/* The plain versions, for what the vectors leave at the end. */
unsigned char ibl_unzip_sum_c(const unsigned char *src, size_t count);
void ibl_unzip_c(const unsigned char *even, const unsigned char *odd,
                 size_t count, unsigned char last[2], unsigned char *dst);
void ibl_half_planes_c(const unsigned char *const plane[3], int count,
                       float *dst);

#endif
