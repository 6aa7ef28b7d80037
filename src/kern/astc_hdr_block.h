/* SPDX-License-Identifier: MIT */
/* The parts of an ASTC block of 4x4 texels, before anything is computed. */
#ifndef IBL_KERN_ASTC_HDR_BLOCK_H
#define IBL_KERN_ASTC_HDR_BLOCK_H

#include "kern/astc_ise.h"

enum {
    IBL_ASTC_SUBSETS = 4,
    IBL_ASTC_VALUES = 18,
    IBL_ASTC_TEXELS = 16
};

typedef struct ibl_astc_block {
    int subsets;                     /* 1 to 4 */
    int pattern;                     /* which texel is of which, if several */
    int mode[IBL_ASTC_SUBSETS];      /* of the endpoints */
    int values, value_range;         /* of all endpoints */
    int width, height, weight_range; /* of the weights */
    int planes, plane2; /* 2: channel plane2 has weights of its own */
    unsigned char value[IBL_ASTC_VALUES]; /* integers of sequences */
    unsigned char weight[2 * IBL_ASTC_TEXELS];
} ibl_astc_block;

/* Takes a block apart, one of a single colour excepted. False: invalid. */
int ibl_astc_unpack(ibl_bits128 bits, ibl_astc_block *b);

/* Puts one together, of one plane, a weight for each texel and one mode for all
 * subsets; width and height are left out of account. */
ibl_bits128 ibl_astc_pack(const ibl_astc_block *b);

/* The subset, 0 to subsets - 1, of each texel. */
void ibl_astc_find_subsets(int pattern, int subsets,
                           unsigned char of[IBL_ASTC_TEXELS]);

#endif
