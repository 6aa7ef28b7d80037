/* SPDX-License-Identifier: MIT */
/*
 * OpenEXR: finds the part and the channels that are the picture, lists its
 * chunks, undoes their compression, and reads rows.
 *
 * OpenEXRCore reads the header and the chunk table. The sizes of chunks are
 * computed here and compared with OpenEXRCore's, so that a header cannot make
 * either write out of bounds. libdeflate undoes ZIP if the build has it,
 * OpenEXR's C++ library all other compressions.
 */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include <OpenEXR/openexr.h>
#if IBL_LIBDEFLATE
#include <libdeflate.h>
#endif

#include "core/alloc.h"
#include "core/context.h"
#include "core/half.h"
#include "io/bridge.h"
#include "io/bridge/openexr.h"
#include "io/layout.h"
#include "io/rows.h"
#include "kern/half_planes.h"

enum {
    MAX_CHANNELS = 1024,
    LIST_BYTES = 400,
    JOB_BYTES = 1 << 17,  /* about 0.2 ms of inflating */
    BAND_BYTES = 1 << 25, /* of a band, but it has at least a row of blocks */
    LIBRARY_BYTES = 8 << 20, /* OpenEXR's C++ library, measured */
    DECODED = 5 /* blocks of memory in which it decodes one, measured */
};

/* Pixels x0..x1, y0..y1, both ends included. */
typedef struct exr_window {
    int x0, y0, x1, y1;
    int width, height;
} exr_window;

/* A worker's memory, of a chunk each. */
typedef struct exr_worker {
    unsigned char *packed, *unpacked;
    const unsigned char
        *pixels; /* unpacked: lines of channels in their order */
    struct libdeflate_decompressor *inflater;
    unsigned char *inflated; /* ZIP's differences */
    int fault, y;            /* of unpack, and the first line of that */
} exr_worker;

/* A file opened by OpenEXRCore, and what of it is the picture. */
typedef struct exr_reader {
    ibl_rows rows;
    const ibl_input *in;
    exr_context_t exr;
    bool no_memory; /* OpenEXRCore ran out of memory */
    int error;      /* errno of a failed read by OpenEXRCore, or 0 */
    char text[256]; /* first error text of OpenEXRCore; callers empty it to get
                       the next one */

    /* choose sets from here on. */
    int part;
    const exr_attr_chlist_t *channels; /* owned by OpenEXRCore */
    int channel[3]; /* indices in the list of R, G and B, or of Y */
    bool grey;
    int alpha; /* index of A, or -1 if not wanted or not there */
    exr_compression_t compression;
    bool tiled;
    bool cube;                     /* the file says that it holds six faces */
    int block_width, block_height; /* of a tile, or a block of scan lines */
    exr_window display, data;

    /* list_chunks: the chunks of level 0 that overlap the image, in the
     * part's order. start_x and start_y are a chunk's first pixel, in the
     * file's coordinates. */
    exr_chunk_info_t *chunks;
    int count;
    int columns;        /* number of chunks side by side: 1 without tiles */
    int lines;          /* height of a chunk; the last ones may have fewer */
    uint64_t unpacked;  /* bytes of all chunks */
    size_t most_packed; /* bytes of the largest chunk, packed */
    size_t most_unpacked;
    int before[4]; /* bytes of a pixel before R, G, B and A, ... */
    int all;       /* ... and of the whole pixel */

    /* begin */
    exr_worker *workers; /* one for each thread */
    int threads;
    ibl_openexr_unpack *library; /* for all but ZIP */
    ibl_half_planes_dsp dsp;

    /* ibl_exr_open */
    bool halves;    /* the three channels are halves */
    bool framed;    /* the data window does not cover the map */
    int begin, end; /* rows of the map that the blocks cover */
    int per_job;    /* chunks */
    int group;      /* number of rows of blocks that keeps all threads busy */
    float *band;    /* rows of blocks of which a call wanted a part */
    int band_row, band_count;
} exr_reader;

/* Why a chunk has no pixels; above 0: errno. */
enum {
    CUT = -1, /* the file has become too short */
    NO_MEMORY = -2,
    DAMAGED = -3
};

bool ibl_exr_is(const unsigned char *bytes, size_t size)
{
    return size >= 4 && !memcmp(bytes, "\x76\x2f\x31\x01", 4);
}

/* ---- the file ------------------------------------------------------- */

static int64_t size_fn(exr_const_context_t exr, void *user)
{
    (void)exr;
    return (int64_t)((const exr_reader *)user)->in->size;
}

static int64_t read_fn(exr_const_context_t exr, void *user, void *buffer,
                       uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t error)
{
    exr_reader *file = user;
    size_t got;
    if (ibl_input_read(file->in, offset, (size_t)size, buffer, &got))
        return (int64_t)got;
    file->error = errno;
    error(exr, EXR_ERR_READ_IO, "%s", strerror(file->error));
    return -1;
}

/* Keeps the first error text of OpenEXRCore: it names the cause, later texts
 * come from its callers. Also records that memory ran out: OpenEXRCore then
 * continues without some data, even without the list of channels. */
static void error_fn(exr_const_context_t exr, exr_result_t code,
                     const char *text)
{
    void *user = NULL;
    if (!exr || exr_get_user_data(exr, &user) || !user)
        return;
    exr_reader *file = user;
    file->no_memory |= code == EXR_ERR_OUT_OF_MEMORY;
    if (!file->text[0])
        snprintf(file->text, sizeof file->text, "%s", text);
}

static void *allocate(size_t bytes)
{
    return ibl_alloc_sparse(bytes, 1);
}

static ibl_status open_file(exr_reader *file)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = error_fn;
    init.user_data = file;
    init.read_fn = read_fn;
    init.size_fn = size_fn;
    init.alloc_fn = allocate;
    init.free_fn = ibl_free;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const exr_result_t rv = exr_start_read(&file->exr, "input", &init);
    if (rv)
        file->exr = NULL;
    if (rv == EXR_ERR_OUT_OF_MEMORY || file->no_memory)
        return ibl_no_memory(file->in->ctx, "the header of an EXR");
    if (!rv)
        return IBL_OK;
    if (file->error)
        return ibl_input_unread(file->in, file->error);
    return ibl_bad_file(file->in, "EXR header damaged or cut short: %s",
                        file->text[0] ? file->text
                                      : exr_get_default_error_message(rv));
}

static const char *compression_name(exr_compression_t compression)
{
    static const char *const names[] = {"uncompressed", "RLE",   "ZIPS", "ZIP",
                                        "PIZ",          "PXR24", "B44",  "B44A",
                                        "DWAA",         "DWAB"};
    const size_t i = (size_t)compression;
    return i < sizeof names / sizeof names[0] ? names[i] : "unknown";
}

/* ---- channels --------------------------------------------------------
 *
 * A channel's name is LAYER.NAME, where the layer is everything before the
 * last dot. Names without a dot belong to the unnamed layer. A layer has
 * colour if it has R, G and B, or Y ("Technical Introduction to OpenEXR"). The
 * Y of X, Y, Z is a coordinate, and layers of Cryptomatte hold numbers.
 */

/* Adds a name to a list for a message, with its part if that is not -1. */
static void list_add(char *list, const char *name, int part)
{
    const size_t used = strlen(list);

    snprintf(list + used, LIST_BYTES - used,
             part < 0 ? "%s%s" : "%s%s (part %d)", used ? ", " : "",
             *name ? name : "(unnamed)", part);
}

static size_t layer_length(const char *channel)
{
    const char *dot = strrchr(channel, '.');
    return dot ? (size_t)(dot - channel) : 0;
}

static bool in_layer(const char *channel, const char *layer, size_t length)
{
    return layer_length(channel) == length && !strncmp(channel, layer, length);
}

/* Index of the layer's channel with this name or the longer one that some
 * programs write, in any case; -1: none. Prefers the exact spelling. */
static int find(const exr_attr_chlist_t *list, const char *layer, size_t length,
                const char *name, const char *longer)
{
    int other = -1;
    for (int i = 0; i < list->num_channels; i++) {
        const char *channel = list->entries[i].name.str;
        if (!in_layer(channel, layer, length))
            continue;
        const char *base = channel + length + (length > 0);
        if (!strcmp(base, name))
            return i;
        if (other < 0 &&
            (!strcasecmp(base, name) || (longer && !strcasecmp(base, longer))))
            other = i;
    }
    return other;
}

static bool find_colour(const exr_attr_chlist_t *list, const char *layer,
                        size_t length, exr_reader *file)
{
    const int r = find(list, layer, length, "R", "red");
    const int g = find(list, layer, length, "G", "green");
    const int b = find(list, layer, length, "B", "blue");
    const int y = find(list, layer, length, "Y", NULL);

    file->alpha = find(list, layer, length, "A", "alpha");
    file->grey = r < 0 || g < 0 || b < 0;
    memcpy(file->channel, file->grey ? (int[]){y, y, y} : (int[]){r, g, b},
           sizeof file->channel);
    return !file->grey || (y >= 0 && find(list, layer, length, "X", NULL) < 0 &&
                           find(list, layer, length, "RY", NULL) < 0);
}

/* What was found in the parts that were searched. */
typedef struct found {
    char layers[LIST_BYTES], names[LIST_BYTES]; /* with colour; all channels */
    bool deep;                                  /* there is such a part */
    int rank, count; /* of the best layers; file has the first */
} found;

/* The name of a part that is not the only one, or "". */
static const char *part_name(const exr_reader *file, int part)
{
    const char *name = NULL;
    return exr_get_name(file->exr, part, &name) || !name ? "" : name;
}

/* How well a layer, by its own name and its part's, is the one that was asked
 * for: 0: it is not. Without a name R, G and B come before Y, and the unnamed
 * layer before others. */
static int rank_of(const char *asked, const char *layer, const char *part,
                   bool luma)
{
    const size_t length = strlen(layer);

    if (!asked)
        return 1 + 2 * !luma + !length;
    if (!strcmp(asked, layer))
        return 6;
    if (*part && !strcmp(asked, part))
        return 3 + 2 * !luma - (length > 0);
    const size_t tail = strlen(asked);
    return length > tail && layer[length - tail - 1] == '.' &&
           !strcmp(layer + length - tail, asked);
}

/* Adds the layers of a part. Channels are sorted by name, but those of one
 * layer need not be adjacent ("a-b.R" sorts between "a" and "a.R"), so a layer
 * counts only at its first channel. The best one goes to file. */
static void look_in_part(exr_reader *file, int part, bool alone,
                         const exr_attr_chlist_t *list, const char *asked,
                         found *f)
{
    const char *of = part_name(file, part);

    for (int i = 0; i < list->num_channels; i++) {
        const char *channel = list->entries[i].name.str;
        const size_t length = layer_length(channel);
        exr_reader this = *file;
        char layer[256];
        bool seen = false;

        list_add(f->names, channel, -1);
        snprintf(layer, sizeof layer, "%.*s", (int)length, channel);
        for (int j = 0; j < i && !seen; j++)
            seen = in_layer(list->entries[j].name.str, channel, length);
        /* Cryptomatte writes layers of crypto and of Crypto. */
        if (seen || strstr(layer, "rypto") ||
            !find_colour(list, channel, length, &this))
            continue;
        list_add(f->layers, *layer || alone ? layer : of, alone ? -1 : part);
        const int rank = rank_of(asked, layer, of, this.grey);
        if (rank > f->rank) {
            f->rank = rank;
            f->count = 0;
            this.part = part;
            this.channels = list;
            *file = this;
        }
        f->count += rank && rank == f->rank;
    }
}

static ibl_status choose_part(exr_reader *file, const ibl_read_options *opts)
{
    const ibl_input *in = file->in;
    found f = {.deep = false};
    int parts = 0;

    if (exr_get_count(file->exr, &parts) || parts < 1)
        return ibl_bad_file(in, "this EXR has no parts");
    if (opts->part >= parts) {
        for (int p = 0; p < parts; p++)
            list_add(f.layers, part_name(file, p), p);
        return ibl_bad_file(in, "no part %d; there are: %s", opts->part,
                            f.layers);
    }
    for (int p = 0; p < parts; p++) {
        const exr_attr_chlist_t *list = NULL;
        exr_storage_t storage;
        if ((opts->part >= 0 && p != opts->part) ||
            exr_get_storage(file->exr, p, &storage))
            continue;
        const bool deep = storage == EXR_STORAGE_DEEP_SCANLINE ||
                          storage == EXR_STORAGE_DEEP_TILED;
        f.deep |= deep;
        if (!deep && !exr_get_channels(file->exr, p, &list) && list &&
            list->num_channels <= MAX_CHANNELS)
            look_in_part(file, p, parts == 1, list, opts->layer, &f);
    }
    if (f.count == 1)
        return IBL_OK;
    if (f.deep && !*f.names)
        return ibl_unsupported(
            in, "deep EXR data has no one colour per pixel; flatten it first");
    if (!*f.layers)
        return ibl_bad_file(in,
                            "no colour in this EXR: it has %s; R, G and B or Y "
                            "alone are needed",
                            *f.names ? f.names : "no channels");
    if (f.count)
        return ibl_bad_file(
            in,
            "several layers have colour: %s; pick one with the layer option",
            f.layers);
    return ibl_bad_file(in, "no layer '%s' with colour; there are: %s",
                        opts->layer ? opts->layer : "", f.layers);
}

/* Where channels lie in a pixel. All must have a sample at each. */
static ibl_status lay_out(exr_reader *file)
{
    for (int i = 0; i < file->channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &file->channels->entries[i];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return ibl_unsupported(
                file->in,
                "channel %s is sampled every %d x %d pixels: save all at full "
                "size",
                e->name.str, e->x_sampling, e->y_sampling);
        for (int c = 0; c < 4; c++)
            if (i == (c < 3 ? file->channel[c] : file->alpha))
                file->before[c] = file->all;
        file->all += e->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    }
    return IBL_OK;
}

/* Checks the windows, and limits the black area around the data: the file's
 * size does not bound it. */
static ibl_status take_windows(exr_reader *file,
                               const exr_attr_box2i_t boxes[2])
{
    static const char *const what[] = {"display", "data"};
    exr_window *const windows[] = {&file->display, &file->data};
    const exr_window *map = &file->display, *data = &file->data;

    for (int i = 0; i < 2; i++) {
        const exr_attr_v2i_t min = boxes[i].min, max = boxes[i].max;
        const long long width = (long long)max.x - min.x + 1;
        const long long height = (long long)max.y - min.y + 1;
        if (width < 1 || height < 1 || width > IBL_MAX_EDGE ||
            height > IBL_MAX_EDGE)
            return ibl_bad_file(
                file->in,
                "the EXR's %s window is %lldx%lld; each edge must be 1 to %d",
                what[i], width, height, IBL_MAX_EDGE);
        *windows[i] =
            (exr_window){min.x, min.y, max.x, max.y, (int)width, (int)height};
    }
    const double pixels = (double)map->width * map->height;
    if (data->x1 < map->x0 || data->x0 > map->x1 || data->y1 < map->y0 ||
        data->y0 > map->y1)
        return ibl_bad_file(file->in, "the EXR's data window lies outside its "
                                      "display window, so the map is empty");
    if (pixels > 8e6 && pixels > 64.0 * data->width * data->height)
        return ibl_bad_file(file->in,
                            "the EXR's display window is %dx%d but its data "
                            "only %dx%d; less than 1/64 is taken for damage",
                            map->width, map->height, data->width, data->height);
    return IBL_OK;
}

/* Finds the part and layer of opts, and the part's windows. If they are not
 * found, the message lists the parts or layers of the file. */
static ibl_status choose(exr_reader *file, const ibl_read_options *opts)
{
    exr_attr_chromaticities_t c;
    exr_attr_box2i_t boxes[2]; /* display, data */
    exr_envmap_t kind;
    int *width = &file->block_width, *height = &file->block_height;
    exr_storage_t storage = EXR_STORAGE_SCANLINE;

    file->text[0] = 0;
    ibl_status status = choose_part(file, opts);
    if (status)
        return status;
    const exr_context_t exr = file->exr;
    const int part = file->part;
    if (opts->alpha == IBL_ALPHA_IGNORE)
        file->alpha = -1;
    exr_get_storage(exr, part, &storage);
    file->tiled = storage == EXR_STORAGE_TILED;
    if (exr_get_display_window(exr, part, &boxes[0]) ||
        exr_get_data_window(exr, part, &boxes[1]) ||
        exr_get_compression(exr, part, &file->compression) ||
        (file->tiled ? exr_get_tile_sizes(exr, part, 0, 0, width, height)
                     : exr_get_scanlines_per_chunk(exr, part, height)))
        return ibl_bad_file(file->in, "damaged EXR header: %s", file->text);
    file->cube = !exr_attr_get_envmap(exr, part, "envmap", &kind) &&
                 kind == EXR_ENVMAP_CUBE;
    ibl_read_report *facts = &file->rows.report;
    facts->has_primaries =
        !exr_attr_get_chromaticities(exr, part, "chromaticities", &c);
    if (facts->has_primaries)
        memcpy(facts->primaries,
               (double[]){c.red_x, c.red_y, c.green_x, c.green_y, c.blue_x,
                          c.blue_y, c.white_x, c.white_y},
               sizeof facts->primaries);
    status = take_windows(file, boxes);
    if (!file->tiled)
        *width = file->data.width;
    return status ? status : lay_out(file);
}

/* ---- the table ------------------------------------------------------ */

/* Upper limits of unpacked to packed size. zlib: 1032, see
 * zlib.net/zlib_tech.html; PXR24 zips 3 bytes of 4, and no other one packs more
 * tightly but DWA, which keeps 1 of 64 coefficients and zips that. */
enum {
    MOST_RATIO = 1376,
    MOST_RATIO_DWA = 64 * 1376
};

static ibl_status cut_short(const exr_reader *file, int y)
{
    return ibl_bad_file(file->in,
                        "EXR cut short: the block of line %d ends past the end "
                        "of the file: copy it again",
                        y);
}

static ibl_status add_chunk(exr_reader *file, const exr_chunk_info_t *chunk)
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
        return cut_short(file, y);
    if (bytes != chunk->unpacked_size || bytes > INT_MAX || packed > bytes ||
        (bytes > 4096 && bytes > ratio * packed))
        return ibl_bad_file(file->in,
                            "damaged EXR: the block of line %d claims %llu "
                            "bytes for %llu, which %s cannot do",
                            y, (unsigned long long)packed,
                            (unsigned long long)bytes,
                            compression_name(file->compression));
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

static ibl_status bad_chunk(const exr_reader *file, int y)
{
    if (file->no_memory)
        return ibl_no_memory(file->in->ctx, "the blocks of an EXR");
    if (file->error)
        return ibl_input_unread(file->in, file->error);
    return ibl_bad_file(
        file->in, "EXR damaged or cut short at the block of line %d: %s", y,
        file->text[0] ? file->text : "its entry cannot be read");
}

/* Checks that the file contains them and that the compression can produce their
 * sizes. */
static ibl_status list_chunks(exr_reader *file)
{
    const int width = file->block_width, height = file->block_height;
    const exr_window *data = &file->data, *map = &file->display;
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

static bool by_libdeflate(const exr_reader *file)
{
    return IBL_LIBDEFLATE && (file->compression == EXR_COMPRESSION_ZIP ||
                              file->compression == EXR_COMPRESSION_ZIPS);
}

/* Gets a chunk and undoes its compression to u->pixels. Returns a fault. */
static int unpack(const exr_reader *file, const exr_chunk_info_t *chunk,
                  exr_worker *u)
{
    const ibl_input *in = file->in;
    size_t got = chunk->packed_size;
    const unsigned char *bytes =
        in->bytes ? in->bytes + chunk->data_offset : u->packed;

    if (!in->bytes &&
        !ibl_input_read(in, chunk->data_offset, got, u->packed, &got))
        return errno;
    if (got != chunk->packed_size)
        return CUT;
    u->pixels = bytes;
    if (chunk->packed_size == chunk->unpacked_size) /* did not shrink */
        return 0;
    if (file->compression == EXR_COMPRESSION_NONE)
        return DAMAGED;
    if (!u->unpacked)
        u->unpacked = ibl_alloc_array(file->most_unpacked, 1);
    if (!u->unpacked)
        return NO_MEMORY;
    u->pixels = u->unpacked;
    if (file->library)
        return file->library(file->channels, chunk, bytes, u->unpacked)
                   ? 0
                   : DAMAGED;
#if IBL_LIBDEFLATE
    const size_t half = chunk->unpacked_size / 2; /* pixels have even sizes */
    unsigned char last[2];
    if (!u->inflater)
        u->inflater = libdeflate_alloc_decompressor();
    if (!u->inflated)
        u->inflated = ibl_alloc_array(file->most_unpacked, 1);
    if (!u->inflater || !u->inflated)
        return NO_MEMORY;
    if (libdeflate_zlib_decompress(u->inflater, bytes, chunk->packed_size,
                                   u->inflated, chunk->unpacked_size,
                                   NULL) != LIBDEFLATE_SUCCESS)
        return DAMAGED;
    ibl_unzip_begin(&file->dsp, u->inflated, half, last);
    file->dsp.unzip(u->inflated, u->inflated + half, half, last, u->unpacked);
#endif
    return 0;
}

/* IBL_ERR_UNSUPPORTED: needs libiblexr.so, which is missing. */
static ibl_status begin(exr_reader *file)
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
             compression_name(file->compression));
    return ibl_bridge_find(file->in, "libiblexr.so", needs,
                           file->compression < EXR_COMPRESSION_DWAA
                               ? IBL_OPENEXR_UNPACK
                               : IBL_OPENEXR_UNPACK_DWA,
                           &file->library);
}

/* Closes the file and frees what it holds. */
static void close_file(exr_reader *file)
{
    for (int i = 0; i < file->threads; i++) {
        exr_worker *u = &file->workers[i];
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

/* ---- pixels --------------------------------------------------------- */

/* Chunks to decode to `rows` rows of the map, from `row` on. */
typedef struct decoding {
    exr_reader *r;
    int first, count; /* chunks */
    int row, rows;
    float *rgb;
} decoding;

/* Converts count samples to floats; uints keep their value. */
static void to_floats(const unsigned char *src, exr_pixel_type_t type,
                      int count, float *dst, int dst_step)
{
    uint16_t half;
    uint32_t number;

    for (int i = 0; i < count; i++, dst += dst_step) {
        if (type == EXR_PIXEL_HALF) {
            memcpy(&half, src + 2 * i, sizeof half);
            *dst = ibl_half_to_float(half);
        } else if (type == EXR_PIXEL_FLOAT) {
            memcpy(dst, src + 4 * i, sizeof *dst);
        } else {
            memcpy(&number, src + 4 * i, sizeof number);
            *dst = (float)number;
        }
    }
}

/* Puts the visible part of a chunk's line, y, in place. */
static void put_line(const decoding *g, const exr_chunk_info_t *chunk, int y,
                     const unsigned char *src)
{
    const exr_reader *r = g->r;
    const exr_window *map = &r->display;
    const int end = chunk->start_x + chunk->width - 1;
    const int x0 = chunk->start_x > map->x0 ? chunk->start_x : map->x0;
    const int count = (end < map->x1 ? end : map->x1) - x0 + 1;
    const int line = y - map->y0, row = line - g->row;
    const size_t width = (size_t)map->width, at = (size_t)(x0 - map->x0);
    const unsigned char *plane[4];
    exr_pixel_type_t type[4];

    if (count < 1 || row < 0 || row >= g->rows)
        return;
    for (int c = 0; c < 4; c++) {
        const int channel = c < 3 ? r->channel[c] : r->alpha;
        type[c] = r->channels->entries[channel < 0 ? 0 : channel].pixel_type;
        plane[c] = src + (size_t)r->before[c] * (size_t)chunk->width +
                   (type[c] == EXR_PIXEL_HALF ? 2 : 4) * (x0 - chunk->start_x);
    }
    float *rgb = g->rgb + 3 * (width * (size_t)row + at);
    if (r->halves)
        r->dsp.to_rgb(plane, count, rgb);
    for (int c = 0; c < 3 && !r->halves; c++)
        to_floats(plane[c], type[c], count, rgb + c, 3);
    if (r->rows.alpha)
        to_floats(plane[3], type[3], count,
                  r->rows.alpha + width * (size_t)line + at, 1);
}

static void decode_job(void *arg, int job, int worker)
{
    const decoding *g = arg;
    const exr_reader *file = g->r;
    exr_worker *u = &file->workers[worker];
    const int first = job * file->per_job;

    for (int i = first; i < first + file->per_job && i < g->count; i++) {
        const exr_chunk_info_t *chunk = &file->chunks[g->first + i];
        const int fault = unpack(file, chunk, u);
        if (fault) {
            if (!u->fault || chunk->start_y < u->y) {
                u->fault = fault;
                u->y = chunk->start_y;
            }
            return;
        }
        const size_t bytes = (size_t)chunk->width * (size_t)file->all;
        for (int line = 0; line < chunk->height; line++)
            put_line(g, chunk, chunk->start_y + line,
                     u->pixels + bytes * (size_t)line);
    }
}

static ibl_status report(const exr_reader *file, const exr_worker *o)
{
    if (o->fault > 0)
        return ibl_input_unread(file->in, o->fault);
    if (o->fault == CUT)
        return cut_short(file, o->y);
    if (o->fault == NO_MEMORY)
        return ibl_no_memory(file->in->ctx, "decoding an EXR");
    return ibl_bad_file(
        file->in, "damaged EXR: the %s block of line %d cannot be unpacked",
        compression_name(file->compression), o->y);
}

/* ---- rows in order --------------------------------------------------
 *
 * Blocks hold some rows each, or, as tiles, parts of some rows. Those that lie
 * within what a call wants are decoded to where it wants them, others to a band
 * that calls copy from.
 */

/* The map's row after the last row of a row of blocks. */
static int row_after(const exr_reader *r, int blocks)
{
    const int row =
        r->chunks[0].start_y + (blocks + 1) * r->lines - r->display.y0;
    return row < r->end ? row : r->end;
}

/* Decodes from `row`, where a row of blocks begins, as many as fit before *end
 * straight to rgb, and sets *end behind them; if fewer than a group fit, a
 * group to the band. */
static ibl_status decode_some(exr_reader *r, int row, int *end, float *rgb)
{
    const int blocks = (row + r->display.y0 - r->chunks[0].start_y) / r->lines;
    const int left = r->count / r->columns - blocks;
    const int group = left < r->group ? left : r->group;
    decoding g = {.r = r, .first = blocks * r->columns, .row = row, .rgb = rgb};
    int count = 0;

    while (count < left && row_after(r, blocks + count) <= *end)
        count++;
    const bool fits = count >= group;
    count = fits ? count : group;
    g.count = count * r->columns;
    g.rows = row_after(r, blocks + count - 1) - row;
    *end = fits ? row + g.rows : row;
    if (!fits) {
        const int needed = r->group * r->lines, height = r->rows.height;
        const size_t line = 3 * (size_t)r->rows.width;
        if (!r->band)
            r->band = ibl_alloc_array(
                (size_t)(needed < height ? needed : height) * line,
                sizeof *r->band);
        if (!r->band)
            return ibl_no_memory(r->rows.ctx, "the blocks of an EXR");
        r->band_row = row;
        r->band_count = g.rows;
        g.rgb = r->band;
        if (r->framed)
            memset(g.rgb, 0, line * (size_t)g.rows * sizeof *g.rgb);
    }
    const int jobs = (g.count + r->per_job - 1) / r->per_job;
    const ibl_status status = ibl_run(r->rows.ctx, NULL, jobs, decode_job, &g);
    /* The first line: the report does not depend on threads. */
    const exr_worker *first = NULL;
    for (int i = 0; i < r->threads; i++) {
        const exr_worker *u = &r->workers[i];
        if (u->fault && (!first || u->y < first->y))
            first = u;
    }
    return status || !first ? status : report(r, first);
}

static void end_decoding(exr_reader *r)
{
    close_file(r);
    ibl_free(r->band);
    r->band = NULL;
}

static ibl_status rows_read(ibl_rows *rows, int count, float *rgb)
{
    exr_reader *r = (exr_reader *)rows;
    const size_t floats = 3 * (size_t)rows->width;
    const int last = rows->row + count, stop = last < r->end ? last : r->end;
    ibl_status status = IBL_OK;

    if (r->framed)
        memset(rgb, 0, floats * (size_t)count * sizeof *rgb);
    for (int row = rows->row > r->begin ? rows->row : r->begin, end;
         row < stop && !status; row = end) {
        const int in_band = row - r->band_row, left = r->band_count - in_band;
        float *to = rgb + floats * (size_t)(row - rows->row);
        end = stop;
        if (in_band < 0 || left <= 0) {
            status = decode_some(r, row, &end, to);
            continue;
        }
        end = end - row > left ? row + left : end;
        memcpy(to, r->band + floats * (size_t)in_band,
               floats * (size_t)(end - row) * sizeof *to);
    }
    if (last == rows->height)
        end_decoding(r);
    return status;
}

static void rows_close(ibl_rows *rows)
{
    end_decoding((exr_reader *)rows);
    ibl_free(rows);
}

/* ---- opening -------------------------------------------------------- */

/* The faces of OpenEXR's cubes (ImfEnvmap.h), turned so that a cube shows what
 * its latitude-longitude map does when that is read. */
static const char envmap_faces[] = "nz/m,pz/m,py/m90,ny/m270,px/m,nx/m";

ibl_status ibl_exr_open(ibl_input *in, const ibl_read_options *opts,
                        ibl_rows **out)
{
    exr_reader *r = ibl_alloc_zeroed(1, sizeof *r);

    *out = NULL;
    if (!r)
        return ibl_no_memory(in->ctx, "an EXR");
    ibl_rows *rows = *out = &r->rows;
    *rows = (ibl_rows){.ctx = in->ctx, .read = rows_read, .close = rows_close};
    r->in = in;
    ibl_read_options own = *opts;
    ibl_status status = open_file(r);
    if (!status)
        status = choose(r, opts);
    if (status)
        return status;
    if (r->cube && !own.layout)
        own.layout = IBL_INPUT_CUBE;
    if (own.layout == IBL_INPUT_CUBE && !r->cube)
        return ibl_bad_file(in, "is an OpenEXR file that does not say that it "
                                "holds a cube");
    r->cube = own.layout == IBL_INPUT_CUBE;
    status = ibl_map_check_size(in, &own, r->display.width, r->display.height);
    if (!status)
        status = list_chunks(r);
    if (!status)
        status = begin(r);
    if (status)
        return status;
    const exr_window *map = &r->display, *data = &r->data;
    const size_t block_bytes =
        3 * sizeof(float) * (size_t)map->width * (size_t)r->lines;
    const uint64_t each = r->unpacked / (uint64_t)r->count;
    r->framed = data->x0 > map->x0 || data->y0 > map->y0 ||
                data->x1 < map->x1 || data->y1 < map->y1;
    r->begin = data->y0 > map->y0 ? data->y0 - map->y0 : 0;
    r->end = (data->y1 < map->y1 ? data->y1 : map->y1) - map->y0 + 1;
    r->per_job = each < JOB_BYTES ? (int)(JOB_BYTES / (each ? each : 1)) : 1;
    r->group = (r->threads * r->per_job + r->columns - 1) / r->columns;
    if ((size_t)r->group > BAND_BYTES / block_bytes)
        r->group = (int)(BAND_BYTES / block_bytes);
    r->group = r->group ? r->group : 1;
    r->halves = true;
    for (int c = 0; c < 3; c++)
        r->halves &=
            r->channels->entries[r->channel[c]].pixel_type == EXR_PIXEL_HALF;
    rows->width = map->width;
    rows->height = map->height;
    if (r->library)
        rows->held = (LIBRARY_BYTES +
                      DECODED * (double)r->threads * (double)r->most_unpacked) /
                     ((double)rows->width * rows->height);
    snprintf(rows->report.format, sizeof rows->report.format, "OpenEXR, %s%s%s",
             compression_name(r->compression), r->tiled ? ", tiled" : "",
             r->grey ? ", Y" : "");
    if (r->cube) {
        rows->report.layout = IBL_INPUT_CUBE;
        rows->to_edges = true;
        ibl_face_order_parse(envmap_faces, rows->face_order);
    }
    return r->alpha < 0 ? IBL_OK : ibl_rows_alloc_alpha(rows);
}

/* ---- the library ---------------------------------------------------- */

const char *ibl_exr_version(void)
{
    return OPENEXR_VERSION_STRING;
}
