/* SPDX-License-Identifier: MIT */
/* Inflating, by libdeflate or, where it was not there to build with, zlib. */
#include "io/exr_inflate.h"

#if IBL_LIBDEFLATE
#include <libdeflate.h>

void *ibl_inflater(void)
{
    return libdeflate_alloc_decompressor();
}

void ibl_inflater_free(void *inflater)
{
    libdeflate_free_decompressor(inflater);
}

bool ibl_inflate(void *inflater, const void *src, size_t size, void *dst,
                 size_t dst_size)
{
    return libdeflate_zlib_decompress(inflater, src, size, dst, dst_size,
                                      NULL) == LIBDEFLATE_SUCCESS;
}

#else
#define ZLIB_CONST
#include <zlib.h>

#include "core/alloc.h"

void *ibl_inflater(void)
{
    z_stream *z = ibl_alloc_zeroed(1, sizeof *z);
    if (z && inflateInit(z) == Z_OK)
        return z;
    ibl_free(z);
    return NULL;
}

void ibl_inflater_free(void *inflater)
{
    if (inflater)
        inflateEnd(inflater);
    ibl_free(inflater);
}

bool ibl_inflate(void *inflater, const void *src, size_t size, void *dst,
                 size_t dst_size)
{
    z_stream *z = inflater;

    z->next_in = src;
    z->avail_in = (uInt)size;
    z->next_out = dst;
    z->avail_out = (uInt)dst_size;
    return inflateReset(z) == Z_OK && inflate(z, Z_FINISH) == Z_STREAM_END &&
           !z->avail_out;
}
#endif
