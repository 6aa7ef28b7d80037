/* SPDX-License-Identifier: MIT */
/* Textures for tests of containers, which do not look into texels. */
#ifndef TEXTURES_H
#define TEXTURES_H

#include <stdbool.h>

#include "ibl/io.h"

/* Of random bytes, which are always the same, with the key zeta; shape: width,
 * height, levels, faces. Exits if there is no memory. */
ibl_texture texture_random(ibl_ctx *ctx, ibl_pixel pixel, const int shape[4],
                           int layers);
/* Shape and bytes, not keys. */
bool texture_same(const ibl_texture *a, const ibl_texture *b);
/* Whether a key has that value; NULL: is not there. */
bool texture_has(const ibl_texture *tex, const char *key, const char *value);

#endif
