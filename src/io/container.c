/* SPDX-License-Identifier: MIT */
#include "io/container.h"

#include <string.h>

#include "core/alloc.h"
#include "io/blocks.h"

uint32_t ibl_input_u32(const ibl_input *in, uint64_t at)
{
    uint32_t value;
    memcpy(&value, in->bytes + at, sizeof value);
    return in->swap ? __builtin_bswap32(value) : value;
}

ibl_status ibl_input_short(const ibl_input *in, const char *what)
{
    return ibl_bad_file(in,
                        "damaged or cut short: its %zu bytes do not hold %s: "
                        "copy or make it again",
                        in->size, what);
}

static size_t edge(int size, int level)
{
    return size >> level ? (size_t)(size >> level) : 1;
}

size_t ibl_texture_width(const ibl_texture *tex, int level)
{
    return edge(tex->width, level);
}

size_t ibl_texture_height(const ibl_texture *tex, int level)
{
    return edge(tex->height, level);
}

ibl_shape ibl_shape_of(const ibl_texture *tex)
{
    return (ibl_shape){.width = (uint32_t)tex->width,
                       .height = (uint32_t)tex->height,
                       .layers = tex->layers > 1 ? (uint32_t)tex->layers : 0,
                       .faces = (uint32_t)tex->faces,
                       .levels = (uint32_t)tex->levels};
}

static uint32_t max_levels(uint32_t width, uint32_t height)
{
    uint32_t levels = 1;
    while (width >> levels || height >> levels)
        levels++;
    return levels;
}

static ibl_status unsupported(const ibl_input *in, const char *what,
                              uint32_t value)
{
    return ibl_unsupported(
        in, "%s (%u): only 2D textures, cubes and arrays of them are read",
        what, value);
}

static ibl_status check_shape(const ibl_input *in, const ibl_shape *s)
{
    if (s->depth > 1)
        return unsupported(in, "a 3D texture, by its depth", s->depth);
    if (s->width && !s->height)
        return unsupported(in, "a 1D texture, by its width", s->width);
    if (s->width < 1 || s->height < 1)
        return ibl_bad_file(in, "%ux%u texels: a texture has at least 1x1",
                            s->width, s->height);
    if (s->width > IBL_MAX_EDGE || s->height > IBL_MAX_EDGE)
        return ibl_unsupported(in, "%ux%u texels: the limit is %d", s->width,
                               s->height, IBL_MAX_EDGE);
    if (s->layers > IBL_MAX_LAYERS)
        return ibl_unsupported(in, "an array of %u layers: the limit is %d",
                               s->layers, IBL_MAX_LAYERS);
    if (s->faces != 1 && s->faces != IBL_FACES)
        return ibl_bad_file(in, "%u faces: must be 6 or 1", s->faces);
    if (s->faces == IBL_FACES && s->width != s->height)
        return ibl_bad_file(in, "cube faces of %ux%u texels: must be square",
                            s->width, s->height);
    if (s->levels > max_levels(s->width, s->height))
        return ibl_bad_file(in, "%u levels of %ux%u texels: the limit is %u",
                            s->levels, s->width, s->height,
                            max_levels(s->width, s->height));
    return IBL_OK;
}

/* Bytes of a row of blocks. */
static uint64_t row_bytes(const ibl_layout *layout, size_t width,
                          uint32_t row_align)
{
    const uint64_t bytes = (uint64_t)ibl_layout_blocks(layout, width) *
                           (uint64_t)layout->block_bytes;
    return (bytes + row_align - 1) / row_align * row_align;
}

uint64_t ibl_place_bytes(const ibl_place *place, const ibl_texture *tex,
                         int level)
{
    return row_bytes(place->layout, ibl_texture_width(tex, level),
                     place->row_align) *
           ibl_layout_blocks(place->layout, ibl_texture_height(tex, level));
}

ibl_status ibl_texture_shape(const ibl_input *in, const ibl_shape *shape,
                             const ibl_place *place, ibl_texture *tex)
{
    const ibl_status status = check_shape(in, shape);
    if (status)
        return status;
    *tex = (ibl_texture){.pixel = place->layout->pixel,
                         .width = (int)shape->width,
                         .height = (int)shape->height,
                         .levels = shape->levels ? (int)shape->levels : 1,
                         .layers = shape->layers ? (int)shape->layers : 1,
                         .faces = (int)shape->faces};
    return IBL_OK;
}

ibl_status ibl_texture_alloc(const ibl_input *in, ibl_texture *tex)
{
    tex->bytes = ibl_texture_offset(tex, tex->levels, 0);
    if (in->head)
        return IBL_OK;
    const ibl_status status =
        ibl_allow(in, tex->bytes + (in->bytes ? in->size : 0));
    if (status)
        return status;
    tex->data = ibl_alloc_array(tex->bytes, 1);
    return tex->data ? IBL_OK : ibl_no_memory(in->ctx, "a texture");
}

ibl_status ibl_texture_begin(const ibl_input *in, const ibl_shape *shape,
                             const ibl_place *place, ibl_texture *tex)
{
    const ibl_status status = ibl_texture_shape(in, shape, place, tex);
    if (status)
        return status;
    const uint64_t images = (uint64_t)tex->layers * (uint64_t)tex->faces;
    uint64_t stored = 0;
    for (int l = 0; l < tex->levels; l++) /* below 2^51, by the limits */
        stored += images * ibl_place_bytes(place, tex, l);
    if (stored > in->size)
        return ibl_bad_file(in,
                            "damaged or cut short: its texels take %llu bytes, "
                            "the file has %zu: copy or make it again",
                            (unsigned long long)stored, in->size);
    /* The texture takes at most 4/3 of the file's size, or 8 times that if it
     * had signed blocks. */
    return ibl_texture_alloc(in, tex);
}

static void turn_words(unsigned char *p, size_t bytes, size_t word)
{
    for (size_t i = 0; i < bytes; i += word) {
        for (size_t a = i, b = i + word - 1; a < b; a++, b--) {
            const unsigned char t = p[a];
            p[a] = p[b];
            p[b] = t;
        }
    }
}

ibl_status ibl_place_read(const ibl_input *in, const ibl_place *place,
                          ibl_texture *tex, int level, int layer, int face)
{
    const ibl_layout *layout = place->layout;
    const size_t width =
        ibl_layout_blocks(layout, ibl_texture_width(tex, level));
    const size_t height =
        ibl_layout_blocks(layout, ibl_texture_height(tex, level));
    const uint64_t in_bytes =
        row_bytes(layout, ibl_texture_width(tex, level), place->row_align);
    const size_t texel = ibl_pixel_bytes(tex->pixel);
    const size_t stored = (size_t)layout->block_bytes; /* less for RGB */
    const size_t out_bytes = width * texel;
    unsigned char *out =
        tex->data + ibl_texture_layer_offset(tex, level, layer, face);

    if (!ibl_input_has(in, place->at, ibl_place_bytes(place, tex, level)))
        return ibl_bad_file(
            in,
            "damaged or cut short: face %d of level %d, layer %d, is at %llu, "
            "beyond the file's %zu bytes: copy or make it again",
            face, level, layer, (unsigned long long)place->at, in->size);
    if (place->bottom_up && layout->block_edge > 1)
        return ibl_unsupported(in, "blocks of texels whose rows begin at the "
                                   "bottom: only those from the top are read");
    if (layout == &ibl_layouts[IBL_LAYOUT_BC6H_SIGNED]) {
        ibl_signed_blocks_to_halves(in->bytes + place->at,
                                    ibl_texture_width(tex, level),
                                    ibl_texture_height(tex, level), out);
        return IBL_OK;
    }
    for (size_t y = 0; y < height; y++) {
        const size_t from = place->bottom_up ? height - 1 - y : y;
        const unsigned char *row = in->bytes + place->at + from * in_bytes;
        unsigned char *to = out + y * out_bytes;
        if (stored == texel)
            memcpy(to, row, out_bytes);
        for (size_t x = 0; x < width && stored < texel; x++)
            memcpy(to + x * texel, row + x * stored, stored);
        if (in->swap)
            turn_words(to, out_bytes, (size_t)layout->word_bytes);
        for (size_t x = 0; x < width && stored < texel; x++)
            ibl_pixel_set_alpha(tex->pixel, to, x, 1);
    }
    return IBL_OK;
}

ibl_status ibl_place_read_level(const ibl_input *in, ibl_place *place,
                                ibl_texture *tex, int level, int images,
                                uint64_t bytes)
{
    const uint64_t face_bytes = ibl_place_bytes(place, tex, level);
    const uint64_t must = (uint64_t)images * face_bytes;

    if (bytes != must)
        return ibl_bad_file(in, "damaged: level %d of %llu bytes, must be %llu",
                            level, (unsigned long long)bytes,
                            (unsigned long long)must);
    for (int i = 0; i < tex->layers * tex->faces; i++) {
        const ibl_status status = ibl_place_read(
            in, place, tex, level, i / tex->faces, i % tex->faces);
        if (status)
            return status;
        place->at += face_bytes;
    }
    return IBL_OK;
}
