/* SPDX-License-Identifier: MIT */
/*
 * Arrays of textures. Where a layer's face is in memory and in each container
 * is written out here by hand, from the specifications: every face is filled
 * with a number of its own, and files are looked through for them.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "ibl/io.h"
#include "test.h"
#include "textures.h"

static ibl_ctx *ctx;   /* prints its errors */
static ibl_ctx *quiet; /* keeps them in kept */
static test_messages kept;

void test_setup(void)
{
    ctx = test_ctx(2, IBL_ISA_AUTO);
    quiet = test_keeping_ctx(1, &kept);
}

/* Where a container says how many layers it has. */
/* All but DDS with the legacy header, which comes last. */
#define OF_ARRAYS IBL_CONTAINER_DDS_LEGACY

static const size_t count_at[OF_ARRAYS] = {32, 48, 140};

static bool said(const char *words)
{
    return test_said(&kept, words);
}

static ibl_texture make(ibl_pixel pixel, int width, int height, int levels,
                        int layers, int faces)
{
    return texture_owned(texture_random(
        ctx, pixel, (int[]){width, height, levels, faces}, layers));
}

/* Every byte of a face is 100 * level + 10 * layer + face + 1. */
static ibl_texture make_numbered(ibl_pixel pixel, int size, int levels,
                                 int layers, int faces)
{
    ibl_texture tex = make(pixel, size, size, levels, layers, faces);
    unsigned char *at = tex.data;
    for (int l = 0; l < levels; l++)
        for (int layer = 0; layer < layers; layer++)
            for (int f = 0; f < faces; f++) {
                const size_t bytes = ibl_texture_face_bytes(&tex, l);
                memset(at, 100 * l + 10 * layer + f + 1, bytes);
                at += bytes;
            }
    return tex;
}

/* Whether the bytes are those of such a face, all of them. */
static bool numbered(const unsigned char *at, size_t bytes, int level,
                     int layer, int face)
{
    for (size_t i = 0; i < bytes; i++)
        if (at[i] != 100 * level + 10 * layer + face + 1)
            return false;
    return true;
}

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
    static const char *const names[] = {"lent", "taken"};
    ibl_outputs *out;
    size_t told[2] = {0};
    NEED(!ibl_outputs_create(ctx, &out));
    CHECK(!ibl_outputs_add_texture(out, file_path(names[0]), tex, container,
                                   &told[0]));
    CHECK(!ibl_outputs_take_texture(out, file_path(names[1]), tex, container,
                                    &told[1]));
    CHECK(!tex->data && !ibl_outputs_commit(out));
    ibl_outputs_free(out);
    for (int i = 0; i < 2; i++) {
        size_t got_size;
        unsigned char *got = file_load(file_path(names[i]), &got_size);
        CHECK(told[i] == size && got_size == size && !memcmp(got, bytes, size));
    }
}

static void round_trip(const int *s, ibl_pixel p, int layers, ibl_container c)
{
    ibl_texture tex = texture_random(ctx, p, s, layers), back;
    ibl_container found = IBL_CONTAINER_COUNT;
    size_t size, size_again;
    ibl_texture_set(ctx, &tex, "iblRoughness", "0 0.25 0.5");
    texture_owned(tex);
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

/* KTX 2.0: layerCount is 0 for no array; levels hold layers, layers faces. */
TEST(ktx2_structure)
{
    /* Faces of 2x2 and 1x1 texels of 4 bytes; 18 of them a level. */
    ibl_texture tex = make_numbered(IBL_PIXEL_RGB9E5, 2, 2, 3, 6);
    size_t size;
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
    CHECK(file_u32(b + 32) == 3 && file_u32(b + 36) == 6 &&
          file_u32(b + 40) == 2);
    CHECK(file_u32(b + 88) == 288 && file_u32(b + 96) == 288);
    CHECK(file_u32(b + 112) == 72 && file_u32(b + 120) == 72);
    CHECK(file_u32(b + 104) + 72 == file_u32(b + 80) &&
          file_u32(b + 80) + 288 == size);
    for (int layer = 0; layer < 3; layer++)
        for (int f = 0; f < 6; f++) {
            const int i = 6 * layer + f;
            CHECK(numbered(b + file_u32(b + 80) + 16 * i, 16, 0, layer, f));
            CHECK(numbered(b + file_u32(b + 104) + 4 * i, 4, 1, layer, f));
        }
}

/* KTX 1.1: imageSize is a face's if a cube is no array, else the level's. */
TEST(ktx_structure)
{
    ibl_texture tex = make_numbered(IBL_PIXEL_RGB9E5, 2, 2, 3, 6);
    size_t size;
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
    CHECK(file_u32(b + 44) == 0 && file_u32(b + 48) == 3 &&
          file_u32(b + 52) == 6 && file_u32(b + 56) == 2);
    const unsigned char *large = b + 64 + file_u32(b + 60);
    const unsigned char *small = large + 4 + 288;
    CHECK(file_u32(large) == 288 && file_u32(small) == 72 &&
          small + 76 == b + size);
    for (int layer = 0; layer < 3; layer++)
        for (int f = 0; f < 6; f++) {
            const int i = 6 * layer + f;
            CHECK(numbered(large + 4 + 16 * i, 16, 0, layer, f));
            CHECK(numbered(small + 4 + 4 * i, 4, 1, layer, f));
        }
}

/* DDS: arraySize counts cubes; layers hold faces, faces hold all levels. */
TEST(dds_structure)
{
    for (int faces = 1; faces <= 6; faces += 5) {
        ibl_texture tex = make_numbered(IBL_PIXEL_RGB9E5, 2, 2, 3, faces);
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &size);
        CHECK(file_u32(b + 132) == 3 &&
              file_u32(b + 136) == (faces == 6 ? 4 : 0) &&
              file_u32(b + 140) == 3);
        CHECK(file_u32(b + 108) == 0x401008 && file_u32(b + 28) == 2);
        const unsigned char *at = b + 148;
        for (int layer = 0; layer < 3; layer++)
            for (int f = 0; f < faces; f++, at += 20)
                CHECK(numbered(at, 16, 0, layer, f) &&
                      numbered(at + 16, 4, 1, layer, f));
        CHECK(at == b + size);
    }
    /* More than one surface, with neither levels nor faces. */
    ibl_texture flat = make(IBL_PIXEL_RG16F, 4, 4, 1, 2, 1);
    size_t size;
    unsigned char *b = texture_encode(ctx, &flat, IBL_CONTAINER_DDS, &size);
    CHECK(file_u32(b + 108) == 0x1008 && file_u32(b + 140) == 2);
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

/* Two layers of 3x2 RGB halves, whose rows of 18 bytes are padded to 20, in
 * big-endian KTX, and the first row is the lowest. */
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
        for (int k = 0; k < 4; k++)
            b[12 + 4 * i + (size_t)k] =
                (unsigned char)(words[i] >> (24 - 8 * k));
    memcpy(b + 64, "\0\0\0\x17KTXorientation\0S=r,T=u\0", KEYS);
    unsigned char *level = b + 64 + KEYS;
    level[3] = LEVEL;
    for (int row = 0; row < 4; row++)
        for (int i = 0; i < 9; i++)
            level[4 + 20 * row + 2 * i + 1] = (unsigned char)(9 * row + i + 1);
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

/* Together and apart again. */
TEST(build)
{
    ibl_texture one[3], whole, twice, layer;
    const ibl_texture *list[3] = {&one[0], &one[1], &one[2]};
    for (int i = 0; i < 3; i++) {
        char text[2] = {(char)('0' + i), '\0'};
        one[i] = texture_random(ctx, IBL_PIXEL_RGB9E5, (int[]){4, 4, 3, 6}, 1);
        for (size_t k = 0; k < one[i].bytes; k++)
            one[i].data[k] = (unsigned char)(one[i].data[k] + i);
        ibl_texture_set(ctx, &one[i], "which", text);
        if (i)
            ibl_texture_set(ctx, &one[i], "only", "some");
        texture_owned(one[i]);
    }
    whole = texture_array(ctx, list, 3);
    CHECK(whole.layers == 3 && whole.bytes == 3 * one[0].bytes);
    /* Faces of 64, 16 and 4 bytes. */
    CHECK(!memcmp(whole.data + 6 * 64, one[1].data, 6 * 64));
    CHECK(
        !memcmp(whole.data + 18 * 64 + 12 * 16, one[2].data + 6 * 64, 6 * 16));
    CHECK(!memcmp(whole.data + 18 * 80 + 12 * 4, one[2].data + 6 * 80, 6 * 4));
    CHECK(texture_has(&whole, "zeta", "last") && whole.key_count == 1);
    for (int i = 0; i < 3; i++) {
        layer = texture_layer(ctx, &whole, i);
        CHECK(texture_same(&layer, &one[i]) &&
              texture_has(&layer, "zeta", "last"));
    }
    /* Arrays one after the other. */
    const ibl_texture *more[3] = {&one[2], &whole, &one[0]};
    static const int order[5] = {2, 0, 1, 2, 0};
    twice = texture_array(ctx, more, 3);
    CHECK(twice.layers == 5);
    for (int i = 0; i < 5; i++) {
        layer = texture_layer(ctx, &twice, i);
        CHECK(texture_same(&layer, &one[order[i]]));
    }
}

/* One layer at a time. */
TEST(filled)
{
    ibl_texture one[3], whole, array, other;
    const ibl_texture *list[3] = {&one[0], &one[1], &one[2]};

    for (int i = 0; i < 3; i++) {
        one[i] = make(IBL_PIXEL_RGBA16F, 5, 5, 3, 1, 6);
        for (size_t k = 0; k < one[i].bytes; k++)
            one[i].data[k] = (unsigned char)(one[i].data[k] + i);
    }
    one[1].premultiplied = 1;
    whole = texture_array(ctx, list, 3);
    NEED(!ibl_texture_array_begin(ctx, &one[2], 3, &array));
    texture_owned(array);
    for (int i = 2; i >= 0; i--)
        CHECK(!ibl_texture_array_put(ctx, &array, i, &one[i]));
    CHECK(array.layers == 3 && array.premultiplied && !array.key_count);
    CHECK(array.bytes == whole.bytes &&
          !memcmp(array.data, whole.data, whole.bytes));
    CHECK(ibl_texture_array_put(quiet, &array, 3, &one[0]) == IBL_ERR_ARGUMENT);
    CHECK(said("layer 3 of an array: must be 0 to 2"));
    CHECK(ibl_texture_array_put(quiet, &array, 0, &whole) == IBL_ERR_ARGUMENT);
    CHECK(said("must be one layer"));
    other = make(IBL_PIXEL_RGBA16F, 5, 5, 2, 1, 6);
    CHECK(ibl_texture_array_put(quiet, &array, 0, &other) == IBL_ERR_ARGUMENT);
    CHECK(said("layer 0 of an array: its texels"));
    CHECK(ibl_texture_array_begin(quiet, &one[0], IBL_MAX_LAYERS + 1, &other) ==
          IBL_ERR_ARGUMENT);
    CHECK(said("2049 layers: must be 1 to 2048") && !other.data);
}

/* What visit gives, one after the other. */
typedef struct gathered {
    unsigned char *bytes;
    size_t size;
} gathered;

static void gather(void *cookie, const void *bytes, size_t size)
{
    gathered *g = cookie;

    g->bytes = realloc(g->bytes, g->size + size);
    if (!g->bytes)
        exit(1);
    memcpy(g->bytes + g->size, bytes, size);
    g->size += size;
}

TEST(visited)
{
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 4, 4, 3, 2, 6);

    for (int c = 0; c < 3; c++) {
        gathered g = {0};
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, c, &size);
        NEED(!ibl_texture_visit(ctx, &tex, (ibl_container)c, gather, &g));
        CHECK(g.size == size && !memcmp(g.bytes, b, size));
        free(g.bytes);
    }
    tex.bytes--;
    CHECK(ibl_texture_visit(quiet, &tex, IBL_CONTAINER_KTX2, gather, NULL) ==
          IBL_ERR_ARGUMENT);
}

TEST(unlike)
{
    ibl_texture a = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 6), out;
    ibl_texture other[6] = {make(IBL_PIXEL_RGB9E5, 4, 4, 2, 1, 6),
                            make(IBL_PIXEL_RGBA16F, 8, 8, 2, 1, 6),
                            make(IBL_PIXEL_RGBA16F, 4, 4, 1, 1, 6),
                            make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 1),
                            make(IBL_PIXEL_RGBA16F, 4, 3, 2, 1, 1),
                            make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 6)};
    other[5].bytes--;
    for (int i = 0; i < 6; i++) {
        const ibl_texture *list[3] = {&a, &other[i], &a};
        CHECK(ibl_texture_array(quiet, list, 3, &out) == IBL_ERR_ARGUMENT);
        CHECK(!out.data && said(i == 5 ? "not a whole" : "texture 1 of"));
    }
    const ibl_texture *list[1] = {&a};
    CHECK(ibl_texture_array(quiet, list, 0, &out) == IBL_ERR_ARGUMENT);
    CHECK(ibl_texture_layer(quiet, &a, 1, &out) == IBL_ERR_ARGUMENT);
    CHECK(said("layer 1 of a texture: must be 0 to 0"));
    CHECK(ibl_texture_layer(quiet, &a, -1, &out) == IBL_ERR_ARGUMENT);
    CHECK(ibl_texture_layer(quiet, &other[5], 0, &out) == IBL_ERR_ARGUMENT);
    CHECK(!out.data);
}

/* What wants one cube or table says so. */
TEST(not_single)
{
    ibl_texture cubes = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 3, 6), layer;
    ibl_texture luts = make(IBL_PIXEL_RG16F, 4, 4, 1, 2, 1);
    ibl_cube cube;
    ibl_lut lut;
    CHECK(ibl_texture_to_cube(quiet, &cubes, &cube) == IBL_ERR_ARGUMENT);
    CHECK(said("3 layers"));
    CHECK(ibl_texture_to_lut(quiet, &luts, &lut) == IBL_ERR_ARGUMENT);
    CHECK(said("2 layers"));
    layer = texture_layer(ctx, &cubes, 2);
    CHECK(!ibl_texture_to_cube(ctx, &layer, &cube));
    ibl_cube_free(&cube);
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
    const ibl_texture *list[2] = {&tex, &tex};
    CHECK(ibl_texture_array(quiet, list, 2, &out) == IBL_ERR_ARGUMENT);
    CHECK(said("4096 layers") && said("the limit is 2048") && !out.data);
    tex.layers++;
    tex.bytes += 120;
    void *bytes = NULL;
    size_t size;
    CHECK(ibl_texture_encode(quiet, &tex, IBL_CONTAINER_DDS, &bytes, &size) ==
          IBL_ERR_ARGUMENT);
    CHECK(said("2049 layers") && !bytes);
}

/* A level of 6.4 GB, too large for an imageSize; its texels are never read. */
TEST(ktx_too_large)
{
    unsigned char byte;
    const ibl_texture tex = {.pixel = IBL_PIXEL_RGBA32F,
                             .width = 1024,
                             .height = 1024,
                             .levels = 1,
                             .layers = 64,
                             .faces = 6,
                             .bytes = (size_t)384 << 24,
                             .data = &byte};
    void *bytes = NULL;
    size_t size;
    CHECK(ibl_texture_encode(quiet, &tex, IBL_CONTAINER_KTX, &bytes, &size) ==
          IBL_ERR_UNSUPPORTED);
    CHECK(said("4 GiB") && !bytes);
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
    size_t places[60];
    for (int i = 0; i < 2 * OF_ARRAYS; i++) {
        ibl_texture tex = make(IBL_PIXEL_R11G11B10F, 2, 2, 2, 1 + i % 2, 6);
        size_t size;
        unsigned char *b =
            texture_encode(ctx, &tex, (ibl_container)(i / 2), &size);
        texture_damage(quiet, b, size);
        for (size_t k = 0; k < 60; k++)
            places[k] = 12 + k * 4 % (size - 16);
        texture_damage_words(quiet, b, size, places, 60, 13);
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

/* The legacy header has no place for the number of layers. */
TEST(no_legacy_arrays)
{
    const ibl_texture tex = make(IBL_PIXEL_RGBA16F, 2, 2, 1, 2, 6);
    void *bytes;
    size_t size;

    CHECK(ibl_texture_encode(quiet, &tex, IBL_CONTAINER_DDS_LEGACY, &bytes,
                             &size) == IBL_ERR_UNSUPPORTED);
    CHECK(test_said(&kept, "no array of 2 layers"));
}
