/* SPDX-License-Identifier: MIT */
/*
 * Khronos KTX 2.0 without supercompression. Sources: KTX File Format
 * Specification 2.0, Khronos Data Format Specification 1.3 (the descriptor:
 * sections 5.1 to 5.10; shared exponents: 10.2, "E5B9G9R9").
 */
#include <assert.h>
#include <string.h>

#include "core/alloc.h"
#include "io/container.h"

static const unsigned char identifier[12] = {
    0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, '\r', '\n', 0x1A, '\n'};

enum {
    VK_FORMAT = 12,
    TYPE_SIZE = 16,
    WIDTH = 20,
    HEIGHT = 24,
    DEPTH = 28,
    LAYERS = 32,
    FACES = 36,
    LEVELS = 40,
    SCHEME = 44, /* of supercompression */
    DFD = 48,    /* offset and size, as KVD */
    KVD = 56,
    SGD = 64,   /* the same in 64 bits */
    INDEX = 80, /* of the levels: offset, size, size uncompressed */
    INDEX_ENTRY = 24
};

bool ibl_is_ktx2(const unsigned char *bytes, size_t size)
{
    return size >= sizeof identifier &&
           !memcmp(bytes, identifier, sizeof identifier);
}

/* ---- data format descriptor ----------------------------------------- */

enum {
    CHANNEL_ALPHA = 15,
    EXPONENT = 0x20, /* qualifiers of a channel */
    SIGNED = 0x40,
    FLOAT = 0x80,
    MAX_SAMPLES = 6,
    DFD_HEAD = 4 + 24, /* total size and the block without samples */
    DFD_FLAGS = 15,
    ALPHA_PREMULTIPLIED = 1,
    SAMPLE_BYTES = 16
};

static const uint32_t float_one = 0x3F800000, float_minus_one = 0xBF800000;

typedef struct sample {
    uint32_t offset, bits, channel, lower, upper;
} sample;

static int float_samples(int channels, uint32_t bits, sample *s)
{
    for (int c = 0; c < channels; c++) {
        const uint32_t channel = c == 3 ? CHANNEL_ALPHA : (uint32_t)c;
        s[c] = (sample){(uint32_t)c * bits, bits, channel | SIGNED | FLOAT,
                        float_minus_one, float_one};
    }
    return channels;
}

/* Mantissa and exponent of each channel in turn; a mantissa of 8448 (2^13 +
 * 2^8) at the exponent's bias of 15 is 1. */
static int shared_exponent_samples(sample *s)
{
    for (uint32_t c = 0; c < 3; c++) {
        s[2 * c] = (sample){9 * c, 9, c, 0, 8448};
        s[2 * c + 1] = (sample){27, 5, c | EXPONENT, 15, 31};
    }
    return 6;
}

static int small_float_samples(sample *s)
{
    s[0] = (sample){0, 11, 0 | FLOAT, 0, float_one};
    s[1] = (sample){11, 11, 1 | FLOAT, 0, float_one};
    s[2] = (sample){22, 10, 2 | FLOAT, 0, float_one};
    return 3;
}

static int samples_of(ibl_pixel pixel, sample s[MAX_SAMPLES])
{
    switch (pixel) {
    case IBL_PIXEL_RGBA16F:
        return float_samples(4, 16, s);
    case IBL_PIXEL_RGBA32F:
        return float_samples(4, 32, s);
    case IBL_PIXEL_RG16F:
        return float_samples(2, 16, s);
    case IBL_PIXEL_RG32F:
        return float_samples(2, 32, s);
    case IBL_PIXEL_RGB9E5:
        return shared_exponent_samples(s);
    case IBL_PIXEL_R11G11B10F:
        return small_float_samples(s);
    default:
        assert(!"a pixel format");
        return 0;
    }
}

static size_t descriptor_bytes(ibl_pixel pixel)
{
    sample s[MAX_SAMPLES];
    return DFD_HEAD + SAMPLE_BYTES * (size_t)samples_of(pixel, s);
}

static void write_descriptor(ibl_pixel pixel, bool premultiplied,
                             unsigned char *dst)
{
    enum {
        VERSION = 2, /* of the specification: 1.3 */
        MODEL_RGBSDA = 1,
        PRIMARIES_BT709 = 1,
        TRANSFER_LINEAR = 1
    };
    const uint32_t flags = premultiplied ? ALPHA_PREMULTIPLIED : 0;
    sample s[MAX_SAMPLES];
    const int count = samples_of(pixel, s);
    const uint32_t bytes = (uint32_t)descriptor_bytes(pixel);

    ibl_put_u32(dst, bytes);
    ibl_put_u32(dst + 4, 0); /* vendor Khronos, basic descriptor */
    ibl_put_u32(dst + 8, VERSION | (bytes - 4) << 16);
    ibl_put_u32(dst + 12, MODEL_RGBSDA | PRIMARIES_BT709 << 8 |
                              TRANSFER_LINEAR << 16 | flags << 24);
    ibl_put_u32(dst + 16, 0); /* blocks of one texel */
    ibl_put_u32(dst + 20, (uint32_t)ibl_pixel_bytes(pixel)); /* plane 0 */
    ibl_put_u32(dst + 24, 0);
    for (int i = 0; i < count; i++) {
        unsigned char *to = dst + DFD_HEAD + SAMPLE_BYTES * i;
        ibl_put_u32(to,
                    s[i].offset | (s[i].bits - 1) << 16 | s[i].channel << 24);
        ibl_put_u32(to + 4, 0); /* at the texel's centre */
        ibl_put_u32(to + 8, s[i].lower);
        ibl_put_u32(to + 12, s[i].upper);
    }
}

/* ---- writing -------------------------------------------------------- */

/* Where everything goes. */
typedef struct plan {
    ibl_key_value *keys;
    int key_count;
    size_t dfd, dfd_bytes, kvd, kvd_bytes;
    size_t level[32]; /* offsets */
    size_t size;
} plan;

static bool make_plan(const ibl_texture *tex, plan *p)
{
    /* lcm(4, texel size): texels take 4, 8 or 16 bytes. */
    const size_t align = ibl_pixel_bytes(tex->pixel);

    p->keys = ibl_keys_list(tex, "rd", &p->key_count);
    if (!p->keys)
        return false;
    p->dfd = INDEX + INDEX_ENTRY * (size_t)tex->levels;
    p->dfd_bytes = descriptor_bytes(tex->pixel);
    p->kvd = p->dfd + p->dfd_bytes;
    p->kvd_bytes = ibl_keys_bytes(p->keys, p->key_count);
    p->size = p->kvd + p->kvd_bytes;
    for (int l = tex->levels - 1; l >= 0; l--) { /* the smallest first */
        p->level[l] = (p->size + align - 1) / align * align;
        p->size = p->level[l] + ibl_texture_level_bytes(tex, l);
    }
    return true;
}

static void write_header(const ibl_texture *tex, const plan *p,
                         unsigned char *dst)
{
    const ibl_layout *layout = &ibl_layouts[tex->pixel];
    memcpy(dst, identifier, sizeof identifier);
    ibl_put_u32(dst + VK_FORMAT, layout->vk);
    ibl_put_u32(dst + TYPE_SIZE, (uint32_t)layout->word_bytes);
    ibl_put_u32(dst + WIDTH, (uint32_t)tex->width);
    ibl_put_u32(dst + HEIGHT, (uint32_t)tex->height);
    /* 0: no array. */
    ibl_put_u32(dst + LAYERS, tex->layers > 1 ? (uint32_t)tex->layers : 0);
    ibl_put_u32(dst + FACES, (uint32_t)tex->faces);
    ibl_put_u32(dst + LEVELS, (uint32_t)tex->levels);
    ibl_put_u32(dst + DFD, (uint32_t)p->dfd);
    ibl_put_u32(dst + DFD + 4, (uint32_t)p->dfd_bytes);
    ibl_put_u32(dst + KVD, (uint32_t)p->kvd);
    ibl_put_u32(dst + KVD + 4, (uint32_t)p->kvd_bytes);
    for (int l = 0; l < tex->levels; l++) {
        unsigned char *entry = dst + INDEX + INDEX_ENTRY * l;
        ibl_put_u64(entry, p->level[l]);
        ibl_put_u64(entry + 8, ibl_texture_level_bytes(tex, l));
        ibl_put_u64(entry + 16, ibl_texture_level_bytes(tex, l));
    }
}

ibl_status ibl_ktx2_encode(ibl_ctx *ctx, const ibl_texture *tex,
                           ibl_pieces *file)
{
    plan p = {0};
    size_t head_bytes = 0;
    ibl_status status = IBL_OK;

    if (make_plan(tex, &p))
        head_bytes = p.level[tex->levels - 1];
    if (!head_bytes || !ibl_pieces_alloc(file, head_bytes, 1 + tex->levels)) {
        status = ibl_no_memory(ctx, "a KTX2 file");
        goto done;
    }
    if (p.kvd_bytes > UINT32_MAX - p.kvd) {
        status = ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                          "KTX2: %zu bytes of keys: the limit is 4 GiB",
                          p.kvd_bytes);
        goto done;
    }
    write_header(tex, &p, file->head);
    write_descriptor(tex->pixel, tex->premultiplied, file->head + p.dfd);
    ibl_keys_write(p.keys, p.key_count, file->head + p.kvd);
    ibl_pieces_add(file, file->head, head_bytes);
    /* Levels are multiples of their alignment: no gaps between them. */
    for (int l = tex->levels - 1; l >= 0; l--)
        ibl_pieces_add_level(file, tex, l);
    assert(file->size == p.size);

done:
    ibl_free(p.keys);
    return status;
}

/* ---- reading -------------------------------------------------------- */

static ibl_status find_layout(const ibl_file *file, const ibl_layout **layout)
{
    static const char *const schemes[] = {"none", "BasisLZ", "Zstandard",
                                          "ZLIB"};
    const uint32_t scheme = ibl_file_u32(file, SCHEME);
    const uint32_t vk = ibl_file_u32(file, VK_FORMAT);

    if (scheme)
        return ibl_fail(file->ctx, IBL_ERR_UNSUPPORTED,
                        "%s: supercompression %u (%s): only uncompressed KTX2 "
                        "is read",
                        file->name, scheme,
                        scheme < 4 ? schemes[scheme] : "unknown");
    for (int i = 0; i < IBL_LAYOUT_COUNT; i++) {
        if (ibl_layouts[i].vk == vk) {
            *layout = &ibl_layouts[i];
            return IBL_OK;
        }
    }
    return ibl_fail(file->ctx, IBL_ERR_UNSUPPORTED,
                    "%s: VkFormat %u: only 97, 109, 123, 122, 83, 103, 90 and "
                    "106 are read (RGBA, RG, RGB floats, RGB9E5, R11G11B10)",
                    file->name, vk);
}

static ibl_status check_header(const ibl_file *file, const ibl_layout *layout)
{
    const uint32_t type_size = ibl_file_u32(file, TYPE_SIZE);
    const uint64_t dfd = ibl_file_u32(file, DFD);
    const uint64_t dfd_bytes = ibl_file_u32(file, DFD + 4);

    if (type_size != (uint32_t)layout->word_bytes)
        return ibl_fail(file->ctx, IBL_ERR_FORMAT,
                        "%s: damaged: typeSize %u, must be %d for VkFormat %u",
                        file->name, type_size, layout->word_bytes, layout->vk);
    if (ibl_file_u64(file, SGD + 8))
        return ibl_fail(file->ctx, IBL_ERR_FORMAT,
                        "%s: damaged: supercompression data without "
                        "supercompression",
                        file->name);
    if (!ibl_file_has(file, dfd, dfd_bytes))
        return ibl_file_short(file, "its data format descriptor");
    if (dfd_bytes < DFD_HEAD || ibl_file_u32(file, dfd) != dfd_bytes)
        return ibl_fail(file->ctx, IBL_ERR_FORMAT,
                        "%s: damaged: a data format descriptor of %llu bytes "
                        "that says otherwise",
                        file->name, (unsigned long long)dfd_bytes);
    return IBL_OK;
}

static ibl_status read_level(const ibl_file *file, const ibl_layout *layout,
                             ibl_texture *tex, int level, bool bottom_up)
{
    const uint64_t entry = INDEX + INDEX_ENTRY * (uint64_t)level;
    ibl_place place = {layout, ibl_file_u64(file, entry), 1, bottom_up};
    const uint64_t bytes = ibl_file_u64(file, entry + 8);
    const uint64_t must = ibl_place_bytes(&place, tex, level) *
                          (uint64_t)tex->layers * (uint64_t)tex->faces;

    if (bytes != must || bytes != ibl_file_u64(file, entry + 16))
        return ibl_fail(file->ctx, IBL_ERR_FORMAT,
                        "%s: damaged: level %d of %llu bytes, must be %llu",
                        file->name, level, (unsigned long long)bytes,
                        (unsigned long long)must);
    /* So that adding a face to the offset cannot overflow. */
    if (!ibl_file_has(file, place.at, bytes))
        return ibl_file_short(file, "one of its levels");
    return ibl_place_read_level(file, &place, tex, level);
}

ibl_status ibl_ktx2_decode(const ibl_file *file, ibl_texture *tex)
{
    const ibl_layout *layout = NULL;
    bool bottom_up;
    ibl_status status;

    if (!ibl_file_has(file, 0, INDEX))
        return ibl_file_short(file, "a KTX2 header");
    status = find_layout(file, &layout);
    if (!status)
        status = check_header(file, layout);
    if (status)
        return status;
    const ibl_shape shape = {
        ibl_file_u32(file, WIDTH), ibl_file_u32(file, HEIGHT),
        ibl_file_u32(file, DEPTH), ibl_file_u32(file, LAYERS),
        ibl_file_u32(file, FACES), ibl_file_u32(file, LEVELS)};
    status = ibl_texture_begin(file, &shape, layout, 1, tex);
    if (status)
        return status;
    if (!ibl_file_has(file, INDEX, INDEX_ENTRY * (uint64_t)tex->levels))
        return ibl_file_short(file, "its level index");
    status =
        ibl_keys_read(file, ibl_file_u32(file, KVD),
                      ibl_file_u32(file, KVD + 4), "rd", "ru", tex, &bottom_up);
    const uint32_t dfd = ibl_file_u32(file, DFD);
    tex->premultiplied =
        layout->texel_bytes == (int)ibl_pixel_bytes(tex->pixel) &&
        ibl_pixel_has_alpha(tex->pixel) &&
        file->bytes[dfd + DFD_FLAGS] & ALPHA_PREMULTIPLIED;
    for (int l = 0; !status && l < tex->levels; l++)
        status = read_level(file, layout, tex, l, bottom_up);
    return status;
}
