/* SPDX-License-Identifier: MIT */
/* OpenEXR by OpenEXRCore, the library's C interface. */
#ifndef IBL_IO_EXR_H
#define IBL_IO_EXR_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/io.h"

/* Whether the bytes begin as an OpenEXR file does. */
bool ibl_exr_is(const void *bytes, size_t size);

/*
 * Decodes the colour of one part and layer, as ibl_image_read says; pixels
 * are as the file has them, not yet mended. Fills img, report->format and
 * report->bridged: DWAA and DWAB go through the bridge where OpenEXRCore says
 * it has not got them.
 */
ibl_status ibl_exr_decode(ibl_ctx *ctx, const char *name,
                          const unsigned char *bytes, size_t size,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report);

#endif
