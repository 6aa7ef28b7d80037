/* SPDX-License-Identifier: MIT */
/* PNG files of 8 bits. */
#ifndef ENGINE_PNG_H
#define ENGINE_PNG_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/io.h"

/* Bytes in memory. A zeroed one is empty. */
typedef struct ibl_blob {
    unsigned char *bytes;
    size_t size, room;
} ibl_blob;

/* Adds bytes; false: no memory. */
bool ibl_blob_add(ibl_blob *blob, const void *bytes, size_t size);
void ibl_blob_free(ibl_blob *blob);

/* Encodes width x height pixels of 4 channels, or of 3 that are sRGB, 8 bits
 * each, rows from the top. keys, if not NULL, has keys that become text chunks.
 * Safe on many threads at once. False: no memory. */
bool ibl_png_encode(const unsigned char *pixels, int channels, int width,
                    int height, const ibl_texture *keys, ibl_blob *out);

/* The size in a header; false: not a PNG, or more than deflate can have packed
 * in its bytes. Allocates nothing. */
bool ibl_png_size(const unsigned char *bytes, size_t size, int *width,
                  int *height);
/* Whether it has that size and 3 or 4 channels of 8 bits. */
bool ibl_png_fits(const unsigned char *bytes, size_t size, int width,
                  int height);
/* Decodes a file of that size and any kind to 4 bytes a texel, as they are:
 * what it says of its gamma does not count. Safe on many threads at once.
 * False: damaged, or no memory. */
bool ibl_png_decode(const unsigned char *bytes, size_t size, int width,
                    int height, unsigned char *rgba);
/* Sets keys of tex by the text chunks of an encoded file. */
ibl_status ibl_png_keys(ibl_ctx *ctx, const unsigned char *bytes, size_t size,
                        ibl_texture *tex);

#endif
