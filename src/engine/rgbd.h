/* SPDX-License-Identifier: MIT */
/*
 * RGBD, as Babylon packs light into 4 bytes: D = floor(255 / the largest
 * component), 1..255, and of each component c the byte (c D / 255)^(1 / 2.2).
 * The largest component is 255.
 */
#ifndef ENGINE_RGBD_H
#define ENGINE_RGBD_H

#include "engine/png.h"

#define IBL_RGBD_MAX 255.0f

/* count texels of 4 floats, of which the last is left out, or becomes 1. */
void ibl_rgbd_encode(const float *texels, size_t count, unsigned char *rgbd);
void ibl_rgbd_decode(const unsigned char *rgbd, size_t count, float *texels);

/*
 * Encodes each face of each level of a cube, on the pool; rows of the files are
 * from the bottom.
 *   tex    a cube of RGBA32F and one layer; gets what the files say
 *   faces  levels * 6, in the order of tex. The caller must free them, after
 *          errors too
 */
ibl_status ibl_rgbd_faces(ibl_ctx *ctx, ibl_texture *tex, ibl_blob *faces);

/* The same backwards. name is for messages; bytes of each of levels * 6 files
 * are not owned. tex is empty, and freed by the caller after success. Checks
 * all files before it allocates. IBL_ERR_FORMAT: a face is no PNG of its size,
 * or damaged. */
ibl_status ibl_rgbd_cube(ibl_ctx *ctx, const char *name, int size, int levels,
                         const ibl_blob *faces, ibl_texture *tex);

#endif
