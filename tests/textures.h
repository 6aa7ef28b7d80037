/* SPDX-License-Identifier: MIT */
/* Textures for tests of containers, which do not look into texels. */
#ifndef TEXTURES_H
#define TEXTURES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ibl/io.h"

/* What it is given, freed after the running test. */
ibl_texture texture_owned(ibl_texture texture);
/* Of random bytes, which are always the same, with the key zeta; shape: width,
 * height, levels, faces. The caller frees it. */
ibl_texture texture_random(ibl_ctx *ctx, ibl_pixel pixel, const int shape[4],
                           int layers);
/* These are freed after the running test, too; they exit if they fail. */
unsigned char *texture_encode(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_container container, size_t *size);
ibl_texture texture_decode(ibl_ctx *ctx, const void *bytes, size_t size);
ibl_texture texture_layer(ibl_ctx *ctx, const ibl_texture *tex, int layer);
ibl_texture texture_array(ibl_ctx *ctx, const ibl_texture *const *list,
                          int count);
/* Encodes count texels as the library does; returns how many components were
 * beyond the largest value. Of blocks count is a multiple of 16. */
size_t texels_encode(ibl_pixel pixel, const float *src, size_t count,
                     void *dst);
/* Shape and bytes, not keys. */
bool texture_same(const ibl_texture *a, const ibl_texture *b);
/* Whether a key has that value; NULL: is not there. */
bool texture_has(const ibl_texture *tex, const char *key, const char *value);

/* Decodes copies of a file, cut everywhere and with one byte changed, in a
 * context that prints nothing, and checks that each is refused or read as no
 * more than it can hold. bytes are as they were afterwards. */
void texture_damage(ibl_ctx *quiet, unsigned char *bytes, size_t size);

#endif
