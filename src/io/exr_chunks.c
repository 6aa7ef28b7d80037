/* SPDX-License-Identifier: MIT */
/*
 * The blocks of an EXR part: which there are, and their pixels.
 *
 * OpenEXRCore reads the chunk table and undoes the compression; the layout of
 * the pixels is computed here and compared with what the core says, so that a
 * header cannot make either of them write out of bounds. A chunk's bytes are
 * its lines from the top, in a line the channels in the list's order, of a
 * channel the samples whose coordinates are multiples of its sampling rates.
 */
#include <limits.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/half.h"
#include "io/exr_file.h"

enum {
    JOB_BYTES = 1 << 17, /* about 1 ms of inflating */
    BLOCK = 256          /* samples converted at once */
};

/* ---- the table ------------------------------------------------------ */

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

static int sample_bytes(const exr_attr_chlist_entry_t *channel)
{
    return channel->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
}

/* Whether the channel has samples on line y. */
static bool has_line(const exr_attr_chlist_entry_t *channel, int y)
{
    return y % channel->y_sampling == 0;
}

/* Bytes of the lines y..y+height-1, width pixels wide. */
static uint64_t layout_bytes(const exr_attr_chlist_t *channels, int y,
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
                lines += has_line(e, y + i);
        bytes += (uint64_t)(width / e->x_sampling) * (uint64_t)lines *
                 (uint64_t)sample_bytes(e);
    }
    return bytes;
}

static ibl_status add_chunk(ibl_ctx *ctx, const ibl_exr_file *file,
                            const ibl_exr_pick *pick,
                            const exr_chunk_info_t *info, int x, int y,
                            ibl_exr_table *table)
{
    const uint64_t bytes =
        layout_bytes(pick->channels, y, info->width, info->height);
    const double ratio =
        (double)bytes / (info->packed_size ? (double)info->packed_size : 1);

    if (info->packed_size > file->size ||
        info->data_offset > file->size - info->packed_size)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: EXR cut short: the block of line %d ends past "
                        "the end of the file",
                        file->name, y);
    if (bytes != info->unpacked_size || bytes > INT_MAX)
        return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                        "%s: the block of line %d unpacks to %llu bytes, not "
                        "what its channels need, or too many for OpenEXRCore",
                        file->name, y, (unsigned long long)bytes);
    if (info->packed_size > bytes ||
        (bytes > 4096 && ratio > max_ratio(pick->compression)))
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: damaged EXR: the block of line %d claims %llu "
                        "bytes for %llu, which %s cannot do",
                        file->name, y, (unsigned long long)info->packed_size,
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
    return IBL_OK;
}

static bool is_shown(const ibl_exr_window *map, int x, int y, int width,
                     int height)
{
    return x <= map->x1 && y <= map->y1 && x + width > map->x0 &&
           y + height > map->y0;
}

static ibl_status bad_chunk(ibl_ctx *ctx, const ibl_exr_file *file, int y)
{
    return ibl_fail(ctx, IBL_ERR_FORMAT,
                    "%s: EXR damaged or cut short at the block of line %d: %s",
                    file->name, y,
                    file->text[0] ? file->text : "its entry cannot be read");
}

static ibl_status list_lines(ibl_ctx *ctx, ibl_exr_file *file,
                             const ibl_exr_pick *pick, int lines,
                             ibl_exr_table *table)
{
    const ibl_exr_window *data = &pick->data;
    const bool all = pick->chroma_step > 1;
    exr_chunk_info_t info;

    for (int y = data->y0; y <= data->y1; y += lines) {
        const int left = data->y1 - y + 1;
        const int height = left < lines ? left : lines;
        if (!all && !is_shown(&pick->display, data->x0, y, data->width, height))
            continue;
        if (exr_read_scanline_chunk_info(file->exr, pick->part, y, &info) ||
            info.height != height || info.width != data->width)
            return bad_chunk(ctx, file, y);
        const ibl_status status =
            add_chunk(ctx, file, pick, &info, data->x0, y, table);
        if (status)
            return status;
    }
    return IBL_OK;
}

static ibl_status list_tiles(ibl_ctx *ctx, ibl_exr_file *file,
                             const ibl_exr_pick *pick, int columns, int rows,
                             ibl_exr_table *table)
{
    exr_chunk_info_t info;

    for (int i = 0; i < columns * rows; i++) {
        const int x = pick->data.x0 + i % columns * pick->tile_width;
        const int y = pick->data.y0 + i / columns * pick->tile_height;
        const int right = pick->data.x1 - x + 1, below = pick->data.y1 - y + 1;
        const int width = right < pick->tile_width ? right : pick->tile_width;
        const int height =
            below < pick->tile_height ? below : pick->tile_height;
        if (!is_shown(&pick->display, x, y, width, height))
            continue;
        if (exr_read_tile_chunk_info(file->exr, pick->part, i % columns,
                                     i / columns, 0, 0, &info) ||
            info.height != height || info.width != width)
            return bad_chunk(ctx, file, y);
        const ibl_status status =
            add_chunk(ctx, file, pick, &info, x, y, table);
        if (status)
            return status;
    }
    return IBL_OK;
}

static int steps(int length, int step)
{
    return (length - 1) / step + 1;
}

ibl_status ibl_exr_list_chunks(ibl_ctx *ctx, ibl_exr_file *file,
                               const ibl_exr_pick *pick, ibl_exr_table *table)
{
    int lines = 1, columns = 1;
    ibl_status status;

    *table = (ibl_exr_table){0};
    ibl_exr_listen(file);
    if (!pick->tiled &&
        (exr_get_scanlines_per_chunk(file->exr, pick->part, &lines) ||
         lines < 1))
        return bad_chunk(ctx, file, pick->data.y0);
    if (pick->tiled && (pick->tile_width < 1 || pick->tile_height < 1))
        return bad_chunk(ctx, file, pick->data.y0);
    if (pick->tiled)
        columns = steps(pick->data.width, pick->tile_width);
    const int rows =
        steps(pick->data.height, pick->tiled ? pick->tile_height : lines);

    /* The table alone takes 8 bytes of the file for each of them. */
    const uint64_t count = (uint64_t)columns * (uint64_t)rows;
    if (count > file->size / 8 || count > INT_MAX)
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: EXR damaged or cut short: its %llu blocks cannot "
                        "be in %zu bytes",
                        file->name, (unsigned long long)count, file->size);
    table->chunks = ibl_alloc_array((size_t)count, sizeof *table->chunks);
    if (!table->chunks)
        return ibl_no_memory(ctx, "the blocks of an EXR");
    status = pick->tiled ? list_tiles(ctx, file, pick, columns, rows, table)
                         : list_lines(ctx, file, pick, lines, table);
    if (status)
        ibl_exr_table_free(table);
    return status;
}

void ibl_exr_table_free(ibl_exr_table *table)
{
    ibl_free(table->chunks);
    *table = (ibl_exr_table){0};
}

/* ---- undoing the compression ---------------------------------------- */

/* A worker's pipeline; made by the first chunk that needs it. */
typedef struct unpacker {
    exr_decode_pipeline_t pipeline;
    bool made;
} unpacker;

/* Stands in for the core's reading: the packed bytes are in memory already.
 * A buffer of size 0 is one that the core does not free. */
static exr_result_t use_bytes(exr_decode_pipeline_t *pipeline)
{
    const ibl_exr_file *file = pipeline->decoding_user_data;
    pipeline->packed_buffer =
        (void *)(uintptr_t)(file->bytes + pipeline->chunk.data_offset);
    pipeline->packed_alloc_size = 0;
    return EXR_ERR_SUCCESS;
}

static exr_result_t leave_packed(exr_decode_pipeline_t *pipeline)
{
    (void)pipeline;
    return EXR_ERR_SUCCESS;
}

static exr_result_t unpack(const ibl_exr_file *file, const ibl_exr_pick *pick,
                           const ibl_exr_chunk *chunk, unpacker *u,
                           const unsigned char **pixels)
{
    const exr_chunk_info_t info = {
        .start_x = chunk->x,
        .start_y = chunk->y,
        .width = chunk->width,
        .height = chunk->height,
        .type = pick->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE,
        .compression = (uint8_t)pick->compression,
        .data_offset = chunk->offset,
        .packed_size = chunk->packed,
        .unpacked_size = chunk->unpacked,
    };
    exr_result_t rv;

    /* B44 too: a block that did not shrink is stored as it is, although the
     * core would take one of B44 for packed. */
    if (chunk->packed == chunk->unpacked) {
        *pixels = file->bytes + chunk->offset;
        return EXR_ERR_SUCCESS;
    }
    if (!u->made) {
        rv =
            exr_decoding_initialize(file->exr, pick->part, &info, &u->pipeline);
        if (!rv) {
            u->made = true;
            rv = exr_decoding_choose_default_routines(file->exr, pick->part,
                                                      &u->pipeline);
        }
        u->pipeline.decoding_user_data = (void *)(uintptr_t)file;
        u->pipeline.read_fn = use_bytes;
        u->pipeline.unpack_and_convert_fn = leave_packed;
    } else {
        rv = exr_decoding_update(file->exr, pick->part, &info, &u->pipeline);
    }
    if (!rv)
        rv = exr_decoding_run(file->exr, pick->part, &u->pipeline);
    *pixels = u->pipeline.unpacked_buffer;
    return rv;
}

static void unpacker_free(const ibl_exr_file *file, unpacker *u)
{
    if (u->made)
        exr_decoding_destroy(file->exr, &u->pipeline);
}

bool ibl_exr_can_decode(ibl_exr_file *file, const ibl_exr_pick *pick,
                        const ibl_exr_table *table)
{
    unpacker u = {.made = false};
    const unsigned char *pixels;
    exr_result_t rv = EXR_ERR_SUCCESS;

    if (pick->compression < EXR_COMPRESSION_DWAA)
        return true;
    for (int i = 0; i < table->count; i++) {
        if (table->chunks[i].packed == table->chunks[i].unpacked)
            continue;
        rv = unpack(file, pick, &table->chunks[i], &u, &pixels);
        break;
    }
    unpacker_free(file, &u);
    return rv != EXR_ERR_FEATURE_NOT_IMPLEMENTED;
}

/* ---- pixels --------------------------------------------------------- */

static uint16_t load16(const unsigned char *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

static uint32_t load32(const unsigned char *p)
{
    return load16(p) | (uint32_t)load16(p + 2) << 16;
}

static float as_float(uint32_t bits)
{
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

/* count samples as floats, uints as the numbers that they are. */
static void to_floats(const unsigned char *src, exr_pixel_type_t type,
                      int count, float *dst, int dst_step)
{
    if (type == EXR_PIXEL_HALF) {
        for (int i = 0; i < count; i++)
            dst[i * dst_step] = ibl_half_to_float(load16(src + 2 * i));
    } else if (type == EXR_PIXEL_FLOAT) {
        for (int i = 0; i < count; i++)
            dst[i * dst_step] = as_float(load32(src + 4 * i));
    } else {
        for (int i = 0; i < count; i++)
            dst[i * dst_step] = (float)load32(src + 4 * i);
    }
}

typedef struct decoding {
    const ibl_exr_file *file;
    const ibl_exr_pick *pick;
    const ibl_exr_table *table;
    int per_job;
    unpacker *unpackers;
    exr_result_t *results; /* of each job, the first that failed */
    ibl_image *img;
    ibl_exr_chroma *chroma;
} decoding;

/* The samples of one channel on a line of a chunk: to component c of the
 * image where they show in it. */
static void put_line(const decoding *d, const ibl_exr_chunk *chunk, int y,
                     const unsigned char *src, exr_pixel_type_t type, int c)
{
    const ibl_exr_window *map = &d->pick->display;
    const int bytes = type == EXR_PIXEL_HALF ? 2 : 4;
    const int x0 = chunk->x > map->x0 ? chunk->x : map->x0;
    const int end = chunk->x + chunk->width - 1;
    const int x1 = end < map->x1 ? end : map->x1;

    if (y < map->y0 || y > map->y1 || x1 < x0)
        return;
    float *dst = d->img->data + 3 * ((size_t)(y - map->y0) * map->width +
                                     (size_t)(x0 - map->x0));
    to_floats(src + (ptrdiff_t)bytes * (x0 - chunk->x), type, x1 - x0 + 1,
              dst + c, 3);
}

/* The same of a half-size chroma channel: to its plane. */
static void put_chroma(const decoding *d, const ibl_exr_chunk *chunk, int y,
                       const unsigned char *src, exr_pixel_type_t type, int c)
{
    const ibl_exr_window *data = &d->pick->data;
    const size_t row = (size_t)((y - data->y0) / 2);
    to_floats(src, type, chunk->width / 2,
              d->chroma->plane[c - 1] + row * d->chroma->width, 1);
}

static void copy_luma(const decoding *d, const ibl_exr_chunk *chunk)
{
    const ibl_exr_window *map = &d->pick->display;
    for (int y = chunk->y; y < chunk->y + chunk->height; y++) {
        if (y < map->y0 || y > map->y1)
            continue;
        float *row =
            d->img->data + 3 * (size_t)(y - map->y0) * (size_t)map->width;
        for (int x = chunk->x; x < chunk->x + chunk->width; x++) {
            if (x < map->x0 || x > map->x1)
                continue;
            float *p = row + 3 * (ptrdiff_t)(x - map->x0);
            p[1] = p[2] = p[0];
        }
    }
}

static void put_chunk(const decoding *d, const ibl_exr_chunk *chunk,
                      const unsigned char *src)
{
    const exr_attr_chlist_t *list = d->pick->channels;
    const bool luma = d->pick->colour == IBL_EXR_LUMA;

    for (int y = chunk->y; y < chunk->y + chunk->height; y++) {
        for (int i = 0; i < list->num_channels; i++) {
            const exr_attr_chlist_entry_t *e = &list->entries[i];
            if (!has_line(e, y))
                continue;
            for (int c = 0; c < (luma ? 1 : 3); c++) {
                if (d->pick->channel[c] != i)
                    continue;
                if (e->x_sampling > 1)
                    put_chroma(d, chunk, y, src, e->pixel_type, c);
                else
                    put_line(d, chunk, y, src, e->pixel_type, c);
            }
            src += (ptrdiff_t)(chunk->width / e->x_sampling) * sample_bytes(e);
        }
    }
    if (luma)
        copy_luma(d, chunk);
}

static void decode_job(void *arg, int job, int worker)
{
    const decoding *d = arg;
    const int first = job * d->per_job;
    for (int i = 0; i < d->per_job && first + i < d->table->count; i++) {
        const ibl_exr_chunk *chunk = &d->table->chunks[first + i];
        const unsigned char *pixels;
        d->results[job] =
            unpack(d->file, d->pick, chunk, &d->unpackers[worker], &pixels);
        if (d->results[job])
            return;
        put_chunk(d, chunk, pixels);
    }
}

/* Names the first job that failed, whatever order they ran in. */
static ibl_status report(ibl_ctx *ctx, const decoding *d, int jobs)
{
    for (int j = 0; j < jobs; j++) {
        if (!d->results[j])
            continue;
        if (d->results[j] == EXR_ERR_OUT_OF_MEMORY &&
            d->pick->compression != EXR_COMPRESSION_PXR24 &&
            d->pick->compression < EXR_COMPRESSION_B44)
            return ibl_no_memory(ctx, "decoding an EXR");
        return ibl_fail(ctx, IBL_ERR_FORMAT,
                        "%s: damaged EXR: the %s block of line %d cannot be "
                        "unpacked: %s",
                        d->file->name,
                        ibl_exr_compression_name(d->pick->compression),
                        d->table->chunks[j * d->per_job].y,
                        exr_get_default_error_message(d->results[j]));
    }
    return IBL_OK;
}

ibl_status ibl_exr_decode_chunks(ibl_ctx *ctx, ibl_exr_file *file,
                                 const ibl_exr_pick *pick,
                                 const ibl_exr_table *table, ibl_image *img,
                                 ibl_exr_chroma *chroma)
{
    const int threads = ibl_ctx_threads(ctx);
    const uint64_t each = table->unpacked / (uint64_t)table->count;
    decoding d = {
        .file = file,
        .pick = pick,
        .table = table,
        .per_job = each < JOB_BYTES ? (int)(JOB_BYTES / (each ? each : 1)) : 1,
        .img = img,
        .chroma = chroma};
    const int jobs = steps(table->count, d.per_job);
    ibl_status status = IBL_OK;

    d.unpackers = ibl_alloc_zeroed((size_t)threads, sizeof *d.unpackers);
    d.results = ibl_alloc_zeroed((size_t)jobs, sizeof *d.results);
    if (!d.unpackers || !d.results) {
        status = ibl_no_memory(ctx, "decoding an EXR");
        goto done;
    }
    file->deaf = true;
    status = ibl_run(ctx, "decode", jobs, decode_job, &d);
    file->deaf = false;
    for (int i = 0; i < threads; i++)
        unpacker_free(file, &d.unpackers[i]);
    if (!status)
        status = report(ctx, &d, jobs);
done:
    ibl_free(d.results);
    ibl_free(d.unpackers);
    return status;
}
