/* SPDX-License-Identifier: MIT */
/*
 * Lists and decodes the chunks of an EXR part.
 *
 * OpenEXRCore reads the chunk table. The layout of the pixels is computed here
 * and compared with OpenEXRCore's, so that a header cannot make either write
 * out of bounds. libdeflate undoes ZIP if the build has it, OpenEXR's C++
 * library DWA if OpenEXRCore does not, and OpenEXRCore all other compressions.
 *
 * A chunk stores its lines from the top; a line its channels in the list's
 * order; a channel the samples whose coordinates are multiples of its sampling
 * rates.
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
#include "core/half.h"
#include "io/bridge.h"
#include "io/colour_space.h"
#include "io/exr_file.h"

enum {
    JOB_BYTES = 1 << 17 /* about 0.2 ms of inflating */
};

/* ---- the layout ----------------------------------------------------- */

/* Upper limit of unpacked to packed size. zlib: 1032, see
 * zlib.net/zlib_tech.html; PXR24 zips 3 bytes of 4; RLE: 128 bytes in 2; PIZ:
 * Huffman codes of 255 repeats of 2 bytes take at least 1 + 1 + 8 bits; B44A:
 * 32 bytes in 3. DWA keeps 1 of 64 coefficients and zips that. */
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

/* Bytes of a sample. */
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

/* ---- the table ------------------------------------------------------ */

static uint32_t larger(uint32_t a, uint64_t b)
{
    return a > b ? a : (uint32_t)b;
}

static ibl_status add_chunk(const ibl_exr_file *file, const ibl_exr_pick *pick,
                            const exr_chunk_info_t *chunk, ibl_exr_table *table)
{
    const int y = chunk->start_y;
    const uint64_t packed = chunk->packed_size;
    const uint64_t bytes =
        layout_bytes(pick->channels, y, chunk->width, chunk->height);
    const double ratio = (double)bytes / (packed ? (double)packed : 1);
    /* on line 0 all channels have samples */
    const uint64_t line = layout_bytes(pick->channels, 0, chunk->width, 1);

    if (!ibl_input_has(file->in, chunk->data_offset, packed))
        return ibl_bad_file(file->in,
                            "EXR cut short: the block of line %d ends past the "
                            "end of the file: copy it again",
                            y);
    if (bytes != chunk->unpacked_size || bytes > INT_MAX)
        return ibl_unsupported(
            file->in,
            "the block of line %d unpacks to %llu bytes, not what its channels "
            "need, or too many for OpenEXRCore",
            y, (unsigned long long)bytes);
    if (packed > bytes ||
        (bytes > 4096 && ratio > max_ratio(pick->compression)))
        return ibl_bad_file(file->in,
                            "damaged EXR: the block of line %d claims %llu "
                            "bytes for %llu, which %s cannot do",
                            y, (unsigned long long)packed,
                            (unsigned long long)bytes,
                            ibl_exr_compression_name(pick->compression));
    table->chunks[table->count++] = *chunk;
    table->unpacked += bytes;
    table->most_packed = larger(table->most_packed, packed);
    table->most_unpacked = larger(table->most_unpacked, bytes);
    table->most_line = larger(table->most_line, line < bytes ? line : bytes);
    if (y == table->chunks[0].start_y)
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
    return ibl_bad_file(
        file->in, "EXR damaged or cut short at the block of line %d: %s", y,
        file->text[0] ? file->text : "its entry cannot be read");
}

static int steps(int length, int step)
{
    return (length - 1) / step + 1;
}

static ibl_status list_blocks(ibl_exr_file *file, const ibl_exr_pick *pick,
                              ibl_exr_table *table)
{
    const int width = pick->block_width, height = pick->block_height;
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
        info.start_x = x; /* for a tile, OpenEXRCore returns its column */
        info.start_y = y;
        const ibl_status status = add_chunk(file, pick, &info, table);
        if (status)
            return status;
    }
    return IBL_OK;
}

ibl_status ibl_exr_list_chunks(ibl_exr_file *file, const ibl_exr_pick *pick,
                               ibl_exr_table *table)
{
    const int width = pick->block_width, height = pick->block_height;

    *table = (ibl_exr_table){0};
    file->text[0] = 0;
    if (width < 1 || height < 1)
        return bad_chunk(file, pick->data.y0);

    /* A chunk takes at least 8 bytes of the file, in the chunk table. */
    const uint64_t count = (uint64_t)steps(pick->data.width, width) *
                           (uint64_t)steps(pick->data.height, height);
    if (count > file->in->size / 8 || count > INT_MAX)
        return ibl_bad_file(
            file->in,
            "EXR damaged or cut short: its %llu blocks cannot be in %zu bytes",
            (unsigned long long)count, file->in->size);
    table->chunks = ibl_alloc_array((size_t)count, sizeof *table->chunks);
    if (!table->chunks)
        return ibl_no_memory(file->in->ctx, "the blocks of an EXR");
    table->lines = height < pick->data.height ? height : pick->data.height;
    return list_blocks(file, pick, table);
}

/* ---- undoing the compression ---------------------------------------- */

/* A worker's state. */
struct ibl_exr_unpacker {
    exr_decode_pipeline_t pipeline;
    bool made; /* pipeline is initialised */
    unsigned char *packed;
    const unsigned char *bytes;  /* packed bytes of the current chunk */
    const unsigned char *pixels; /* next line of the chunk, unless ZIP */
    /* For ZIP and d->library: an unpacked chunk; for ZIP, one line of it. */
    struct libdeflate_decompressor *inflater;
    unsigned char *inflated, *line;
    const unsigned char *even, *odd; /* bytes of the next line; NULL: not ZIP */
    unsigned char last[2];
};

/* Replaces OpenEXRCore's reading: the packed bytes are in memory already.
 * OpenEXRCore does not free a buffer of size 0. */
static exr_result_t use_bytes(exr_decode_pipeline_t *pipeline)
{
    const ibl_exr_unpacker *u = pipeline->decoding_user_data;
    pipeline->packed_buffer = (void *)(uintptr_t)u->bytes;
    pipeline->packed_alloc_size = 0;
    return EXR_ERR_SUCCESS;
}

static exr_result_t leave_packed(exr_decode_pipeline_t *pipeline)
{
    (void)pipeline;
    return EXR_ERR_SUCCESS;
}

/* Gets the packed bytes of a chunk. On failure *error is errno, or 0 if the
 * file has become too short. */
static bool fetch(const ibl_exr_file *file, const exr_chunk_info_t *chunk,
                  ibl_exr_unpacker *u, int *error)
{
    size_t got;

    *error = 0;
    if (file->in->bytes) {
        u->bytes = file->in->bytes + chunk->data_offset;
        return true;
    }
    u->bytes = u->packed;
    if (!ibl_input_read(file->in, chunk->data_offset, chunk->packed_size,
                        u->packed, &got)) {
        *error = errno;
        return false;
    }
    return got == chunk->packed_size;
}

#if IBL_LIBDEFLATE
/* Returns false without memory. */
static bool make_unzipper(const ibl_exr_decoder *d, ibl_exr_unpacker *u)
{
    if (!u->inflater)
        u->inflater = libdeflate_alloc_decompressor();
    if (!u->inflated)
        u->inflated = ibl_alloc_array(d->table.most_unpacked, 1);
    if (!u->line)
        u->line = ibl_alloc_array(d->table.most_line, 1);
    return u->inflater && u->inflated && u->line;
}

/* Inflates ZIP and ZIPS; next_line undoes the differences. */
static exr_result_t unzip(const ibl_exr_decoder *d,
                          const exr_chunk_info_t *chunk, ibl_exr_unpacker *u)
{
    if (!make_unzipper(d, u))
        return EXR_ERR_OUT_OF_MEMORY;
    if (libdeflate_zlib_decompress(u->inflater, u->bytes, chunk->packed_size,
                                   u->inflated, chunk->unpacked_size,
                                   NULL) != LIBDEFLATE_SUCCESS)
        return EXR_ERR_CORRUPT_CHUNK;
    u->even = u->inflated;
    u->odd = u->inflated + chunk->unpacked_size / 2;
    ibl_unzip_begin(&d->dsp, u->even, chunk->unpacked_size / 2, u->last);
    return EXR_ERR_SUCCESS;
}
#endif

/* Undoes the compression with OpenEXR's C++ library. */
static exr_result_t run_library(const ibl_exr_decoder *d,
                                const exr_chunk_info_t *chunk,
                                ibl_exr_unpacker *u)
{
    if (!u->inflated)
        u->inflated = ibl_alloc_array(d->table.most_unpacked, 1);
    u->pixels = u->inflated;
    return u->inflated &&
                   d->library(d->pick.channels, chunk, u->bytes, u->inflated)
               ? EXR_ERR_SUCCESS
               : EXR_ERR_CORRUPT_CHUNK;
}

/* Undoes the compression with OpenEXRCore. */
static exr_result_t run_pipeline(const ibl_exr_decoder *d,
                                 const exr_chunk_info_t *chunk,
                                 ibl_exr_unpacker *u)
{
    const exr_context_t exr = d->file.exr;
    exr_decode_pipeline_t *p = &u->pipeline;
    const int part = d->pick.part;
    exr_result_t rv = EXR_ERR_SUCCESS;

    if (u->made) {
        rv = exr_decoding_update(exr, part, chunk, p);
    } else {
        rv = exr_decoding_initialize(exr, part, chunk, p);
        u->made = !rv;
        if (!rv)
            rv = exr_decoding_choose_default_routines(exr, part, p);
        p->decoding_user_data = u;
        p->read_fn = use_bytes;
        p->unpack_and_convert_fn = leave_packed;
    }
    return rv ? rv : exr_decoding_run(exr, part, p);
}

/* Undoes the compression of a fetched chunk; for ZIP, next_line finishes. */
static exr_result_t unpack(const ibl_exr_decoder *d,
                           const exr_chunk_info_t *chunk, ibl_exr_unpacker *u)
{
    u->even = NULL;
    /* For B44 too: OpenEXRCore would unpack a B44 block that did not shrink,
     * although it is stored uncompressed. */
    if (chunk->packed_size == chunk->unpacked_size) {
        u->pixels = u->bytes;
        return EXR_ERR_SUCCESS;
    }
#if IBL_LIBDEFLATE
    if (d->pick.compression == EXR_COMPRESSION_ZIP ||
        d->pick.compression == EXR_COMPRESSION_ZIPS)
        return unzip(d, chunk, u);
#endif
    if (d->library)
        return run_library(d, chunk, u);
    const exr_result_t rv = run_pipeline(d, chunk, u);
    u->pixels = u->pipeline.unpacked_buffer;
    return rv;
}

/* Returns the unpacked chunk's next line, y. Lines have even sizes. */
static const unsigned char *next_line(const ibl_exr_decoder *d,
                                      const exr_chunk_info_t *chunk, int y,
                                      ibl_exr_unpacker *u)
{
    const size_t bytes = layout_bytes(d->pick.channels, y, chunk->width, 1);

    if (!u->even) {
        u->pixels += bytes;
        return u->pixels - bytes;
    }
    d->dsp.unzip(u->even, u->odd, bytes / 2, u->last, u->line);
    u->even += bytes / 2;
    u->odd += bytes / 2;
    return u->line;
}

/* Whether the picture is three channels of halves at full size. */
static bool is_halves(const ibl_exr_pick *pick)
{
    bool all = pick->colour != IBL_EXR_LUMA && pick->chroma_step == 1;
    for (int c = 0; c < 3; c++)
        all = all && pick->channels->entries[pick->channel[c]].pixel_type ==
                         EXR_PIXEL_HALF;
    return all;
}

/* Whether this OpenEXRCore can undo the compression; tries one chunk. */
static bool can_decode(ibl_exr_decoder *d)
{
    int error;

    if (d->pick.compression < EXR_COMPRESSION_DWAA)
        return true;
    for (int i = 0; i < d->table.count; i++) {
        const exr_chunk_info_t *chunk = &d->table.chunks[i];
        if (chunk->packed_size == chunk->unpacked_size)
            continue;
        return !fetch(&d->file, chunk, &d->unpackers[0], &error) ||
               unpack(d, chunk, &d->unpackers[0]) !=
                   EXR_ERR_FEATURE_NOT_IMPLEMENTED;
    }
    return true;
}

static ibl_status load_library(ibl_exr_decoder *d)
{
    const ibl_input *in = d->file.in;
    const char *compression = ibl_exr_compression_name(d->pick.compression);
    char needs[64];

    for (int i = 0; i < d->pick.channels->num_channels; i++)
        if (d->pick.channels->entries[i].x_sampling != 1 ||
            d->pick.channels->entries[i].y_sampling != 1)
            return ibl_unsupported(in,
                                   "%s with channels of a smaller size is not "
                                   "read: save all at full size",
                                   compression);
    snprintf(needs, sizeof needs, "is OpenEXR, %s", compression);
    return ibl_bridge_find(in, "libiblexr.so", needs, IBL_OPENEXR_UNPACK,
                           &d->library);
}

ibl_status ibl_exr_decoder_init(ibl_exr_decoder *d)
{
    ibl_ctx *ctx = d->file.in->ctx;
    const size_t threads = (size_t)ibl_ctx_threads(ctx);
    const uint64_t each = d->table.unpacked / (uint64_t)d->table.count;

    ibl_half_planes_dsp_init(&d->dsp, ibl_ctx_isa(ctx));
    d->halves = is_halves(&d->pick);
    d->look = ibl_max_finite(ibl_ctx_isa(ctx));
    d->per_job = each < JOB_BYTES ? (int)(JOB_BYTES / (each ? each : 1)) : 1;
    d->threads = (int)threads;
    d->unpackers = ibl_alloc_zeroed(threads, sizeof *d->unpackers);
    if (!d->unpackers)
        return ibl_no_memory(ctx, "decoding an EXR");
    for (size_t i = 0; i < threads && !d->file.in->bytes; i++) {
        d->unpackers[i].packed = ibl_alloc_array(d->table.most_packed, 1);
        if (!d->unpackers[i].packed)
            return ibl_no_memory(ctx, "decoding an EXR");
    }
    return can_decode(d) ? IBL_OK : load_library(d);
}

void ibl_exr_decoder_free(ibl_exr_decoder *d)
{
    if (!d)
        return;
    for (int i = 0; d->unpackers && i < d->threads; i++) {
        if (d->unpackers[i].made)
            exr_decoding_destroy(d->file.exr, &d->unpackers[i].pipeline);
#if IBL_LIBDEFLATE
        libdeflate_free_decompressor(d->unpackers[i].inflater);
#endif
        ibl_free(d->unpackers[i].inflated);
        ibl_free(d->unpackers[i].line);
        ibl_free(d->unpackers[i].packed);
    }
    ibl_free(d->unpackers);
    ibl_free(d->table.chunks);
    if (d->file.exr)
        exr_finish(&d->file.exr);
    ibl_free(d);
}

/* ---- pixels --------------------------------------------------------- */

/* Converts count samples to floats; uints keep their value. */
static void to_floats(const unsigned char *src, exr_pixel_type_t type,
                      int count, float *dst, int dst_step)
{
    uint16_t half;
    uint32_t number;

    if (type == EXR_PIXEL_HALF) {
        for (int i = 0; i < count; i++) {
            memcpy(&half, src + 2 * i, sizeof half);
            dst[i * dst_step] = ibl_half_to_float(half);
        }
    } else if (type == EXR_PIXEL_FLOAT) {
        for (int i = 0; i < count; i++)
            memcpy(&dst[i * dst_step], src + 4 * i, sizeof *dst);
    } else {
        for (int i = 0; i < count; i++) {
            memcpy(&number, src + 4 * i, sizeof number);
            dst[i * dst_step] = (float)number;
        }
    }
}

/* The first error in a job. */
typedef struct outcome {
    exr_result_t code; /* EXR_ERR_READ_IO: reading failed, see error */
    int error;
    int y;
} outcome;

/* A set of chunks to decode. */
typedef struct decoding {
    const ibl_exr_decoder *d;
    int first, count; /* chunks */
    const ibl_exr_target *target;
    outcome *outcomes; /* one for each job */
} decoding;

/* The visible part of a chunk's line, and its place in the target. */
typedef struct shown {
    int skip, count;    /* pixels before the visible ones; visible pixels */
    float *rgb, *alpha; /* NULL: not wanted */
} shown;

static shown shown_of(const decoding *g, const exr_chunk_info_t *chunk, int y)
{
    const ibl_exr_window *map = &g->d->pick.display;
    const ibl_exr_target *t = g->target;
    const int end = chunk->start_x + chunk->width - 1;
    const int x0 = chunk->start_x > map->x0 ? chunk->start_x : map->x0;
    const int x1 = end < map->x1 ? end : map->x1;
    const int line = y - map->y0, row = line - t->row;
    const size_t width = (size_t)map->width, at = (size_t)(x0 - map->x0);
    shown s = {.skip = x0 - chunk->start_x, .count = x1 - x0 + 1};

    if (s.count < 1 || y < map->y0 || y > map->y1)
        return s;
    if (row >= 0 && row < t->count)
        s.rgb = t->rgb + 3 * (width * (size_t)row + at);
    if (t->alpha)
        s.alpha = t->alpha + width * (size_t)line + at;
    return s;
}

/* Stores a line of a half-size chroma channel in its plane. */
static void put_chroma(const decoding *g, const exr_chunk_info_t *chunk, int y,
                       const unsigned char *src, exr_pixel_type_t type, int c)
{
    const ibl_exr_chroma *chroma = g->target->chroma;
    const size_t row = (size_t)((y - g->d->pick.data.y0) / 2);
    to_floats(src, type, chunk->width / 2,
              chroma->plane[c - 1] + row * chroma->width, 1);
}

/* Converts count pixels to RGB, from Y or from full-size Y RY BY. */
static void finish_pixels(const ibl_exr_pick *pick, float *p, int count)
{
    if (pick->colour == IBL_EXR_LUMA_CHROMA && pick->chroma_step == 1)
        ibl_luma_to_rgb(pick->luma, p, count);
    if (pick->colour != IBL_EXR_LUMA)
        return;
    for (; count > 0; count--, p += 3)
        p[1] = p[2] = p[0];
}

static void put_line(const decoding *g, const exr_chunk_info_t *chunk, int y,
                     const unsigned char *src)
{
    const ibl_exr_pick *pick = &g->d->pick;
    const ibl_exr_target *t = g->target;
    const int wanted = pick->colour == IBL_EXR_LUMA ? 1 : 3;
    const shown s = shown_of(g, chunk, y);
    const unsigned char *plane[3] = {NULL, NULL, NULL};

    for (int i = 0; i < pick->channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &pick->channels->entries[i];
        const ptrdiff_t bytes = sample_bytes(e);
        const unsigned char *first = src + bytes * s.skip;
        if (!has_line(e, y))
            continue;
        if (i == pick->alpha && s.alpha)
            to_floats(first, e->pixel_type, s.count, s.alpha, 1);
        for (int c = 0; c < wanted; c++) {
            if (pick->channel[c] != i)
                continue;
            if (e->x_sampling > 1)
                put_chroma(g, chunk, y, src, e->pixel_type, c);
            else if (g->d->halves)
                plane[c] = first;
            else if (s.rgb)
                to_floats(first, e->pixel_type, s.count, s.rgb + c, 3);
        }
        src += bytes * (chunk->width / e->x_sampling);
    }
    if (!s.rgb)
        return;
    if (g->d->halves)
        g->d->dsp.to_rgb(plane, s.count, s.rgb);
    finish_pixels(pick, s.rgb, s.count);
    if (t->most) { /* then a chunk has whole rows */
        const size_t floats = 3 * (size_t)pick->display.width;
        const int row = y - pick->display.y0 - t->row;
        t->most[row] = g->d->look(t->rgb + floats * (size_t)row, floats);
    }
}

static void decode_job(void *arg, int job, int worker)
{
    const decoding *g = arg;
    const ibl_exr_decoder *d = g->d;
    ibl_exr_unpacker *u = &d->unpackers[worker];
    outcome *o = &g->outcomes[job];
    const int first = job * d->per_job;

    for (int i = first; i < first + d->per_job && i < g->count; i++) {
        const exr_chunk_info_t *chunk = &d->table.chunks[g->first + i];
        o->y = chunk->start_y;
        o->code = EXR_ERR_READ_IO;
        if (fetch(&d->file, chunk, u, &o->error))
            o->code = unpack(d, chunk, u);
        if (o->code)
            return;
        for (int y = chunk->start_y; y < chunk->start_y + chunk->height; y++)
            put_line(g, chunk, y, next_line(d, chunk, y, u));
    }
}

static ibl_status report(const ibl_exr_decoder *d, const outcome *o)
{
    const exr_compression_t compression = d->pick.compression;

    if (o->code == EXR_ERR_READ_IO && o->error)
        return ibl_input_unread(d->file.in, o->error);
    if (o->code == EXR_ERR_READ_IO)
        return ibl_bad_file(d->file.in,
                            "EXR cut short: the block of line %d ends past the "
                            "end of the file: copy it again",
                            o->y);
    if (o->code == EXR_ERR_OUT_OF_MEMORY &&
        compression != EXR_COMPRESSION_PXR24 &&
        compression < EXR_COMPRESSION_B44)
        return ibl_no_memory(d->file.in->ctx, "decoding an EXR");
    return ibl_bad_file(
        d->file.in,
        "damaged EXR: the %s block of line %d cannot be unpacked: %s",
        ibl_exr_compression_name(compression), o->y,
        exr_get_default_error_message(o->code));
}

ibl_status ibl_exr_decode_chunks(ibl_exr_decoder *d, int first, int count,
                                 const ibl_exr_target *target)
{
    ibl_ctx *ctx = d->file.in->ctx;
    const int jobs = (count + d->per_job - 1) / d->per_job;
    decoding g = {.d = d, .first = first, .count = count, .target = target};

    g.outcomes = ibl_alloc_zeroed((size_t)jobs, sizeof *g.outcomes);
    if (!g.outcomes)
        return ibl_no_memory(ctx, "decoding an EXR");
    d->file.deaf = true;
    ibl_status status = ibl_run(ctx, NULL, jobs, decode_job, &g);
    d->file.deaf = false;
    /* The first job in order: the report does not depend on threads. */
    for (int j = 0; j < jobs && !status; j++) {
        if (g.outcomes[j].code)
            status = report(d, &g.outcomes[j]);
    }
    ibl_free(g.outcomes);
    return status;
}
