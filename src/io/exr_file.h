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

/* Pixels x0..x1, y0..y1, both ends included. */
typedef struct ibl_exr_window {
    int x0, y0, x1, y1;
    int width, height;
} ibl_exr_window;

/* A worker's memory, of a chunk each. */
typedef struct ibl_exr_worker {
    unsigned char *packed, *unpacked;
    const unsigned char
        *pixels; /* unpacked: lines of channels in their order */
    struct libdeflate_decompressor *inflater;
    unsigned char *inflated; /* ZIP's differences */
    int fault, y;            /* of ibl_exr_unpack, and the first line of that */
} ibl_exr_worker;

/* A file opened by OpenEXRCore, and what of it is the picture. */
typedef struct ibl_exr_file {
    ibl_rows rows;
    const ibl_input *in;
    exr_context_t exr;
    bool no_memory; /* OpenEXRCore ran out of memory */
    int error;      /* errno of a failed read by OpenEXRCore, or 0 */
    char text[256]; /* first error text of OpenEXRCore; callers empty it to get
                       the next one */

    /* ibl_exr_choose sets from here on. */
    int part;
    const exr_attr_chlist_t *channels; /* owned by OpenEXRCore */
    int channel[3]; /* indices in the list of R, G and B, or of Y */
    bool grey;
    int alpha; /* index of A, or -1 if not wanted or not there */
    exr_compression_t compression;
    bool tiled;
    bool cube;                     /* the file says that it holds six faces */
    int block_width, block_height; /* of a tile, or a block of scan lines */
    ibl_exr_window display, data;

    /* ibl_exr_list_chunks: the chunks of level 0 that overlap the image, in the
     * part's order. start_x and start_y are a chunk's first pixel, in the
     * file's coordinates. */
    exr_chunk_info_t *chunks;
    int count;
    int columns;        /* number of chunks side by side: 1 without tiles */
    int lines;          /* height of a chunk; the last ones may have fewer */
    uint64_t unpacked;  /* bytes of all chunks */
    size_t most_packed; /* bytes of the largest chunk, packed */
    size_t most_unpacked;
    int before[4]; /* bytes of a pixel before R, G, B and A, ... */
    int all;       /* ... and of the whole pixel */

    /* ibl_exr_begin */
    ibl_exr_worker *workers; /* one for each thread */
    int threads;
    ibl_openexr_unpack *library; /* for all but ZIP */
    ibl_half_planes_dsp dsp;

    /* ibl_exr_open */
    bool halves;    /* the three channels are halves */
    bool framed;    /* the data window does not cover the map */
    int begin, end; /* rows of the map that the blocks cover */
    int per_job;    /* chunks */
    int group;      /* number of rows of blocks that keeps all threads busy */
    float *band;    /* rows of blocks of which a call wanted a part */
    int band_row, band_count;
} ibl_exr_file;

/* "ZIP", "DWAA", ... */
const char *ibl_exr_compression_name(exr_compression_t compression);

/* Finds the part and layer of opts, and the part's windows. If they are not
 * found, the message lists the parts or layers of the file. */
ibl_status ibl_exr_choose(ibl_exr_file *file, const ibl_read_options *opts);
/* Lists the chunks. Checks that the file contains them and that the compression
 * can produce their sizes. */
ibl_status ibl_exr_list_chunks(ibl_exr_file *file);
/* IBL_ERR_UNSUPPORTED: needs libiblexr.so, which is missing. */
ibl_status ibl_exr_begin(ibl_exr_file *file);
/* Closes the file and frees what it holds. */
void ibl_exr_end(ibl_exr_file *file);

/* Why a chunk has no pixels; above 0: errno. */
enum {
    IBL_EXR_CUT = -1, /* the file has become too short */
    IBL_EXR_NO_MEMORY = -2,
    IBL_EXR_DAMAGED = -3
};

/* Gets a chunk and undoes its compression to u->pixels. */
int ibl_exr_unpack(const ibl_exr_file *file, const exr_chunk_info_t *chunk,
                   ibl_exr_worker *u);
/* Reports that the file ends within the block of a line. */
ibl_status ibl_exr_cut(const ibl_exr_file *file, int y);

#endif
