/* SPDX-License-Identifier: MIT */
/*
 * DirectDraw Surface with the DX10 header, or with a float format of Direct3D 9
 * in place of a FourCC (D3DFMT_A16B16G16R16F is 113). Source: Microsoft,
 * "Programming Guide for DDS". Order of texels: layers, then faces, then the
 * levels of each face.
 */
#include <stddef.h>
#include <string.h>

#include "io/container.h"

typedef struct header {
    char magic[4];
    uint32_t size, flags, height, width, pitch, depth, levels;
    uint32_t reserved[11];
    uint32_t pf_size, pf_flags, pf_fourcc, pf_bits; /* pixel format */
    uint32_t pf_masks[4];
    uint32_t caps, caps2, caps3, caps4, reserved2;
    /* The DX10 header. misc_2 stays 0, "alpha unknown", since D3DX refuses
     * other values. array counts cubes, not faces. */
    uint32_t dxgi, dimension, misc, array, misc_2;
} header;

enum {
    HEADER_BYTES = 128, /* size without the DX10 header */
    SIZE = 124,
    PF_SIZE = 32,

    HAS_CAPS = 0x1,
    HAS_HEIGHT = 0x2,
    HAS_WIDTH = 0x4,
    HAS_PITCH = 0x8,
    HAS_PIXELFORMAT = 0x1000,
    HAS_LEVELS = 0x20000,
    HAS_LINEAR_SIZE = 0x80000, /* pitch is the size of level 0 */
    HAS_DEPTH = 0x800000,

    PF_HAS_FOURCC = 0x4,
    PF_HAS_RGBA = 0x41,

    CAPS_COMPLEX = 0x8,
    CAPS_TEXTURE = 0x1000,
    CAPS_MIPMAP = 0x400000,
    CAPS2_CUBE = 0x200,
    CAPS2_FACES = 0xFC00, /* all six faces */
    CAPS2_VOLUME = 0x200000,

    DIMENSION_2D = 3,
    MISC_CUBE = 0x4
};

_Static_assert(offsetof(header, dxgi) == HEADER_BYTES && sizeof(header) == 148,
               "as the guide has them");

static const uint32_t fourcc_dx10 = 0x30315844; /* "DX10" */

static header header_of(const ibl_texture *tex, uint32_t fourcc)
{
    const bool cube = tex->faces == IBL_FACES, mips = tex->levels > 1;
    const bool many = cube || mips || tex->layers > 1;
    const bool blocks = ibl_pixel_block(tex->pixel) > 1;
    const size_t pitch = blocks
                             ? ibl_texture_face_bytes(tex, 0)
                             : (size_t)tex->width * ibl_pixel_bytes(tex->pixel);
    return (header){
        .magic = IBL_DDS_MAGIC,
        .size = SIZE,
        .flags = HAS_CAPS | HAS_HEIGHT | HAS_WIDTH | HAS_PIXELFORMAT |
                 (blocks ? HAS_LINEAR_SIZE : HAS_PITCH) |
                 (mips ? HAS_LEVELS : 0),
        .height = (uint32_t)tex->height,
        .width = (uint32_t)tex->width,
        .pitch = (uint32_t)pitch,
        .levels = (uint32_t)tex->levels,
        .pf_size = PF_SIZE,
        .pf_flags = PF_HAS_FOURCC,
        .pf_fourcc = fourcc,
        .caps =
            CAPS_TEXTURE | (many ? CAPS_COMPLEX : 0) | (mips ? CAPS_MIPMAP : 0),
        .caps2 = cube ? CAPS2_CUBE | CAPS2_FACES : 0,
        .dxgi = ibl_layouts[tex->pixel].dxgi,
        .dimension = DIMENSION_2D,
        .misc = cube ? MISC_CUBE : 0,
        .array = (uint32_t)tex->layers,
    };
}

/* Writes the first head_bytes of a header and the texels. */
static ibl_status encode(ibl_ctx *ctx, const ibl_texture *tex, uint32_t fourcc,
                         size_t head_bytes, ibl_pieces *file)
{
    const int images = tex->layers * tex->faces;
    const header h = header_of(tex, fourcc);
    if (!ibl_pieces_alloc(file, head_bytes, 1 + images * tex->levels))
        return ibl_no_memory(ctx, "a DDS file");
    memcpy(file->head, &h, head_bytes);
    ibl_pieces_add(file, file->head, head_bytes);
    for (int i = 0; i < images; i++)
        for (int l = 0; l < tex->levels; l++)
            ibl_pieces_add(file,
                           tex->data + ibl_texture_layer_offset(tex, l,
                                                                i / tex->faces,
                                                                i % tex->faces),
                           ibl_texture_face_bytes(tex, l));
    return IBL_OK;
}

ibl_status ibl_dds_encode(ibl_ctx *ctx, const ibl_texture *tex,
                          ibl_pieces *file)
{
    return encode(ctx, tex, fourcc_dx10, sizeof(header), file);
}

ibl_status ibl_dds_legacy_encode(ibl_ctx *ctx, const ibl_texture *tex,
                                 ibl_pieces *file)
{
    if (tex->layers > 1)
        return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                        "dds-legacy files hold no array of %d layers: dds "
                        "files do",
                        tex->layers);
    return encode(ctx, tex, ibl_layouts[tex->pixel].d3d, HEADER_BYTES, file);
}

size_t ibl_dds_picture(const unsigned char *bytes, size_t size,
                       unsigned char *dst)
{
    static const uint32_t rgba[] = {0xff, 0xff00, 0xff0000, 0xff000000};
    static const uint32_t bgra[] = {0xff0000, 0xff00, 0xff, 0xff000000};
    header h = {.dxgi = 0};
    size_t head = sizeof h;

    memcpy(dst, bytes, size);
    if (size < sizeof h || ibl_dds_is_legacy(bytes, size))
        return size;
    memcpy(&h, bytes, sizeof h);
    if (h.misc & MISC_CUBE)
        h.caps2 |= CAPS2_CUBE | CAPS2_FACES;
    const bool is_rgba = h.dxgi == 28 || h.dxgi == 29;
    if (is_rgba || h.dxgi == 87 || h.dxgi == 91) {
        h.pf_flags = PF_HAS_RGBA;
        h.pf_fourcc = 0;
        h.pf_bits = 32;
        memcpy(h.pf_masks, is_rgba ? rgba : bgra, sizeof rgba);
        head = HEADER_BYTES;
    }
    memcpy(dst, &h, head);
    memcpy(dst + head, bytes + sizeof h, size - sizeof h);
    return size - sizeof h + head;
}

bool ibl_dds_is_legacy(const unsigned char *bytes, size_t size)
{
    const size_t at = offsetof(header, pf_fourcc);

    return size >= at + sizeof fourcc_dx10 &&
           memcmp(bytes + at, &fourcc_dx10, sizeof fourcc_dx10) != 0;
}

static ibl_status read_dx10(const ibl_input *in, const header *h,
                            const ibl_layout **layout, ibl_extent *shape)
{
    if (!ibl_input_has(in, 0, sizeof *h))
        return ibl_input_short(in, "a DX10 header");
    *layout = ibl_layout_find(offsetof(ibl_layout, dxgi), h->dxgi);
    if (!*layout)
        return ibl_unsupported(
            in,
            "DXGI format %u: only 10, 2, 67, 26, 95, 96, 34, 16 and 6 are read "
            "(RGBA, RG, RGB floats, RGB9E5, R11G11B10, BC6H)",
            h->dxgi);
    if (h->dimension != DIMENSION_2D) {
        const char *name = h->dimension == 2   ? " (1D)"
                           : h->dimension == 4 ? " (3D)"
                                               : "";
        return ibl_reject(in, *name ? IBL_ERR_UNSUPPORTED : IBL_ERR_FORMAT,
                          "resource dimension %u%s: must be 3 (2D)",
                          h->dimension, name);
    }
    if (!h->array)
        return ibl_bad_file(in, "damaged: an array of no textures");
    shape->layers = h->array;
    if (h->misc & MISC_CUBE)
        shape->faces = IBL_FACES;
    return IBL_OK;
}

/* Some writers mark a cube in the old header only, or count its faces as the
 * elements of an array: it is one if the file has so many texels. */
static void settle_faces(const ibl_input *in, const header *h,
                         const ibl_place *place, ibl_texture *tex)
{
    const uint64_t images =
        (in->size - place->at) / ibl_place_all_bytes(place, tex, 1);

    if (tex->faces != IBL_FACES && !(h->caps2 & CAPS2_CUBE))
        return;
    if (tex->layers == IBL_FACES && images >= IBL_FACES &&
        images < IBL_FACES * IBL_FACES) {
        tex->layers = 1;
        tex->faces = IBL_FACES;
    } else if (tex->width == tex->height &&
               images >= IBL_FACES * (uint64_t)tex->layers) {
        tex->faces = IBL_FACES;
    }
}

static ibl_status read_direct3d9(const ibl_input *in, const header *h,
                                 const ibl_layout **layout, ibl_extent *shape)
{
    *layout = ibl_layout_find(offsetof(ibl_layout, d3d), h->pf_fourcc);
    if (!*layout) {
        char text[5] = {0}, quoted[IBL_QUOTE_BYTES];
        memcpy(text, &h->pf_fourcc, 4);
        return ibl_unsupported(in,
                               "FourCC 0x%X (%s): only DX10 and the formats "
                               "112, 113, 115 and 116 of Direct3D 9 are read",
                               h->pf_fourcc, ibl_quote(text, quoted));
    }
    if (!(h->caps2 & CAPS2_CUBE))
        return IBL_OK;
    shape->faces = IBL_FACES;
    if ((h->caps2 & CAPS2_FACES) == CAPS2_FACES)
        return IBL_OK;
    return ibl_unsupported(in, "a cube of some faces only (0x%X)",
                           h->caps2 & CAPS2_FACES);
}

ibl_status ibl_dds_decode(const ibl_input *in, ibl_texture *tex)
{
    ibl_place place = {.row_align = 1, .at = HEADER_BYTES};
    header h = {.dxgi = 0};

    if (!ibl_input_has(in, 0, HEADER_BYTES))
        return ibl_input_short(in, "a DDS header");
    memcpy(&h, in->bytes,
           ibl_input_has(in, 0, sizeof h) ? sizeof h : HEADER_BYTES);
    if (h.size != SIZE || h.pf_size != PF_SIZE)
        return ibl_bad_file(
            in, "damaged: headers of %u and %u bytes, must be %d and %d",
            h.size, h.pf_size, SIZE, PF_SIZE);
    if (!(h.pf_flags & PF_HAS_FOURCC))
        return ibl_unsupported(
            in, "texels of %u integer bits: only float formats are read",
            h.pf_bits);
    ibl_extent shape = {
        .width = h.width, .height = h.height, .faces = 1, .levels = h.levels};
    /* Do not trust an old writer's flag, or its depth without the flag. */
    if (h.caps2 & CAPS2_VOLUME || (h.flags & HAS_DEPTH && h.depth > 1))
        shape.depth = h.depth | 1;
    ibl_status status;
    if (h.pf_fourcc == fourcc_dx10) {
        place.at = sizeof h;
        status = read_dx10(in, &h, &place.layout, &shape);
    } else {
        status = read_direct3d9(in, &h, &place.layout, &shape);
    }
    if (!status)
        status = ibl_texture_shape(in, &shape, &place, tex);
    if (status)
        return status;
    if (h.pf_fourcc == fourcc_dx10)
        settle_faces(in, &h, &place, tex);
    status = ibl_check_stored(in, &place, tex);
    if (!status)
        status = ibl_texture_alloc(in, tex);
    for (int i = 0; i < tex->layers * tex->faces; i++)
        for (int l = 0; !status && tex->data && l < tex->levels; l++)
            status = ibl_place_read(in, &place, tex, l, i);
    return status;
}
