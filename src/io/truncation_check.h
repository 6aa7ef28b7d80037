/* SPDX-License-Identifier: MIT */
/*
 * Whether a PNG, JPEG, TIFF or Maya IFF file is all there. OpenImageIO 2.4
 * reads the missing rest of a cut TIFF, JPEG or IFF as black without a word,
 * and libpng prints what it misses to stderr.
 */
#ifndef IBL_IO_TRUNCATION_CHECK_H
#define IBL_IO_TRUNCATION_CHECK_H

#include <stddef.h>

/* NULL if nothing is known to be missing, else what is, as the end of a
 * sentence; static. reader: OpenImageIO's name of the format. */
const char *ibl_truncation_check(const char *reader, const unsigned char *bytes,
                                 size_t size);

/*
 * Copies the chunks of a whole PNG that hold the picture, so that libpng has
 * nothing to print warnings about. dst has room for size bytes. Returns the
 * bytes written.
 */
size_t ibl_png_picture(const unsigned char *bytes, size_t size,
                       unsigned char *dst);

#endif
