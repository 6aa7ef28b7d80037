/* SPDX-License-Identifier: MIT */
/* Streams of zlib (RFC 1950), as EXR's ZIP blocks are. */
#ifndef IBL_IO_EXR_INFLATE_H
#define IBL_IO_EXR_INFLATE_H

#include <stdbool.h>
#include <stddef.h>

/* What ibl_inflate works with, one for each thread; NULL without memory. */
void *ibl_inflater(void);
void ibl_inflater_free(void *inflater); /* NULL is fine */

/* Whether the size bytes of src, below 2 GiB, begin with a whole stream, its
 * checksum included, of just dst_size bytes, which then are in dst. */
bool ibl_inflate(void *inflater, const void *src, size_t size, void *dst,
                 size_t dst_size);

#endif
