/* SPDX-License-Identifier: MIT */
/* The ways to store a block that UASTC HDR 4x4 allows, and what is the same for
 * all blocks stored so. */
#ifndef IBL_KERN_ASTC_WAYS_H
#define IBL_KERN_ASTC_WAYS_H

#include "kern/astc_fit.h"
#include "kern/astc_hdr_endpoints.h"
#include "kern/astc_ise.h"
#include "kern/astc_quantise.h"

typedef struct ibl_astc_way {
    unsigned char subsets, mode, weight_range, value_range;
} ibl_astc_way;

/* Those of 24 that are worth trying besides one colour for all, each kind from
 * most levels of weights on. */
enum {
    IBL_ASTC_DIRECT_1 = 0, /* one subset */
    IBL_ASTC_SCALE_2 = 2,  /* two */
    IBL_ASTC_WAYS = 5
};
extern const ibl_astc_way ibl_astc_ways[IBL_ASTC_WAYS];

/* The patterns of two subsets that BC6H has, too. */
extern const unsigned short ibl_astc_patterns[IBL_ASTC_PATTERNS];

typedef struct ibl_astc_tables {
    const ibl_astc_fit_dsp *fit;
    ibl_astc_levels levels[IBL_ISE_16 + 1];
    ibl_astc_codes codes[IBL_ISE_RANGES];
    /* Of patterns: see ibl_astc_fit_dsp. */
    float second[IBL_BLOCK_TEXELS][IBL_ASTC_PATTERNS_PADDED];
    float count[IBL_ASTC_PATTERNS_PADDED];
    /* BC6H's pattern, and whether its first region is the second subset. */
    unsigned char region[IBL_ASTC_PATTERNS], inverse[IBL_ASTC_PATTERNS];
} ibl_astc_tables;

void ibl_astc_set_tables(const ibl_astc_fit_dsp *fit, ibl_astc_tables *t);

/* A subset's line as it is stored. */
typedef struct ibl_astc_line {
    float error;
    unsigned char values[6];
    unsigned char level[IBL_BLOCK_TEXELS];
} ibl_astc_line;

/*
 * The error of what the Basis Universal transcoder makes of a block for BC6H:
 * it takes the finest mode that has the ends, and the nearest weights.
 *   t, l  a subset and its line, or two of each
 */
float ibl_astc_error_as_bc6h(const ibl_astc_tables *tb, const ibl_astc_way *w,
                             int pattern, const ibl_astc_texels t[],
                             const ibl_astc_line l[]);

#endif
