/* SPDX-License-Identifier: MIT */
/*
 * Radiance pictures (.hdr, .pic): RGBE and XYZE. A header, then scanlines,
 * whose ends are found by passing over them; then they are decoded in parallel.
 *
 * Format: Radiance reference manual, "Picture files"; Ward 1991, "Real
 * Pixels", Graphics Gems II.
 */
#ifndef IBL_IO_RGBE_H
#define IBL_IO_RGBE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/input.h"
#include "io/rows.h"

/* Whether the bytes begin like a Radiance picture: "#?". */
bool ibl_rgbe_is(const void *bytes, size_t size);

/*
 * Opens a picture for its rows, the first at the top of it whatever the
 * orientation. EXPOSURE and COLORCORR are divided out. XYZ becomes RGB with
 * the file's PRIMARIES; its unit is kept (Radiance has Y in cd/m^2 where RGB
 * has W/sr/m^2, a factor of 179). Where scanlines are columns or begin at the
 * bottom the rows come from a whole image.
 *   in    must stay as long as rows
 *   opts  for the size that is taken
 * IBL_ERR_FORMAT: damaged, cut short or no picture. IBL_ERR_UNSUPPORTED: a
 * FORMAT other than the two. IBL_ERR_IO, IBL_ERR_MEMORY, IBL_ERR_CANCELLED.
 */
ibl_status ibl_rgbe_open(const ibl_input *in, const ibl_read_options *opts,
                         ibl_rows **rows);

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

/* The most bytes of a picture with this beginning, and 1 MiB after it. */
uint64_t ibl_rgbe_longest(const void *bytes, size_t size);

/* Reads the header; of a file as much as that takes. */
ibl_status ibl_rgbe_parse(const ibl_input *in, ibl_rgbe_header *header);

/* No scanline takes more bytes than this and has no fault. */
size_t ibl_rgbe_most_bytes(const ibl_rgbe_header *header);

#endif
