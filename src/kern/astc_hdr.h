/* SPDX-License-Identifier: MIT */
/*
 * ASTC HDR blocks of 4x4 texels, RGB: the part of them that UASTC HDR 4x4
 * allows (Binomial, "UASTC HDR 4x4 Texture Specification" 1.1; Khronos Data
 * Format Specification 1.3, chapter 23), which the Basis Universal transcoder
 * turns into BC6H too.
 */
#ifndef IBL_KERN_ASTC_HDR_H
#define IBL_KERN_ASTC_HDR_H

#include "kern/blocks.h"
#include "kern/isa.h"

/* The largest value of a texel: with what texels lie between, 65504 is beyond
 * reach, since 12 bits of the logarithm hold no more. */
#define IBL_ASTC_HDR_MAX 65216.0f

/* The first 64 bits of a block of one colour, three halves and alpha. */
#define IBL_ASTC_ONE_COLOUR UINT64_C(0xFFFFFFFFFFFFFFFC)

enum {
    IBL_ASTC_PAST = 256 /* blocks whose weights another one may have */
};

/* The weights of the last blocks that have some of their own. */
typedef struct ibl_astc_past {
    float places[IBL_BLOCK_TEXELS][IBL_ASTC_PAST]; /* between the ends */
    unsigned char level[IBL_ASTC_PAST][IBL_BLOCK_TEXELS];
    int count, next; /* blocks, and where the next one goes */
    float alike;     /* the share of blocks that had weights of others */
} ibl_astc_past;

/* With many blocks alike, less is lost for more of them. */
#define IBL_ASTC_ALIKE 0.625f
#define IBL_ASTC_ALIKE_LOSS 3

/*
 * Of a block, encode minimises the sum over its texels t of |error|^2 (1 /
 * (|t|^2
 * + (2^-17 m)^2) + 128 |t|^2 / S^2), where m is the largest value in it and S
 * the sum of |t|^2: dark texels keep their values, and so does a sun. That of
 * ASTC's decoder has 7/10 in it, the other part is that of BC6H as transcoded.
 * The former is never more than that of the best colour for all.
 */
typedef struct ibl_astc_hdr_dsp {
    ibl_encode_blocks_fn *encode;
    /*
     * The same for a file that is to be compressed: a block whose weights are
     * those of an earlier one, byte by byte, is taken instead of the best one
     * if its error is at most 1 + (1 - share / IBL_ASTC_ALIKE)
     * IBL_ASTC_ALIKE_LOSS times that of the best; share is that of the last
     * blocks that were taken so. *past starts as 0; other calls with it go on.
     */
    void (*encode_alike)(const float *texels, size_t count, ibl_quality quality,
                         ibl_astc_past *past, unsigned char *blocks);
} ibl_astc_hdr_dsp;

IBL_DECLARE_KERNEL(ibl_astc_hdr);

/* As decoders of the HDR profile of ASTC. Other ASTC blocks are not valid;
 * their texels are 0. */
ibl_decode_block_fn ibl_astc_hdr_decode_block;

#endif
