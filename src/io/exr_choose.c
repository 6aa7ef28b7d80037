/* SPDX-License-Identifier: MIT */
/*
 * Finds the part and the channels of an EXR file that are the picture.
 *
 * A channel's name is LAYER.NAME, where the layer is everything before the
 * last dot. Names without a dot belong to the unnamed layer. A layer has
 * colour if it has R, G and B, or Y, or Y, RY and BY ("Technical Introduction
 * to OpenEXR"). The Y of X, Y, Z is a coordinate, and layers of Cryptomatte
 * hold numbers.
 */
#define _GNU_SOURCE /* strcasestr */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/context.h"
#include "io/colour_space.h"
#include "io/exr_file.h"

enum {
    MAX_CHANNELS = 1024
};

const char *ibl_exr_compression_name(exr_compression_t compression)
{
    static const char *const names[] = {"uncompressed", "RLE",   "ZIPS", "ZIP",
                                        "PIZ",          "PXR24", "B44",  "B44A",
                                        "DWAA",         "DWAB"};
    const size_t i = (size_t)compression;
    return i < sizeof names / sizeof names[0] ? names[i] : "unknown";
}

/* A list for a message; ends in dots if it gets too long. */
typedef struct list {
    char text[400];
    size_t used;
    int count;
    bool cut;
} text_list;

static void list_add(text_list *l, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));

static void list_add(text_list *l, const char *fmt, ...)
{
    const size_t room = sizeof l->text - l->used - sizeof ", ...";
    char item[280];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(item, sizeof item, fmt, ap);
    va_end(ap);
    if (l->cut)
        return;
    l->cut = strlen(item) + 2 > room;
    l->used += (size_t)sprintf(l->text + l->used, "%s%s", l->count ? ", " : "",
                               l->cut ? "..." : item);
    l->count++;
}

static const char *base_name(const char *channel)
{
    const char *dot = strrchr(channel, '.');
    return dot ? dot + 1 : channel;
}

static size_t layer_length(const char *channel)
{
    const char *dot = strrchr(channel, '.');
    return dot ? (size_t)(dot - channel) : 0;
}

static bool in_layer(const char *channel, const char *layer, size_t length)
{
    return layer_length(channel) == length &&
           (length == 0 || !strncmp(channel, layer, length));
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
        const char *base = base_name(channel);
        if (!strcmp(base, name))
            return i;
        if (other < 0 &&
            (!strcasecmp(base, name) || (longer && !strcasecmp(base, longer))))
            other = i;
    }
    return other;
}

static bool find_colour(const exr_attr_chlist_t *list, const char *layer,
                        size_t length, ibl_exr_pick *pick)
{
    const int r = find(list, layer, length, "R", "red");
    const int g = find(list, layer, length, "G", "green");
    const int b = find(list, layer, length, "B", "blue");
    pick->alpha = find(list, layer, length, "A", "alpha");
    if (r >= 0 && g >= 0 && b >= 0) {
        pick->colour = IBL_EXR_RGB;
        memcpy(pick->channel, (int[]){r, g, b}, sizeof pick->channel);
        return true;
    }
    const int y = find(list, layer, length, "Y", NULL);
    const int ry = find(list, layer, length, "RY", NULL);
    const int by = find(list, layer, length, "BY", NULL);
    if (y < 0 || find(list, layer, length, "X", NULL) >= 0)
        return false;
    pick->colour = ry >= 0 && by >= 0 ? IBL_EXR_LUMA_CHROMA : IBL_EXR_LUMA;
    memcpy(pick->channel,
           pick->colour == IBL_EXR_LUMA ? (int[]){y, y, y} : (int[]){y, ry, by},
           sizeof pick->channel);
    return true;
}

static bool is_deep(exr_storage_t storage)
{
    return storage == EXR_STORAGE_DEEP_SCANLINE ||
           storage == EXR_STORAGE_DEEP_TILED;
}

static const exr_attr_chlist_t *channels_of(const ibl_exr_file *file, int part)
{
    const exr_attr_chlist_t *list = NULL;
    if (exr_get_channels(file->exr, part, &list))
        return NULL;
    return list && list->num_channels <= MAX_CHANNELS ? list : NULL;
}

/* What was found in the parts that were searched. */
typedef struct found {
    text_list layers, names; /* layers with colour, all channels */
    int deep, flat;          /* number of such parts */
    int rank, count;         /* of the best layers; pick has the first */
} found;

/* Reports why no layer, or no single one, is the picture. */
static ibl_status explain(const ibl_exr_file *file, const char *layer,
                          const found *f)
{
    if (f->deep && !f->flat)
        return ibl_unsupported(
            file->in,
            "deep EXR data has no one colour per pixel; flatten it first");
    if (!f->layers.count)
        return ibl_bad_file(file->in,
                            "no colour in this EXR: it has %s; R, G and B or Y "
                            "alone are needed",
                            f->names.count ? f->names.text : "no channels");
    if (f->count)
        return ibl_bad_file(
            file->in,
            "several layers have colour: %s; pick one with the layer option",
            f->layers.text);
    return ibl_bad_file(file->in, "no layer '%s' with colour; there are: %s",
                        layer ? layer : "", f->layers.text);
}

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
 * counts only at its first channel. */
static void look_in_part(const ibl_exr_file *file, const ibl_exr_pick *part,
                         bool alone, const char *asked, ibl_exr_pick *pick,
                         found *f)
{
    const exr_attr_chlist_t *list = part->channels;
    const char *of = part_name(file, part->part);

    for (int i = 0; i < list->num_channels; i++) {
        const char *channel = list->entries[i].name.str;
        const size_t length = layer_length(channel);
        ibl_exr_pick this = *part;
        char layer[256];
        bool seen = false;

        list_add(&f->names, "%s", channel);
        snprintf(layer, sizeof layer, "%.*s", (int)length, channel);
        for (int j = 0; j < i && !seen; j++)
            seen = in_layer(list->entries[j].name.str, channel, length);
        if (seen || strcasestr(layer, "crypto") ||
            !find_colour(list, channel, length, &this))
            continue;
        const char *name = *layer ? layer : *of ? of : "(unnamed)";
        if (alone)
            list_add(&f->layers, "%s", *layer ? layer : "(unnamed)");
        else
            list_add(&f->layers, "%s (part %d)", name, part->part);
        const int rank = rank_of(asked, layer, of, this.colour == IBL_EXR_LUMA);
        if (rank > f->rank) {
            f->rank = rank;
            f->count = 0;
            *pick = this;
        }
        f->count += rank && rank == f->rank;
    }
}

static ibl_status no_such_part(const ibl_exr_file *file, int part, int parts)
{
    text_list names = {.count = 0};
    for (int p = 0; p < parts; p++) {
        const char *name = part_name(file, p);
        list_add(&names, "%d %s", p, *name ? name : "(unnamed)");
    }
    return ibl_bad_file(file->in, "no part %d; there are: %s", part,
                        names.text);
}

static ibl_status choose_part(const ibl_exr_file *file,
                              const ibl_read_options *opts, ibl_exr_pick *pick)
{
    found f = {.deep = 0};
    int parts = 0;

    if (exr_get_count(file->exr, &parts) || parts < 1)
        return ibl_bad_file(file->in, "this EXR has no parts");
    if (opts->part >= parts)
        return no_such_part(file, opts->part, parts);
    for (int p = 0; p < parts; p++) {
        exr_storage_t storage;
        if ((opts->part >= 0 && p != opts->part) ||
            exr_get_storage(file->exr, p, &storage))
            continue;
        const bool deep = is_deep(storage);
        const ibl_exr_pick part = {.part = p,
                                   .tiled = storage == EXR_STORAGE_TILED,
                                   .channels =
                                       deep ? NULL : channels_of(file, p)};
        f.deep += deep;
        f.flat += !deep;
        if (part.channels)
            look_in_part(file, &part, parts == 1, opts->layer, pick, &f);
    }
    return f.count == 1 ? IBL_OK : explain(file, opts->layer, &f);
}

/* Accepts a rate of 1, or 2 for both chroma channels. Other channels may have
 * any rate that divides the lines of a chunk, since OpenEXRCore computes wrong
 * sizes for the rest. */
static ibl_status check_sampling(const ibl_exr_file *file, ibl_exr_pick *pick)
{
    const exr_attr_chlist_entry_t *all = pick->channels->entries;
    const int lines = pick->tiled ? 1 : pick->block_height;

    for (int i = 0; i < pick->channels->num_channels; i++) {
        if (lines > 1 && lines % all[i].y_sampling)
            return ibl_unsupported(file->in,
                                   "channel %s has every %dth line only, which "
                                   "%s blocks of %d lines cannot hold",
                                   all[i].name.str, all[i].y_sampling,
                                   ibl_exr_compression_name(pick->compression),
                                   lines);
    }
    pick->chroma_step = 1;
    if (pick->colour == IBL_EXR_LUMA_CHROMA)
        pick->chroma_step = all[pick->channel[1]].x_sampling;
    for (int c = 0; c < 3; c++) {
        const bool chroma = pick->colour == IBL_EXR_LUMA_CHROMA && c > 0;
        const int step = chroma ? pick->chroma_step : 1;
        const exr_attr_chlist_entry_t *e = &all[pick->channel[c]];
        if (e->x_sampling != step || e->y_sampling != step || step > 2)
            return ibl_unsupported(file->in,
                                   "channel %s is sampled every %d x %d "
                                   "pixels; only RY and BY may be, every 2 x 2",
                                   e->name.str, e->x_sampling, e->y_sampling);
    }
    const exr_attr_chlist_entry_t *a =
        pick->alpha < 0 ? NULL : &all[pick->alpha];
    if (a && (a->x_sampling != 1 || a->y_sampling != 1))
        return ibl_unsupported(
            file->in,
            "channel %s is sampled every %d x %d pixels; alpha may not be",
            a->name.str, a->x_sampling, a->y_sampling);
    return IBL_OK;
}

static ibl_status read_window(const ibl_exr_file *file,
                              const exr_attr_box2i_t *box, const char *what,
                              ibl_exr_window *w)
{
    const long long width = (long long)box->max.x - box->min.x + 1;
    const long long height = (long long)box->max.y - box->min.y + 1;
    if (width < 1 || height < 1 || width > IBL_MAX_EDGE ||
        height > IBL_MAX_EDGE)
        return ibl_bad_file(
            file->in, "the EXR's %s is %lldx%lld; each edge must be 1 to %d",
            what, width, height, IBL_MAX_EDGE);
    *w = (ibl_exr_window){box->min.x, box->min.y, box->max.x,
                          box->max.y, (int)width, (int)height};
    return IBL_OK;
}

/* Limits the black area around the data: the file's size does not bound it. */
static ibl_status check_windows(const ibl_exr_file *file,
                                const ibl_exr_pick *pick)
{
    const ibl_exr_window *map = &pick->display, *data = &pick->data;
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

static ibl_status read_primaries(const ibl_exr_file *file, ibl_exr_pick *pick)
{
    exr_attr_chromaticities_t c;
    double rgb_from_xyz[9];

    memcpy(pick->primaries, ibl_primaries_xy(IBL_PRIMARIES_REC709),
           sizeof pick->primaries);
    pick->has_primaries = !exr_attr_get_chromaticities(file->exr, pick->part,
                                                       "chromaticities", &c);
    if (pick->has_primaries)
        memcpy(pick->primaries,
               (double[]){c.red_x, c.red_y, c.green_x, c.green_y, c.blue_x,
                          c.blue_y, c.white_x, c.white_y},
               sizeof pick->primaries);
    if (pick->colour == IBL_EXR_LUMA_CHROMA &&
        (!ibl_colour_space(pick->primaries, rgb_from_xyz, pick->luma) ||
         fabsf(pick->luma[1]) < 1e-6f))
        return ibl_bad_file(file->in,
                            "the EXR's chromaticities span no colour space");
    return IBL_OK;
}

ibl_status ibl_exr_choose(ibl_exr_file *file, const ibl_read_options *opts,
                          ibl_exr_pick *pick)
{
    exr_attr_box2i_t display, data;
    exr_envmap_t kind;
    int *width = &pick->block_width, *height = &pick->block_height;
    ibl_status status;

    *pick = (ibl_exr_pick){0};
    file->text[0] = 0;
    status = choose_part(file, opts, pick);
    if (status)
        return status;
    if (opts->alpha == IBL_ALPHA_IGNORE)
        pick->alpha = -1;
    if (exr_get_display_window(file->exr, pick->part, &display) ||
        exr_get_data_window(file->exr, pick->part, &data) ||
        exr_get_compression(file->exr, pick->part, &pick->compression) ||
        (pick->tiled
             ? exr_get_tile_sizes(file->exr, pick->part, 0, 0, width, height)
             : exr_get_scanlines_per_chunk(file->exr, pick->part, height)))
        return ibl_bad_file(file->in, "damaged EXR header: %s", file->text);
    if (!exr_attr_get_envmap(file->exr, pick->part, "envmap", &kind))
        pick->cube = kind == EXR_ENVMAP_CUBE;
    status = read_window(file, &display, "display window", &pick->display);
    if (!status)
        status = read_window(file, &data, "data window", &pick->data);
    if (!pick->tiled)
        *width = pick->data.width;
    if (!status)
        status = check_windows(file, pick);
    if (!status)
        status = check_sampling(file, pick);
    if (!status)
        status = read_primaries(file, pick);
    return status;
}
