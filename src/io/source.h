/* SPDX-License-Identifier: MIT */
/* What ibl_image_read knows of a source beyond ibl/io.h. */
#ifndef IBL_IO_SOURCE_H
#define IBL_IO_SOURCE_H

#include "ibl/io.h"

/* ibl_source_open of bytes in memory, which must stay until all rows have
 * been read. */
ibl_status ibl_source_over(ibl_ctx *ctx, const char *name, const void *bytes,
                           size_t size, const ibl_read_options *opts,
                           ibl_source **out);
/* All rows of a source of which none has been read. */
ibl_status ibl_source_image(ibl_source *source, ibl_image *img);

#endif
