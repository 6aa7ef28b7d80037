/* SPDX-License-Identifier: MIT */
/* Layouts of environments: found by shape, turned into equirectangular maps. */
#ifndef IBL_IO_LAYOUT_H
#define IBL_IO_LAYOUT_H

#include "ibl/io.h"

/* The layout of an image with this shape as opts say; AUTO: none has it. Cube
 * is a texture's, whose faces are stored like a vertical strip. */
ibl_input_layout ibl_input_layout_of(const ibl_read_options *opts,
                                     long long width, long long height);

/* Makes the map of an image in another layout than equirectangular; its shape
 * is that layout's. map: empty, filled here. */
ibl_status ibl_unwrap(ibl_ctx *ctx, ibl_input_layout layout,
                      const ibl_image *img, ibl_image *map);

#endif
