/* SPDX-License-Identifier: MIT */
/* The interface of all image readers: each returns the next rows of a map. */
#ifndef IBL_IO_ROWS_H
#define IBL_IO_ROWS_H

#include <stdbool.h>
#include <stdint.h>

#include "ibl/io.h"
#include "io/input.h"

/* Refuses sizes over IBL_MAX_EDGE, and shapes that are not of opts->layout or,
 * if that is AUTO, of no layout. Readers call it before they decode. */
ibl_status ibl_map_check_size(const ibl_input *in, const ibl_read_options *opts,
                              long long width, long long height);
/* Allocates an image for a whole map; its size must have been checked. */
ibl_status ibl_map_alloc(const ibl_input *in, int width, int height,
                         ibl_image *img);

typedef struct ibl_rows ibl_rows;

/* The first member of a reader's own struct. Rows come from the zenith down,
 * with the values of the file; io/mend.h mends them. */
struct ibl_rows {
    ibl_ctx *ctx;
    int width, height;
    int row; /* the next row to read */
    /* Readers set format, low_range and bridged; io/mend.h and source.c set
     * the rest. */
    ibl_read_report report;
    /* Reads count rows from `row` on, using the pool; the caller then adds
     * count to row. Do not call it again after an error. With the last row it
     * frees what it decoded with. */
    ibl_status (*read)(ibl_rows *rows, int count, float *rgb);
    void (*close)(ibl_rows *rows); /* also frees the struct */
    /* The whole image, if the reader decodes it at once. A caller that takes it
     * passes its data to read as rgb. */
    ibl_image whole;
    /* Bytes of memory for each pixel that the reader holds, beside whole. */
    double held;
    bool silent; /* no progress reports: decoding reported it already */
    /* Alpha of the whole map; ibl_rows_alloc_alpha makes it if it is wanted and
     * in the file. read fills in its rows; ibl_rows_close frees it. */
    float *alpha;
    bool straight; /* colours are not multiplied by alpha */
    /* xy of red, green, blue and white; zeros: Rec.709's. */
    double primaries[8];
    bool has_primaries; /* the file names them */
    int orientation;    /* of EXIF, 1 to 8: how the rows lie; 0: as 1 */
    unsigned char face_order[IBL_FACES]; /* the file's own; zeros: none */
    bool to_edges; /* the first and last texels of its faces lie on edges */
};

/*
 * A kind of file. open reads its header, and checks sizes before it takes
 * memory for them. in    open where it is read by rows, until they are closed
 *   rows  NULL; the caller must close them, after errors too
 */
typedef struct ibl_reader {
    bool (*is)(const unsigned char *bytes, size_t size); /* of the first ones */
    ibl_status (*open)(ibl_input *in, const ibl_read_options *opts,
                       ibl_rows **rows);
} ibl_reader;

/* Opens a file of any kind, by the table of readers in source.c. */
ibl_status ibl_rows_open(ibl_input *in, const ibl_read_options *opts,
                         ibl_rows **rows);

/* ---- cube_rows.c: textures --------------------------------------------- */

bool ibl_texture_is(const unsigned char *bytes, size_t size);
ibl_status ibl_texture_open(ibl_input *in, const ibl_read_options *opts,
                            ibl_rows **rows);

/* ---- rows --------------------------------------------------------------- */

/* Calls rows->read, reports progress and advances row. */
ibl_status ibl_rows_read(ibl_rows *rows, int count, float *rgb);
/* Reports progress inside a call of read: its first `done` rows are done. */
void ibl_rows_progress(const ibl_rows *rows, int done);
void ibl_rows_close(ibl_rows *rows); /* accepts NULL */
/* Allocates rows->alpha, width x height, all 0. */
ibl_status ibl_rows_alloc_alpha(ibl_rows *rows);

/* Turns an image into rows, which then own it, even after an error. */
ibl_status ibl_rows_of_image(ibl_ctx *ctx, ibl_image *img, ibl_rows **out);

/* Turns rows to lie as they should be seen: reads them all and replaces them,
 * maybe after an error, too. */
ibl_status ibl_rows_upright(const ibl_input *in, ibl_rows **rows);

/* The pixels of a program, which are checked, as ibl_reader says. */
ibl_status ibl_rows_of_pixels(const ibl_input *in, const ibl_pixels *pixels,
                              const ibl_read_options *opts, ibl_rows **rows);

#endif
