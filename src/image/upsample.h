/* SPDX-License-Identifier: MIT */
/*
 * Resamples a source to a finer grid. Maps whose pixels are larger than the
 * texels are interpolated bilinearly. Maps with few columns get each pixel
 * repeated, which keeps the strips of level 0 short. Rows come one by one; a
 * fine row needs at most two of them.
 */
#ifndef IBL_IMAGE_UPSAMPLE_H
#define IBL_IMAGE_UPSAMPLE_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "kern/octant_sums.h"

typedef struct ibl_upsample {
    int width, height; /* size of the source */
    int scale_x, scale_y;
    int columns, rows; /* size of the fine grid */
    bool bilinear; /* false: a fine pixel has the value of its source pixel */
    ibl_octant_tap *taps; /* columns; NULL if the grid is the source's */
    double *bend;         /* height + 1 entries, if bilinear: see upsample.c */
} ibl_upsample;

/* Chooses the grid for faces of n x n texels. */
ibl_status ibl_upsample_init(ibl_ctx *ctx, int width, int height, int n,
                             ibl_upsample *f);
void ibl_upsample_free(ibl_upsample *f);

/*
 * A fine row between two rows of the source; the caller must supply rows
 * source[0] and source[1]. Beyond a pole, the row next to the pole continues,
 * half a turn away.
 */
ibl_octant_blend ibl_upsample_between(const ibl_upsample *f, int row,
                                      int source[2]);

#endif
