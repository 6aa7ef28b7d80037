/* SPDX-License-Identifier: MIT */
/*
 * Khronos KTX 2.0, without supercompression or with Zstandard. Sources: KTX
 * File Format Specification 2.0, Khronos Data Format Specification 1.3 (the
 * descriptor: sections 5.1 to 5.10; shared exponents: 10.2, "E5B9G9R9").
 * Descriptors are the same with and without Zstandard (KTX-Specification#217).
 */
#include <stddef.h>
#include <string.h>

#include "core/alloc.h"
#include "io/container.h"

typedef struct header {
    char identifier[12];
    uint32_t vk_format, type_size;
    ibl_extent shape;
    uint32_t scheme; /* supercompressionScheme */
    /* Offsets and sizes in bytes: the data format descriptor, the keys, and the
     * global data of supercompression. */
    uint32_t dfd, dfd_bytes, kvd, kvd_bytes;
    uint64_t sgd, sgd_bytes;
} header;

/* An entry of the level index, which follows the header. */
typedef struct index_entry {
    uint64_t at, bytes, bytes_uncompressed;
} index_entry;

_Static_assert(sizeof(header) == 80 && sizeof(index_entry) == 24,
               "as the specification has them");

static const char rows_down[] = "rd", rows_up[] = "ru";

enum {
    SCHEME_NONE,
    SCHEME_ZSTD = 2
};

/* ---- the data format descriptor -------------------------------------- */

enum {
    VERSION = 2, /* of the data format specification: 1.3 */
    PRIMARIES_BT709 = 1,
    TRANSFER_LINEAR = 1,
    ALPHA_PREMULTIPLIED = 1
};

typedef struct descriptor {
    uint32_t bytes; /* size of the descriptor */
    uint32_t vendor, version_and_block_bytes;
    uint8_t model, primaries, transfer, flags;
    uint8_t edge_less_one[4]; /* of a block: width, height, ... */
    uint32_t plane_bytes[2];
    ibl_sample samples[IBL_MAX_SAMPLES];
} descriptor;

_Static_assert(offsetof(descriptor, samples) == 28 && sizeof(ibl_sample) == 16,
               "as the specification has them");

static descriptor descriptor_of(const ibl_texture *tex)
{
    const uint8_t edge = (uint8_t)(ibl_pixel_block(tex->pixel) - 1);
    descriptor d = {.model = (uint8_t)ibl_pixel_model(tex->pixel),
                    .primaries =
                        (uint8_t)(tex->primaries < 0    ? 0
                                  : tex->primaries == 0 ? PRIMARIES_BT709
                                                        : tex->primaries),
                    .transfer = TRANSFER_LINEAR,
                    .flags = tex->premultiplied ? ALPHA_PREMULTIPLIED : 0,
                    .edge_less_one = {edge, edge},
                    .plane_bytes = {(uint32_t)ibl_pixel_bytes(tex->pixel)}};
    const int samples = ibl_pixel_samples(tex->pixel, d.samples);

    d.bytes = (uint32_t)(offsetof(descriptor, samples) +
                         (size_t)samples * sizeof *d.samples);
    d.version_and_block_bytes = VERSION | (d.bytes - (uint32_t)sizeof d.bytes)
                                              << 16;
    return d;
}

/* ---- writing -------------------------------------------------------- */

ibl_status ibl_ktx2_encode(ibl_ctx *ctx, const ibl_texture *tex,
                           ibl_pieces *file)
{
    const descriptor d = descriptor_of(tex);
    const size_t index = sizeof(header);
    const size_t dfd = index + (size_t)tex->levels * sizeof(index_entry);
    const size_t kvd = dfd + d.bytes;
    const size_t kvd_bytes = ibl_keys_write(tex, rows_down, NULL);
    /* lcm(4, block size) of 4, 8 or 16 bytes; frames begin anywhere. */
    const size_t align = tex->zstd ? 1 : ibl_pixel_bytes(tex->pixel);
    ibl_piece frames[IBL_MAX_TEXTURE_LEVELS];
    const size_t head_bytes = (kvd + kvd_bytes + align - 1) / align * align;

    if (head_bytes > UINT32_MAX)
        return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                        "KTX2: %zu bytes of keys: the limit is 4 GiB",
                        kvd_bytes);
    if (!ibl_pieces_alloc(file, head_bytes, 1 + tex->levels))
        return ibl_no_memory(ctx, "a KTX2 file");
    if (tex->zstd) {
        const ibl_status status =
            ibl_zstd_pack(ctx, tex, &file->packed, frames);
        if (status)
            return status;
    }
    const header h = {.identifier = IBL_KTX2_MAGIC,
                      .vk_format = ibl_layouts[tex->pixel].vk,
                      .type_size = (uint32_t)ibl_layouts[tex->pixel].word_bytes,
                      .shape = ibl_extent_of(tex),
                      .scheme = tex->zstd ? SCHEME_ZSTD : SCHEME_NONE,
                      .dfd = (uint32_t)dfd,
                      .dfd_bytes = d.bytes,
                      .kvd = (uint32_t)kvd,
                      .kvd_bytes = (uint32_t)kvd_bytes};
    memcpy(file->head, &h, sizeof h);
    memcpy(file->head + dfd, &d, d.bytes);
    ibl_keys_write(tex, rows_down, file->head + kvd);
    ibl_pieces_add(file, file->head, head_bytes);
    /* Smallest level first. Sizes are multiples of the alignment: no gaps. */
    for (int l = tex->levels - 1; l >= 0; l--) {
        const uint64_t bytes = ibl_texture_level_bytes(tex, l);
        const ibl_piece level =
            tex->zstd
                ? frames[l]
                : (ibl_piece){tex->data + ibl_texture_offset(tex, l, 0), bytes};
        const index_entry entry = {file->size, level.size, bytes};
        memcpy(file->head + index + sizeof entry * (size_t)l, &entry,
               sizeof entry);
        ibl_pieces_add(file, level.bytes, level.size);
    }
    return IBL_OK;
}

/* ---- reading -------------------------------------------------------- */

/* Checks what does not depend on the shape, and finds the layout. */
static ibl_status find_layout(const ibl_input *in, const header *h,
                              const ibl_layout **layout)
{
    static const char *const schemes[] = {"none", "BasisLZ", "Zstandard",
                                          "ZLIB"};

    if (h->scheme != SCHEME_NONE && h->scheme != SCHEME_ZSTD)
        return ibl_unsupported(
            in, "supercompression %u (%s): only none and Zstandard are read",
            h->scheme, h->scheme < 4 ? schemes[h->scheme] : "unknown");
    const ibl_layout *l =
        ibl_layout_find(offsetof(ibl_layout, vk), h->vk_format);
    if (!l)
        return ibl_unsupported(
            in,
            "VkFormat %u: only 97, 109, 123, 122, 143, 144, 1000066000, 83, "
            "103, 90 and 106 are read (RGBA, RG, RGB floats, RGB9E5, "
            "R11G11B10, BC6H, ASTC 4x4 HDR)",
            h->vk_format);
    if (h->type_size != (uint32_t)l->word_bytes)
        return ibl_bad_file(in,
                            "damaged: typeSize %u, must be %d for VkFormat %u",
                            h->type_size, l->word_bytes, l->vk);
    if (h->sgd_bytes)
        return ibl_bad_file(
            in, "damaged: global data of a supercompression that has none");
    if (!ibl_input_has(in, h->dfd, h->dfd_bytes))
        return ibl_input_short(in, "its data format descriptor");
    if (h->dfd_bytes && (h->dfd_bytes < offsetof(descriptor, samples) ||
                         ibl_input_u32(in, h->dfd) != h->dfd_bytes))
        return ibl_bad_file(
            in,
            "damaged: a data format descriptor of %u bytes that says otherwise",
            h->dfd_bytes);
    /* UASTC HDR and ASTC have the same number in Vulkan. Without a descriptor
     * the number alone counts. */
    const int model =
        h->dfd_bytes ? in->bytes[h->dfd + offsetof(descriptor, model)] : 0;
    *layout = l->pixel == IBL_PIXEL_UASTC_HDR && model != IBL_MODEL_UASTC_HDR
                  ? &ibl_layouts[IBL_PIXEL_ASTC4X4HDR]
                  : l;
    return IBL_OK;
}

static index_entry entry_of(const ibl_input *in, int level)
{
    index_entry entry;
    memcpy(&entry, in->bytes + sizeof(header) + sizeof entry * (size_t)level,
           sizeof entry);
    return entry;
}

/* Checks that all levels are in the file and can hold their texels. */
static ibl_status check_levels(const ibl_input *in, bool packed,
                               const ibl_place *place, const ibl_texture *tex)
{
    if (!ibl_input_has(in, sizeof(header),
                       sizeof(index_entry) * (uint64_t)tex->levels))
        return ibl_input_short(in, "its level index");
    for (int l = 0; l < tex->levels; l++) {
        const uint64_t must = (uint64_t)tex->layers * (uint64_t)tex->faces *
                              ibl_place_bytes(place, tex, l);
        const index_entry e = entry_of(in, l);
        if (e.at > in->size || e.bytes > in->size - e.at)
            return ibl_input_short(in, "one of its levels");
        ibl_status status =
            ibl_check_level_bytes(in, l, e.bytes_uncompressed, must);
        if (!status)
            status = packed ? ibl_zstd_check(in, l, e.bytes, must)
                            : ibl_check_level_bytes(in, l, e.bytes, must);
        if (status)
            return status;
    }
    return IBL_OK;
}

static ibl_status read_level(const ibl_input *in, bool packed, ibl_place *place,
                             ibl_texture *tex, int level)
{
    const index_entry e = entry_of(in, level);
    unsigned char *unpacked = NULL;

    place->at = e.at;
    if (!packed)
        return ibl_place_read_level(in, place, tex, level);
    ibl_status status = ibl_zstd_unpack(in, level, e.at, e.bytes,
                                        e.bytes_uncompressed, &unpacked);
    if (!status) {
        const ibl_input texels =
            ibl_input_of(in->ctx, in->name, unpacked, e.bytes_uncompressed);
        place->at = 0;
        status = ibl_place_read_level(&texels, place, tex, level);
    }
    ibl_free(unpacked);
    return status;
}

ibl_status ibl_ktx2_decode(const ibl_input *in, ibl_texture *tex)
{
    ibl_place place = {.row_align = 1};
    header h;

    if (!ibl_input_has(in, 0, sizeof h))
        return ibl_input_short(in, "a KTX2 header");
    memcpy(&h, in->bytes, sizeof h);
    const bool packed = h.scheme == SCHEME_ZSTD;
    ibl_status status = find_layout(in, &h, &place.layout);
    if (!status)
        status = ibl_texture_shape(in, &h.shape, &place, tex);
    if (!status && !packed)
        status = ibl_check_stored(in, &place, tex);
    if (!status)
        status = check_levels(in, packed, &place, tex);
    if (!status)
        status = ibl_texture_alloc(in, tex);
    if (status)
        return status;
    status = ibl_keys_read(in, h.kvd, h.kvd_bytes, rows_down, rows_up, tex,
                           &place.bottom_up);
    const unsigned char *d = h.dfd_bytes ? in->bytes + h.dfd : NULL;
    tex->primaries = d && d[offsetof(descriptor, primaries)]
                         ? d[offsetof(descriptor, primaries)]
                         : IBL_UNKNOWN_PRIMARIES;
    tex->premultiplied =
        d && place.layout->block_bytes == (int)ibl_pixel_bytes(tex->pixel) &&
        ibl_pixel_has_alpha(tex->pixel) &&
        d[offsetof(descriptor, flags)] & ALPHA_PREMULTIPLIED;
    for (int l = 0; !status && tex->data && l < tex->levels; l++)
        status = read_level(in, packed, &place, tex, l);
    return status;
}
