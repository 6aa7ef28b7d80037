/* SPDX-License-Identifier: MIT */
/*
 * Textures in memory and in their containers. The headers are compared with
 * numbers from the specifications written out here, the readers with files
 * that are turned round, widened, cut and damaged.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "maps.h"
#include "textures.h"

static ibl_ctx *ctx;   /* prints its errors */
static ibl_ctx *quiet; /* keeps them in kept */
static test_messages kept;

void test_setup(void)
{
    ctx = test_ctx(2, IBL_ISA_AUTO);
    quiet = test_keeping_ctx(1, &kept);
}

static bool said(const char *words)
{
    return test_said(&kept, words);
}

static ibl_texture make(ibl_pixel pixel, int width, int height, int levels,
                        int layers, int faces)
{
    ibl_texture tex = texture_random(
        ctx, pixel, (int[]){width, height, levels, faces}, layers);
    ibl_texture_set(ctx, &tex, "iblRoughness", "0 0.25 0.5");
    return texture_owned(tex);
}

TEST(keys)
{
    ibl_texture tex = {0};
    CHECK(!ibl_texture_set(ctx, &tex, "b", "1"));
    CHECK(!ibl_texture_set(ctx, &tex, "c", "2"));
    CHECK(!ibl_texture_set(ctx, &tex, "a", "3"));
    CHECK(!ibl_texture_set(ctx, &tex, "b", "\xC3\xA9t\xC3\xA9"));
    CHECK(tex.key_count == 3 && texture_has(&tex, "a", "3") &&
          texture_has(&tex, "b", "\xC3\xA9t\xC3\xA9") &&
          texture_has(&tex, "c", "2"));
    CHECK(!strcmp(tex.keys[0].key, "a") && !strcmp(tex.keys[2].key, "c"));
    CHECK(!ibl_texture_get(&tex, "d") && !ibl_texture_get(&tex, ""));
    char key[258];
    memset(key, 'k', sizeof key);
    key[256] = '\0';
    CHECK(ibl_texture_set(quiet, &tex, key, "") == IBL_ERR_ARGUMENT);
    key[255] = '\0';
    CHECK(!ibl_texture_set(quiet, &tex, key, ""));
    CHECK(ibl_texture_set(quiet, &tex, "", "v") == IBL_ERR_ARGUMENT);
    static const char *const bad[] = {"\x80",         "\xC0\xAF",
                                      "\xED\xA0\x80", "\xF5\x80\x80\x80",
                                      "\xE2\x82",     "\xFF"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        CHECK(ibl_texture_set(quiet, &tex, "x", bad[i]) == IBL_ERR_ARGUMENT);
    CHECK(tex.key_count == 4);
    ibl_texture_free(&tex);
    ibl_texture_free(&tex);
    ibl_texture_free(NULL);
}

TEST(cubes)
{
    ibl_ctx *const one = test_ctx(1, IBL_ISA_C);
    test_random r = {7};
    ibl_cube cube = cube_alloc(ctx, 70, 5), back;
    const size_t floats = 3 * ibl_cube_texels(70, 5);
    for (size_t i = 0; i < floats; i++)
        cube.data[i] = (float)ldexp(test_random_unit(&r),
                                    (int)(test_random_u64(&r) % 30) - 12);
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        ibl_texture a, b;
        ibl_overflow_report beyond_a, beyond_b;
        const ibl_texel_options o = {.pixel = p, .overflow = IBL_OVERFLOW_CLIP};
        if (ibl_pixel_channels(p) == 2) {
            CHECK(ibl_texture_from_cube(quiet, &cube, &o, &a, NULL) ==
                  IBL_ERR_ARGUMENT);
            continue;
        }
        NEED(!ibl_texture_from_cube(ctx, &cube, &o, &a, &beyond_a));
        NEED(!ibl_texture_from_cube(one, &cube, &o, &b, &beyond_b));
        CHECK(texture_same(&a, &b) && beyond_a.values == beyond_b.values);
        CHECK((beyond_a.values > 0) == (p != IBL_PIXEL_RGBA32F));
        NEED(!ibl_texture_to_cube(ctx, &a, &back));
        CHECK(back.size == 70 && back.levels == 5);
        /* The last texel of all, or the last block, which is the last face. */
        float last[3 * 16];
        unsigned char texel[16];
        const size_t n = (size_t)(ibl_pixel_block(p) * ibl_pixel_block(p));
        texels_encode(p, cube.data + floats - 3 * n, n, texel);
        ibl_pixel_decode(p, texel, n, last);
        CHECK(!memcmp(last, back.data + floats - 3 * n, 3 * n * sizeof *last));
        CHECK(ibl_texture_offset(&a, 4, 5) + ibl_texture_face_bytes(&a, 4) ==
              a.bytes);
        ibl_lut lut;
        CHECK(ibl_texture_to_lut(quiet, &a, &lut) == IBL_ERR_ARGUMENT);
        ibl_cube_free(&back);
        ibl_texture_free(&a);
        ibl_texture_free(&b);
    }
}

TEST(luts)
{
    float data[2 * 9] = {0, 1, 0.5f, 70000, 0.25f, -1};
    const ibl_lut lut = {3, data, IBL_LUT_SPLIT};
    for (ibl_pixel p = IBL_PIXEL_RG16F; p <= IBL_PIXEL_RG32F; p++) {
        ibl_texture tex;
        ibl_lut back;
        ibl_cube cube;
        size_t beyond;
        NEED(!ibl_texture_from_lut(ctx, &lut, p, &tex, &beyond));
        CHECK(beyond == (p == IBL_PIXEL_RG16F));
        CHECK(tex.faces == 1 && tex.levels == 1 && tex.width == 3);
        NEED(!ibl_texture_to_lut(ctx, &tex, &back));
        CHECK(back.size == 3 && back.data[2] == 0.5f && back.data[5] == -1);
        CHECK(ibl_texture_to_cube(quiet, &tex, &cube) == IBL_ERR_ARGUMENT);
        free(back.data);
        ibl_texture_free(&tex);
    }
    ibl_texture tex = make(IBL_PIXEL_RG16F, 4, 2, 1, 1, 1);
    ibl_lut back;
    CHECK(ibl_texture_to_lut(quiet, &tex, &back) == IBL_ERR_ARGUMENT);
    CHECK(ibl_texture_from_lut(quiet, &lut, IBL_PIXEL_RGB9E5, &tex, NULL) ==
          IBL_ERR_ARGUMENT);
}

/* KTX 2.0, section 3: the header's words, 0 layers for no array; 3.10: levels,
 * smallest first. */
TEST(ktx2_header)
{
    static const uint32_t formats[][2] = {
        [IBL_PIXEL_RGBA16F] = {97, 2},
        [IBL_PIXEL_RGBA32F] = {109, 4},
        [IBL_PIXEL_RGB9E5] = {123, 4},
        [IBL_PIXEL_R11G11B10F] = {122, 4},
        [IBL_PIXEL_BC6H] = {143, 1},
        [IBL_PIXEL_UASTC_HDR] = {1000066000, 1},
        [IBL_PIXEL_ASTC4X4HDR] = {1000066000, 1},
        [IBL_PIXEL_RG16F] = {83, 2},
        [IBL_PIXEL_RG32F] = {103, 4}};
    for (int n = 0; n < 2 * IBL_PIXEL_COUNT; n++) {
        const ibl_pixel p = (ibl_pixel)(n / 2);
        const uint32_t layers = n % 2 ? 3 : 1;
        ibl_texture tex = make(p, 5, 5, 3, (int)layers, 6);
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        CHECK(!memcmp(b, "\xABKTX 20\xBB\r\n\x1A\n", 12));
        const uint32_t want[] = {
            formats[p][0], formats[p][1], 5, 5, 0, layers / 3 * 3, 6, 3, 0};
        for (size_t i = 0; i < sizeof want / sizeof want[0]; i++)
            CHECK(file_u32(b + 12 + 4 * i) == want[i]);
        const uint32_t dfd = file_u32(b + 48), kvd = file_u32(b + 56);
        CHECK(dfd == 80 + 3 * 24 && file_u32(b + dfd) == file_u32(b + 52));
        CHECK(kvd == dfd + file_u32(b + 52));
        CHECK(!file_u32(b + 64) && !file_u32(b + 68) && !file_u32(b + 72) &&
              !file_u32(b + 76));
        size_t end = kvd + file_u32(b + 60);
        for (int l = 2; l >= 0; l--) {
            const unsigned char *entry = b + 80 + 24 * l;
            const size_t texel = ibl_pixel_bytes(p), at = file_u32(entry);
            CHECK(at % texel == 0 && at % 4 == 0);
            CHECK(at >= end && at - end < texel);
            for (; end < at; end++)
                CHECK(!b[end]);
            CHECK(file_u32(entry + 8) ==
                  6 * layers * ibl_texture_face_bytes(&tex, l));
            CHECK(file_u32(entry + 16) == file_u32(entry + 8));
            CHECK(!memcmp(b + at, tex.data + ibl_texture_offset(&tex, l, 0),
                          file_u32(entry + 8)));
            end = at + file_u32(entry + 8);
        }
        CHECK(end == size);
    }
}

/* The metadata, byte for byte, sorted. */
TEST(ktx2_metadata)
{
    static const char want[] = "\x12\0\0\0KTXorientation\0rd\0\0\0"
                               "\x18\0\0\0KTXwriter\0iblbake " IBL_VERSION "\0"
                               "\x18\0\0\0iblRoughness\0"
                               "0 0.25 0.5\0"
                               "\x0A\0\0\0zeta\0last\0\0\0";
    ibl_texture tex = make(IBL_PIXEL_RGB9E5, 1, 1, 1, 1, 6);
    size_t size;
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    CHECK_MSG(file_u32(b + 60) == sizeof want - 1, "%u b, not %zu",
              file_u32(b + 60), sizeof want - 1);
    CHECK(!memcmp(b + file_u32(b + 56), want, sizeof want - 1));
}

/* KTX 1.1: imageSize is a face's if a cube is no array, else the level's. */
TEST(ktx_header)
{
    /* Type, its size, format, internal format; base format if that differs. */
    static const uint32_t gl[IBL_PIXEL_COUNT][5] = {
        [IBL_PIXEL_RGBA16F] = {0x140B, 2, 0x1908, 0x881A},
        [IBL_PIXEL_RGBA32F] = {0x1406, 4, 0x1908, 0x8814},
        [IBL_PIXEL_RGB9E5] = {0x8C3E, 4, 0x1907, 0x8C3D},
        [IBL_PIXEL_R11G11B10F] = {0x8C3B, 4, 0x1907, 0x8C3A},
        [IBL_PIXEL_BC6H] = {0, 1, 0, 0x8E8F, 0x1907},
        [IBL_PIXEL_ASTC4X4HDR] = {0, 1, 0, 0x93B0, 0x1908},
        [IBL_PIXEL_RG16F] = {0x140B, 2, 0x8227, 0x822F},
        [IBL_PIXEL_RG32F] = {0x1406, 4, 0x8227, 0x8230}};
    for (int n = 0; n < 2 * IBL_PIXEL_COUNT; n++) {
        const ibl_pixel p = (ibl_pixel)(n / 2);
        const uint32_t layers = n % 2 ? 3 : 0;
        if (!ibl_container_holds(IBL_CONTAINER_KTX, p))
            continue;
        ibl_texture tex = make(p, 5, 5, 3, n % 2 ? 3 : 1, 6);
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
        const uint32_t want[] = {0x04030201, gl[p][0], gl[p][1],
                                 gl[p][2],   gl[p][3], gl[p][gl[p][4] ? 4 : 2],
                                 5,          5,        0,
                                 layers,     6,        3};
        CHECK(!memcmp(b, "\xABKTX 11\xBB\r\n\x1A\n", 12));
        for (size_t i = 0; i < sizeof want / sizeof want[0]; i++)
            CHECK(file_u32(b + 12 + 4 * i) == want[i]);
        CHECK(!memcmp(b + 64, "\x17\0\0\0KTXorientation\0S=r,T=d\0\0", 28));
        size_t at = 64 + file_u32(b + 60);
        CHECK(at % 4 == 0);
        for (int l = 0; l < 3; l++) {
            const size_t face = ibl_texture_face_bytes(&tex, l);
            const size_t bytes = face * 6 * (layers ? layers : 1);
            CHECK(file_u32(b + at) == (layers ? bytes : face));
            CHECK(!memcmp(b + at + 4, tex.data + ibl_texture_offset(&tex, l, 0),
                          bytes));
            at += 4 + bytes;
        }
        CHECK(at == size);
    }
}

/* arraySize counts cubes; layers hold faces, faces hold all levels. */
TEST(dds_header)
{
    static const uint32_t dxgi[IBL_PIXEL_COUNT] = {
        [IBL_PIXEL_RGBA16F] = 10, [IBL_PIXEL_RGBA32F] = 2,
        [IBL_PIXEL_RGB9E5] = 67,  [IBL_PIXEL_R11G11B10F] = 26,
        [IBL_PIXEL_BC6H] = 95,    [IBL_PIXEL_RG16F] = 34,
        [IBL_PIXEL_RG32F] = 16};
    for (int n = 0; n < 2 * IBL_PIXEL_COUNT; n++) {
        const ibl_pixel p = (ibl_pixel)(n / 2);
        const int layers = n % 2 ? 3 : 1;
        if (!ibl_container_holds(IBL_CONTAINER_DDS, p))
            continue;
        const bool blocks = p == IBL_PIXEL_BC6H;
        ibl_texture tex = make(p, 5, 5, 3, layers, 6);
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &size);
        CHECK(!memcmp(b, "DDS \x7C\0\0\0", 8) &&
              file_u32(b + 8) == (blocks ? 0xA1007 : 0x2100F));
        CHECK(file_u32(b + 12) == 5 && file_u32(b + 16) == 5 &&
              file_u32(b + 24) == 0);
        CHECK(file_u32(b + 20) == (blocks ? 4 * 16 : 5 * ibl_pixel_bytes(p)) &&
              file_u32(b + 28) == 3);
        CHECK(!memcmp(b + 76, "\x20\0\0\0\x04\0\0\0DX10", 12));
        CHECK(file_u32(b + 108) == 0x401008 && file_u32(b + 112) == 0xFE00);
        CHECK(file_u32(b + 128) == dxgi[p] && file_u32(b + 132) == 3 &&
              file_u32(b + 136) == 4 && file_u32(b + 140) == (uint32_t)layers &&
              file_u32(b + 144) == 0);
        const unsigned char *at = b + 148;
        for (int i = 0; i < 6 * layers * 3; i++) {
            const int l = i % 3, f = i / 3 % 6;
            const size_t face = ibl_texture_face_bytes(&tex, l);
            CHECK(!memcmp(
                at, tex.data + ibl_texture_layer_offset(&tex, l, i / 18, f),
                face));
            at += face;
        }
        CHECK(at == b + size);
    }
    /* More than one surface, with neither levels nor faces. */
    for (int layers = 1; layers <= 2; layers++) {
        ibl_texture flat = make(IBL_PIXEL_RG16F, 4, 4, 1, layers, 1);
        size_t size;
        unsigned char *b = texture_encode(ctx, &flat, IBL_CONTAINER_DDS, &size);
        CHECK(file_u32(b + 8) == 0x100F && !file_u32(b + 112) &&
              file_u32(b + 108) == (layers > 1 ? 0x1008 : 0x1000) &&
              !file_u32(b + 136) && file_u32(b + 140) == (uint32_t)layers);
    }
}

/* The same without the DX10 header, and a number for its FourCC, as Direct3D 9
 * has them; of a cube all faces. */
TEST(dds_legacy_header)
{
    static const uint32_t d3d[IBL_PIXEL_COUNT] = {[IBL_PIXEL_RGBA16F] = 113,
                                                  [IBL_PIXEL_RGBA32F] = 116,
                                                  [IBL_PIXEL_RG16F] = 112,
                                                  [IBL_PIXEL_RG32F] = 115};
    static const struct {
        size_t at;
        uint32_t value;
        ibl_status status;
    } changes[] = {{24, 4, IBL_OK}, /* a depth that no flag tells of */
                   {8, 0x82100F, IBL_ERR_UNSUPPORTED}, /* which this is */
                   {24, 1, IBL_OK},
                   {112, 0x0600, IBL_ERR_UNSUPPORTED}}; /* +X alone */
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        CHECK(ibl_container_holds(IBL_CONTAINER_DDS_LEGACY, p) == (d3d[p] > 0));
        if (!d3d[p])
            continue;
        const ibl_texture tex = make(p, 5, 5, 3, 1, 6);
        ibl_container found;
        size_t size, more;
        unsigned char *b =
            texture_encode(ctx, &tex, IBL_CONTAINER_DDS_LEGACY, &size);
        unsigned char *a = texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &more);
        CHECK(size + 20 == more && file_u32(b + 84) == d3d[p]);
        file_set_u32(a + 84, d3d[p]);
        CHECK(!memcmp(a, b, 128) && !memcmp(a + 148, b + 128, size - 128));
        texture_damage(quiet, b, size);
        for (size_t i = 0; i < 4; i++) {
            ibl_texture back;
            file_set_u32(b + changes[i].at, changes[i].value);
            const ibl_status status =
                ibl_texture_decode(quiet, "x", b, size, &back, &found);
            CHECK_MSG(status == changes[i].status, "%zu: %d", i, (int)status);
            CHECK(status || (found == IBL_CONTAINER_DDS_LEGACY &&
                             texture_same(&tex, &back)));
            ibl_texture_free(&back);
        }
    }
}

/* Filament's cmgen writes the internal format as glType, a glTypeSize of 1. */
TEST(ktx_cmgen)
{
    ibl_texture tex = make(IBL_PIXEL_R11G11B10F, 4, 4, 3, 1, 6), back;
    size_t size;
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
    file_set_u32(b + 16, 0x8C3A);
    file_set_u32(b + 20, 1);
    back = texture_decode(ctx, b, size);
    CHECK(texture_same(&tex, &back));
    /* On demand, ours does so, too. */
    tex.filament = 1;
    size_t other;
    const unsigned char *f =
        texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &other);
    file_set_u32(b + 32, 0x8C3A);
    CHECK(other == size && !memcmp(f, b, size));
    tex = make(IBL_PIXEL_RGBA16F, 4, 4, 3, 1, 6);
    b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
    tex.filament = 1;
    f = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &other);
    CHECK(other == size && !memcmp(f, b, size));
}

/* Ours with the format turned to R32G32B32_SFLOAT and as many b less. */
TEST(ktx2_rgb_floats)
{
    ibl_texture tex = make(IBL_PIXEL_RGBA32F, 3, 2, 1, 1, 1), back;
    size_t size;
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    file_set_u32(b + 12, 106);
    file_set_u32(b + 88, 72);
    CHECK(ibl_texture_decode(quiet, "rgb", b, size, &back, NULL) ==
          IBL_ERR_FORMAT); /* 96 uncompressed */
    file_set_u32(b + 96, 72);
    b[file_u32(b + 48) + 15] = 1; /* premultiplied, by an alpha that is not */
    back = texture_decode(ctx, b, file_u32(b + 80) + 72);
    CHECK(back.pixel == IBL_PIXEL_RGBA32F && back.bytes == 96);
    CHECK(!back.premultiplied);
    for (int i = 0; i < 6; i++) {
        CHECK(!memcmp(back.data + 16 * i, b + file_u32(b + 80) + 12 * i, 12));
        CHECK(file_u32(back.data + 16 * i + 12) == 0x3F800000);
    }
}

static void orientation(ibl_container container, const char *from,
                        const char *to)
{
    for (int faces = 1; faces <= 6; faces += 5) {
        ibl_texture tex = make(IBL_PIXEL_RG32F, 3, 3, 2, 1, faces), back;
        size_t size, at = 0;
        unsigned char *b = texture_encode(ctx, &tex, container, &size);
        while (memcmp(b + at, from, strlen(from)))
            at++;
        memcpy(b + at, to, strlen(to));
        const ibl_status status =
            ibl_texture_decode(quiet, "up", b, size, &back, NULL);
        if (faces == 6) {
            CHECK(status == IBL_ERR_UNSUPPORTED);
            CHECK(test_said(&kept, to));
        } else {
            NEED(!status);
            CHECK(!ibl_texture_get(&back, "KTXorientation"));
            for (size_t y = 0; y < 3; y++)
                CHECK(!memcmp(tex.data + 24 * y, back.data + 24 * (2 - y), 24));
            CHECK(!memcmp(tex.data + 72, back.data + 72, 8));
        }
        ibl_texture_free(&back);
    }
}

TEST(bottom_up)
{
    orientation(IBL_CONTAINER_KTX2, "rd", "ru");
    orientation(IBL_CONTAINER_KTX, "S=r,T=d", "S=r,T=u");
}

/* What is not read is named. */
TEST(named)
{
    static const struct {
        ibl_container container;
        size_t at;
        uint32_t value;
        ibl_status status;
        const char *text;
    } cases[] = {
        {IBL_CONTAINER_KTX2, 12, 37, IBL_ERR_UNSUPPORTED, "VkFormat 37"},
        {IBL_CONTAINER_KTX2, 16, 1, IBL_ERR_FORMAT, "typeSize 1"},
        {IBL_CONTAINER_KTX2, 44, 3, IBL_ERR_UNSUPPORTED, "ZLIB"},
        {IBL_CONTAINER_KTX2, 44, 2, IBL_ERR_FORMAT, "Zstandard"},
        {IBL_CONTAINER_KTX2, 44, 1, IBL_ERR_UNSUPPORTED, "BasisLZ"},
        {IBL_CONTAINER_KTX2, 28, 4, IBL_ERR_UNSUPPORTED, "3D"},
        {IBL_CONTAINER_KTX2, 32, 3, IBL_ERR_FORMAT, "cut short"},
        {IBL_CONTAINER_KTX2, 32, 2049, IBL_ERR_UNSUPPORTED, "2048"},
        {IBL_CONTAINER_KTX2, 24, 0, IBL_ERR_UNSUPPORTED, "1D"},
        {IBL_CONTAINER_KTX2, 24, 3, IBL_ERR_FORMAT, "square"},
        {IBL_CONTAINER_KTX2, 36, 5, IBL_ERR_FORMAT, "5 faces"},
        {IBL_CONTAINER_KTX2, 40, 9, IBL_ERR_FORMAT, "9 levels"},
        {IBL_CONTAINER_KTX2, 20, 70000, IBL_ERR_UNSUPPORTED, "70000x4"},
        {IBL_CONTAINER_KTX, 12, 5, IBL_ERR_FORMAT, "endianness"},
        {IBL_CONTAINER_KTX, 12, 0x01020304, IBL_ERR_UNSUPPORTED, "big endian"},
        {IBL_CONTAINER_KTX, 16, 0, IBL_ERR_UNSUPPORTED, "compressed"},
        {IBL_CONTAINER_KTX, 28, 0x8058, IBL_ERR_UNSUPPORTED, "0x8058"},
        {IBL_CONTAINER_KTX, 60, 1 << 20, IBL_ERR_FORMAT, "metadata"},
        {IBL_CONTAINER_DDS, 4, 100, IBL_ERR_FORMAT, "100"},
        {IBL_CONTAINER_DDS, 84, 0x31545844, IBL_ERR_UNSUPPORTED, "DXT1"},
        {IBL_CONTAINER_DDS, 80, 0x41, IBL_ERR_UNSUPPORTED, "integer"},
        {IBL_CONTAINER_DDS, 128, 98, IBL_ERR_UNSUPPORTED, "DXGI format 98"},
        {IBL_CONTAINER_DDS, 132, 4, IBL_ERR_UNSUPPORTED, "3D"},
        {IBL_CONTAINER_DDS, 140, 2, IBL_ERR_FORMAT, "cut short"},
        {IBL_CONTAINER_DDS, 140, 0, IBL_ERR_FORMAT, "no textures"},
    };
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 6), back;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, cases[i].container, &size);
        file_set_u32(b + cases[i].at, cases[i].value);
        kept.text[IBL_LOG_ERROR][0] = '\0';
        const ibl_status status =
            ibl_texture_decode(quiet, "NAME", b, size, &back, NULL);
        const char *text = kept.text[IBL_LOG_ERROR];
        CHECK_MSG(status == cases[i].status && strstr(text, cases[i].text) &&
                      !strncmp(text, "NAME: ", 6),
                  "case %zu: status %d: %s", i, (int)status, text);
        CHECK(!back.data && !back.keys);
    }
    CHECK(ibl_texture_decode(quiet, "NAME", "GIF89a", 6, &back, NULL) ==
          IBL_ERR_FORMAT);
}

/* Metadata that is no text, has no padding at the end, is there twice. */
TEST(odd_metadata)
{
    static const struct {
        const char *bytes;
        uint32_t size;
        ibl_status status;
        int keys;
        const char *value; /* of the key a, NULL: none */
    } cases[] = {
        {"\x04\0\0\0a\0b\0", 8, IBL_OK, 1, "b"},
        {"\x03\0\0\0a\0b", 7, IBL_OK, 1, "b"},   /* no zero, no padding */
        {"\x02\0\0\0a\0\0\0", 8, IBL_OK, 1, ""}, /* empty */
        {"\x06\0\0\0a\0\1\0\2\0\0\0", 12, IBL_OK, 0, NULL}, /* binary */
        {"\x04\0\0\0a\0\xFF\0", 8, IBL_OK, 0, NULL},
        {"\x04\0\0\0a\0b\0\x04\0\0\0a\0c\0", 16, IBL_ERR_FORMAT, 0, NULL},
        {"\x04\0\0\0abcd", 8, IBL_ERR_FORMAT, 0, NULL},  /* no end of the key */
        {"\x04\0\0\0\0bcd", 8, IBL_ERR_FORMAT, 0, NULL}, /* no key */
        {"\x05\0\0\0a\0b\0", 8, IBL_ERR_FORMAT, 0, NULL},
        {"\xFF\xFF\xFF\xFF"
         "a\0b\0",
         8, IBL_ERR_FORMAT, 0, NULL},
        {"\x01\0\0\0a\0\0\0", 8, IBL_ERR_FORMAT, 0, NULL},
        {"\x04\0\0", 3, IBL_ERR_FORMAT, 0, NULL},
    };
    ibl_texture tex = make(IBL_PIXEL_RGB9E5, 2, 2, 1, 1, 1), back;
    size_t size;
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        unsigned char *longer = test_alloc(1, size + cases[i].size);
        memcpy(longer, b, size);
        memcpy(longer + size, cases[i].bytes, cases[i].size);
        file_set_u32(longer + 56, (uint32_t)size);
        file_set_u32(longer + 60, cases[i].size);
        const ibl_status status = ibl_texture_decode(
            quiet, "odd", longer, size + cases[i].size, &back, NULL);
        CHECK_MSG(status == cases[i].status && back.key_count == cases[i].keys,
                  "case %zu: status %d, %d keys", i, (int)status,
                  back.key_count);
        CHECK(!cases[i].value || texture_has(&back, "a", cases[i].value));
        ibl_texture_free(&back);
    }
}

TEST(bad_arguments)
{
    const ibl_texture good = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 6);
    ibl_texture bad[8];
    void *bytes = NULL;
    size_t size;

    for (int i = 0; i < 8; i++)
        bad[i] = good;
    bad[0].width += 2;
    bad[1].height += 2;
    bad[2].levels += 2;
    bad[3].faces += 2;
    bad[4].layers += 2;
    bad[5].pixel = (ibl_pixel)100;
    bad[6].bytes--;
    bad[7].levels = 4; /* one more than there are, with bytes for it */
    bad[7].bytes = ibl_texture_offset(&bad[7], 4, 0);
    for (int i = 0; i < 8; i++)
        CHECK_MSG(ibl_texture_encode(quiet, &bad[i], IBL_CONTAINER_DDS, &bytes,
                                     &size) == IBL_ERR_ARGUMENT,
                  "%d", i);
    CHECK(ibl_texture_encode(quiet, &good, IBL_CONTAINER_COUNT, &bytes,
                             &size) == IBL_ERR_ARGUMENT);
    CHECK(!bytes);
}

TEST(files)
{
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 8, 8, 4, 1, 6), back;
    const char *path = file_path("t.dds");
    ibl_container found;
    size_t size;
    const void *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);

    CHECK(ibl_texture_read(quiet, path, &back, NULL) == IBL_ERR_IO);
    NEED(file_save(path, b, size));
    NEED(!ibl_texture_read(ctx, path, &back, &found));
    CHECK(found == IBL_CONTAINER_KTX && texture_same(&tex, &back));
    ibl_texture_free(&back);
    NEED(file_save(path, "text", 4));
    CHECK(ibl_texture_read(quiet, path, &back, NULL) == IBL_ERR_FORMAT);
    CHECK(test_said(&kept, "t.dds: not a texture"));
}

/* ---- arrays -------------------------------------------------------------- */

/* All but DDS with the legacy header, which comes last. */
#define OF_ARRAYS IBL_CONTAINER_DDS_LEGACY

/* Where a container says how many layers it has. */
static const size_t count_at[OF_ARRAYS] = {32, 48, 140};

TEST(offsets)
{
    /* Faces of 128, 32 and 8 bytes; levels of 3840, 960 and 240. */
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 4, 4, 3, 5, 6);
    CHECK(tex.bytes == 5040);
    CHECK(ibl_texture_offset(&tex, 0, 2) == 256);
    CHECK(ibl_texture_offset(&tex, 1, 0) == 3840);
    CHECK(ibl_texture_offset(&tex, 3, 0) == 5040);
    CHECK(ibl_texture_layer_offset(&tex, 0, 1, 0) == 768);
    CHECK(ibl_texture_layer_offset(&tex, 1, 2, 3) == 3840 + 15 * 32);
    CHECK(ibl_texture_layer_offset(&tex, 2, 4, 5) == 5032);
}

/* A texture written to a file has the bytes of its encoding. Takes tex. */
static void check_files(ibl_texture *tex, ibl_container container,
                        const void *bytes, size_t size)
{
    ibl_outputs *out;
    size_t told, got_size;
    NEED(!ibl_outputs_create(ctx, 0, &out));
    CHECK(!ibl_outputs_take_texture(out, file_path("taken"), tex, container,
                                    &told));
    CHECK(!tex->data && !ibl_outputs_commit(out));
    ibl_outputs_free(out);
    unsigned char *got = file_load(file_path("taken"), &got_size);
    CHECK(told == size && got_size == size && !memcmp(got, bytes, size));
}

static void round_trip(const int *s, ibl_pixel p, int layers, ibl_container c)
{
    ibl_texture tex = make(p, s[0], s[1], s[2], layers, s[3]), back;
    ibl_container found = IBL_CONTAINER_COUNT;
    size_t size, size_again;
    unsigned char *bytes = texture_encode(ctx, &tex, c, &size);
    NEED(!ibl_texture_decode(ctx, "x", bytes, size, &back, &found));
    CHECK(found == c && texture_same(&tex, &back));
    if (c == IBL_CONTAINER_DDS) {
        CHECK(!back.key_count);
    } else {
        CHECK(back.key_count == 3 && texture_has(&back, "zeta", "last") &&
              texture_has(&back, "iblRoughness", "0 0.25 0.5") &&
              texture_has(&back, "KTXwriter", "iblbake " IBL_VERSION));
        unsigned char *again = texture_encode(ctx, &back, c, &size_again);
        CHECK(size == size_again && !memcmp(bytes, again, size));
    }
    check_files(&back, c, bytes, size);
}

TEST(round_trips)
{
    static const int counts[] = {1, 2, 5};
    static const int shapes[][4] = {/* width, height, levels, faces */
                                    {1, 1, 1, 6},   {3, 3, 2, 6}, {8, 8, 4, 6},
                                    {17, 17, 5, 6}, {7, 3, 3, 1}, {1, 9, 4, 1},
                                    {16, 2, 1, 1}};
    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; i++)
        for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++)
            for (int n = 0; n < 3; n++)
                for (ibl_container c = 0; c < OF_ARRAYS; c++)
                    if (ibl_container_holds(c, p))
                        round_trip(shapes[i], p, counts[n], c);
}

/* One layer is written as no array, and an array of one is read as one layer:
 * in KTX its cube has another imageSize, or that of a cube alone. */
TEST(arrays_of_one)
{
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 6), back;
    for (ibl_container c = 0; c < OF_ARRAYS; c++) {
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, c, &size);
        CHECK(file_u32(b + count_at[c]) == (c == IBL_CONTAINER_DDS));
        file_set_u32(b + count_at[c], 1);
        if (c == IBL_CONTAINER_KTX) {
            CHECK(!ibl_texture_decode(quiet, "one", b, size, &back, NULL) &&
                  back.faces == 6 && back.layers == 1);
            ibl_texture_free(&back);
            unsigned char *level = b + 64 + file_u32(b + 60);
            CHECK(file_u32(level) == 128 && file_u32(level + 4 + 768) == 32);
            file_set_u32(level, 768);
            file_set_u32(level + 4 + 768, 192);
        }
        back = texture_decode(ctx, b, size);
        CHECK(texture_same(&tex, &back));
    }
}

/* Two layers of 3x2 RGB halves, whose rows of 18 bytes are padded to 20 in KTX,
 * and the first row is the lowest. */
TEST(ktx_turned_and_widened)
{
    enum {
        KEYS = 28,
        LEVEL = 80
    };
    unsigned char b[64 + KEYS + 4 + LEVEL] = "\xABKTX 11\xBB\r\n\x1A\n";
    static const uint32_t words[] = {
        0x04030201, 0x140B, 2, 0x1907, 0x881B, 0x1907, 3, 2, 0, 2, 1, 0, KEYS};
    ibl_texture tex;
    for (size_t i = 0; i < 13; i++)
        file_set_u32(b + 12 + 4 * i, words[i]);
    memcpy(b + 64, "\x17\0\0\0KTXorientation\0S=r,T=u\0", KEYS);
    unsigned char *level = b + 64 + KEYS;
    level[0] = LEVEL;
    for (int row = 0; row < 4; row++)
        for (int i = 0; i < 9; i++)
            level[4 + 20 * row + 2 * i] = (unsigned char)(9 * row + i + 1);
    tex = texture_decode(ctx, b, sizeof b);
    CHECK(tex.layers == 2 && tex.pixel == IBL_PIXEL_RGBA16F && tex.bytes == 96);
    for (int layer = 0; layer < 2; layer++)
        for (int y = 0; y < 2; y++)
            for (int x = 0; x < 3; x++) {
                const unsigned char *t = tex.data + 48 * layer + 24 * y + 8 * x;
                const int first = 18 * layer + 9 * (1 - y) + 3 * x + 1;
                CHECK(t[0] == first && t[2] == first + 1 && t[4] == first + 2 &&
                      t[7] == 0x3C);
            }
}

/* Together and apart again, also one layer at a time. */
TEST(build)
{
    ibl_texture one[3], layer, array, other;
    for (int i = 0; i < 3; i++) {
        char text[2] = {(char)('0' + i), '\0'};
        one[i] = texture_random(ctx, IBL_PIXEL_RGB9E5, (int[]){5, 5, 3, 6}, 1);
        for (size_t k = 0; k < one[i].bytes; k++)
            one[i].data[k] = (unsigned char)(one[i].data[k] + i);
        ibl_texture_set(ctx, &one[i], "which", text);
        if (i)
            ibl_texture_set(ctx, &one[i], "only", "some");
        texture_owned(one[i]);
    }
    one[1].premultiplied = 1;
    NEED(!ibl_texture_array_begin(ctx, &one[2], 3, &array));
    texture_owned(array);
    for (int i = 2; i >= 0; i--)
        CHECK(!ibl_texture_array_put(ctx, &array, i, &one[i]));
    CHECK(array.layers == 3 && array.bytes == 3 * one[0].bytes);
    CHECK(array.premultiplied && !array.key_count);
    for (int i = 0; i < 3; i++) {
        layer = texture_layer(ctx, &array, i);
        CHECK(texture_same(&layer, &one[i]));
    }
    layer = texture_layer(ctx, &one[0], 0);
    CHECK(texture_has(&layer, "zeta", "last"));
    CHECK(ibl_texture_array_put(quiet, &array, 3, &one[0]) == IBL_ERR_ARGUMENT);
    CHECK(said("layer 3 of an array: must be 0 to 2"));
    CHECK(ibl_texture_array_put(quiet, &array, 0, &array) == IBL_ERR_ARGUMENT);
    CHECK(said("must be one layer"));
    other = make(IBL_PIXEL_RGB9E5, 5, 5, 2, 1, 6);
    CHECK(ibl_texture_array_put(quiet, &array, 0, &other) == IBL_ERR_ARGUMENT);
    CHECK(said("layer 0 of an array: its texels"));
    CHECK(ibl_texture_array_begin(quiet, &one[0], IBL_MAX_LAYERS + 1, &other) ==
          IBL_ERR_ARGUMENT);
    CHECK(said("2049 layers: must be 1 to 2048") && !other.data);
}

TEST(unlike)
{
    ibl_texture a = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 6), two, out;
    ibl_texture other[6] = {make(IBL_PIXEL_RGB9E5, 4, 4, 2, 1, 6),
                            make(IBL_PIXEL_RGBA16F, 8, 8, 2, 1, 6),
                            make(IBL_PIXEL_RGBA16F, 4, 4, 1, 1, 6),
                            make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 1),
                            make(IBL_PIXEL_RGBA16F, 4, 3, 2, 1, 1),
                            make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 6)};
    other[5].bytes--;
    NEED(!ibl_texture_array_begin(ctx, &a, 2, &two));
    texture_owned(two);
    for (int i = 0; i < 6; i++) {
        CHECK(ibl_texture_array_put(quiet, &two, 1, &other[i]) ==
              IBL_ERR_ARGUMENT);
        CHECK(said(i == 5 ? "not a whole" : "layer 1 of an array"));
    }
    CHECK(ibl_texture_layer(quiet, &a, 1, &out) == IBL_ERR_ARGUMENT);
    CHECK(said("layer 1 of a texture: must be 0 to 0"));
    CHECK(ibl_texture_layer(quiet, &a, -1, &out) == IBL_ERR_ARGUMENT);
    CHECK(ibl_texture_layer(quiet, &other[5], 0, &out) == IBL_ERR_ARGUMENT);
    CHECK(!out.data);
}

/* The most layers, and one more. */
TEST(limits)
{
    ibl_texture tex = make(IBL_PIXEL_RGB9E5, 2, 2, 2, IBL_MAX_LAYERS, 6), out;
    for (ibl_container c = 0; c < OF_ARRAYS; c++) {
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, c, &size);
        out = texture_decode(ctx, b, size);
        CHECK(texture_same(&tex, &out));
        file_set_u32(b + count_at[c], IBL_MAX_LAYERS + 1);
        CHECK(ibl_texture_decode(quiet, "most", b, size, &out, NULL) ==
              IBL_ERR_UNSUPPORTED);
        CHECK(said("most: an array of 2049 layers: the limit is 2048"));
    }
    tex.layers++;
    tex.bytes += 120;
    void *bytes = NULL;
    size_t size;
    CHECK(ibl_texture_encode(quiet, &tex, IBL_CONTAINER_DDS, &bytes, &size) ==
          IBL_ERR_ARGUMENT);
    CHECK(said("2049 layers") && !bytes);
}

/* Counts that are not what the file has. */
TEST(counts)
{
    static const uint32_t lies[] = {
        0x80000000, 0xFFFFFFFF, 0x7FFFFFFF, 0x2AAAAAAB, 65537, 2049,
        2048,       4,          2,          1,          0};
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 3, 6), back;
    for (ibl_container c = 0; c < OF_ARRAYS; c++) {
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, c, &size);
        for (size_t i = 0; i < sizeof lies / sizeof lies[0]; i++) {
            file_set_u32(b + count_at[c], lies[i]);
            const ibl_status status =
                ibl_texture_decode(quiet, "lie", b, size, &back, NULL);
            /* A DDS file does not say how long it is. */
            const bool part =
                c == IBL_CONTAINER_DDS && (lies[i] == 1 || lies[i] == 2);
            const ibl_status want = part             ? IBL_OK
                                    : lies[i] > 2048 ? IBL_ERR_UNSUPPORTED
                                                     : IBL_ERR_FORMAT;
            CHECK_MSG(status == want, "%s, %u layers: status %d: %s",
                      ibl_container_name(c), lies[i], (int)status,
                      kept.text[IBL_LOG_ERROR]);
            CHECK(part == (back.data != NULL));
            if (lies[i] == 2048 || lies[i] == 4)
                CHECK(said("cut short"));
            ibl_texture_free(&back);
        }
    }
}

TEST(damaged)
{
    for (int i = 0; i < 2 * OF_ARRAYS; i++) {
        ibl_texture tex = make(IBL_PIXEL_R11G11B10F, 2, 2, 2, 1 + i % 2, 6);
        size_t size;
        unsigned char *b =
            texture_encode(ctx, &tex, (ibl_container)(i / 2), &size);
        texture_damage(quiet, b, size);
    }
}

/* Headers of the largest cubes and arrays, and nothing behind them. */
TEST(boundless)
{
    static const size_t places[][4] = {
        {20, 24, 40, 32}, {36, 40, 56, 48}, {16, 12, 28, 140}};
    static const uint32_t lies[] = {65536, 65536, 17, 2048};
    for (int i = 0; i < 2 * OF_ARRAYS; i++) {
        const int layers = 1 + i % 2;
        ibl_texture tex = make(IBL_PIXEL_RGBA32F, 4, 4, 1, layers, 6);
        size_t size;
        unsigned char *b =
            texture_encode(ctx, &tex, (ibl_container)(i / 2), &size);
        for (int k = 0; k < 2 + layers; k++)
            file_set_u32(b + places[i / 2][k], lies[k]);
        texture_boundless(quiet, b, size);
        CHECK(said("cut short"));
    }
}

/* What wants one cube or table says so, and what has no place for layers; of a
 * level of 6.4 GB, too large for an imageSize, texels are never read. */
TEST(refused_arrays)
{
    unsigned char byte;
    ibl_texture cubes = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 3, 6), layer;
    ibl_texture luts = make(IBL_PIXEL_RG16F, 4, 4, 1, 2, 1);
    const ibl_texture vast = {.pixel = IBL_PIXEL_RGBA32F,
                              .width = 1024,
                              .height = 1024,
                              .levels = 1,
                              .layers = 64,
                              .faces = 6,
                              .bytes = (size_t)384 << 24,
                              .data = &byte};
    ibl_cube cube;
    ibl_lut lut;
    void *bytes = NULL;
    size_t size;

    CHECK(ibl_texture_to_cube(quiet, &cubes, &cube) == IBL_ERR_ARGUMENT &&
          said("3 layers"));
    CHECK(ibl_texture_to_lut(quiet, &luts, &lut) == IBL_ERR_ARGUMENT &&
          said("2 layers"));
    layer = texture_layer(ctx, &cubes, 2);
    CHECK(!ibl_texture_to_cube(ctx, &layer, &cube));
    ibl_cube_free(&cube);
    CHECK(ibl_texture_encode(quiet, &cubes, IBL_CONTAINER_DDS_LEGACY, &bytes,
                             &size) == IBL_ERR_UNSUPPORTED &&
          said("no array of 3 layers"));
    CHECK(ibl_texture_encode(quiet, &vast, IBL_CONTAINER_KTX, &bytes, &size) ==
              IBL_ERR_UNSUPPORTED &&
          said("4 GiB") && !bytes);
}
