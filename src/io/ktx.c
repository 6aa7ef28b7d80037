/* SPDX-License-Identifier: MIT */
/* Khronos KTX 1.1. Source: KTX File Format Specification, version 1.1.
 * imageSize is the size of one face for a cube, and of the level for all other
 * textures and for cube arrays. Rows are padded to 4 bytes. */
#include <stddef.h>
#include <string.h>

#include "io/container.h"

enum {
    ROW_ALIGN = 4
};

typedef struct header {
    char identifier[12];
    uint32_t endianness;
    uint32_t gl_type, gl_type_size, gl_format;
    uint32_t gl_internal_format, gl_base_internal_format;
    ibl_extent shape; /* layers is numberOfArrayElements */
    uint32_t key_bytes;
} header;

_Static_assert(sizeof(header) == 64, "as the specification has it");

static const uint32_t little_endian = 0x04030201, big_endian = 0x01020304;
static const char rows_down[] = "S=r,T=d", rows_up[] = "S=r,T=u";

static header header_of(const ibl_texture *tex, size_t key_bytes)
{
    const ibl_layout *layout = &ibl_layouts[tex->pixel];
    header h = {.identifier = IBL_KTX_MAGIC,
                .endianness = little_endian,
                .gl_type = layout->gl_type,
                .gl_type_size = (uint32_t)layout->word_bytes,
                .gl_format = layout->gl_type ? layout->gl_format : 0,
                .gl_internal_format = layout->gl_internal,
                .gl_base_internal_format = layout->gl_format,
                .shape = ibl_extent_of(tex),
                .key_bytes = (uint32_t)key_bytes};

    if (tex->filament && tex->pixel == IBL_PIXEL_R11G11B10F) {
        h.gl_type = h.gl_base_internal_format = h.gl_internal_format;
        h.gl_type_size = 1;
    }
    return h;
}

/* imageSize of a level. */
static size_t image_size(const ibl_texture *tex, int level)
{
    return tex->layers > 1 ? ibl_texture_level_bytes(tex, level)
                           : ibl_texture_face_bytes(tex, level);
}

ibl_status ibl_ktx_encode(ibl_ctx *ctx, const ibl_texture *tex,
                          ibl_pieces *file)
{
    const size_t key_bytes = ibl_keys_write(tex, rows_down, NULL);
    const size_t begin = sizeof(header) + key_bytes;

    if (image_size(tex, 0) > UINT32_MAX)
        return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                        "KTX 1.1: a %s of %dx%d %s texels is over its limit of "
                        "4 GiB; use ktx2",
                        tex->layers > 1 ? "level of an array" : "face",
                        tex->width, tex->height, ibl_pixel_name(tex->pixel));
    if (key_bytes > UINT32_MAX ||
        !ibl_pieces_alloc(file, begin + 4 * (size_t)tex->levels,
                          1 + 2 * tex->levels))
        return ibl_no_memory(ctx, "a KTX file");
    const header h = header_of(tex, key_bytes);
    memcpy(file->head, &h, sizeof h);
    ibl_keys_write(tex, rows_down, file->head + sizeof h);
    ibl_pieces_add(file, file->head, begin);
    /* imageSize comes before each level. Blocks of 4, 8 or 16 bytes need no
     * padding of rows, faces or levels. */
    for (int l = 0; l < tex->levels; l++) {
        const uint32_t size = (uint32_t)image_size(tex, l);
        unsigned char *to = file->head + begin + sizeof size * (size_t)l;
        memcpy(to, &size, sizeof size);
        ibl_pieces_add(file, to, sizeof size);
        ibl_pieces_add(file, tex->data + ibl_texture_offset(tex, l, 0),
                       ibl_texture_level_bytes(tex, l));
    }
    return IBL_OK;
}

static ibl_status find_layout(const ibl_input *in, const header *h,
                              const ibl_layout **layout)
{
    const uint32_t type = h->gl_type, format = h->gl_format;
    const uint32_t internal = h->gl_internal_format;

    if (!type || !format) {
        *layout = ibl_layout_find(offsetof(ibl_layout, gl_internal), internal);
        if (*layout && !type && !format && !(*layout)->gl_type)
            return IBL_OK;
        return ibl_unsupported(in,
                               "compressed texels (glInternalFormat 0x%X): "
                               "only float formats, BC6H (0x8E8F, 0x8E8E) and "
                               "ASTC 4x4 (0x93B0) are read",
                               internal);
    }
    for (int i = 0; i < IBL_LAYOUT_COUNT; i++) {
        const ibl_layout *l = &ibl_layouts[i];
        /* An unsized internal format equals the format. Filament's cmgen stores
         * the internal format as the type. */
        if ((l->gl_type == type && l->gl_format == format &&
             (l->gl_internal == internal || format == internal)) ||
            (l->gl_internal == internal && type == internal)) {
            *layout = l;
            return IBL_OK;
        }
    }
    return ibl_unsupported(
        in,
        "glType 0x%X, glFormat 0x%X, glInternalFormat 0x%X: only RGBA, RGB and "
        "RG of half or float, RGB9_E5 and R11F_G11F_B10F are read",
        type, format, internal);
}

/* Reads a level at place->at and moves place->at behind it. array: the file
 * declares an array. One of a single element is a cube for some writers, which
 * then state the size of a face. */
static ibl_status read_level(const ibl_input *in, ibl_place *place, bool array,
                             ibl_texture *tex, int level)
{
    const uint64_t face = ibl_place_bytes(place, tex, level);

    if (!ibl_input_has(in, place->at, 4))
        return ibl_input_short(in, "one of its levels");
    const uint32_t bytes = ibl_input_u32(in, place->at);
    place->at += sizeof bytes;
    array &= tex->layers > 1 || bytes != face;
    const ibl_status status = ibl_check_level_bytes(
        in, level, bytes,
        array ? (uint64_t)(tex->layers * tex->faces) * face : face);
    return status ? status : ibl_place_read_level(in, place, tex, level);
}

ibl_status ibl_ktx_decode(const ibl_input *in, ibl_texture *tex)
{
    ibl_place place = {.row_align = ROW_ALIGN};
    header h;

    if (!ibl_input_has(in, 0, sizeof h))
        return ibl_input_short(in, "a KTX header");
    memcpy(&h, in->bytes, sizeof h);
    if (h.endianness == big_endian)
        return ibl_unsupported(in, "big endian: only little-endian KTX files "
                                   "are read");
    if (h.endianness != little_endian)
        return ibl_bad_file(in, "damaged: endianness 0x%08X, must be 0x%08X",
                            h.endianness, little_endian);
    ibl_status status = find_layout(in, &h, &place.layout);
    if (status)
        return status;
    if (h.gl_type_size != (uint32_t)place.layout->word_bytes &&
        h.gl_type_size != 1)
        return ibl_bad_file(in, "damaged: glTypeSize %u, must be %d",
                            h.gl_type_size, place.layout->word_bytes);
    status = ibl_texture_shape(in, &h.shape, &place, tex);
    if (!status)
        status = ibl_check_stored(in, &place, tex);
    if (!status)
        status = ibl_texture_alloc(in, tex);
    if (!status)
        status = ibl_keys_read(in, sizeof h, h.key_bytes, rows_down, rows_up,
                               tex, &place.bottom_up);
    place.at = sizeof h + (uint64_t)h.key_bytes;
    for (int l = 0; !status && tex->data && l < tex->levels; l++)
        status = read_level(in, &place, h.shape.layers > 0, tex, l);
    return status;
}
