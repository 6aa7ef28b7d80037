/* SPDX-License-Identifier: MIT */
/* Reads pictures from the framebuffer; writes PNG and OpenEXR. */
#ifndef VIEW_PICTURE_H
#define VIEW_PICTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ibl/ibl.h"
#include "view/gl.h"

/* Reads a framebuffer, 0 for the screen: 8-bit RGB, rows from the top, no
 * padding; the caller must free it. NULL: no memory. */
unsigned char *view_picture_read(GLuint framebuffer, int width, int height);
/* Reverses the order of the rows. */
void view_picture_flip(void *pixels, size_t row_bytes, int height);
/* Writes a PNG with an sRGB chunk, completely or not at all. False, with a
 * message. */
bool view_picture_write(ibl_ctx *ctx, const char *path, int width, int height,
                        const unsigned char *rgb);

/*
 * The bytes of an EXR, ZIP, with the channels A, B, G and R: the halves of
 * rgba, linear and premultiplied by alpha.
 *   name   for messages
 *   rgba   4 halves a pixel, rows from the top
 *   bytes  for free(); NULL after an error
 * False, with a message.
 */
bool view_exr_encode(const char *name, int width, int height,
                     const uint16_t *rgba, void **bytes, size_t *size);

#endif
