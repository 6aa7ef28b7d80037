/* SPDX-License-Identifier: MIT */
/*
 * Khronos KTX 1.1. Source: KTX File Format Specification, version 1.1. A
 * cube's imageSize is that of one face, any other's and a cube array's that
 * of the level; rows are padded to 4 bytes.
 */
#include <string.h>

#include "core/alloc.h"
#include "io/container.h"

static const unsigned char identifier[12] = {
    0xAB, 'K', 'T', 'X', ' ', '1', '1', 0xBB, '\r', '\n', 0x1A, '\n'};

enum {
    ENDIANNESS = 12,
    GL_TYPE = 16,
    GL_TYPE_SIZE = 20,
    GL_FORMAT = 24,
    GL_INTERNAL_FORMAT = 28,
    GL_BASE_INTERNAL_FORMAT = 32,
    WIDTH = 36,
    HEIGHT = 40,
    DEPTH = 44,
    ELEMENTS = 48, /* of an array */
    FACES = 52,
    LEVELS = 56,
    KEY_BYTES = 60,
    HEADER = 64,
    ROW_ALIGN = 4
};

static const uint32_t little = 0x04030201, big = 0x01020304;
static const char rows_down[] = "S=r,T=d", rows_up[] = "S=r,T=u";

bool ibl_is_ktx(const unsigned char *bytes, size_t size)
{
    return size >= sizeof identifier &&
           !memcmp(bytes, identifier, sizeof identifier);
}

static void write_header(const ibl_texture *tex, size_t key_bytes,
                         unsigned char *dst)
{
    const ibl_layout *layout = &ibl_layouts[tex->pixel];
    memset(dst, 0, HEADER);
    memcpy(dst, identifier, sizeof identifier);
    ibl_put_u32(dst + ENDIANNESS, little);
    ibl_put_u32(dst + GL_TYPE, layout->gl_type);
    ibl_put_u32(dst + GL_TYPE_SIZE, (uint32_t)layout->word_bytes);
    ibl_put_u32(dst + GL_FORMAT, layout->gl_format);
    ibl_put_u32(dst + GL_INTERNAL_FORMAT, layout->gl_internal);
    ibl_put_u32(dst + GL_BASE_INTERNAL_FORMAT, layout->gl_format);
    ibl_put_u32(dst + WIDTH, (uint32_t)tex->width);
    ibl_put_u32(dst + HEIGHT, (uint32_t)tex->height);
    /* 0: no array. */
    ibl_put_u32(dst + ELEMENTS, tex->layers > 1 ? (uint32_t)tex->layers : 0);
    ibl_put_u32(dst + FACES, (uint32_t)tex->faces);
    ibl_put_u32(dst + LEVELS, (uint32_t)tex->levels);
    ibl_put_u32(dst + KEY_BYTES, (uint32_t)key_bytes);
}

/* What is written before a level. */
static size_t image_size(const ibl_texture *tex, int level)
{
    return tex->layers > 1 ? ibl_texture_level_bytes(tex, level)
                           : ibl_texture_face_bytes(tex, level);
}

ibl_status ibl_ktx_encode(ibl_ctx *ctx, const ibl_texture *tex,
                          ibl_pieces *file)
{
    int count;
    if (image_size(tex, 0) > UINT32_MAX)
        return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                        "KTX 1.1: a %s of %dx%d %s texels is over its limit "
                        "of 4 GiB; use ktx2",
                        tex->layers > 1 ? "level of an array" : "face",
                        tex->width, tex->height, ibl_pixel_name(tex->pixel));
    ibl_key_value *keys = ibl_keys_list(tex, rows_down, &count);
    if (!keys)
        return ibl_no_memory(ctx, "a KTX file");
    const size_t key_bytes = ibl_keys_bytes(keys, count);
    const size_t begin = HEADER + key_bytes;
    if (key_bytes > UINT32_MAX ||
        !ibl_pieces_alloc(file, begin + 4 * (size_t)tex->levels,
                          1 + 2 * tex->levels)) {
        ibl_free(keys);
        return ibl_no_memory(ctx, "a KTX file");
    }
    write_header(tex, key_bytes, file->head);
    ibl_keys_write(keys, count, file->head + HEADER);
    ibl_pieces_add(file, file->head, begin);
    /* A size before each level. Texels of 4, 8 or 16 bytes leave nothing to
     * pad, neither rows nor faces nor levels. */
    for (int l = 0; l < tex->levels; l++) {
        unsigned char *size = file->head + begin + 4 * l;
        ibl_put_u32(size, (uint32_t)image_size(tex, l));
        ibl_pieces_add(file, size, 4);
        ibl_pieces_add_level(file, tex, l);
    }
    ibl_free(keys);
    return IBL_OK;
}

static ibl_status find_layout(const ibl_file *file, const ibl_layout **layout)
{
    const uint32_t type = ibl_file_u32(file, GL_TYPE);
    const uint32_t format = ibl_file_u32(file, GL_FORMAT);
    const uint32_t internal = ibl_file_u32(file, GL_INTERNAL_FORMAT);

    if (!type || !format)
        return ibl_fail(file->ctx, IBL_ERR_UNSUPPORTED,
                        "%s: compressed texels (glInternalFormat 0x%X): only "
                        "float formats are read",
                        file->name, internal);
    for (int i = 0; i < IBL_LAYOUT_COUNT; i++) {
        const ibl_layout *l = &ibl_layouts[i];
        /* Unsized internal formats are the format's own number. Filament's
         * cmgen has the internal format for a type. */
        if ((l->gl_type == type && l->gl_format == format &&
             (l->gl_internal == internal || format == internal)) ||
            (l->gl_internal == internal && type == internal)) {
            *layout = l;
            return IBL_OK;
        }
    }
    return ibl_fail(file->ctx, IBL_ERR_UNSUPPORTED,
                    "%s: glType 0x%X, glFormat 0x%X, glInternalFormat 0x%X: "
                    "only RGBA, RGB and RG of half or float, RGB9_E5 and "
                    "R11F_G11F_B10F are read",
                    file->name, type, format, internal);
}

static ibl_status check_order(ibl_file *file)
{
    const uint32_t order = ibl_file_u32(file, ENDIANNESS);
    file->swap = order == big;
    if (order != little && order != big)
        return ibl_fail(file->ctx, IBL_ERR_FORMAT,
                        "%s: damaged: endianness 0x%08X, must be 0x%08X or "
                        "0x%08X",
                        file->name, order, little, big);
    return IBL_OK;
}

/* Reads a level at place->at and moves that behind it. array: the file says
 * that it is one, be it of one element. */
static ibl_status read_level(const ibl_file *file, ibl_place *place, bool array,
                             ibl_texture *tex, int level)
{
    const uint64_t images =
        array ? (uint64_t)tex->layers * (uint64_t)tex->faces : 1;
    const uint64_t must = images * ibl_place_bytes(place, tex, level);
    if (!ibl_file_has(file, place->at, 4))
        return ibl_file_short(file, "one of its levels");
    const uint64_t bytes = ibl_file_u32(file, place->at);
    if (bytes != must)
        return ibl_fail(file->ctx, IBL_ERR_FORMAT,
                        "%s: damaged: level %d of %llu bytes, must be %llu",
                        file->name, level, (unsigned long long)bytes,
                        (unsigned long long)must);
    place->at += 4;
    return ibl_place_read_level(file, place, tex, level);
}

ibl_status ibl_ktx_decode(ibl_file *file, ibl_texture *tex)
{
    ibl_place place = {.row_align = ROW_ALIGN};
    ibl_status status;

    if (!ibl_file_has(file, 0, HEADER))
        return ibl_file_short(file, "a KTX header");
    status = check_order(file);
    if (!status)
        status = find_layout(file, &place.layout);
    if (status)
        return status;
    /* And 1 for its size, which matters to no file that is not turned. */
    const uint32_t type_size = ibl_file_u32(file, GL_TYPE_SIZE);
    if (type_size != (uint32_t)place.layout->word_bytes &&
        (type_size != 1 || file->swap))
        return ibl_fail(file->ctx, IBL_ERR_FORMAT,
                        "%s: damaged: glTypeSize %u, must be %d", file->name,
                        type_size, place.layout->word_bytes);
    const ibl_shape shape = {
        ibl_file_u32(file, WIDTH), ibl_file_u32(file, HEIGHT),
        ibl_file_u32(file, DEPTH), ibl_file_u32(file, ELEMENTS),
        ibl_file_u32(file, FACES), ibl_file_u32(file, LEVELS)};
    status = ibl_texture_begin(file, &shape, place.layout, ROW_ALIGN, tex);
    if (status)
        return status;
    const uint64_t key_bytes = ibl_file_u32(file, KEY_BYTES);
    status = ibl_keys_read(file, HEADER, key_bytes, rows_down, rows_up, tex,
                           &place.bottom_up);
    place.at = HEADER + key_bytes;
    for (int l = 0; !status && l < tex->levels; l++)
        status = read_level(file, &place, shape.layers > 0, tex, l);
    return status;
}
