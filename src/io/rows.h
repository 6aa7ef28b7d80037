/* SPDX-License-Identifier: MIT */
/* The interface of all image readers: each gives the next rows of a map. */
#ifndef IBL_IO_ROWS_H
#define IBL_IO_ROWS_H

#include <stdbool.h>
#include <stdint.h>

#include "ibl/io.h"
#include "io/input.h"

/* Refuses sizes over IBL_MAX_EDGE and, without opts->any_aspect, maps that
 * are not 2:1. Readers call it before they decode. */
ibl_status ibl_map_check_size(const ibl_input *in, const ibl_read_options *opts,
                              long long width, long long height);
/* An image for all of a map, whose size has been checked. */
ibl_status ibl_map_alloc(const ibl_input *in, int width, int height,
                         ibl_image *img);

typedef struct ibl_rows ibl_rows;

/*
 * The head of a reader's own struct. Rows come from the zenith down, with the
 * values of the file; io/repair.h mends them.
 */
struct ibl_rows {
    ibl_ctx *ctx;
    int width, height;
    int row; /* the next */
    /* Format, low_range and bridged, once all is read; io/repair.h and
     * source.c fill in the rest. */
    ibl_read_report report;
    /* Reads the count rows from `row` on the pool; the caller then adds count
     * to row. most: for each row the ibl_max_finite of its floats. Not to be
     * called again after an error. */
    ibl_status (*read)(ibl_rows *rows, int count, float *rgb, uint32_t *most);
    void (*close)(ibl_rows *rows); /* frees the struct, too */
    /* The whole image, of readers that have it anyway. A caller that takes it
     * passes its data to read as rgb. */
    ibl_image whole;
    bool silent; /* progress was reported before, up to the last row */
    /* Of the whole map, by ibl_rows_alloc_alpha, if it is asked for and the
     * file has it; read fills in its rows. ibl_rows_close frees it. */
    float *alpha;
    bool straight; /* colours are not multiplied by it */
};

/* rows->read; counts row up. */
ibl_status ibl_rows_read(ibl_rows *rows, int count, float *rgb, uint32_t *most);
/* Reports that the first `done` rows of a call of read are done. */
void ibl_rows_progress(const ibl_rows *rows, int done);
void ibl_rows_close(ibl_rows *rows); /* NULL is fine */
/* Makes rows->alpha of width x height, all 0. */
ibl_status ibl_rows_alloc_alpha(ibl_rows *rows);

/* Rows of an image, which becomes theirs, even after an error. */
ibl_status ibl_rows_of_image(ibl_ctx *ctx, ibl_image *img, ibl_rows **out);

/* Fills in most, for readers whose jobs do not see whole rows. */
ibl_status ibl_rows_look(ibl_ctx *ctx, const float *rgb, int width, int count,
                         uint32_t *most);

#endif
