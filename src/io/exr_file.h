/* SPDX-License-Identifier: MIT */
/* Shared by the files of the EXR reader. */
#ifndef IBL_IO_EXR_FILE_H
#define IBL_IO_EXR_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <OpenEXR/openexr.h>

#include "io/input.h"
#include "io/rows.h"
#include "kern/half_planes.h"
#include "kern/max_finite.h"

/* A file opened by OpenEXRCore. */
typedef struct ibl_exr_file {
    const ibl_input *in;
    exr_context_t exr;
    bool deaf;      /* jobs run: texts of the core are not kept */
    bool no_memory; /* it ran out for the core */
    int error;      /* errno of a read of the core's that failed, or 0 */
    char text[256]; /* the first complaint of the core; emptied before
                       the next one is wanted */
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

/* The pixels that are wanted: a part and three of its channels. */
typedef struct ibl_exr_pick {
    int part;
    ibl_exr_colour colour;
    int channel[3];  /* places in the part's list: R G B, Y Y Y or Y RY BY */
    int alpha;       /* place of A, if it is wanted and there, or -1 */
    int chroma_step; /* 1, or 2 where RY and BY have half the edge */
    const exr_attr_chlist_t *channels; /* owned by the core */
    exr_compression_t compression;
    bool tiled;
    int block_width, block_height; /* of a tile, or of a scan line's block */
    ibl_exr_window display, data;
    float luma[3]; /* Y's weights of R, G and B */
} ibl_exr_pick;

/* "ZIP", "DWAA", ... */
const char *ibl_exr_compression_name(exr_compression_t compression);

/* Finds the part and layer of opts, and the part's windows. If they cannot be
 * read, the message lists the parts or layers of the file. */
ibl_status ibl_exr_choose(ibl_exr_file *file, const ibl_read_options *opts,
                          ibl_exr_pick *pick);

/* Every chunk of level 0 that shows in the image, in the part's order.
 * start_x and start_y are its first pixel, in the file's coordinates. A chunk
 * whose packed and unpacked sizes are equal is stored as it is. */
typedef struct ibl_exr_table {
    exr_chunk_info_t *chunks;
    int count;
    int columns;          /* chunks side by side: 1 without tiles */
    int lines;            /* of a chunk, but for the last ones */
    uint64_t unpacked;    /* bytes of all of them */
    uint32_t most_packed; /* bytes of the largest */
    uint32_t most_unpacked, most_line; /* of a line of one */
} ibl_exr_table;

/* Lists the chunks; checks that the file holds them and that the compression
 * can reach their sizes. */
ibl_status ibl_exr_list_chunks(ibl_exr_file *file, const ibl_exr_pick *pick,
                               ibl_exr_table *table);
/* Half-size planes of RY and BY, those of the data window. */
typedef struct ibl_exr_chroma {
    int width, height;
    float *plane[2];
} ibl_exr_chroma;

/* A worker's own things. */
typedef struct ibl_exr_unpacker ibl_exr_unpacker;

/* The state of decoding a part. */
typedef struct ibl_exr_decoder {
    ibl_exr_file file;
    ibl_exr_pick pick;
    ibl_exr_table table;
    /* by ibl_exr_decoder_init: */
    ibl_exr_unpacker *unpackers; /* one for each thread */
    ibl_max_finite_fn *look;
    ibl_half_planes_dsp dsp;
    bool halves; /* all channels are */
    int threads;
    int per_job; /* chunks */
} ibl_exr_decoder;

/* file, pick and table must be filled. Freeing d (of ibl_alloc_zeroed) also
 * closes the file. */
ibl_status ibl_exr_decoder_init(ibl_exr_decoder *d);
void ibl_exr_decoder_free(ibl_exr_decoder *d); /* NULL is fine */

/* Whether this core can undo the compression; tries it on one chunk. */
bool ibl_exr_can_decode(ibl_exr_decoder *d);

/* Rows of the map that chunks are decoded to. */
typedef struct ibl_exr_target {
    float *rgb;
    int row, count; /* the first, in the display window, and how many */
    uint32_t *most; /* of each, by d->look; or NULL */
    float *alpha;   /* of the whole map, or NULL */
    ibl_exr_chroma *chroma;
} ibl_exr_target;

/* Decodes the visible part of count chunks to the target, on the pool. Pixels
 * outside the data window stay unchanged. Half-size chroma goes to chroma. */
ibl_status ibl_exr_decode_chunks(ibl_exr_decoder *d, int first, int count,
                                 const ibl_exr_target *target);

/* Turns an image of Y to R G B; half-size chroma is interpolated. */
ibl_status ibl_exr_to_rgb(ibl_ctx *ctx, const ibl_exr_pick *pick,
                          const ibl_exr_chroma *chroma, ibl_image *img);

#endif
