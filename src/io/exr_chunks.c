/* SPDX-License-Identifier: MIT */
/*
 * Lists and unpacks the chunks of an EXR part.
 *
 * OpenEXRCore reads the chunk table. The sizes of chunks are computed here and
 * compared with OpenEXRCore's, so that a header cannot make either write out of
 * bounds. libdeflate undoes ZIP if the build has it, OpenEXR's C++ library all
 * other compressions.
 */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#if IBL_LIBDEFLATE
#include <libdeflate.h>
#endif

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge.h"
#include "io/exr_file.h"

/* ---- the table ------------------------------------------------------ */

/* Upper limits of unpacked to packed size. zlib: 1032, see
 * zlib.net/zlib_tech.html; PXR24 zips 3 bytes of 4, and no other one packs more
 * tightly but DWA, which keeps 1 of 64 coefficients and zips that. */
enum {
    MOST_RATIO = 1376,
    MOST_RATIO_DWA = 64 * 1376
};

ibl_status ibl_exr_cut(const ibl_exr_file *file, int y)
{
    return ibl_bad_file(file->in,
                        "EXR cut short: the block of line %d ends past the end "
                        "of the file: copy it again",
                        y);
}

static ibl_status add_chunk(ibl_exr_file *file, const exr_chunk_info_t *chunk)
{
    const int y = chunk->start_y;
    const uint64_t packed = chunk->packed_size;
    const uint64_t bytes =
        (uint64_t)chunk->width * (uint64_t)chunk->height * (uint64_t)file->all;
    const uint64_t ratio = file->compression == EXR_COMPRESSION_NONE ? 1
                           : file->compression < EXR_COMPRESSION_DWAA
                               ? MOST_RATIO
                               : MOST_RATIO_DWA;

    if (!ibl_input_has(file->in, chunk->data_offset, packed))
        return ibl_exr_cut(file, y);
    if (bytes != chunk->unpacked_size || bytes > INT_MAX || packed > bytes ||
        (bytes > 4096 && bytes > ratio * packed))
        return ibl_bad_file(file->in,
                            "damaged EXR: the block of line %d claims %llu "
                            "bytes for %llu, which %s cannot do",
                            y, (unsigned long long)packed,
                            (unsigned long long)bytes,
                            ibl_exr_compression_name(file->compression));
    file->chunks[file->count++] = *chunk;
    file->unpacked += bytes;
    if (packed > file->most_packed)
        file->most_packed = packed;
    if (bytes > file->most_unpacked)
        file->most_unpacked = bytes;
    if (y == file->chunks[0].start_y)
        file->columns = file->count;
    return IBL_OK;
}

static ibl_status bad_chunk(const ibl_exr_file *file, int y)
{
    if (file->no_memory)
        return ibl_no_memory(file->in->ctx, "the blocks of an EXR");
    if (file->error)
        return ibl_input_unread(file->in, file->error);
    return ibl_bad_file(
        file->in, "EXR damaged or cut short at the block of line %d: %s", y,
        file->text[0] ? file->text : "its entry cannot be read");
}

ibl_status ibl_exr_list_chunks(ibl_exr_file *file)
{
    const int width = file->block_width, height = file->block_height;
    const ibl_exr_window *data = &file->data, *map = &file->display;
    exr_chunk_info_t info;

    file->text[0] = 0;
    if (width < 1 || height < 1)
        return bad_chunk(file, data->y0);
    const int columns = (data->width - 1) / width + 1;
    const int rows = (data->height - 1) / height + 1;
    /* A chunk takes at least 8 bytes of the file, in the chunk table. */
    const uint64_t count = (uint64_t)columns * (uint64_t)rows;
    if (count > file->in->size / 8 || count > INT_MAX)
        return ibl_bad_file(
            file->in,
            "EXR damaged or cut short: its %llu blocks cannot be in %zu bytes",
            (unsigned long long)count, file->in->size);
    file->chunks = ibl_alloc_array((size_t)count, sizeof *file->chunks);
    if (!file->chunks)
        return ibl_no_memory(file->in->ctx, "the blocks of an EXR");
    file->lines = height < data->height ? height : data->height;
    for (int i = 0; i < columns * rows; i++) {
        const int column = i % columns, row = i / columns;
        const int x = data->x0 + column * width, right = data->x1 - x + 1;
        const int y = data->y0 + row * height, below = data->y1 - y + 1;
        const int w = right < width ? right : width;
        const int h = below < height ? below : height;
        if (x > map->x1 || y > map->y1 || x + w <= map->x0 || y + h <= map->y0)
            continue;
        const exr_result_t rv =
            file->tiled
                ? exr_read_tile_chunk_info(file->exr, file->part, column, row,
                                           0, 0, &info)
                : exr_read_scanline_chunk_info(file->exr, file->part, y, &info);
        if (rv || info.height != h || info.width != w)
            return bad_chunk(file, y);
        info.start_x = x; /* for a tile, OpenEXRCore returns its column */
        info.start_y = y;
        const ibl_status status = add_chunk(file, &info);
        if (status)
            return status;
    }
    return IBL_OK;
}

/* ---- undoing the compression ---------------------------------------- */

static bool by_libdeflate(const ibl_exr_file *file)
{
    return IBL_LIBDEFLATE && (file->compression == EXR_COMPRESSION_ZIP ||
                              file->compression == EXR_COMPRESSION_ZIPS);
}

int ibl_exr_unpack(const ibl_exr_file *file, const exr_chunk_info_t *chunk,
                   ibl_exr_worker *u)
{
    const ibl_input *in = file->in;
    size_t got = chunk->packed_size;
    const unsigned char *bytes =
        in->bytes ? in->bytes + chunk->data_offset : u->packed;

    if (!in->bytes &&
        !ibl_input_read(in, chunk->data_offset, got, u->packed, &got))
        return errno;
    if (got != chunk->packed_size)
        return IBL_EXR_CUT;
    u->pixels = bytes;
    if (chunk->packed_size == chunk->unpacked_size) /* did not shrink */
        return 0;
    if (file->compression == EXR_COMPRESSION_NONE)
        return IBL_EXR_DAMAGED;
    if (!u->unpacked)
        u->unpacked = ibl_alloc_array(file->most_unpacked, 1);
    if (!u->unpacked)
        return IBL_EXR_NO_MEMORY;
    u->pixels = u->unpacked;
    if (file->library)
        return file->library(file->channels, chunk, bytes, u->unpacked)
                   ? 0
                   : IBL_EXR_DAMAGED;
#if IBL_LIBDEFLATE
    const size_t half = chunk->unpacked_size / 2; /* pixels have even sizes */
    unsigned char last[2];
    if (!u->inflater)
        u->inflater = libdeflate_alloc_decompressor();
    if (!u->inflated)
        u->inflated = ibl_alloc_array(file->most_unpacked, 1);
    if (!u->inflater || !u->inflated)
        return IBL_EXR_NO_MEMORY;
    if (libdeflate_zlib_decompress(u->inflater, bytes, chunk->packed_size,
                                   u->inflated, chunk->unpacked_size,
                                   NULL) != LIBDEFLATE_SUCCESS)
        return IBL_EXR_DAMAGED;
    ibl_unzip_begin(&file->dsp, u->inflated, half, last);
    file->dsp.unzip(u->inflated, u->inflated + half, half, last, u->unpacked);
#endif
    return 0;
}

ibl_status ibl_exr_begin(ibl_exr_file *file)
{
    ibl_ctx *ctx = file->in->ctx;
    const size_t threads = (size_t)ibl_ctx_threads(ctx);
    char needs[64];

    ibl_half_planes_dsp_init(&file->dsp, ibl_ctx_isa(ctx));
    file->workers = ibl_alloc_zeroed(threads, sizeof *file->workers);
    if (!file->workers)
        return ibl_no_memory(ctx, "decoding an EXR");
    file->threads = (int)threads;
    for (size_t i = 0; i < threads && !file->in->bytes; i++) {
        file->workers[i].packed = ibl_alloc_array(file->most_packed, 1);
        if (!file->workers[i].packed)
            return ibl_no_memory(ctx, "decoding an EXR");
    }
    if (file->compression == EXR_COMPRESSION_NONE || by_libdeflate(file))
        return IBL_OK;
    snprintf(needs, sizeof needs, "is OpenEXR, %s",
             ibl_exr_compression_name(file->compression));
    return ibl_bridge_find(file->in, "libiblexr.so", needs,
                           file->compression < EXR_COMPRESSION_DWAA
                               ? IBL_OPENEXR_UNPACK
                               : IBL_OPENEXR_UNPACK_DWA,
                           &file->library);
}

void ibl_exr_end(ibl_exr_file *file)
{
    for (int i = 0; i < file->threads; i++) {
        ibl_exr_worker *u = &file->workers[i];
#if IBL_LIBDEFLATE
        libdeflate_free_decompressor(u->inflater);
#endif
        ibl_free(u->inflated);
        ibl_free(u->unpacked);
        ibl_free(u->packed);
    }
    ibl_free(file->workers);
    ibl_free(file->chunks);
    if (file->exr)
        exr_finish(&file->exr);
    file->exr = NULL;
    file->workers = NULL;
    file->chunks = NULL;
    file->threads = 0;
}
