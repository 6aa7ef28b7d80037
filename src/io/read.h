/* SPDX-License-Identifier: MIT */
/* What the readers of each kind of image share. */
#ifndef IBL_IO_READ_H
#define IBL_IO_READ_H

#include "ibl/io.h"

/* Refuses sizes over IBL_MAX_EDGE and, without opts->any_aspect, maps that
 * are not 2:1. Readers call it before they decode. */
ibl_status ibl_read_check_size(ibl_ctx *ctx, const char *name,
                               const ibl_read_options *opts, long long width,
                               long long height);
/* An image for all of a map, whose size has been checked. */
ibl_status ibl_read_alloc(ibl_ctx *ctx, const char *name, int width, int height,
                          ibl_image *img);

#endif
