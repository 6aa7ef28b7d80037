/* SPDX-License-Identifier: MIT */
/* The image bridge: OpenImageIO in a shared object, loaded when needed. */
#ifndef IBL_IO_BRIDGE_H
#define IBL_IO_BRIDGE_H

#include "io/bridge/bridge.h"
#include "io/rows.h"

typedef struct ibl_bridge_source {
    const ibl_input *in; /* loaded into memory */
    char kind[64];       /* kind of the file, for messages; "": unknown */
    /* Format, part and channels are set; ibl_bridge_rows fills in the rest. */
    ibl_bridge_request request;
} ibl_bridge_source;

/*
 * Opens the file for reading by rows: linear RGB floats, not yet mended. The
 * map is the display window. Fills in the report of the rows.
 *   source   its input must live as long as rows
 * IBL_ERR_UNSUPPORTED: the bridge is not installed.
 */
ibl_status ibl_bridge_rows(const ibl_bridge_source *source,
                           const ibl_read_options *opts, ibl_rows **rows);

/* ---- truncation_check.c ------------------------------------------------ */

/* Checks whether a PNG, JPEG, TIFF or Maya IFF file is complete: OpenImageIO
 * 2.4 reads the missing rest of a TIFF, JPEG or IFF as black without an error,
 * and libpng prints to stderr. Returns NULL if nothing seems to be missing,
 * else the end of a sentence that says what, a static text. reader:
 * OpenImageIO's name of the format. */
const char *ibl_truncation_check(const char *reader, const unsigned char *bytes,
                                 size_t size);

/* Copies the chunks of a complete PNG that libpng needs for the picture, so
 * that it prints no warnings, and gAMA. dst has room for size bytes. Returns
 * the bytes written. */
size_t ibl_png_picture(const unsigned char *bytes, size_t size,
                       unsigned char *dst);
/* The same of a PNM or PFM: without the CR of a CRLF before the pixels. */
size_t ibl_pnm_picture(const unsigned char *bytes, size_t size,
                       unsigned char *dst);

#endif
