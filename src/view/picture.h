/* SPDX-License-Identifier: MIT */
/* Reads pictures from the framebuffer; writes PNG and OpenEXR. */
#ifndef VIEW_PICTURE_H
#define VIEW_PICTURE_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/ibl.h"
#include "view/gl.h"

/* Reads a framebuffer, 0 for the screen: 8-bit RGB, rows from the top, no
 * padding; the caller must free it. NULL: no memory. */
unsigned char *view_picture_read(GLuint framebuffer, int width, int height);
/* Reverses the order of the rows. */
void view_picture_flip(void *pixels, size_t row_bytes, int height);
/* Whether a picture of that name holds linear floats: it ends in .exr. */
bool view_picture_is_linear(const char *path);
/* Writes a picture, completely or not at all: 8-bit RGB as PNG with an sRGB
 * chunk, or RGB floats as EXR, as view_picture_is_linear says. False, with a
 * message. */
bool view_picture_write(ibl_ctx *ctx, const char *path, int width, int height,
                        const void *rgb);

#endif
