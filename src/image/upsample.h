/* SPDX-License-Identifier: MIT */
/*
 * A source on a finer grid: for maps whose pixels are larger than the texels,
 * interpolated bilinearly, and for those of few columns, each pixel repeated,
 * which keeps the straight pieces of level 0 short. Rows come one by one; a
 * fine row needs two of them at most.
 */
#ifndef IBL_IMAGE_UPSAMPLE_H
#define IBL_IMAGE_UPSAMPLE_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "kern/octant_sums.h"

typedef struct ibl_upsample {
    int width, height; /* of the source */
    int scale_x, scale_y;
    int columns, rows; /* of the fine grid */
    bool bilinear;     /* else every fine pixel has its source pixel's value */
    ibl_octant_tap *taps; /* columns; NULL where the grid is the source's */
    double *bend;         /* height + 1, if bilinear: see upsample.c */
} ibl_upsample;

/* For faces of n x n texels. */
ibl_status ibl_upsample_init(ibl_ctx *ctx, int width, int height, int n,
                             ibl_upsample *f);
void ibl_upsample_free(ibl_upsample *f);

/*
 * A fine row between two of the source, which are the caller's to find: rows
 * source[0] and source[1]. Beyond a pole is the row next to it, half a turn
 * away.
 */
ibl_octant_blend ibl_upsample_between(const ibl_upsample *f, int row,
                                      int source[2]);

#endif
