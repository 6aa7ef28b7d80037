/* SPDX-License-Identifier: MIT */
/* What every reader of images is: something that gives the next rows. */
#ifndef IBL_IO_ROWS_H
#define IBL_IO_ROWS_H

#include <stdbool.h>
#include <stdint.h>

#include "ibl/io.h"

typedef struct ibl_rows ibl_rows;

/*
 * The head of a reader's own struct. Rows come from the zenith down, as the
 * file has them: what is not finite or negative is mended by others.
 */
struct ibl_rows {
    ibl_ctx *ctx;
    int width, height;
    int row;                /* the next */
    ibl_read_report report; /* format, low_range and bridged, once all is
                               read */
    /*
     * Reads count rows, which are there, from row on (which the caller then
     * counts up) on the pool. most: for each the ibl_max_finite of its floats.
     * Not to be called again after an error.
     */
    ibl_status (*read)(ibl_rows *rows, int count, float *rgb, uint32_t *most);
    void (*close)(ibl_rows *rows); /* frees the struct, too */
    /* The whole image, for readers that have it anyway. Who has taken it
     * gives read its own data for rgb. */
    ibl_image whole;
    bool silent; /* progress was told before, as if all had been read */
    /* Of the whole map, by ibl_rows_alloc_alpha, where it is asked for and the
     * file has it: read fills it for the rows that it reads, as the file has
     * it. Not the reader's to free. */
    float *alpha;
    bool straight; /* colours are not multiplied by it */
};

/* rows->read; counts row up. */
ibl_status ibl_rows_read(ibl_rows *rows, int count, float *rgb, uint32_t *most);
/* For readers that do much in one call: tells of the first `done` of its
 * rows. */
void ibl_rows_progress(const ibl_rows *rows, int done);
void ibl_rows_close(ibl_rows *rows); /* NULL is fine */
/* Makes rows->alpha of width x height, all 0. */
ibl_status ibl_rows_alloc_alpha(ibl_rows *rows);

/* Rows of an image, which becomes theirs, even after an error. */
ibl_status ibl_rows_of_image(ibl_ctx *ctx, ibl_image *img, ibl_rows **out);

/* Fills most for rows that a reader could not look at in its jobs. */
ibl_status ibl_rows_look(ibl_ctx *ctx, const float *rgb, int width, int count,
                         uint32_t *most);

#endif
