/* SPDX-License-Identifier: MIT */
/* Encoders of the pixel formats in ibl/io.h, and a decoder. All versions give
 * the same bytes and the same count as the plain one: they round alike and sum
 * nothing. */
#ifndef IBL_KERN_PIXEL_H
#define IBL_KERN_PIXEL_H

#include <stddef.h>
#include <stdint.h>

#include "ibl/io.h"
#include "kern/isa.h"

/*
 * Encodes count texels of ibl_pixel_channels(pixel) floats to count texels of
 * ibl_pixel_bytes(pixel), as ibl/io.h says. No alignment, any count;
 * accesses nothing outside of the two arrays. Returns how many components were
 * beyond the largest finite value.
 */
typedef size_t ibl_encode_fn(const float *src, size_t count, void *dst);

/* NULL: pixels of blocks, which kern/blocks.h describes. */
typedef struct ibl_pixel_dsp {
    ibl_encode_fn *encode[IBL_PIXEL_COUNT];
    /* Decodes count texels of RGBA16F to three floats each. Exact, except that
     * a NaN may become any NaN. */
    void (*decode_rgba16f)(const void *src, size_t count, float *dst);
} ibl_pixel_dsp;

IBL_DECLARE_KERNEL(ibl_pixel);

#define IBL_HALF_MAX 65504.0f    /* (2 - 2^-10) 2^15 */
#define IBL_SMALL11_MAX 65024.0f /* (2 - 2^-6) 2^15 */
#define IBL_SMALL10_MAX 64512.0f /* (2 - 2^-5) 2^15 */
#define IBL_RGB9E5_MAX 65408.0f  /* 511/512 2^16 */

/* The plain versions, for the rest after whole vectors. */
ibl_encode_fn ibl_encode_rgba16f_c, ibl_encode_rg16f_c;
void ibl_decode_rgba16f_c(const void *src, size_t count, float *dst);

#endif
