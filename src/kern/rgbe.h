/* SPDX-License-Identifier: MIT */
/*
 * The loops of the Radiance reader: run lengths to bytes, bytes to floats.
 * Every version gives the same bits.
 */
#ifndef IBL_KERN_RGBE_H
#define IBL_KERN_RGBE_H

#include <stddef.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

/* Bytes that ibl_rgbe_dsp.expand may read and write beyond its arrays. */
#define IBL_RGBE_SLACK 64

typedef struct ibl_rgbe_dsp {
    /*
     * Expands one component of a run-length encoded scanline to count bytes.
     *   src   a checked record: its counts sum to count, none is 0. Readable
     *         for IBL_RGBE_SLACK bytes beyond the record.
     *   dst   writable for count + IBL_RGBE_SLACK bytes
     * Returns the end of the record. The plain version needs no slack.
     */
    const unsigned char *(*expand)(const unsigned char *src, int count,
                                   unsigned char *dst);
    /*
     * Decodes count pixels from four planes of bytes, plane_bytes apart (R, G,
     * B, exponent), to tightly packed RGB:
     *   dst = (m * 2^(e - 136)) * scale[c], 0 where e is 0
     * No half is added to the mantissa. No alignment is needed.
     */
    void (*to_rgb)(const unsigned char *src, size_t plane_bytes, int count,
                   const float scale[3], float *dst);
} ibl_rgbe_dsp;

IBL_DECLARE_KERNEL(ibl_rgbe);

/* The plain version, for the rest after whole vectors. */
void ibl_rgbe_to_rgb_c(const unsigned char *src, size_t plane_bytes, int count,
                       const float scale[3], float *dst);

#endif
