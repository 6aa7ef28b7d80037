/* SPDX-License-Identifier: MIT */
/*
 * KTX2 files with Zstandard. What is written is unpacked by libzstd itself,
 * level by level; what is read is put together of frames that other writers may
 * leave, or that lie.
 */
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include "files.h"
#include "test.h"
#include "textures.h"

enum {
    SCHEME = 44,
    GLOBAL = 64, /* 16 bytes of the supercompression's global data */
    INDEX = 80,
    ENTRY = 24
};

static ibl_ctx *ctx;
static ibl_ctx *quiet;
static test_messages kept;

void test_setup(void)
{
    ctx = test_ctx(2, IBL_ISA_AUTO);
    quiet = test_keeping_ctx(1, &kept);
}

static ibl_texture make(ibl_pixel pixel, int size, int levels, int layers,
                        int faces)
{
    return texture_owned(
        texture_random(ctx, pixel, (int[]){size, size, levels, faces}, layers));
}

/* Checks the file of a texture, whose levels are smallest first and without
 * gaps, and returns its bytes. */
static size_t check_file(const ibl_texture *tex)
{
    size_t size;
    const unsigned char *b =
        texture_encode(ctx, tex, IBL_CONTAINER_KTX2, &size);
    size_t end = file_u32(b + 56) + file_u32(b + 60);

    CHECK(file_u32(b + SCHEME) == 2);
    for (int k = 0; k < 16; k += 4)
        CHECK(!file_u32(b + GLOBAL + k));
    for (int l = tex->levels - 1; l >= 0; l--) {
        const unsigned char *entry = b + INDEX + ENTRY * l;
        const size_t at = file_u32(entry), packed = file_u32(entry + 8);
        const size_t bytes =
            ibl_texture_face_bytes(tex, l) * (size_t)(tex->layers * tex->faces);
        unsigned char *level = test_alloc(bytes, 1);
        CHECK(at == end && file_u32(entry + 16) == bytes);
        CHECK(ZSTD_getFrameContentSize(b + at, packed) == bytes);
        CHECK(ZSTD_decompress(level, bytes, b + at, packed) == bytes);
        CHECK(!memcmp(level, tex->data + ibl_texture_offset(tex, l, 0), bytes));
        end = at + packed;
    }
    CHECK(end == size);
    const ibl_texture back = texture_decode(ctx, b, size);
    CHECK(texture_same(tex, &back) && texture_has(&back, "zeta", "last"));
    CHECK(!back.zstd);
    return size;
}

TEST(round_trip)
{
    static const int shapes[][4] = {
        {1, 1, 1, 1}, {5, 3, 1, 6}, {8, 4, 3, 6}, {31, 5, 2, 1}};
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; i++) {
            const int *s = shapes[i];
            ibl_texture tex = make(p, s[0], s[1], s[2], s[3]);
            for (tex.zstd = 1; tex.zstd <= IBL_MAX_ZSTD; tex.zstd += 7)
                check_file(&tex);
        }
    }
}

/* Of one value, and of more than a chunk. Every level of compression. */
TEST(smaller)
{
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 300, 3, 1, 1);
    memset(tex.data, 7, tex.bytes / 2);
    for (tex.zstd = 1; tex.zstd <= IBL_MAX_ZSTD; tex.zstd += 21) {
        const size_t size = check_file(&tex);
        CHECK(size > tex.bytes / 2 && size < tex.bytes * 55 / 100);
    }
}

TEST(threads)
{
    ibl_texture tex = make(IBL_PIXEL_RGBA32F, 130, 6, 1, 6);
    tex.zstd = 3;
    size_t size, other;
    const unsigned char *b =
        texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    for (int n = 1; n <= 7; n += 3) {
        const unsigned char *c = texture_encode(test_ctx(n, IBL_ISA_C), &tex,
                                                IBL_CONTAINER_KTX2, &other);
        CHECK(other == size && !memcmp(b, c, size));
    }
}

TEST(refused)
{
    ibl_texture tex = make(IBL_PIXEL_RG16F, 4, 1, 1, 1);
    static const int levels[] = {-1, IBL_MAX_ZSTD + 1, 5, 5};
    static const ibl_container containers[] = {
        IBL_CONTAINER_KTX2, IBL_CONTAINER_KTX2, IBL_CONTAINER_KTX,
        IBL_CONTAINER_DDS};
    for (int i = 0; i < 4; i++) {
        void *bytes;
        size_t size;
        tex.zstd = levels[i];
        CHECK(ibl_texture_encode(quiet, &tex, containers[i], &bytes, &size) ==
              IBL_ERR_ARGUMENT);
        CHECK(test_said(&kept, "Zstandard"));
    }
}

/* ---- files of others --------------------------------------------------- */

/* Bytes of frames, one after the other. */
typedef struct frames {
    unsigned char bytes[20000];
    size_t size;
} frames;

static void add_bytes(frames *f, const void *bytes, size_t size)
{
    memcpy(f->bytes + f->size, bytes, size);
    f->size += size;
}

/* Appends a frame; flags: 1 states the size, 2 has a checksum. */
static void add_frame(frames *f, const void *bytes, size_t size, int flags)
{
    ZSTD_CCtx *z = ZSTD_createCCtx();
    ZSTD_CCtx_setParameter(z, ZSTD_c_contentSizeFlag, flags & 1);
    ZSTD_CCtx_setParameter(z, ZSTD_c_checksumFlag, flags >> 1);
    f->size += ZSTD_compress2(z, f->bytes + f->size, sizeof f->bytes - f->size,
                              bytes, size);
    ZSTD_freeCCtx(z);
}

/* The file of tex, which has one level, with these bytes as its level. */
static unsigned char *splice(const ibl_texture *tex, const frames *f,
                             size_t *size)
{
    size_t plain;
    const unsigned char *b =
        texture_encode(ctx, tex, IBL_CONTAINER_KTX2, &plain);
    const size_t at = plain - tex->bytes;
    unsigned char *made = test_alloc(at + f->size, 1);

    memcpy(made, b, at);
    memcpy(made + at, f->bytes, f->size);
    file_set_u32(made + SCHEME, 2);
    file_set_u32(made + INDEX + 8, (uint32_t)f->size);
    *size = at + f->size;
    return made;
}

static void check_read(const ibl_texture *tex, const frames *f)
{
    size_t size;
    const unsigned char *b = splice(tex, f, &size);
    const ibl_texture back = texture_decode(ctx, b, size);
    CHECK(texture_same(tex, &back));
}

static void check_refused(const ibl_texture *tex, const frames *f,
                          const char *words)
{
    size_t size;
    ibl_texture back;
    const unsigned char *b = splice(tex, f, &size);
    kept.text[IBL_LOG_ERROR][0] = '\0';
    const ibl_status status =
        ibl_texture_decode(quiet, "NAME", b, size, &back, NULL);
    CHECK_MSG(status == IBL_ERR_FORMAT && test_said(&kept, words) &&
                  test_said(&kept, "NAME: "),
              "status %d, not %s: %s", (int)status, words,
              kept.text[IBL_LOG_ERROR]);
    CHECK(!back.data);
}

static const unsigned char skippable[] = {0x53, 0x2A, 0x4D, 0x18, 3, 0,
                                          0,    0,    1,    2,    3};

/* RFC 8878: frames may follow one another, be skippable, not state their size,
 * and have a checksum. */
TEST(other_frames)
{
    const ibl_texture tex = make(IBL_PIXEL_RGBA16F, 9, 1, 1, 6);
    const size_t part = tex.bytes / 3;
    for (int flags = 0; flags < 4; flags++) {
        frames f = {.size = 0};
        add_frame(&f, tex.data, tex.bytes, flags);
        check_read(&tex, &f);
        add_bytes(&f, skippable, sizeof skippable);
        check_read(&tex, &f);
        f.size = 0;
        add_bytes(&f, skippable, sizeof skippable);
        add_frame(&f, tex.data, part, flags);
        add_frame(&f, tex.data + part, tex.bytes - part, flags ^ 1);
        check_read(&tex, &f);
    }
}

TEST(lying_frames)
{
    const ibl_texture tex = make(IBL_PIXEL_RGBA16F, 9, 1, 1, 6);
    unsigned char more[5000] = {0};
    memcpy(more, tex.data, tex.bytes);
    for (int flags = 0; flags < 4; flags++) {
        frames f = {.size = 0};
        add_frame(&f, more, tex.bytes + 1, flags);
        check_refused(&tex, &f, "level 0");
        f.size = 0;
        add_frame(&f, tex.data, tex.bytes - 1, flags);
        check_refused(&tex, &f, "shorter");
        f.size = 0;
        add_frame(&f, tex.data, tex.bytes, flags);
        f.bytes[f.size++] = 0;
        check_refused(&tex, &f, "level 0");
        f.size -= 2;
        check_refused(&tex, &f, "level 0");
        f.size++;
        f.bytes[f.size - 1] ^= 1;
        if (flags & 2)
            check_refused(&tex, &f, "checksum");
        f.size = 0;
        add_frame(&f, tex.data, tex.bytes, flags);
        add_frame(&f, tex.data, 10, flags);
        check_refused(&tex, &f, "level 0");
    }
    frames none = {.size = 0};
    check_refused(&tex, &none, "too short");
    add_bytes(&none, skippable, sizeof skippable);
    check_refused(&tex, &none, "shorter");
    none.size = 0;
    add_bytes(&none, tex.data, tex.bytes);
    check_refused(&tex, &none, "level 0");
}

/* A file says what its texels take, and the header another thing. */
TEST(lying_index)
{
    const ibl_texture tex = make(IBL_PIXEL_RGBA16F, 9, 1, 1, 6);
    frames f = {.size = 0};
    add_frame(&f, tex.data, tex.bytes, 1);
    static const int places[] = {INDEX + 16, INDEX + 20, INDEX + 8, INDEX + 12,
                                 INDEX,      INDEX + 4,  GLOBAL + 8};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        for (uint32_t value = 1; value; value *= 256) {
            size_t size;
            ibl_texture back;
            unsigned char *b = splice(&tex, &f, &size);
            file_set_u32(b + places[i], value);
            CHECK(ibl_texture_decode(quiet, "x", b, size, &back, NULL) ==
                  IBL_ERR_FORMAT);
        }
    }
}

/* Three channels become four on the way. */
TEST(rgb_floats)
{
    ibl_texture tex = make(IBL_PIXEL_RGBA32F, 9, 1, 1, 6), back;
    frames f = {.size = 0};
    size_t size;
    add_frame(&f, tex.data, tex.bytes / 4 * 3, 1);
    unsigned char *b = splice(&tex, &f, &size);
    file_set_u32(b + 12, 106);
    file_set_u32(b + INDEX + 16, (uint32_t)(tex.bytes / 4 * 3));
    back = texture_decode(ctx, b, size);
    CHECK(back.pixel == IBL_PIXEL_RGBA32F && back.bytes == tex.bytes);
    for (size_t i = 0; i < tex.bytes / 16; i++) {
        CHECK(!memcmp(back.data + 16 * i, tex.data + 12 * i, 12));
        CHECK(file_u32(back.data + 16 * i + 12) == 0x3F800000);
    }
}

/* ---- damage -------------------------------------------------------------- */

TEST(damaged)
{
    size_t size;
    ibl_texture tex = make(IBL_PIXEL_R11G11B10F, 2, 2, 1, 6);
    tex.zstd = 19;
    memset(tex.data + 10, 0, tex.bytes - 20);
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    texture_damage(quiet, b, size);
}

/* The largest cubes in few bytes: of a header alone, and of frames that claim
 * to hold them; a window of 2 GiB, and one of 2 TiB. */
TEST(bombs)
{
    const ibl_texture tex = make(IBL_PIXEL_RGBA32F, 4, 1, 1, 6);
    static const unsigned char claim[] = {
        0x28, 0xB5, 0x2F, 0xFD, 0xC0, 0x58, /* magic, 8 bytes of size, window */
        0,    0,    0,    0,    0x60, 0,    0, 0, /* 6 * 65536^2 * 16 */
        3,    0,    0x10, 7};                     /* a block of 128 KiB of 7 */
    frames f = {.size = 0};
    size_t size;
    add_bytes(&f, claim, sizeof claim);
    unsigned char *b = splice(&tex, &f, &size);
    file_set_u32(b + 20, 65536);
    file_set_u32(b + 24, 65536);
    file_set_u32(b + INDEX + 16, 0);
    file_set_u32(b + INDEX + 20, 0x60);
    texture_boundless(quiet, b, size);
    CHECK(test_said(&kept, "too short"));
    static const unsigned char windows[] = {21 << 3, 31 << 3};
    for (int i = 0; i < 2; i++) {
        const unsigned char head[] = {0x28,       0xB5, 0x2F, 0xFD, 0,
                                      windows[i], 1,    0x10, 0};
        f.size = 0;
        add_bytes(&f, head, sizeof head);
        add_bytes(&f, tex.data, 512);
        check_refused(&tex, &f, "level 0");
    }
}
