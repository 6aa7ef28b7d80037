/* SPDX-License-Identifier: MIT */
/*
 * Radiance pictures (.hdr, .pic): RGBE and XYZE.
 *
 * Three steps, so that a caller may also take them one at a time: the header,
 * an index of the scanlines that proves the file whole, single scanlines.
 * Nothing is allocated for pixels before the index is there.
 *
 * Format: Radiance reference manual, "Picture files"; Ward 1991, "Real
 * Pixels", Graphics Gems II.
 */
#ifndef IBL_IO_RGBE_H
#define IBL_IO_RGBE_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/ibl.h"
#include "kern/rgbe.h"

/* Whether the bytes begin like a Radiance picture: "#?". */
bool ibl_rgbe_is(const void *bytes, size_t size);

/*
 * Decodes a whole picture; row 0 of img is the top of the picture whatever
 * the orientation. EXPOSURE and COLORCORR are divided out. XYZ becomes RGB
 * with the file's PRIMARIES; its unit is kept (Radiance has Y in cd/m^2 where
 * RGB has W/sr/m^2, a factor of 179).
 *   name     stands in messages
 *   img      empty; the caller's to free with ibl_image_free
 *   format   filled with a short description
 * IBL_ERR_FORMAT: damaged, cut short or no picture. IBL_ERR_UNSUPPORTED: a
 * FORMAT other than the two. IBL_ERR_MEMORY, IBL_ERR_CANCELLED.
 */
ibl_status ibl_rgbe_decode(ibl_ctx *ctx, const char *name,
                           const unsigned char *bytes, size_t size,
                           ibl_image *img, char format[64]);

typedef struct ibl_rgbe_header {
    int width, height;   /* of the picture as it is seen */
    int row_px, rows;    /* scanlines as they are stored */
    bool by_column;      /* scanlines are columns of the picture */
    bool reverse_rows;   /* the first scanline is the bottom or right one */
    bool reverse_pixels; /* the first pixel is the right or bottom one */
    bool xyz;
    float scale[3];  /* undoes exposure and colour correction; 1 for XYZ */
    float matrix[9]; /* XYZ to RGB, exposure undone; row-major */
    size_t data;     /* offset of the first scanline */
} ibl_rgbe_header;

ibl_status ibl_rgbe_parse(ibl_ctx *ctx, const char *name,
                          const unsigned char *bytes, size_t size,
                          ibl_rgbe_header *header);

/* Where the scanlines are. */
typedef struct ibl_rgbe_index {
    size_t *row;  /* rows + 1 offsets, the last is the end of the data */
    bool flat;    /* no scanline is encoded, whatever it looks like */
    bool has_new; /* some are run-length encoded by component */
    bool has_old; /* some are run-length encoded by pixel */
} ibl_rgbe_index;

/* Finds and checks every scanline. */
ibl_status ibl_rgbe_scan(ibl_ctx *ctx, const char *name,
                         const unsigned char *bytes, size_t size,
                         const ibl_rgbe_header *header, ibl_rgbe_index *index);
void ibl_rgbe_index_free(ibl_rgbe_index *index); /* zeroed is fine */

/* Bytes of scratch that ibl_rgbe_row needs. */
size_t ibl_rgbe_scratch(const ibl_rgbe_header *header);

/*
 * Decodes scanline row, in the order of the file, to header->row_px RGB
 * pixels. bytes, size: the file that was scanned. Safe on many threads at
 * once, each with its own scratch.
 */
void ibl_rgbe_row(const ibl_rgbe_dsp *dsp, const unsigned char *bytes,
                  size_t size, const ibl_rgbe_header *header,
                  const ibl_rgbe_index *index, int row, unsigned char *scratch,
                  float *dst);

#endif
