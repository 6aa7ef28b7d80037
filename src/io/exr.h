/* SPDX-License-Identifier: MIT */
/* OpenEXR by OpenEXRCore, the library's C interface. */
#ifndef IBL_IO_EXR_H
#define IBL_IO_EXR_H

#include <stdbool.h>
#include <stddef.h>

#include "io/input.h"
#include "io/rows.h"

/* Whether the bytes begin as an OpenEXR file does. */
bool ibl_exr_is(const void *bytes, size_t size);

/*
 * Opens the colour of one part and layer, as ibl_image_read says, for its
 * rows; pixels are as the file has them, not yet mended. DWAA and DWAB go
 * through the bridge where OpenEXRCore says it has not got them, and where
 * chroma has half the size the rows come from a whole image.
 *   in    must stay as long as rows; loaded for the bridge
 */
ibl_status ibl_exr_open(ibl_input *in, const ibl_read_options *opts,
                        ibl_rows **rows);

#endif
