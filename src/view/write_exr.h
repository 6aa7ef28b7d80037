/* SPDX-License-Identifier: MIT */
/* Pictures of halves as OpenEXR. */
#ifndef VIEW_WRITE_EXR_H
#define VIEW_WRITE_EXR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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
