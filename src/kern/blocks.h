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

/* A block, bit 0 first; low is its first 8 bytes, little endian. */
typedef struct ibl_bits128 {
    uint64_t low, high;
} ibl_bits128;

static inline ibl_bits128 ibl_bits128_load(const unsigned char *block)
{
    ibl_bits128 b = {0, 0};
    for (int i = 0; i < 8; i++) {
        b.low |= (uint64_t)block[i] << 8 * i;
        b.high |= (uint64_t)block[8 + i] << 8 * i;
    }
    return b;
}

static inline void ibl_bits128_store(ibl_bits128 b, unsigned char *block)
{
    for (int i = 0; i < 8; i++) {
        block[i] = (unsigned char)(b.low >> 8 * i);
        block[8 + i] = (unsigned char)(b.high >> 8 * i);
    }
}

/* n bits, 0 to 32, from bit `at` on; bits beyond the last are 0. */
static inline unsigned ibl_bits128_get(ibl_bits128 b, int at, int n)
{
    uint64_t v = 0;
    if (at < 64)
        v = b.low >> at | (at ? b.high << (64 - at) : 0);
    else if (at < 128)
        v = b.high >> (at - 64);
    return (unsigned)(v & ((UINT64_C(1) << n) - 1));
}

/* Sets n bits that are 0 to the lowest of value. */
static inline void ibl_bits128_put(ibl_bits128 *b, int at, int n, int value)
{
    const uint64_t v = (uint64_t)value & ((UINT64_C(1) << n) - 1);
    if (at < 64)
        b->low |= v << at;
    if (at >= 64)
        b->high |= v << (at - 64);
    else if (at + n > 64)
        b->high |= v >> (64 - at);
}

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
