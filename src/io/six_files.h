/* SPDX-License-Identifier: MIT */
/* Six files, one for each face, read as one image. */
#ifndef IBL_IO_SIX_FILES_H
#define IBL_IO_SIX_FILES_H

#include "io/rows.h"

/* Reads the faces one below the other, mended and converted to opts'
 * primaries and exposure, but not clamped. The report is the sum of the files'
 * reports.
 *   name   of all of them, for messages */
ibl_status ibl_six_files_open(ibl_ctx *ctx, const char *name,
                              char *const files[IBL_FACES],
                              const ibl_read_options *opts, ibl_rows **out);

#endif
