/* SPDX-License-Identifier: MIT */
/* Block-compressed pixels. */
#ifndef IBL_IO_BLOCKS_H
#define IBL_IO_BLOCKS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/context.h"
#include "ibl/io.h"
#include "kern/blocks.h"

/* Images of width x height texels, one after the other in src and dst. */
typedef struct ibl_block_images {
    ibl_pixel pixel;
    ibl_quality quality;
    bool alike; /* as in ibl_texel_options */
    int width, height;
    size_t images;
    const float *src;
    unsigned char *dst;
} ibl_block_images;

/* Encodes images on the pool, with NaN and negative values as 0. Texels
 * beyond an edge repeat the last ones. Adds to *beyond how many components of
 * the others were above the largest value. */
ibl_status ibl_blocks_encode_images(ibl_ctx *ctx, const ibl_block_images *of,
                                    size_t *beyond);

/* Decode the blocks of width x height texels to rows of floats, or of RGBA16F;
 * leave out texels beyond the edges. False: a block is not valid. */
int ibl_blocks_to_floats(ibl_pixel pixel, const unsigned char *blocks,
                         size_t width, size_t height, float *rgb);
int ibl_blocks_to_halves(ibl_pixel pixel, const unsigned char *blocks,
                         size_t width, size_t height, unsigned char *rgba);
/* The same for signed BC6H. */
void ibl_signed_blocks_to_halves(const unsigned char *blocks, size_t width,
                                 size_t height, unsigned char *rgba);

#endif
