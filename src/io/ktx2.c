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
    ibl_shape shape;
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
    /* lcm(4, block size): blocks take 4, 8 or 16 bytes. Frames begin anywhere.
     */
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
                      .shape = ibl_shape_of(tex),
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
        const index_entry entry = {file->size,
                                   tex->zstd ? frames[l].size : bytes, bytes};
        memcpy(file->head + index + sizeof entry * (size_t)l, &entry,
               sizeof entry);
        if (tex->zstd)
            ibl_pieces_add(file, frames[l].bytes, frames[l].size);
        else
            ibl_pieces_add_level(file, tex, l);
    }
    return IBL_OK;
}

/* ---- reading -------------------------------------------------------- */

static ibl_status find_layout(const ibl_input *in, const header *h,
                              const ibl_layout **layout)
{
    static const char *const schemes[] = {"none", "BasisLZ", "Zstandard",
                                          "ZLIB"};

    if (h->scheme != SCHEME_NONE && h->scheme != SCHEME_ZSTD)
        return ibl_unsupported(
            in, "supercompression %u (%s): only none and Zstandard are read",
            h->scheme, h->scheme < 4 ? schemes[h->scheme] : "unknown");
    *layout = ibl_layout_find(offsetof(ibl_layout, vk), h->vk_format);
    if (*layout)
        return IBL_OK;
    return ibl_unsupported(
        in,
        "VkFormat %u: only 97, 109, 123, 122, 143, 144, 1000066000, 83, 103, "
        "90 and 106 are read (RGBA, RG, RGB floats, RGB9E5, R11G11B10, BC6H, "
        "ASTC 4x4 HDR)",
        h->vk_format);
}

static ibl_status check_header(const ibl_input *in, const header *h,
                               const ibl_layout *layout)
{
    if (h->type_size != (uint32_t)layout->word_bytes)
        return ibl_bad_file(in,
                            "damaged: typeSize %u, must be %d for VkFormat %u",
                            h->type_size, layout->word_bytes, layout->vk);
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
    return IBL_OK;
}

/* UASTC HDR and ASTC have the same number in Vulkan. Without a descriptor the
 * number alone counts. */
static const ibl_layout *settle_astc(const ibl_input *in, const header *h,
                                     const ibl_layout *layout)
{
    const int model =
        h->dfd_bytes ? in->bytes[h->dfd + offsetof(descriptor, model)] : 0;

    return layout->pixel == IBL_PIXEL_UASTC_HDR && model != IBL_MODEL_UASTC_HDR
               ? &ibl_layouts[IBL_PIXEL_ASTC4X4HDR]
               : layout;
}

/* The index entry of a level whose bytes are in the file. */
static ibl_status find_level(const ibl_input *in, int level, index_entry *entry)
{
    memcpy(entry, in->bytes + sizeof(header) + sizeof *entry * (size_t)level,
           sizeof *entry);
    return entry->at <= in->size && entry->bytes <= in->size - entry->at
               ? IBL_OK
               : ibl_input_short(in, "one of its levels");
}

static ibl_status wrong_size(const ibl_input *in, int level, uint64_t bytes,
                             uint64_t must)
{
    return ibl_bad_file(in, "damaged: level %d of %llu bytes, must be %llu",
                        level, (unsigned long long)bytes,
                        (unsigned long long)must);
}

static ibl_status read_level(const ibl_input *in, ibl_place *place,
                             ibl_texture *tex, int level)
{
    index_entry entry;
    const ibl_status status = find_level(in, level, &entry);

    if (status)
        return status;
    if (entry.bytes != entry.bytes_uncompressed)
        return wrong_size(in, level, entry.bytes, entry.bytes_uncompressed);
    place->at = entry.at;
    return ibl_place_read_level(in, place, tex, level, tex->layers * tex->faces,
                                entry.bytes);
}

/* Checks that all levels are frames that can hold their texels. */
static ibl_status check_frames(const ibl_input *in, const ibl_place *place,
                               const ibl_texture *tex)
{
    ibl_status status = IBL_OK;

    for (int l = 0; !status && l < tex->levels; l++) {
        const uint64_t must = (uint64_t)tex->layers * (uint64_t)tex->faces *
                              ibl_place_bytes(place, tex, l);
        index_entry entry;
        status = find_level(in, l, &entry);
        if (!status && entry.bytes_uncompressed != must)
            status = wrong_size(in, l, entry.bytes_uncompressed, must);
        if (!status && !in->head)
            status = ibl_zstd_check(in, l, entry.at, entry.bytes, must);
    }
    return status;
}

/* Reads a level that check_frames has seen. */
static ibl_status unpack_level(const ibl_input *in, ibl_place *place,
                               ibl_texture *tex, int level)
{
    unsigned char *unpacked = NULL;
    index_entry entry;
    ibl_status status = find_level(in, level, &entry);

    if (!status)
        status = ibl_zstd_unpack(in, level, entry.at, entry.bytes,
                                 entry.bytes_uncompressed, &unpacked);
    if (status)
        return status;
    const ibl_input texels =
        ibl_input_of(in->ctx, in->name, unpacked, entry.bytes_uncompressed);
    place->at = 0;
    status = ibl_place_read_level(&texels, place, tex, level,
                                  tex->layers * tex->faces,
                                  entry.bytes_uncompressed);
    ibl_free(unpacked);
    return status;
}

/* Allocates tex if the file has its texels. */
static ibl_status begin(const ibl_input *in, const header *h,
                        const ibl_place *place, ibl_texture *tex)
{
    ibl_status status = ibl_texture_shape(in, &h->shape, place, tex);

    if (!status && !ibl_input_has(in, sizeof *h,
                                  sizeof(index_entry) * (uint64_t)tex->levels))
        status = ibl_input_short(in, "its level index");
    if (status || h->scheme == SCHEME_NONE)
        return status ? status : ibl_texture_begin(in, &h->shape, place, tex);
    status = check_frames(in, place, tex);
    return status ? status : ibl_texture_alloc(in, tex);
}

ibl_status ibl_ktx2_decode(ibl_input *in, ibl_texture *tex)
{
    ibl_place place = {.row_align = 1};
    header h;
    ibl_status status;

    if (!ibl_input_has(in, 0, sizeof h))
        return ibl_input_short(in, "a KTX2 header");
    memcpy(&h, in->bytes, sizeof h);
    status = find_layout(in, &h, &place.layout);
    if (!status)
        status = check_header(in, &h, place.layout);
    if (!status)
        place.layout = settle_astc(in, &h, place.layout);
    if (!status)
        status = begin(in, &h, &place, tex);
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
        status = h.scheme == SCHEME_ZSTD ? unpack_level(in, &place, tex, l)
                                         : read_level(in, &place, tex, l);
    return status;
}
