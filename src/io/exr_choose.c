/* SPDX-License-Identifier: MIT */
/*
 * Finds the part and the channels of an EXR file that are the picture.
 *
 * A channel's name is LAYER.NAME, where the layer is everything before the
 * last dot. Names without a dot belong to the unnamed layer. A layer has
 * colour if it has R, G and B, or Y ("Technical Introduction to OpenEXR"). The
 * Y of X, Y, Z is a coordinate, and layers of Cryptomatte hold numbers.
 */
#define _GNU_SOURCE /* strcasestr */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/context.h"
#include "io/exr_file.h"

enum {
    MAX_CHANNELS = 1024,
    LIST_BYTES = 400
};

const char *ibl_exr_compression_name(exr_compression_t compression)
{
    static const char *const names[] = {"uncompressed", "RLE",   "ZIPS", "ZIP",
                                        "PIZ",          "PXR24", "B44",  "B44A",
                                        "DWAA",         "DWAB"};
    const size_t i = (size_t)compression;
    return i < sizeof names / sizeof names[0] ? names[i] : "unknown";
}

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
                        size_t length, ibl_exr_file *file)
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
static const char *part_name(const ibl_exr_file *file, int part)
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
static void look_in_part(ibl_exr_file *file, int part, bool alone,
                         const exr_attr_chlist_t *list, const char *asked,
                         found *f)
{
    const char *of = part_name(file, part);

    for (int i = 0; i < list->num_channels; i++) {
        const char *channel = list->entries[i].name.str;
        const size_t length = layer_length(channel);
        ibl_exr_file this = *file;
        char layer[256];
        bool seen = false;

        list_add(f->names, channel, -1);
        snprintf(layer, sizeof layer, "%.*s", (int)length, channel);
        for (int j = 0; j < i && !seen; j++)
            seen = in_layer(list->entries[j].name.str, channel, length);
        if (seen || strcasestr(layer, "crypto") ||
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

static ibl_status choose_part(ibl_exr_file *file, const ibl_read_options *opts)
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
static ibl_status lay_out(ibl_exr_file *file)
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
static ibl_status take_windows(ibl_exr_file *file,
                               const exr_attr_box2i_t boxes[2])
{
    static const char *const what[] = {"display", "data"};
    ibl_exr_window *const windows[] = {&file->display, &file->data};
    const ibl_exr_window *map = &file->display, *data = &file->data;

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
        *windows[i] = (ibl_exr_window){min.x, min.y,      max.x,
                                       max.y, (int)width, (int)height};
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

ibl_status ibl_exr_choose(ibl_exr_file *file, const ibl_read_options *opts)
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
    ibl_read_report *report = &file->rows.report;
    report->has_primaries =
        !exr_attr_get_chromaticities(exr, part, "chromaticities", &c);
    if (report->has_primaries)
        memcpy(report->primaries,
               (double[]){c.red_x, c.red_y, c.green_x, c.green_y, c.blue_x,
                          c.blue_y, c.white_x, c.white_y},
               sizeof report->primaries);
    status = take_windows(file, boxes);
    if (!file->tiled)
        *width = file->data.width;
    return status ? status : lay_out(file);
}
