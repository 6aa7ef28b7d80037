/* SPDX-License-Identifier: MIT */
/*
 * DirectDraw Surface with the DX10 header; files that name a float format of
 * Direct3D 9 in place of a FourCC are read too. Source: Microsoft,
 * "Programming Guide for DDS". Layer after layer, in a layer face after face,
 * and each face is followed by its own levels.
 */
#include <string.h>

#include "io/container.h"

enum {
    MAGIC = 0,
    SIZE = 4,
    FLAGS = 8,
    HEIGHT = 12,
    WIDTH = 16,
    PITCH = 20,
    DEPTH = 24,
    LEVELS = 28,
    PF_SIZE = 76, /* pixel format */
    PF_FLAGS = 80,
    PF_FOURCC = 84,
    PF_BITS = 88,
    CAPS = 108,
    CAPS2 = 112,
    HEADER = 128,
    DXGI = 128, /* the DX10 header */
    DIMENSION = 132,
    MISC = 136,
    ARRAY = 140,
    HEADER_DX10 = 148,

    HEADER_SIZE = 124,
    PF_HEADER_SIZE = 32,

    HAS_CAPS = 0x1,
    HAS_HEIGHT = 0x2,
    HAS_WIDTH = 0x4,
    HAS_PITCH = 0x8,
    HAS_PIXELFORMAT = 0x1000,
    HAS_LEVELS = 0x20000,
    HAS_DEPTH = 0x800000,

    PF_HAS_FOURCC = 0x4,

    CAPS_COMPLEX = 0x8,
    CAPS_TEXTURE = 0x1000,
    CAPS_MIPMAP = 0x400000,
    CAPS2_CUBE = 0x200,
    CAPS2_FACES = 0xFC00, /* all six */
    CAPS2_VOLUME = 0x200000,

    DIMENSION_2D = 3,
    MISC_CUBE = 0x4
};

static const uint32_t magic = 0x20534444;       /* "DDS " */
static const uint32_t fourcc_dx10 = 0x30315844; /* "DX10" */

bool ibl_is_dds(const unsigned char *bytes, size_t size)
{
    return size >= sizeof magic && !memcmp(bytes, &magic, sizeof magic);
}

static void write_header(const ibl_texture *tex, unsigned char *dst)
{
    const bool cube = tex->faces == IBL_FACES, mips = tex->levels > 1;
    const bool many = cube || mips || tex->layers > 1;
    memset(dst, 0, HEADER_DX10);
    ibl_put_u32(dst + MAGIC, magic);
    ibl_put_u32(dst + SIZE, HEADER_SIZE);
    ibl_put_u32(dst + FLAGS, HAS_CAPS | HAS_HEIGHT | HAS_WIDTH | HAS_PITCH |
                                 HAS_PIXELFORMAT | (mips ? HAS_LEVELS : 0));
    ibl_put_u32(dst + HEIGHT, (uint32_t)tex->height);
    ibl_put_u32(dst + WIDTH, (uint32_t)tex->width);
    ibl_put_u32(dst + PITCH,
                (uint32_t)tex->width * (uint32_t)ibl_pixel_bytes(tex->pixel));
    ibl_put_u32(dst + LEVELS, (uint32_t)tex->levels);
    ibl_put_u32(dst + PF_SIZE, PF_HEADER_SIZE);
    ibl_put_u32(dst + PF_FLAGS, PF_HAS_FOURCC);
    ibl_put_u32(dst + PF_FOURCC, fourcc_dx10);
    ibl_put_u32(dst + CAPS, CAPS_TEXTURE | (many ? CAPS_COMPLEX : 0) |
                                (mips ? CAPS_MIPMAP : 0));
    ibl_put_u32(dst + CAPS2, cube ? CAPS2_CUBE | CAPS2_FACES : 0);
    ibl_put_u32(dst + DXGI, ibl_layouts[tex->pixel].dxgi);
    ibl_put_u32(dst + DIMENSION, DIMENSION_2D);
    ibl_put_u32(dst + MISC, cube ? MISC_CUBE : 0);
    ibl_put_u32(dst + ARRAY, (uint32_t)tex->layers); /* cubes, not faces */
    /* miscFlags2 stays 0, "alpha unknown": D3DX refuses any other. */
}

ibl_status ibl_dds_encode(ibl_ctx *ctx, const ibl_texture *tex,
                          ibl_pieces *file)
{
    const int images = tex->layers * tex->faces;
    if (!ibl_pieces_alloc(file, HEADER_DX10, 1 + images * tex->levels))
        return ibl_no_memory(ctx, "a DDS file");
    write_header(tex, file->head);
    ibl_pieces_add(file, file->head, HEADER_DX10);
    for (int i = 0; i < images; i++)
        for (int l = 0; l < tex->levels; l++)
            ibl_pieces_add(file,
                           tex->data + ibl_texture_layer_offset(tex, l,
                                                                i / tex->faces,
                                                                i % tex->faces),
                           ibl_texture_face_bytes(tex, l));
    return IBL_OK;
}

static const ibl_layout *find_dxgi(uint32_t dxgi)
{
    for (int i = 0; dxgi && i < IBL_LAYOUT_COUNT; i++) {
        if (ibl_layouts[i].dxgi == dxgi)
            return &ibl_layouts[i];
    }
    return NULL;
}

static const ibl_layout *find_d3d(uint32_t d3d)
{
    for (int i = 0; d3d && i < IBL_LAYOUT_COUNT; i++) {
        if (ibl_layouts[i].d3d == d3d)
            return &ibl_layouts[i];
    }
    return NULL;
}

static ibl_status read_dx10(const ibl_file *file, const ibl_layout **layout,
                            ibl_shape *shape)
{
    if (!ibl_file_has(file, 0, HEADER_DX10))
        return ibl_file_short(file, "a DX10 header");
    const uint32_t dxgi = ibl_file_u32(file, DXGI);
    const uint32_t dimension = ibl_file_u32(file, DIMENSION);
    const uint32_t array = ibl_file_u32(file, ARRAY);

    *layout = find_dxgi(dxgi);
    if (!*layout)
        return ibl_fail(file->ctx, IBL_ERR_UNSUPPORTED,
                        "%s: DXGI format %u: only 10, 2, 67, 26, 34, 16 and 6 "
                        "are read (RGBA, RG, RGB floats, RGB9E5, R11G11B10)",
                        file->name, dxgi);
    if (dimension != DIMENSION_2D)
        return ibl_fail(file->ctx,
                        dimension == 2 || dimension == 4 ? IBL_ERR_UNSUPPORTED
                                                         : IBL_ERR_FORMAT,
                        "%s: resource dimension %u%s: must be 3 (2D)",
                        file->name, dimension,
                        dimension == 2   ? " (1D)"
                        : dimension == 4 ? " (3D)"
                                         : "");
    shape->layers = array;
    if (!array)
        return ibl_fail(file->ctx, IBL_ERR_FORMAT,
                        "%s: damaged: an array of no textures", file->name);
    if (ibl_file_u32(file, MISC) & MISC_CUBE)
        shape->faces = IBL_FACES;
    return IBL_OK;
}

static ibl_status read_direct3d9(const ibl_file *file,
                                 const ibl_layout **layout, ibl_shape *shape)
{
    const uint32_t caps2 = ibl_file_u32(file, CAPS2);
    const uint32_t fourcc = ibl_file_u32(file, PF_FOURCC);

    *layout = find_d3d(fourcc);
    if (!*layout) {
        char text[5] = {0};
        memcpy(text, file->bytes + PF_FOURCC, 4);
        for (int i = 0; i < 4; i++)
            text[i] = text[i] >= ' ' && text[i] < 127 ? text[i] : '.';
        return ibl_fail(file->ctx, IBL_ERR_UNSUPPORTED,
                        "%s: FourCC 0x%X (%s): only DX10 and the formats 112, "
                        "113, 115 and 116 of Direct3D 9 are read",
                        file->name, fourcc, text);
    }
    if (caps2 & CAPS2_CUBE) {
        if ((caps2 & CAPS2_FACES) != CAPS2_FACES)
            return ibl_fail(file->ctx, IBL_ERR_UNSUPPORTED,
                            "%s: a cube of some faces only (0x%X)", file->name,
                            caps2 & CAPS2_FACES);
        shape->faces = IBL_FACES;
    }
    return IBL_OK;
}

static ibl_status check_header(const ibl_file *file)
{
    const uint32_t size = ibl_file_u32(file, SIZE);
    const uint32_t pf_size = ibl_file_u32(file, PF_SIZE);
    if (size != HEADER_SIZE || pf_size != PF_HEADER_SIZE)
        return ibl_fail(file->ctx, IBL_ERR_FORMAT,
                        "%s: damaged: headers of %u and %u bytes, must be %d "
                        "and %d",
                        file->name, size, pf_size, HEADER_SIZE, PF_HEADER_SIZE);
    if (!(ibl_file_u32(file, PF_FLAGS) & PF_HAS_FOURCC))
        return ibl_fail(file->ctx, IBL_ERR_UNSUPPORTED,
                        "%s: texels of %u integer bits: only float formats "
                        "are read",
                        file->name, ibl_file_u32(file, PF_BITS));
    return IBL_OK;
}

ibl_status ibl_dds_decode(const ibl_file *file, ibl_texture *tex)
{
    ibl_place place = {.row_align = 1, .at = HEADER};
    ibl_status status;

    if (!ibl_file_has(file, 0, HEADER))
        return ibl_file_short(file, "a DDS header");
    status = check_header(file);
    if (status)
        return status;
    ibl_shape shape = {.width = ibl_file_u32(file, WIDTH),
                       .height = ibl_file_u32(file, HEIGHT),
                       .faces = 1,
                       .levels = ibl_file_u32(file, LEVELS)};
    /* The flags of old writers are not to be relied upon, the depth without
     * its flag neither. */
    if (ibl_file_u32(file, CAPS2) & CAPS2_VOLUME ||
        (ibl_file_u32(file, FLAGS) & HAS_DEPTH &&
         ibl_file_u32(file, DEPTH) > 1))
        shape.depth = ibl_file_u32(file, DEPTH) | 1;
    if (ibl_file_u32(file, PF_FOURCC) == fourcc_dx10) {
        place.at = HEADER_DX10;
        status = read_dx10(file, &place.layout, &shape);
    } else {
        status = read_direct3d9(file, &place.layout, &shape);
    }
    if (!status)
        status = ibl_texture_begin(file, &shape, place.layout, 1, tex);
    if (status)
        return status;
    for (int i = 0; i < tex->layers * tex->faces; i++) {
        for (int l = 0; !status && l < tex->levels; l++) {
            status = ibl_place_read(file, &place, tex, l, i / tex->faces,
                                    i % tex->faces);
            place.at += ibl_place_bytes(&place, tex, l);
        }
    }
    return status;
}
