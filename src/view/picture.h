/* SPDX-License-Identifier: MIT */
/* Pictures out of the framebuffer and into PNG files. */
#ifndef VIEW_PICTURE_H
#define VIEW_PICTURE_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "view/gl.h"

/* Reads a framebuffer, 0 for the screen: 8-bit RGB, rows from the top, no
 * padding; free() it. NULL: no memory. */
unsigned char *view_picture_read(GLuint framebuffer, int width, int height);
/* Exchanges the rows: the first one becomes the last. */
void view_picture_flip(void *pixels, size_t row_bytes, int height);
/* Writes a PNG with an sRGB chunk, whole or not at all. False, with a
 * message. */
bool view_picture_write(ibl_ctx *ctx, const char *path, int width, int height,
                        const unsigned char *rgb);

#endif
