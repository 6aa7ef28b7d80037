/* SPDX-License-Identifier: MIT */
/*
 * Weighted sums of trilinear lookups in a cube: one texel of a prefiltered
 * map. All versions compute the same lookup positions and the same weights to
 * the last bit; only the order and the fusing of the final sums differ.
 */
#ifndef IBL_KERN_GATHER_H
#define IBL_KERN_GATHER_H

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_GATHER_ALIGN = 16, /* in samples; groups begin at multiples of it */
    IBL_GATHER_MAX_GROUP = 256, /* most samples summed in float */
    IBL_GATHER_MAX_EDGE = 8192  /* offsets in floats then fit an int */
};

/* A mip level as in image/pyramid.h: six faces of (edge + 2)^2 texels of 4
 * floats with a border of one texel. The fourth float is finite and ignored. */
typedef struct ibl_gather_level {
    const float *texels;
    int edge; /* 1..IBL_GATHER_MAX_EDGE */
} ibl_gather_level;

/* Samples that look up one mip level, and if mips is 2 also the next. */
typedef struct ibl_gather_group {
    int first; /* a multiple of IBL_GATHER_ALIGN */
    int count; /* 1..IBL_GATHER_MAX_GROUP */
    int level;
    int mips; /* 1 or 2 */
} ibl_gather_group;

/*
 * Samples as separate arrays, 64-byte aligned. They must be readable, with
 * directions not zero, up to the next multiple of IBL_GATHER_ALIGN after each
 * group.
 */
typedef struct ibl_gather_samples {
    const float *x, *y, *z;     /* direction along tangent, bitangent, normal;
                                   any length but zero, finite */
    const float *fine, *coarse; /* weights of the two mips */
    const ibl_gather_group *groups;
    int group_count;
} ibl_gather_samples;

typedef struct ibl_gather_dsp {
    /*
     * rgb = sum over samples of fine lookup(level) + coarse lookup(level + 1).
     *   levels  indexed by the groups' level
     *   frame   tangent, bitangent, normal: three vectors of x, y, z
     */
    void (*gather)(const ibl_gather_samples *samples,
                   const ibl_gather_level *levels, const float frame[9],
                   double rgb[3]);
} ibl_gather_dsp;

IBL_DECLARE_KERNEL(ibl_gather);

#endif
