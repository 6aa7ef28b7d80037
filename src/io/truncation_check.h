/* SPDX-License-Identifier: MIT */
/* Checks whether a PNG, JPEG, TIFF or Maya IFF file is complete. OpenImageIO
 * 2.4 reads the missing rest of a TIFF, JPEG or IFF as black without an error,
 * and libpng prints to stderr. */
#ifndef IBL_IO_TRUNCATION_CHECK_H
#define IBL_IO_TRUNCATION_CHECK_H

#include <stddef.h>

/* Returns NULL if nothing seems to be missing, else the end of a sentence that
 * says what, a static text. reader: OpenImageIO's name of the format. */
const char *ibl_truncation_check(const char *reader, const unsigned char *bytes,
                                 size_t size);

/* Copies the chunks of a complete PNG that libpng needs for the picture, so
 * that it prints no warnings. dst has room for size bytes. Returns the bytes
 * written. */
size_t ibl_png_picture(const unsigned char *bytes, size_t size,
                       unsigned char *dst);

#endif
