/* SPDX-License-Identifier: MIT */
/* What the codecs of block-compressed pixels have in common. */
#ifndef IBL_KERN_BLOCKS_H
#define IBL_KERN_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "ibl/io.h"

enum {
    IBL_BLOCK_EDGE = 4,
    IBL_BLOCK_TEXELS = IBL_BLOCK_EDGE * IBL_BLOCK_EDGE,
    IBL_BLOCK_BYTES = 16
};

/*
 * Encodes count blocks, each for itself, without allocating memory.
 *   texels  for each block 16 texels of 3 floats, rows from the top; finite, in
 *           [0, the format's largest value]
 *   blocks  IBL_BLOCK_BYTES each; no alignment
 * Minimises squared errors relative to each texel: dark texels beside a bright
 * one keep their values. Never writes a block with Inf or NaN.
 */
typedef void ibl_encode_blocks_fn(const float *texels, size_t count,
                                  ibl_quality quality, unsigned char *blocks);

/*
 * Decodes a block to halves, exactly as the specification says. Any 16 bytes
 * are allowed. Returns 0 if they are no valid block; texels are then what the
 * specification says, or 0.
 */
typedef int ibl_decode_block_fn(const unsigned char *block,
                                uint16_t texels[IBL_BLOCK_TEXELS][3]);

#endif
