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
#include <unistd.h>

#include "files.h"
#include "ibl/sidecar.h"
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

static ibl_texture make(ibl_pixel pixel, int width, int height, int levels,
                        int faces)
{
    ibl_texture tex =
        texture_random(ctx, pixel, (int[]){width, height, levels, faces}, 1);
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
        if (ibl_pixel_channels(p) == 2) {
            CHECK(ibl_texture_from_cube(
                      quiet, &cube,
                      &(ibl_texel_options){.struct_size =
                                               sizeof(ibl_texel_options),
                                           .pixel = p,
                                           .overflow = IBL_OVERFLOW_CLIP},
                      &a, NULL) == IBL_ERR_ARGUMENT);
            continue;
        }
        NEED(!ibl_texture_from_cube(
            ctx, &cube,
            &(ibl_texel_options){.struct_size = sizeof(ibl_texel_options),
                                 .pixel = p,
                                 .overflow = IBL_OVERFLOW_CLIP},
            &a, &beyond_a));
        NEED(!ibl_texture_from_cube(
            one, &cube,
            &(ibl_texel_options){.struct_size = sizeof(ibl_texel_options),
                                 .pixel = p,
                                 .overflow = IBL_OVERFLOW_CLIP},
            &b, &beyond_b));
        CHECK(texture_same(&a, &b) && beyond_a.values == beyond_b.values);
        CHECK((beyond_a.values > 0) == (p != IBL_PIXEL_RGBA32F));
        NEED(!ibl_texture_to_cube(ctx, &a, &back));
        CHECK(back.size == 70 && back.levels == 5);
        /* The last texel of all, or the last block, which is the last face. */
        float last[3 * 16];
        unsigned char texel[16];
        const size_t n = (size_t)(ibl_pixel_block(p) * ibl_pixel_block(p));
        ibl_pixel_encode(p, cube.data + floats - 3 * n, n, texel);
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
    ibl_texture tex = make(IBL_PIXEL_RG16F, 4, 2, 1, 1);
    ibl_lut back;
    CHECK(ibl_texture_to_lut(quiet, &tex, &back) == IBL_ERR_ARGUMENT);
    CHECK(ibl_texture_from_lut(quiet, &lut, IBL_PIXEL_RGB9E5, &tex, NULL) ==
          IBL_ERR_ARGUMENT);
}

/* KTX 2.0, section 3: the header's words; 3.10: levels, smallest first. */
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
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        ibl_texture tex = make(p, 5, 5, 3, 6);
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        CHECK(!memcmp(b, "\xABKTX 20\xBB\r\n\x1A\n", 12));
        const uint32_t want[] = {
            formats[p][0], formats[p][1], 5, 5, 0, 0, 6, 3, 0};
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
            CHECK(file_u32(entry + 8) == 6 * ibl_texture_face_bytes(&tex, l));
            CHECK(file_u32(entry + 16) == file_u32(entry + 8));
            CHECK(!memcmp(b + at, tex.data + ibl_texture_offset(&tex, l, 0),
                          file_u32(entry + 8)));
            end = at + file_u32(entry + 8);
        }
        CHECK(end == size);
    }
}

/* Words of Khronos' own descriptor tool for these formats (KTX-Software,
 * dfdutils): block head, then samples of offset | bits - 1 | channel, lower
 * and upper. */
TEST(ktx2_descriptor)
{
    static const struct {
        int samples;
        uint32_t word[6][3];
        uint32_t model, edges; /* edges of a block, less one */
    } want[IBL_PIXEL_COUNT] = {
        {4,
         {{0xC00F0000, 0xBF800000, 0x3F800000},
          {0xC10F0010, 0xBF800000, 0x3F800000},
          {0xC20F0020, 0xBF800000, 0x3F800000},
          {0xCF0F0030, 0xBF800000, 0x3F800000}},
         1,
         0},
        {4,
         {{0xC01F0000, 0xBF800000, 0x3F800000},
          {0xC11F0020, 0xBF800000, 0x3F800000},
          {0xC21F0040, 0xBF800000, 0x3F800000},
          {0xCF1F0060, 0xBF800000, 0x3F800000}},
         1,
         0},
        {6,
         {{0x00080000, 0, 8448},
          {0x2004001B, 15, 31},
          {0x01080009, 0, 8448},
          {0x2104001B, 15, 31},
          {0x02080012, 0, 8448},
          {0x2204001B, 15, 31}},
         1,
         0},
        {3,
         {{0x800A0000, 0, 0x3F800000},
          {0x810A000B, 0, 0x3F800000},
          {0x82090016, 0, 0x3F800000}},
         1,
         0},
        {1, {{0x807F0000, 0, 0x3F800000}}, 133, 0x0303},
        {1, {{0x807F0000, 0, 0x3F800000}}, 167, 0x0303},
        {1, {{0xC07F0000, 0xBF800000, 0x3F800000}}, 162, 0x0303},
        {2,
         {{0xC00F0000, 0xBF800000, 0x3F800000},
          {0xC10F0010, 0xBF800000, 0x3F800000}},
         1,
         0},
        {2,
         {{0xC01F0000, 0xBF800000, 0x3F800000},
          {0xC11F0020, 0xBF800000, 0x3F800000}},
         1,
         0},
    };
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        ibl_texture tex = make(p, 2, 2, 1, 1);
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        const unsigned char *d = b + file_u32(b + 48);
        const uint32_t block = 24 + 16 * (uint32_t)want[p].samples;
        CHECK(file_u32(d) == block + 4 && file_u32(d + 4) == 0);
        CHECK(file_u32(d + 8) == (2 | block << 16) &&
              file_u32(d + 12) == (0x00010100 | want[p].model));
        CHECK(file_u32(d + 16) == want[p].edges &&
              file_u32(d + 20) == ibl_pixel_bytes(p) && file_u32(d + 24) == 0);
        for (int s = 0; s < want[p].samples; s++) {
            const unsigned char *at = d + 28 + 16 * s;
            CHECK(file_u32(at) == want[p].word[s][0] && file_u32(at + 4) == 0 &&
                  file_u32(at + 8) == want[p].word[s][1] &&
                  file_u32(at + 12) == want[p].word[s][2]);
        }
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
    ibl_texture tex = make(IBL_PIXEL_RGB9E5, 1, 1, 1, 6);
    size_t size;
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    CHECK_MSG(file_u32(b + 60) == sizeof want - 1, "%u b, not %zu",
              file_u32(b + 60), sizeof want - 1);
    CHECK(!memcmp(b + file_u32(b + 56), want, sizeof want - 1));
}

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
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        if (!ibl_container_holds(IBL_CONTAINER_KTX, p))
            continue;
        ibl_texture tex = make(p, 5, 5, 3, 6);
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
        const uint32_t want[] = {0x04030201, gl[p][0], gl[p][1],
                                 gl[p][2],   gl[p][3], gl[p][gl[p][4] ? 4 : 2],
                                 5,          5,        0,
                                 0,          6,        3};
        CHECK(!memcmp(b, "\xABKTX 11\xBB\r\n\x1A\n", 12));
        for (size_t i = 0; i < sizeof want / sizeof want[0]; i++)
            CHECK(file_u32(b + 12 + 4 * i) == want[i]);
        CHECK(!memcmp(b + 64, "\x17\0\0\0KTXorientation\0S=r,T=d\0\0", 28));
        size_t at = 64 + file_u32(b + 60);
        CHECK(at % 4 == 0);
        for (int l = 0; l < 3; l++) {
            const size_t face = ibl_texture_face_bytes(&tex, l);
            CHECK(file_u32(b + at) == face);
            CHECK(!memcmp(b + at + 4, tex.data + ibl_texture_offset(&tex, l, 0),
                          6 * face));
            at += 4 + 6 * face;
        }
        CHECK(at == size);
    }
}

TEST(dds_header)
{
    static const uint32_t dxgi[IBL_PIXEL_COUNT] = {
        [IBL_PIXEL_RGBA16F] = 10, [IBL_PIXEL_RGBA32F] = 2,
        [IBL_PIXEL_RGB9E5] = 67,  [IBL_PIXEL_R11G11B10F] = 26,
        [IBL_PIXEL_BC6H] = 95,    [IBL_PIXEL_RG16F] = 34,
        [IBL_PIXEL_RG32F] = 16};
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        if (!ibl_container_holds(IBL_CONTAINER_DDS, p))
            continue;
        const bool blocks = p == IBL_PIXEL_BC6H;
        ibl_texture tex = make(p, 5, 5, 3, 6);
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
              file_u32(b + 136) == 4 && file_u32(b + 140) == 1 &&
              file_u32(b + 144) == 0);
        const unsigned char *at = b + 148;
        for (int f = 0; f < 6; f++) {
            for (int l = 0; l < 3; l++) {
                const size_t face = ibl_texture_face_bytes(&tex, l);
                CHECK(!memcmp(at, tex.data + ibl_texture_offset(&tex, l, f),
                              face));
                at += face;
            }
        }
        CHECK(at == b + size);
    }
    ibl_texture flat = make(IBL_PIXEL_RG16F, 4, 4, 1, 1);
    size_t size;
    unsigned char *b = texture_encode(ctx, &flat, IBL_CONTAINER_DDS, &size);
    CHECK(file_u32(b + 8) == 0x100F && file_u32(b + 108) == 0x1000 &&
          !file_u32(b + 112) && !file_u32(b + 136));
}

/* The same without the DX10 header, and a number for its FourCC. */
TEST(dds_legacy_header)
{
    static const uint32_t d3d[IBL_PIXEL_COUNT] = {[IBL_PIXEL_RGBA16F] = 113,
                                                  [IBL_PIXEL_RGBA32F] = 116,
                                                  [IBL_PIXEL_RG16F] = 112,
                                                  [IBL_PIXEL_RG32F] = 115};
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        CHECK(ibl_container_holds(IBL_CONTAINER_DDS_LEGACY, p) == (d3d[p] > 0));
        if (!d3d[p])
            continue;
        const ibl_texture tex = make(p, 5, 5, 3, 6);
        ibl_container found;
        ibl_texture back;
        size_t size, more;
        unsigned char *b =
            texture_encode(ctx, &tex, IBL_CONTAINER_DDS_LEGACY, &size);
        unsigned char *a = texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &more);
        CHECK(size + 20 == more && file_u32(b + 84) == d3d[p]);
        file_set_u32(a + 84, d3d[p]);
        CHECK(!memcmp(a, b, 128) && !memcmp(a + 148, b + 128, size - 128));
        NEED(!ibl_texture_decode(ctx, "x", b, size, &back, &found));
        texture_owned(back);
        CHECK(found == IBL_CONTAINER_DDS_LEGACY && texture_same(&tex, &back));
        texture_damage(quiet, b, size);
    }
}

static void turn(unsigned char *p, size_t bytes, size_t word)
{
    for (size_t i = 0; i + word <= bytes; i += word) {
        for (size_t a = 0; a < word / 2; a++) {
            const unsigned char t = p[i + a];
            p[i + a] = p[i + word - 1 - a];
            p[i + word - 1 - a] = t;
        }
    }
}

/* A little-endian KTX file with every word turned round. */
static void turn_ktx(unsigned char *b, const ibl_texture *tex, size_t word)
{
    const size_t keys_end = 64 + file_u32(b + 60);
    turn(b + 12, 52, 4);
    for (size_t at = 64; at < keys_end;) {
        const size_t bytes = (file_u32(b + at) + 3) / 4 * 4;
        turn(b + at, 4, 4);
        at += 4 + bytes;
    }
    size_t at = keys_end;
    for (int l = 0; l < tex->levels; l++) {
        const size_t bytes =
            (size_t)tex->faces * ibl_texture_face_bytes(tex, l);
        turn(b + at, 4, 4);
        turn(b + at + 4, bytes, word);
        at += 4 + bytes;
    }
}

TEST(ktx_big_endian)
{
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        if (!ibl_container_holds(IBL_CONTAINER_KTX, p))
            continue;
        ibl_texture tex = make(p, 6, 6, 3, 6), back;
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
        turn_ktx(b, &tex, file_u32(b + 20));
        back = texture_decode(ctx, b, size);
        CHECK(texture_same(&tex, &back) && texture_has(&back, "zeta", "last"));
        if (ibl_pixel_block(p) > 1)
            continue;
        /* What is to be turned is not known of words of one byte. */
        file_set_u32(b + 20, 0x01000000);
        CHECK(ibl_texture_decode(quiet, "big", b, size, &back, NULL) ==
              IBL_ERR_FORMAT);
    }
}

/* Filament's cmgen writes the internal format as glType, a glTypeSize of 1. */
TEST(ktx_cmgen)
{
    ibl_texture tex = make(IBL_PIXEL_R11G11B10F, 4, 4, 3, 6), back;
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
    tex = make(IBL_PIXEL_RGBA16F, 4, 4, 3, 6);
    b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
    tex.filament = 1;
    f = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &other);
    CHECK(other == size && !memcmp(f, b, size));
}

/* A 3x2 KTX of RGB halves in either byte order; rows are padded to 20. */
TEST(ktx_rgb_halves)
{
    for (int big = 0; big < 2; big++) {
        unsigned char b[64 + 4 + 40] = "\xABKTX 11\xBB\r\n\x1A\n";
        const uint32_t words[] = {0x04030201, 0x140B, 2, 0x1907, 0x881B,
                                  0x1907,     3,      2, 0,      0,
                                  1,          0,      0, 40};
        ibl_texture tex;
        for (size_t i = 0; i < 14; i++)
            file_set_u32(b + 12 + 4 * i, words[i]);
        for (int y = 0; y < 2; y++) {
            for (int i = 0; i < 9; i++)
                b[68 + 20 * y + 2 * i] = (unsigned char)(9 * y + i + 1);
        }
        if (big) {
            turn(b + 12, 56, 4);
            turn(b + 68, 40, 2);
        }
        tex = texture_decode(ctx, b, sizeof b);
        CHECK(tex.pixel == IBL_PIXEL_RGBA16F && tex.bytes == 48 &&
              tex.levels == 1);
        for (int i = 0; i < 6; i++) {
            const unsigned char *t = tex.data + 8 * i;
            CHECK(t[0] == 3 * i + 1 && t[2] == 3 * i + 2 && t[4] == 3 * i + 3);
            CHECK(t[1] == 0 && t[6] == 0 && t[7] == 0x3C);
        }
    }
}

/* Ours with the format turned to R32G32B32_SFLOAT and as many b less. */
TEST(ktx2_rgb_floats)
{
    ibl_texture tex = make(IBL_PIXEL_RGBA32F, 3, 2, 1, 1), back;
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

/* DDS files of Direct3D 9, with a number for a FourCC. */
TEST(dds_direct3d9)
{
    static const struct {
        ibl_pixel pixel;
        uint32_t d3d;
    } formats[] = {{IBL_PIXEL_RGBA16F, 113},
                   {IBL_PIXEL_RGBA32F, 116},
                   {IBL_PIXEL_RG16F, 112},
                   {IBL_PIXEL_RG32F, 115}};
    for (size_t i = 0; i < 4; i++) {
        ibl_texture tex = make(formats[i].pixel, 4, 4, 3, 6), back;
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &size);
        file_set_u32(b + 84, formats[i].d3d);
        memmove(b + 128, b + 148, size - 148);
        file_set_u32(b + 24, 4); /* a depth that no flag tells of */
        back = texture_decode(ctx, b, size - 20);
        CHECK(texture_same(&tex, &back));
        b[10] |= 0x80; /* DDSD_DEPTH */
        CHECK(ibl_texture_decode(quiet, "d3d9", b, size - 20, &back, NULL) ==
              IBL_ERR_UNSUPPORTED);
        file_set_u32(b + 24, 1);
        back = texture_decode(ctx, b, size - 20);
        file_set_u32(b + 112, 0x0600); /* +X alone */
        CHECK(ibl_texture_decode(quiet, "d3d9", b, size - 20, &back, NULL) ==
              IBL_ERR_UNSUPPORTED);
    }
}

static void orientation(ibl_container container, const char *from,
                        const char *to)
{
    for (int faces = 1; faces <= 6; faces += 5) {
        ibl_texture tex = make(IBL_PIXEL_RG32F, 3, 3, 2, faces), back;
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
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 6), back;
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
    ibl_texture tex = make(IBL_PIXEL_RGB9E5, 2, 2, 1, 1), back;
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
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 6), bad;
    ibl_outputs *out;
    void *bytes = NULL;
    size_t size;
    const ibl_texture good = tex;
    for (int i = 0; i < 7; i++) {
        bad = good;
        *(i == 0   ? &bad.width
          : i == 1 ? &bad.height
          : i == 2 ? &bad.levels
          : i == 3 ? &bad.faces
          : i == 4 ? &bad.layers
                   : (int *)&bad.pixel) += i == 6 ? 100 : 2;
        CHECK(ibl_texture_encode(quiet, &bad, IBL_CONTAINER_KTX2, &bytes,
                                 &size) == IBL_ERR_ARGUMENT);
    }
    bad = good;
    bad.bytes--;
    CHECK(ibl_texture_encode(quiet, &bad, IBL_CONTAINER_DDS, &bytes, &size) ==
          IBL_ERR_ARGUMENT);
    /* A level more than there are, with bytes for it. */
    bad = good;
    bad.levels = 4;
    bad.bytes = ibl_texture_offset(&bad, bad.levels, 0);
    CHECK(ibl_texture_encode(quiet, &bad, IBL_CONTAINER_DDS, &bytes, &size) ==
          IBL_ERR_ARGUMENT);
    bad.bytes--;
    NEED(!ibl_outputs_create(quiet, &out));
    CHECK(ibl_outputs_add_texture(out, "x", &bad, IBL_CONTAINER_DDS, &size) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_outputs_add_texture(out, "/proc/x", &good, IBL_CONTAINER_DDS,
                                  &size) == IBL_ERR_IO);
    ibl_outputs_free(out);
    CHECK(ibl_texture_encode(quiet, &good, IBL_CONTAINER_COUNT, &bytes,
                             &size) == IBL_ERR_ARGUMENT);
    CHECK(!bytes);
}

TEST(files)
{
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 8, 8, 4, 6), back;
    const char *path = file_path("t.dds");
    ibl_container found;
    char pipe_path[40];
    size_t size;
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
    CHECK(ibl_texture_read(quiet, path, &back, NULL) == IBL_ERR_IO);
    CHECK(ibl_texture_read(quiet, test_dir(), &back, NULL) == IBL_ERR_IO);
    CHECK(test_said(&kept, "directory"));
    NEED(file_save(path, b, size));
    NEED(!ibl_texture_read(ctx, path, &back, &found));
    CHECK(found == IBL_CONTAINER_KTX && texture_same(&tex, &back));
    ibl_texture_free(&back);

    /* A pipe, as a shell makes one of <(command). */
    int ends[2];
    NEED(!pipe(ends));
    NEED(write(ends[1], b, size) == (ssize_t)size && !close(ends[1]));
    snprintf(pipe_path, sizeof pipe_path, "/dev/fd/%d", ends[0]);
    CHECK(!ibl_texture_read(ctx, pipe_path, &back, NULL) &&
          texture_same(&tex, &back));
    close(ends[0]);
    ibl_texture_free(&back);

    const int saved = dup(STDIN_FILENO);
    NEED(!pipe(ends));
    NEED(write(ends[1], "text", 4) == 4 && !close(ends[1]));
    dup2(ends[0], STDIN_FILENO);
    CHECK(ibl_texture_read(quiet, "-", &back, NULL) == IBL_ERR_FORMAT);
    CHECK(test_said(&kept, "standard input: not a texture"));
    dup2(saved, STDIN_FILENO);
    close(saved);
    close(ends[0]);
}

/* ---- what a texture holds ------------------------------------------------ */

/* All keys of a file that the program wrote are those of the library's. */
static void check_described(const ibl_sidecar_options *facts,
                            ibl_content content, const char *name)
{
    const ibl_sidecar_output output = {.struct_size = sizeof output,
                                       .content = content};
    ibl_texture file, described = {0}, *tex = &described;

    NEED(!ibl_texture_describe(ctx, tex, facts, &output));
    NEED(!ibl_texture_read(ctx, file_path(name), &file, NULL));
    CHECK(tex->key_count >= 2);
    for (int i = 0; i < tex->key_count; i++) {
        const char *had = ibl_texture_get(&file, tex->keys[i].key);
        CHECK_MSG(had && !strcmp(had, tex->keys[i].value),
                  "%s: %s is %s, not %s", name, tex->keys[i].key,
                  tex->keys[i].value, had ? had : "set");
    }
    for (int i = 0; i < file.key_count; i++) {
        const char *key = file.keys[i].key;
        CHECK_MSG(ibl_texture_get(tex, key) || strncmp(key, "iblbake.", 8),
                  "%s: the library sets no %s", name, key);
    }
    ibl_texture_free(&file);
    ibl_texture_free(tex);
}

TEST(described_as_by_the_program)
{
    ibl_specular_options o = ibl_specular_options_default();
    ibl_bake_result bake = {.irradiance_degree = 1};
    ibl_sidecar_options facts = ibl_sidecar_options_default();
    ibl_lobe_table_options table = ibl_lobe_table_options_default();
    ibl_image map;
    ibl_cube cube;
    char here[4096];

    NEED(getcwd(here, sizeof here));
    NEED(file_run("'%s' -q '%s/data/sky.exr' -o . --size 16 --samples 64 "
                  "--method sampled --roughness-range 0:0.9",
                  file_built("iblbake"), here));
    o.size = 16;
    o.samples = 64;
    o.method = IBL_METHOD_SAMPLED;
    o.roughness_max = 0.9;
    NEED(!ibl_image_read(ctx, "data/sky.exr", NULL, &map, NULL));
    NEED(!ibl_bake_specular_report(ctx, &map, &o, &cube, &bake.report));
    facts.specular = &o;
    facts.made = &bake;
    facts.lobe_table = &table;
    table.layout = bake.report.layout;
    check_described(&facts, IBL_CONTENT_SPECULAR, "sky_specular.ktx2");
    check_described(&facts, IBL_CONTENT_IRRADIANCE, "sky_irradiance.ktx2");
    check_described(&facts, IBL_CONTENT_LUT, "brdf_lut.ktx2");
    check_described(&facts, IBL_CONTENT_LOBE_TABLE, "sky_lobe_lut.ktx2");
    ibl_cube_free(&cube);
    ibl_image_free(&map);
}
