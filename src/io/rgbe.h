/* SPDX-License-Identifier: MIT */
/*
 * Radiance pictures (.hdr, .pic): RGBE, flat or run-length. A header, then
 * scanlines. One job finds where scanlines end; then they are decoded in
 * parallel.
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
bool ibl_rgbe_is(const unsigned char *bytes, size_t size);

/*
 * Opens a picture, as ibl_reader says. Divides by EXPOSURE and COLORCORR.
 * IBL_ERR_FORMAT: damaged, cut short or no picture. IBL_ERR_UNSUPPORTED: XYZE,
 * unknown FORMAT, run lengths of before 1991. IBL_ERR_IO, IBL_ERR_MEMORY,
 * IBL_ERR_CANCELLED.
 */
ibl_status ibl_rgbe_open(ibl_input *in, const ibl_read_options *opts,
                         ibl_rows **rows);

typedef struct ibl_rgbe_header {
    int row_px, rows;    /* pixels of a stored scanline; scanlines */
    int orientation;     /* of EXIF, 1 to 8: how the scanlines lie */
    float scale[3];      /* inverse of exposure and colour correction */
    bool has_primaries;  /* the file names them */
    double primaries[8]; /* xy of red, green, blue, white; zeros: Rec.709's */
    size_t data;         /* offset of the first scanline, in bytes */
} ibl_rgbe_header;

/* Parses the header. */
ibl_status ibl_rgbe_parse(const ibl_input *in, ibl_rgbe_header *header);

#endif
