/* SPDX-License-Identifier: MIT */
#include "io/container.h"

#include <string.h>

#include "io/blocks.h"

uint32_t ibl_input_u32(const ibl_input *in, uint64_t at)
{
    uint32_t value;
    memcpy(&value, in->bytes + at, sizeof value);
    return value;
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

ibl_extent ibl_extent_of(const ibl_texture *tex)
{
    return (ibl_extent){.width = (uint32_t)tex->width,
                        .height = (uint32_t)tex->height,
                        .layers = tex->layers > 1 ? (uint32_t)tex->layers : 0,
                        .faces = (uint32_t)tex->faces,
                        .levels = (uint32_t)tex->levels};
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

ibl_status ibl_texture_shape(const ibl_input *in, const ibl_extent *s,
                             const ibl_place *place, ibl_texture *tex)
{
    uint32_t most = 1;

    if (s->depth > 1 || (s->width && !s->height))
        return ibl_unsupported(in,
                               "a %s texture: only 2D textures, cubes and "
                               "arrays of them are read",
                               s->depth > 1 ? "3D" : "1D");
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
    while (s->width >> most || s->height >> most)
        most++;
    if (s->levels > most)
        return ibl_bad_file(in, "%u levels of %ux%u texels: the limit is %u",
                            s->levels, s->width, s->height, most);
    *tex = (ibl_texture){.pixel = place->layout->pixel,
                         .width = (int)s->width,
                         .height = (int)s->height,
                         .levels = s->levels ? (int)s->levels : 1,
                         .layers = s->layers ? (int)s->layers : 1,
                         .faces = (int)s->faces};
    return IBL_OK;
}

/* The texels take at most 4/3 of the file's size, or 8 times that if it has
 * signed blocks; of compressed levels what ibl_allow allows. */
ibl_status ibl_texture_alloc(const ibl_input *in, ibl_texture *tex)
{
    tex->bytes = ibl_texture_offset(tex, tex->levels, 0);
    if (in->head)
        return IBL_OK;
    const ibl_status status =
        ibl_allow(in, tex->bytes + (in->bytes ? in->size : 0));
    return status ? status : ibl_texture_room(in->ctx, tex);
}

uint64_t ibl_place_all_bytes(const ibl_place *place, const ibl_texture *tex,
                             uint64_t images)
{
    uint64_t bytes = 0;
    for (int l = 0; l < tex->levels; l++) /* below 2^51, by the limits */
        bytes += images * ibl_place_bytes(place, tex, l);
    return bytes;
}

ibl_status ibl_check_stored(const ibl_input *in, const ibl_place *place,
                            const ibl_texture *tex)
{
    const uint64_t bytes = ibl_place_all_bytes(
        place, tex, (uint64_t)tex->layers * (uint64_t)tex->faces);
    return bytes <= in->size
               ? IBL_OK
               : ibl_bad_file(in,
                              "damaged or cut short: its texels take %llu "
                              "bytes, the file has %zu: copy or make it again",
                              (unsigned long long)bytes, in->size);
}

ibl_status ibl_check_level_bytes(const ibl_input *in, int level, uint64_t bytes,
                                 uint64_t must)
{
    return bytes == must
               ? IBL_OK
               : ibl_bad_file(
                     in, "damaged: level %d of %llu bytes, must be %llu", level,
                     (unsigned long long)bytes, (unsigned long long)must);
}

ibl_status ibl_place_read(const ibl_input *in, ibl_place *place,
                          ibl_texture *tex, int level, int image)
{
    const ibl_layout *layout = place->layout;
    const size_t width = ibl_texture_width(tex, level);
    const size_t columns = ibl_layout_blocks(layout, width);
    const size_t rows =
        ibl_layout_blocks(layout, ibl_texture_height(tex, level));
    const uint64_t bytes = ibl_place_bytes(place, tex, level);
    const unsigned char *from = in->bytes + place->at;
    const size_t texel = ibl_pixel_bytes(tex->pixel);
    const size_t stored = (size_t)layout->block_bytes; /* less for RGB */
    unsigned char *to =
        tex->data + ibl_texture_layer_offset(tex, level, image / tex->faces,
                                             image % tex->faces);

    if (!ibl_input_has(in, place->at, bytes))
        return ibl_bad_file(
            in,
            "damaged or cut short: image %d of level %d is at %llu, beyond the "
            "file's %zu bytes: copy or make it again",
            image, level, (unsigned long long)place->at, in->size);
    place->at += bytes;
    if (place->bottom_up && layout->block_edge > 1)
        return ibl_unsupported(in, "blocks of texels whose rows begin at the "
                                   "bottom: only those from the top are read");
    if (layout == &ibl_layouts[IBL_LAYOUT_BC6H_SIGNED]) {
        ibl_signed_blocks_to_halves(from, width, ibl_texture_height(tex, level),
                                    to);
        return IBL_OK;
    }
    for (size_t y = 0; y < rows; y++) {
        const unsigned char *row =
            from + (place->bottom_up ? rows - 1 - y : y) *
                       row_bytes(layout, width, place->row_align);
        if (stored == texel)
            memcpy(to, row, columns * texel);
        for (size_t x = 0; x < columns && stored < texel; x++) {
            memcpy(to + x * texel, row + x * stored, stored);
            ibl_pixel_set_alpha(tex->pixel, to, x, 1);
        }
        to += columns * texel;
    }
    return IBL_OK;
}

ibl_status ibl_place_read_level(const ibl_input *in, ibl_place *place,
                                ibl_texture *tex, int level)
{
    ibl_status status = IBL_OK;
    for (int i = 0; i < tex->layers * tex->faces && !status; i++)
        status = ibl_place_read(in, place, tex, level, i);
    return status;
}
