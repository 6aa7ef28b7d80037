/* SPDX-License-Identifier: MIT */
/* OpenEXR files, read with OpenEXRCore, the C interface of OpenEXR. */
#ifndef IBL_IO_EXR_H
#define IBL_IO_EXR_H

#include "io/rows.h"

bool ibl_exr_is(const unsigned char *bytes, size_t size);

/*
 * Opens the colour of one part and layer, as ibl_image_read says, for reading
 * by rows: see ibl_reader. libiblexr.so undoes all compressions but ZIP.
 * IBL_ERR_UNSUPPORTED: also if libiblexr.so is needed and missing.
 */
ibl_status ibl_exr_open(ibl_input *in, const ibl_read_options *opts,
                        ibl_rows **rows);

#endif
