/* SPDX-License-Identifier: MIT */
/* Texels of cubes to floats, on the pool. */
#ifndef IBL_IO_CUBE_TEXELS_H
#define IBL_IO_CUBE_TEXELS_H

#include "io/container.h"

/* Decodes a cube of one layer and 3 channels, whose shape cube has. */
ibl_status ibl_cube_texels_decode(ibl_ctx *ctx, const ibl_texture *tex,
                                  const ibl_cube *cube);

/* Decodes a level of a texture of 3 channels: its layers and faces one below
 * the other. */
ibl_status ibl_texels_decode(ibl_ctx *ctx, const ibl_texture *tex, int level,
                             float *rgb);

#endif
