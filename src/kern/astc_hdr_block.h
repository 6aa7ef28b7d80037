/* SPDX-License-Identifier: MIT */
/* The parts of a block of UASTC HDR, before anything is computed. */
#ifndef IBL_KERN_ASTC_HDR_BLOCK_H
#define IBL_KERN_ASTC_HDR_BLOCK_H

#include "kern/astc_ise.h"

enum {
    IBL_ASTC_VALUES = 12
};

typedef struct ibl_astc_block {
    int subsets;             /* 1 or 2 */
    int pattern;             /* which texel is of which, of two */
    int mode;                /* IBL_ASTC_SCALE or IBL_ASTC_DIRECT */
    int values, value_range; /* of all endpoints */
    int weight_range;
    unsigned char value[IBL_ASTC_VALUES]; /* integers of sequences */
    unsigned char weight[IBL_BLOCK_TEXELS];
} ibl_astc_block;

/* Takes a block apart, one of a single colour excepted. False: it is none of
 * UASTC HDR. */
int ibl_astc_unpack(ibl_bits128 bits, ibl_astc_block *b);
ibl_bits128 ibl_astc_pack(const ibl_astc_block *b);

/* The subset, 0 or 1, of each texel in a pattern of two. */
void ibl_astc_find_subsets(int pattern, unsigned char of[IBL_BLOCK_TEXELS]);

#endif
