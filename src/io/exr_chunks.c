/* SPDX-License-Identifier: MIT */
/*
 * The blocks of an EXR part: which there are.
 *
 * OpenEXRCore reads the chunk table; the layout of the pixels is computed here
 * and compared with what the core says, so that a header cannot make either of
 * them write out of bounds.
 */
#include <limits.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/exr_file.h"

/* The most that a block can shrink. zlib: 1032 (zlib.net/zlib_tech.html), of
 * which PXR24 packs 3 bytes of 4; RLE: 128 bytes in 2; PIZ: Huffman codes of
 * 255 repeats in no less than 1 + 1 + 8 bits, of 2 bytes each; B44A: 32 bytes
 * in 3. DWA keeps 1 of 64 coefficients and zips that. */
static double max_ratio(exr_compression_t compression)
{
    switch (compression) {
    case EXR_COMPRESSION_NONE:
        return 1;
    case EXR_COMPRESSION_RLE:
        return 64;
    case EXR_COMPRESSION_ZIPS:
    case EXR_COMPRESSION_ZIP:
        return 1032;
    case EXR_COMPRESSION_PXR24:
        return 1376;
    case EXR_COMPRESSION_PIZ:
        return 512;
    case EXR_COMPRESSION_B44:
    case EXR_COMPRESSION_B44A:
        return 11;
    default:
        return 64 * 1376;
    }
}

int ibl_exr_sample_bytes(const exr_attr_chlist_entry_t *channel)
{
    return channel->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
}

bool ibl_exr_has_line(const exr_attr_chlist_entry_t *channel, int y)
{
    return y % channel->y_sampling == 0;
}

uint64_t ibl_exr_layout_bytes(const exr_attr_chlist_t *channels, int y,
                              int width, int height)
{
    uint64_t bytes = 0;
    for (int c = 0; c < channels->num_channels; c++) {
        const exr_attr_chlist_entry_t *e = &channels->entries[c];
        int lines = 0;
        if (e->y_sampling == 1)
            lines = height;
        else
            for (int i = 0; i < height; i++)
                lines += ibl_exr_has_line(e, y + i);
        bytes += (uint64_t)(width / e->x_sampling) * (uint64_t)lines *
                 (uint64_t)ibl_exr_sample_bytes(e);
    }
    return bytes;
}

static ibl_status add_chunk(const ibl_exr_file *file, const ibl_exr_pick *pick,
                            const exr_chunk_info_t *info, int x, int y,
                            ibl_exr_table *table)
{
    const uint64_t bytes =
        ibl_exr_layout_bytes(pick->channels, y, info->width, info->height);
    const double ratio =
        (double)bytes / (info->packed_size ? (double)info->packed_size : 1);
    /* at 0 all channels have samples */
    const uint64_t line =
        ibl_exr_layout_bytes(pick->channels, 0, info->width, 1);

    if (info->packed_size > file->in->size ||
        info->data_offset > file->in->size - info->packed_size)
        return ibl_reject(file->in, IBL_ERR_FORMAT,
                          "EXR cut short: the block of line %d ends past the "
                          "end of the file: copy it again",
                          y);
    if (bytes != info->unpacked_size || bytes > INT_MAX)
        return ibl_reject(file->in, IBL_ERR_UNSUPPORTED,
                          "the block of line %d unpacks to %llu bytes, not "
                          "what its channels need, or too many for OpenEXRCore",
                          y, (unsigned long long)bytes);
    if (info->packed_size > bytes ||
        (bytes > 4096 && ratio > max_ratio(pick->compression)))
        return ibl_reject(file->in, IBL_ERR_FORMAT,
                          "damaged EXR: the block of line %d claims %llu bytes "
                          "for %llu, which %s cannot do",
                          y, (unsigned long long)info->packed_size,
                          (unsigned long long)bytes,
                          ibl_exr_compression_name(pick->compression));
    table->chunks[table->count++] = (ibl_exr_chunk){info->data_offset,
                                                    (uint32_t)info->packed_size,
                                                    (uint32_t)bytes,
                                                    x,
                                                    y,
                                                    info->width,
                                                    info->height};
    table->unpacked += bytes;
    if (info->packed_size > table->most_packed)
        table->most_packed = (uint32_t)info->packed_size;
    if (bytes > table->most_unpacked)
        table->most_unpacked = (uint32_t)bytes;
    if ((line < bytes ? line : bytes) > table->most_line)
        table->most_line = (uint32_t)(line < bytes ? line : bytes);
    if (y == table->chunks[0].y)
        table->columns = table->count;
    return IBL_OK;
}

static bool is_shown(const ibl_exr_window *map, int x, int y, int width,
                     int height)
{
    return x <= map->x1 && y <= map->y1 && x + width > map->x0 &&
           y + height > map->y0;
}

static ibl_status bad_chunk(const ibl_exr_file *file, int y)
{
    if (file->no_memory)
        return ibl_no_memory(file->in->ctx, "the blocks of an EXR");
    if (file->error)
        return ibl_input_unread(file->in, file->error);
    return ibl_reject(file->in, IBL_ERR_FORMAT,
                      "EXR damaged or cut short at the block of line %d: %s", y,
                      file->text[0] ? file->text : "its entry cannot be read");
}

static int steps(int length, int step)
{
    return (length - 1) / step + 1;
}

/* Lists blocks of width x height pixels, columns * rows of them. */
static ibl_status list_blocks(ibl_exr_file *file, const ibl_exr_pick *pick,
                              int width, int height, ibl_exr_table *table)
{
    const ibl_exr_window *data = &pick->data;
    const int columns = steps(data->width, width);
    const int rows = steps(data->height, height);
    const bool all = pick->chroma_step > 1;
    exr_chunk_info_t info;

    for (int i = 0; i < columns * rows; i++) {
        const int column = i % columns, row = i / columns;
        const int x = data->x0 + column * width, right = data->x1 - x + 1;
        const int y = data->y0 + row * height, below = data->y1 - y + 1;
        const int w = right < width ? right : width;
        const int h = below < height ? below : height;
        if (!all && !is_shown(&pick->display, x, y, w, h))
            continue;
        const exr_result_t rv =
            pick->tiled
                ? exr_read_tile_chunk_info(file->exr, pick->part, column, row,
                                           0, 0, &info)
                : exr_read_scanline_chunk_info(file->exr, pick->part, y, &info);
        if (rv || info.height != h || info.width != w)
            return bad_chunk(file, y);
        const ibl_status status = add_chunk(file, pick, &info, x, y, table);
        if (status)
            return status;
    }
    return IBL_OK;
}

ibl_status ibl_exr_list_chunks(ibl_exr_file *file, const ibl_exr_pick *pick,
                               ibl_exr_table *table)
{
    int width = pick->data.width, height = 0;

    *table = (ibl_exr_table){0};
    ibl_exr_listen(file);
    if (pick->tiled) {
        width = pick->tile_width;
        height = pick->tile_height;
    } else if (exr_get_scanlines_per_chunk(file->exr, pick->part, &height)) {
        height = 0;
    }
    if (width < 1 || height < 1)
        return bad_chunk(file, pick->data.y0);

    /* The table alone takes 8 bytes of the file for each of them. */
    const uint64_t count = (uint64_t)steps(pick->data.width, width) *
                           (uint64_t)steps(pick->data.height, height);
    if (count > file->in->size / 8 || count > INT_MAX)
        return ibl_reject(file->in, IBL_ERR_FORMAT,
                          "EXR damaged or cut short: its %llu blocks cannot be "
                          "in %zu bytes",
                          (unsigned long long)count, file->in->size);
    table->chunks = ibl_alloc_array((size_t)count, sizeof *table->chunks);
    if (!table->chunks)
        return ibl_no_memory(file->in->ctx, "the blocks of an EXR");
    table->lines = height < pick->data.height ? height : pick->data.height;
    const ibl_status status = list_blocks(file, pick, width, height, table);
    if (status)
        ibl_exr_table_free(table);
    return status;
}

void ibl_exr_table_free(ibl_exr_table *table)
{
    ibl_free(table->chunks);
    *table = (ibl_exr_table){0};
}
