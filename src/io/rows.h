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
    /* Readers set format, low_range, bridged and primaries; io/mend.h and
     * source.c set the rest. */
    ibl_read_report report;
    /* Reads count rows from `row` on, using the pool; the caller then adds
     * count to row. Do not call it again after an error. With the last row it
     * frees what it decoded with. */
    ibl_status (*read)(ibl_rows *rows, int count, float *rgb);
    void (*close)(ibl_rows *rows); /* also frees the struct */
    /* The whole image, if the reader decodes it at once. A caller that passes
     * its data to read as rgb may take it afterwards. */
    ibl_image whole;
    /* Bytes of memory for each pixel that the reader holds, beside whole. */
    double held;
    /* Alpha of the whole map; ibl_rows_alloc_alpha makes it if it is wanted and
     * in the file. read fills in its rows; ibl_rows_close frees it. */
    float *alpha;
    bool straight;   /* colours are not multiplied by alpha */
    int orientation; /* of EXIF, 1 to 8: how the rows lie; 0: as 1 */
    unsigned char face_order[IBL_FACES]; /* the file's own; zeros: none */
    bool to_edges; /* the first and last texels of its faces lie on edges */
};

/* Opens a file: reads its header, and checks sizes before it takes memory for
 * them.
 *   in    open where it is read by rows, until they are closed
 *   rows  NULL; the caller must close them, after errors too */
typedef ibl_status ibl_open_fn(ibl_input *in, const ibl_read_options *opts,
                               ibl_rows **rows);
/* Whether a file begins like a kind. */
typedef bool ibl_is_fn(const unsigned char *bytes, size_t size);

/* Opens a file of any kind, by the table of readers in source.c. */
ibl_open_fn ibl_rows_open;

/* OpenEXR: the colour of one part and layer, as ibl_image_read says.
 * IBL_ERR_UNSUPPORTED: also if libiblexr.so, which undoes all compressions but
 * ZIP, is needed and missing. */
ibl_is_fn ibl_exr_is;
ibl_open_fn ibl_exr_open;
/* Radiance pictures. Divides by EXPOSURE and COLORCORR. IBL_ERR_UNSUPPORTED:
 * XYZE, unknown FORMAT, run lengths of before 1991. */
ibl_is_fn ibl_rgbe_is;
ibl_open_fn ibl_rgbe_open;
/* KTX2, KTX, DDS and Babylon's .env: level 0. */
ibl_is_fn ibl_texture_is;
ibl_open_fn ibl_texture_open;
/* JPEG; with a gain map 1 is the white of a plain screen, and colours are in
 * the primaries of the first JPEG's ICC profile. IBL_ERR_UNSUPPORTED: no
 * bridge; a profile or a kind of gain map that is not known. */
ibl_open_fn ibl_jpeg_open;
/* What OpenImageIO reads. What is missing at its end is an error. */
ibl_open_fn ibl_other_image_open;

/* Finds the primaries of an ICC profile (ICC.1:2022) of three colorants. xy:
 * red, green, blue and white. False: they are none of sRGB's, Display P3's and
 * Rec. 2020's. */
bool ibl_icc_primaries(const unsigned char *bytes, size_t size, double xy[8]);

/* ---- rows --------------------------------------------------------------- */

/* Calls rows->read and advances row. */
ibl_status ibl_rows_read(ibl_rows *rows, int count, float *rgb);
void ibl_rows_close(ibl_rows *rows); /* accepts NULL */
/* Allocates rows->alpha, width x height, all 0. */
ibl_status ibl_rows_alloc_alpha(ibl_rows *rows);

/* Turns an image into rows, which then own it, even after an error. What they
 * tell of the file is that of `like`, if that is not NULL. */
ibl_status ibl_rows_of_image(ibl_ctx *ctx, ibl_image *img, const ibl_rows *like,
                             ibl_rows **out);

/* Turns rows to lie as they should be seen: reads them all and replaces them,
 * maybe after an error, too. */
ibl_status ibl_rows_upright(const ibl_input *in, ibl_rows **rows);

/* The pixels of a program, which are checked, as ibl_open_fn says. */
ibl_status ibl_rows_of_pixels(const ibl_input *in, const ibl_pixels *pixels,
                              const ibl_read_options *opts, ibl_rows **rows);

#endif
