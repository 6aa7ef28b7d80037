/* SPDX-License-Identifier: MIT */
/* Shared by the files of the EXR reader. */
#ifndef IBL_IO_EXR_FILE_H
#define IBL_IO_EXR_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <OpenEXR/openexr.h>

#include "io/bridge/openexr.h"
#include "io/input.h"
#include "io/rows.h"
#include "kern/half_planes.h"
#include "kern/max_finite.h"

/* A file opened by OpenEXRCore. */
typedef struct ibl_exr_file {
    const ibl_input *in;
    exr_context_t exr;
    bool deaf;      /* jobs run: error texts of OpenEXRCore are dropped */
    bool no_memory; /* OpenEXRCore ran out of memory */
    int error;      /* errno of a failed read by OpenEXRCore, or 0 */
    char text[256]; /* first error text of OpenEXRCore; callers empty it to get
                       the next one */
} ibl_exr_file;

/* Pixels x0..x1, y0..y1, both ends included. */
typedef struct ibl_exr_window {
    int x0, y0, x1, y1;
    int width, height;
} ibl_exr_window;

typedef enum ibl_exr_colour {
    IBL_EXR_RGB,
    IBL_EXR_LUMA,       /* only Y */
    IBL_EXR_LUMA_CHROMA /* Y RY BY */
} ibl_exr_colour;

/* The pixels to read: a part and three of its channels. */
typedef struct ibl_exr_pick {
    int part;
    ibl_exr_colour colour;
    int channel[3];  /* indices in the part's list: R G B, Y Y Y or Y RY BY */
    int alpha;       /* index of A, or -1 if not wanted or not there */
    int chroma_step; /* 1; 2 where RY and BY have half the width and height */
    const exr_attr_chlist_t *channels; /* owned by OpenEXRCore */
    exr_compression_t compression;
    bool tiled;
    bool cube;                     /* the file says that it holds six faces */
    int block_width, block_height; /* of a tile, or a block of scan lines */
    ibl_exr_window display, data;
    float luma[3];      /* weights of R, G and B in Y; of IBL_EXR_LUMA_CHROMA */
    bool has_primaries; /* the file has chromaticities */
    double primaries[8]; /* xy of red, green, blue, white; else Rec. 709's */
} ibl_exr_pick;

/* "ZIP", "DWAA", ... */
const char *ibl_exr_compression_name(exr_compression_t compression);

/* Finds the part and layer of opts, and the part's windows. If they are not
 * found, the message lists the parts or layers of the file. */
ibl_status ibl_exr_choose(ibl_exr_file *file, const ibl_read_options *opts,
                          ibl_exr_pick *pick);

/* The chunks of level 0 that overlap the image, in the part's order. start_x
 * and start_y are a chunk's first pixel, in the file's coordinates. A chunk
 * whose packed and unpacked sizes are equal is not compressed. */
typedef struct ibl_exr_table {
    exr_chunk_info_t *chunks;
    int count;
    int columns;          /* number of chunks side by side: 1 without tiles */
    int lines;            /* height of a chunk; the last ones may have fewer */
    uint64_t unpacked;    /* bytes of all chunks */
    uint32_t most_packed; /* bytes of the largest chunk, packed */
    uint32_t most_unpacked, most_line; /* and unpacked; of a line */
} ibl_exr_table;

/* Lists the chunks. Checks that the file contains them and that the compression
 * can produce their sizes. */
ibl_status ibl_exr_list_chunks(ibl_exr_file *file, const ibl_exr_pick *pick,
                               ibl_exr_table *table);
/* Planes of RY and BY, half the data window's width and height. */
typedef struct ibl_exr_chroma {
    int width, height;
    float *plane[2];
} ibl_exr_chroma;

/* A worker's state for undoing the compression. */
typedef struct ibl_exr_unpacker ibl_exr_unpacker;

/* The state of decoding a part. */
typedef struct ibl_exr_decoder {
    ibl_exr_file file;
    ibl_exr_pick pick;
    ibl_exr_table table;
    /* ibl_exr_decoder_init sets the members from here on. */
    ibl_exr_unpacker *unpackers; /* one for each thread */
    ibl_openexr_unpack *library; /* NULL: OpenEXRCore does without */
    ibl_max_finite_fn *look;
    ibl_half_planes_dsp dsp;
    bool halves; /* the three channels are halves at full size */
    int threads;
    int per_job; /* chunks */
} ibl_exr_decoder;

/* file, pick and table must be set. IBL_ERR_UNSUPPORTED: the compression needs
 * libiblexr.so, which is missing or cannot undo it here. ibl_exr_decoder_free
 * also closes the file and frees d, which must come from ibl_alloc_zeroed. */
ibl_status ibl_exr_decoder_init(ibl_exr_decoder *d);
void ibl_exr_decoder_free(ibl_exr_decoder *d); /* accepts NULL */

/* Rows of the map that receive the decoded chunks. */
typedef struct ibl_exr_target {
    float *rgb;
    int row, count; /* the first, in the display window; how many */
    uint32_t *most; /* d->look of each row, or NULL */
    float *alpha;   /* of the whole map, or NULL */
    ibl_exr_chroma *chroma;
} ibl_exr_target;

/* Decodes the visible part of count chunks to the target, on the pool. Does not
 * write pixels outside the data window. Half-size chroma goes to chroma. */
ibl_status ibl_exr_decode_chunks(ibl_exr_decoder *d, int first, int count,
                                 const ibl_exr_target *target);

/* Converts an image of Y to RGB; interpolates the half-size chroma. */
ibl_status ibl_exr_to_rgb(ibl_ctx *ctx, const ibl_exr_pick *pick,
                          const ibl_exr_chroma *chroma, ibl_image *img);

#endif
