/* SPDX-License-Identifier: MIT */
/*
 * A source on a finer grid: for maps whose pixels are larger than the texels,
 * interpolated bilinearly, and for those of few columns, each pixel repeated,
 * which keeps the straight pieces of level 0 short. Rows come one by one; a
 * fine row needs two of them at most.
 */
#ifndef IBL_IMAGE_FINER_H
#define IBL_IMAGE_FINER_H

#include <stdbool.h>

#include "ibl/ibl.h"

/* Where a fine column lies between two of the source: their offsets in floats
 * and the weight of the second. */
typedef struct ibl_finer_tap {
    int at[2];
    double weight;
} ibl_finer_tap;

typedef struct ibl_finer {
    int width, height; /* of the source */
    int scale_x, scale_y;
    int columns, rows; /* of the fine grid */
    bool bilinear;     /* else every fine pixel has its source pixel's value */
    ibl_finer_tap *taps; /* columns; NULL where the grid is the source's */
    double *bend;        /* height + 1, if bilinear: see finer.c */
} ibl_finer;

/* For faces of n x n texels. */
ibl_status ibl_finer_init(ibl_ctx *ctx, int width, int height, int n,
                          ibl_finer *f);
void ibl_finer_free(ibl_finer *f);

/* A fine row between two of the source. Beyond a pole is the row next to it,
 * half a turn away: those columns are taken half the grid further on. */
typedef struct ibl_finer_row {
    int row[2];  /* of the source */
    int turn[2]; /* fine columns to go on by */
    double weight[2];
} ibl_finer_row;

ibl_finer_row ibl_finer_between(const ibl_finer *f, int row);

/*
 * ibl_octants_collect from the fine grid.
 *   source  the two rows of the source
 *   column  count of IBL_OCTANTS fine columns
 *   lanes   how many of them to write; what others hold stays
 */
void ibl_finer_collect(const ibl_finer *f, const ibl_finer_row *row,
                       const float *const source[2], const int *column,
                       int count, int lanes, double *pixels);

#endif
