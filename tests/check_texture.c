/* SPDX-License-Identifier: MIT */
/*
 * Textures in memory and in their containers. Truth: numbers from the
 * specifications, texels of random bytes that come back, libzstd, and files of
 * others that are put together here. check-readers.sh has other programs read
 * what is written, the fuzzers damage it.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

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

static ibl_texture make(ibl_pixel pixel, int width, int height, int levels,
                        int layers, int faces)
{
    ibl_texture tex = texture_random(
        ctx, pixel, (int[]){width, height, levels, faces}, layers);
    ibl_texture_set(ctx, &tex, "iblRoughness", "0 0.25 0.5");
    return texture_owned(tex);
}

/* Decodes what must be refused, in one line that begins with a name. */
static void check_refused(const void *bytes, size_t size, ibl_status status,
                          const char *words, const char *what)
{
    ibl_texture back;

    kept.text[IBL_LOG_ERROR][0] = '\0';
    const ibl_status got =
        ibl_texture_decode(quiet, "NAME", bytes, size, &back, NULL);
    CHECK_MSG(got == status && test_said(&kept, words) &&
                  !strncmp(kept.text[IBL_LOG_ERROR], "NAME: ", 6),
              "%s: status %d: %s", what, (int)got, kept.text[IBL_LOG_ERROR]);
    CHECK(!back.data && !back.keys);
}

/* ---- in memory ----------------------------------------------------------- */

TEST(keys)
{
    static const char *const bad[] = {"\x80",         "\xC0\xAF",
                                      "\xED\xA0\x80", "\xF5\x80\x80\x80",
                                      "\xE2\x82",     "\xFF"};
    char key[258];
    ibl_texture tex = {0};
    for (const char *k = "bcab"; *k; k++)
        CHECK(!ibl_texture_set(ctx, &tex, (char[]){*k, 0},
                               k[1] ? "1" : "\xC3\xA9t\xC3\xA9"));
    CHECK(tex.key_count == 3 && texture_has(&tex, "a", "1") &&
          texture_has(&tex, "b", "\xC3\xA9t\xC3\xA9") &&
          !strcmp(tex.keys[0].key, "a") && !strcmp(tex.keys[2].key, "c"));
    CHECK(!ibl_texture_get(&tex, "d") && !ibl_texture_get(&tex, ""));
    memset(key, 'k', sizeof key);
    key[256] = '\0';
    CHECK(ibl_texture_set(quiet, &tex, key, "") == IBL_ERR_ARGUMENT);
    key[255] = '\0';
    CHECK(!ibl_texture_set(quiet, &tex, key, ""));
    CHECK(ibl_texture_set(quiet, &tex, "", "v") == IBL_ERR_ARGUMENT);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        CHECK(ibl_texture_set(quiet, &tex, "x", bad[i]) == IBL_ERR_ARGUMENT);
    CHECK(tex.key_count == 4);
    ibl_texture_free(&tex);
    ibl_texture_free(&tex);
    ibl_texture_free(NULL);
}

/* Values over 30 octaves, many beyond halves; here and there what is no light.
 */
static ibl_cube make_cube(int size)
{
    test_random r = {(uint64_t)size};
    ibl_cube cube = cube_alloc(ctx, size, ilogb(size) + 1);
    for (size_t i = 0; i < cube_floats(&cube); i++)
        cube.data[i] = i % 41 == 40   ? -5
                       : i % 37 == 36 ? NAN
                                      : (float)ldexp(test_random_unit(&r),
                                                     (int)(i % 30) - 12);
    return cube;
}

/* The blocks of a face of a level, one after the other; texels beyond an edge
 * are the last ones. back: the other way. */
static void gather(float *face, int edge, int block, float *blocks, bool back)
{
    const int row = (edge + block - 1) / block, all = row * block;
    for (int y = 0; y < all; y++)
        for (int x = 0; x < all; x++) {
            const int texel =
                (y < edge ? y : edge - 1) * edge + (x < edge ? x : edge - 1);
            float *at =
                blocks +
                3 * (((y / block * row + x / block) * block + y % block) *
                         block +
                     x % block);
            if (!back)
                memcpy(at, face + 3 * texel, 3 * sizeof *at);
            else if (x < edge && y < edge)
                memcpy(face + 3 * texel, at, 3 * sizeof *at);
        }
}

/* Each texel or block is where it should be, and what encoding it alone gives;
 * what is beyond is counted once, though edges repeat it; by any threads and
 * instruction set. */
TEST(texels)
{
    static const int sizes[] = {1, 2, 3, 5, 9, 70};
    ibl_ctx *const one = test_ctx(1, IBL_ISA_C);
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        const int block = ibl_pixel_block(p);
        const ibl_texel_options o = {.pixel = p,
                                     .quality = IBL_QUALITY_NORMAL,
                                     .overflow = IBL_OVERFLOW_CLIP};
        for (int i = 0; i < (block > 1 ? 5 : 6); i++) {
            const ibl_cube cube = make_cube(sizes[i]);
            ibl_cube back, want = make_cube(sizes[i]);
            ibl_overflow_report beyond, other;
            ibl_texture a, b;
            ibl_lut lut;
            size_t count = 0, bytes = 0, above = 0;
            if (ibl_pixel_channels(p) == 2) {
                CHECK(ibl_texture_from_cube(quiet, &cube, &o, &a, NULL) ==
                      IBL_ERR_ARGUMENT);
                continue;
            }
            NEED(!ibl_texture_from_cube(ctx, &cube, &o, &a, &beyond));
            texture_owned(a);
            NEED(!ibl_texture_from_cube(one, &cube, &o, &b, &other));
            texture_owned(b);
            CHECK(texture_same(&a, &b) && beyond.values == other.values);
            NEED(!ibl_texture_to_cube(ctx, &a, &back));
            test_cube(back);
            for (int l = 0; l < 6 * cube.levels; l++) {
                const int edge = ibl_cube_edge(sizes[i], l / 6);
                const size_t row = (size_t)((edge + block - 1) / block);
                const size_t all = row * row * (size_t)(block * block);
                float *texel = test_alloc(3 * all, sizeof *texel);
                unsigned char *packed = test_alloc(16, all);
                gather(ibl_cube_face(&cube, l / 6, l % 6), edge, block, texel,
                       false);
                count += texels_encode(p, texel, all, packed);
                CHECK(!memcmp(packed,
                              a.data + ibl_texture_offset(&a, l / 6, l % 6),
                              row * row * ibl_pixel_bytes(p)));
                ibl_pixel_decode(p, packed, all, texel);
                gather(ibl_cube_face(&want, l / 6, l % 6), edge, block, texel,
                       true);
                bytes += row * row * ibl_pixel_bytes(p);
            }
            for (size_t k = 0; k < cube_floats(&cube); k++)
                above += cube.data[k] > ibl_pixel_max(p);
            CHECK(beyond.values == (block > 1 ? above : count) &&
                  (p == IBL_PIXEL_RGBA32F ? !count : count > 0 || i < 2));
            CHECK(a.bytes == bytes && back.size == sizes[i] &&
                  !memcmp(back.data, want.data,
                          cube_floats(&cube) * sizeof(float)));
            CHECK(ibl_texture_to_lut(quiet, &a, &lut) == IBL_ERR_ARGUMENT);
        }
    }
}

TEST(luts)
{
    float data[2 * 16] = {0, 1, 0.5f, 70000, 0.25f, -1};
    const ibl_lut lut = {4, data, IBL_LUT_SPLIT};
    ibl_texture tex;
    ibl_lut back;
    ibl_cube cube;
    size_t beyond;
    for (ibl_pixel p = IBL_PIXEL_RG16F; p <= IBL_PIXEL_RG32F; p++) {
        NEED(!ibl_texture_from_lut(ctx, &lut, p, &tex, &beyond));
        texture_owned(tex);
        CHECK(beyond == (p == IBL_PIXEL_RG16F));
        CHECK(tex.faces == 1 && tex.levels == 1 && tex.width == 4);
        NEED(!ibl_texture_to_lut(ctx, &tex, &back));
        CHECK(back.size == 4 && back.data[2] == 0.5f && back.data[5] == -1);
        CHECK(ibl_texture_to_cube(quiet, &tex, &cube) == IBL_ERR_ARGUMENT);
        free(back.data);
    }
    tex = make(IBL_PIXEL_RG16F, 4, 2, 1, 1, 1);
    CHECK(ibl_texture_to_lut(quiet, &tex, &back) == IBL_ERR_ARGUMENT);
    tex = make(IBL_PIXEL_RG16F, 4, 4, 1, 2, 1);
    CHECK(ibl_texture_to_lut(quiet, &tex, &back) == IBL_ERR_ARGUMENT &&
          test_said(&kept, "2 layers"));
    CHECK(ibl_texture_from_lut(quiet, &lut, IBL_PIXEL_RGB9E5, &tex, NULL) ==
          IBL_ERR_ARGUMENT);
}

/* Arrays: together and apart again, one layer at a time, last one first. */
TEST(build)
{
    ibl_texture one[3], layer, array, odd;
    for (int i = 0; i < 3; i++) {
        one[i] = make(IBL_PIXEL_RGB9E5, 5, 5, 3, 1, 6);
        one[i].data[0] = (unsigned char)i;
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
    odd = one[0];
    odd.bytes--;
    const struct {
        const ibl_texture of;
        int at;
        const char *words;
    } refused[] = {{one[0], 3, "layer 3 of an array: must be 0 to 2"},
                   {array, 0, "must be one layer"},
                   {odd, 0, "not a whole"},
                   {make(IBL_PIXEL_R11G11B10F, 5, 5, 3, 1, 6), 1, "layer 1 of"},
                   {make(IBL_PIXEL_RGB9E5, 8, 8, 3, 1, 6), 1, "layer 1 of"},
                   {make(IBL_PIXEL_RGB9E5, 5, 5, 2, 1, 6), 0, "its texels"},
                   {make(IBL_PIXEL_RGB9E5, 5, 5, 3, 1, 1), 1, "layer 1 of"},
                   {make(IBL_PIXEL_RGB9E5, 5, 4, 3, 1, 1), 1, "layer 1 of"}};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++)
        CHECK_MSG(ibl_texture_array_put(quiet, &array, refused[i].at,
                                        &refused[i].of) == IBL_ERR_ARGUMENT &&
                      test_said(&kept, refused[i].words),
                  "%zu: %s", i, kept.text[IBL_LOG_ERROR]);
    CHECK(ibl_texture_array_begin(quiet, &one[0], IBL_MAX_LAYERS + 1, &layer) ==
              IBL_ERR_ARGUMENT &&
          test_said(&kept, "2049 layers: must be 1 to 2048") && !layer.data);
    for (int at = -1; at < 2; at += 2)
        CHECK(ibl_texture_layer(quiet, &one[0], at, &layer) ==
              IBL_ERR_ARGUMENT);
    CHECK(ibl_texture_layer(quiet, &odd, 0, &layer) == IBL_ERR_ARGUMENT &&
          !layer.data);
}

/* ---- what is written ----------------------------------------------------- */

/* VkFormat (KTX 2.0, 12.) and size of its type; GL's type, format, internal
 * and base format; DXGI_FORMAT; FourCC as of Direct3D 9. 0: is not held. */
static const struct {
    uint32_t vk, size, gl[4], dxgi, d3d;
} format[IBL_PIXEL_COUNT] = {
    [IBL_PIXEL_RGBA16F] = {97, 2, {0x140B, 0x1908, 0x881A, 0x1908}, 10, 113},
    [IBL_PIXEL_RGBA32F] = {109, 4, {0x1406, 0x1908, 0x8814, 0x1908}, 2, 116},
    [IBL_PIXEL_RGB9E5] = {123, 4, {0x8C3E, 0x1907, 0x8C3D, 0x1907}, 67, 0},
    [IBL_PIXEL_R11G11B10F] = {122, 4, {0x8C3B, 0x1907, 0x8C3A, 0x1907}, 26, 0},
    [IBL_PIXEL_BC6H] = {143, 1, {0, 0, 0x8E8F, 0x1907}, 95, 0},
    [IBL_PIXEL_UASTC_HDR] = {1000066000, 1, {0}, 0, 0},
    [IBL_PIXEL_ASTC4X4HDR] = {1000066000, 1, {0, 0, 0x93B0, 0x1908}, 0, 0},
    [IBL_PIXEL_RG16F] = {83, 2, {0x140B, 0x8227, 0x822F, 0x8227}, 34, 112},
    [IBL_PIXEL_RG32F] = {103, 4, {0x1406, 0x8227, 0x8230, 0x8227}, 16, 115}};

static void check_words(const unsigned char *b, const uint32_t *want,
                        size_t count, ibl_container c, ibl_pixel p)
{
    for (size_t i = 0; i < count; i++)
        CHECK_MSG(file_u32(b + 4 * i) == want[i], "%s of %s: word %zu: %#x",
                  ibl_container_name(c), ibl_pixel_name(p), i,
                  file_u32(b + 4 * i));
}
#define WORDS(b, c, p, ...)                                                    \
    check_words(b, (const uint32_t[]){__VA_ARGS__},                            \
                sizeof(uint32_t[]){__VA_ARGS__} / 4, c, p)

/* Levels begin at multiples of their texels, smallest first, without gaps but
 * for zeroes (KTX 2.0, 3.9); are frames of Zstandard or the texels. */
static void check_ktx2(const ibl_texture *tex, const unsigned char *b,
                       size_t size)
{
    const uint32_t dfd = file_u32(b + 48), kvd = file_u32(b + 56);
    const size_t texel = tex->zstd ? 1 : ibl_pixel_bytes(tex->pixel);
    const size_t align = tex->zstd ? 1 : texel < 4 ? 4 : texel;
    size_t end = kvd + file_u32(b + 60);
    CHECK(dfd == 80 + 24 * (uint32_t)tex->levels &&
          file_u32(b + dfd) == file_u32(b + 52) &&
          kvd == dfd + file_u32(b + 52));
    for (int l = tex->levels - 1; l >= 0; l--) {
        const unsigned char *entry = b + 80 + 24 * l;
        const size_t at = file_u32(entry), packed = file_u32(entry + 8);
        const size_t bytes =
            ibl_texture_face_bytes(tex, l) * (size_t)(tex->layers * tex->faces);
        unsigned char *level = test_alloc(bytes, 1);
        CHECK(at % align == 0 && at >= end && at - end < align);
        for (; end < at; end++)
            CHECK(!b[end]);
        if (!tex->zstd)
            memcpy(level, b + at, bytes);
        else
            CHECK(ZSTD_getFrameContentSize(b + at, packed) == bytes &&
                  ZSTD_decompress(level, bytes, b + at, packed) == bytes);
        CHECK(file_u32(entry + 16) == bytes && (tex->zstd || packed == bytes) &&
              !memcmp(level, tex->data + ibl_texture_offset(tex, l, 0), bytes));
        end = at + packed;
    }
    CHECK(end == size);
}

TEST(headers)
{
    for (int n = 0; n < 2 * IBL_PIXEL_COUNT; n++) {
        const ibl_pixel p = (ibl_pixel)(n / 2);
        const bool blocks = p == IBL_PIXEL_BC6H;
        const uint32_t layers = n % 2 ? 3 : 1, many = layers / 3 * 3;
        const uint32_t vk = format[p].vk, *gl = format[p].gl;
        ibl_texture tex = make(p, 5, 5, 3, (int)layers, 6);
        const uint32_t held[IBL_CONTAINER_COUNT] = {
            [IBL_CONTAINER_KTX2] = vk,
            [IBL_CONTAINER_KTX] = gl[2],
            [IBL_CONTAINER_DDS] = format[p].dxgi,
            [IBL_CONTAINER_DDS_LEGACY] = format[p].d3d};
        for (ibl_container c = 0; c < IBL_CONTAINER_COUNT; c++) {
            void *bytes = NULL;
            size_t size, more;
            const bool here =
                held[c] && (c != IBL_CONTAINER_DDS_LEGACY || layers == 1);
            CHECK(ibl_container_holds(c, p) == (held[c] > 0));
            if (!here) {
                CHECK(ibl_texture_encode(quiet, &tex, c, &bytes, &size) ==
                          IBL_ERR_UNSUPPORTED &&
                      !bytes &&
                      test_said(&kept, held[c] ? "no array of 3 layers"
                                               : ibl_pixel_name(p)));
                continue;
            }
            unsigned char *b = texture_encode(ctx, &tex, c, &size);
            if (c == IBL_CONTAINER_KTX2) {
                CHECK(!memcmp(b, "\xABKTX 20\xBB\r\n\x1A\n", 12));
                WORDS(b + 12, c, p, vk, format[p].size, 5, 5, 0, many, 6, 3, 0);
                WORDS(b + 64, c, p, 0, 0, 0, 0);
                check_ktx2(&tex, b, size);
            } else if (c == IBL_CONTAINER_KTX) {
                /* imageSize is a face's if a cube is no array. */
                CHECK(!memcmp(b, "\xABKTX 11\xBB\r\n\x1A\n", 12));
                WORDS(b + 12, c, p, 0x04030201, gl[0], format[p].size, gl[1],
                      gl[2], gl[3], 5, 5, 0, many, 6, 3);
                CHECK(!memcmp(b + 64, "\x17\0\0\0KTXorientation\0S=r,T=d\0\0",
                              28));
                WORDS(b + 64 + file_u32(b + 60), c, p,
                      (uint32_t)ibl_texture_face_bytes(&tex, 0) *
                          (many ? 18 : 1));
                CHECK(size == 64 + file_u32(b + 60) + 12 + tex.bytes);
            } else if (c == IBL_CONTAINER_DDS) {
                CHECK(!memcmp(b, "DDS \x7C\0\0\0", 8));
                WORDS(b + 8, c, p, blocks ? 0xA1007 : 0x2100F, 5, 5,
                      blocks ? 64 : 5 * (uint32_t)ibl_pixel_bytes(p), 0, 3);
                CHECK(!memcmp(b + 76, "\x20\0\0\0\x04\0\0\0DX10", 12));
                WORDS(b + 108, c, p, 0x401008, 0xFE00, 0, 0, 0, held[c], 3, 4,
                      layers, 0);
                CHECK(size == 148 + tex.bytes);
            } else { /* all but the DX10 header, and another FourCC */
                unsigned char *a =
                    texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &more);
                file_set_u32(a + 84, held[c]);
                CHECK(size + 20 == more && !memcmp(a, b, 128) &&
                      !memcmp(a + 148, b + 128, size - 128));
            }
        }
    }
    /* More than one surface, with neither levels nor faces. */
    for (uint32_t layers = 1; layers <= 2; layers++) {
        ibl_texture flat = make(IBL_PIXEL_RG16F, 4, 4, 1, (int)layers, 1);
        size_t size;
        unsigned char *b = texture_encode(ctx, &flat, IBL_CONTAINER_DDS, &size);
        WORDS(b + 8, IBL_CONTAINER_DDS, flat.pixel, 0x100F);
        WORDS(b + 108, IBL_CONTAINER_DDS, flat.pixel,
              layers > 1 ? 0x1008 : 0x1000, 0, 0, 0, 0, 34, 3, 0, layers);
    }
}

/* Memory, files, and what was read is written the same. */
static void round_trip(ibl_texture *tex, ibl_container c)
{
    const bool keys = c < IBL_CONTAINER_DDS;
    ibl_texture back;
    ibl_container found = IBL_CONTAINER_COUNT;
    ibl_outputs *out;
    size_t size, told, again;
    unsigned char *bytes = texture_encode(ctx, tex, c, &size);
    if (c == IBL_CONTAINER_KTX2)
        check_ktx2(tex, bytes, size);
    NEED(!ibl_texture_decode(ctx, "x", bytes, size, &back, &found));
    CHECK(found == c && texture_same(tex, &back) && !back.zstd);
    CHECK(back.key_count == 3 * keys &&
          (!keys || (texture_has(&back, "zeta", "last") &&
                     texture_has(&back, "iblRoughness", "0 0.25 0.5") &&
                     texture_has(&back, "KTXwriter", "iblbake " IBL_VERSION))));
    back.zstd = tex->zstd;
    NEED(!ibl_outputs_create(ctx, 0, &out));
    CHECK(!ibl_outputs_take_texture(out, file_path("taken"), &back, c, &told));
    CHECK(!back.data && !ibl_outputs_commit(out));
    ibl_outputs_free(out);
    const unsigned char *file = file_load(file_path("taken"), &again);
    CHECK(told == size && again == size &&
          (keys || !memcmp(file, bytes, size)));
    NEED(!ibl_texture_read(ctx, file_path("taken"), &back, &found));
    texture_owned(back);
    CHECK(found == c && texture_same(tex, &back));
}

TEST(round_trips)
{
    static const int counts[] = {1, 2, 5};
    static const int shapes[][4] = {/* width, height, levels, faces */
                                    {1, 1, 1, 6},   {3, 3, 2, 6}, {8, 8, 4, 6},
                                    {17, 17, 5, 6}, {7, 3, 3, 1}, {1, 9, 4, 1},
                                    {16, 2, 1, 1}};
    for (size_t i = 0; i < 3 * sizeof shapes / sizeof *shapes; i++)
        for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++)
            for (int n = 0; n <= IBL_CONTAINER_COUNT; n++) {
                const int *s = shapes[i / 3], layers = counts[i % 3];
                const ibl_container c =
                    (ibl_container)(n % IBL_CONTAINER_COUNT);
                ibl_texture tex = make(p, s[0], s[1], s[2], layers, s[3]);
                tex.zstd = n == IBL_CONTAINER_COUNT ? 1 + (int)p * 2 : 0;
                if (ibl_container_holds(c, p) &&
                    (c != IBL_CONTAINER_DDS_LEGACY || layers == 1))
                    round_trip(&tex, c);
            }
    /* Of one value, more than a chunk, by any threads. */
    ibl_texture tex = make(IBL_PIXEL_RGBA16F, 300, 300, 3, 1, 1);
    size_t size, other;
    memset(tex.data, 7, tex.bytes / 2);
    for (tex.zstd = 1; tex.zstd <= IBL_MAX_ZSTD; tex.zstd += 21) {
        const void *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        const void *c = texture_encode(test_ctx(7, IBL_ISA_C), &tex,
                                       IBL_CONTAINER_KTX2, &other);
        CHECK(size == other && !memcmp(b, c, size));
        CHECK(size > tex.bytes / 2 && size < tex.bytes * 55 / 100);
        check_ktx2(&tex, b, size);
    }
}

/* What is no texture, or none for a container. Of a level of 6.4 GB, too large
 * for an imageSize, texels are never read. */
TEST(not_written)
{
    const ibl_texture good = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 1, 6);
    ibl_texture bad[11], cubes = make(IBL_PIXEL_RGBA16F, 4, 4, 2, 3, 6);
    unsigned char byte;
    ibl_cube cube;
    void *bytes = NULL;
    size_t size;

    for (int i = 0; i < 11; i++)
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
    bad[8].layers = IBL_MAX_LAYERS + 1;
    bad[8].bytes *= IBL_MAX_LAYERS + 1;
    bad[9].zstd = -1;
    bad[10].zstd = IBL_MAX_ZSTD + 1;
    for (int i = 0; i < 11; i++)
        CHECK_MSG(ibl_texture_encode(quiet, &bad[i], IBL_CONTAINER_KTX2, &bytes,
                                     &size) == IBL_ERR_ARGUMENT,
                  "%d", i);
    bad[9].zstd = 5;
    for (ibl_container c = IBL_CONTAINER_KTX; c < IBL_CONTAINER_COUNT; c++)
        CHECK(ibl_texture_encode(quiet, &bad[9], c, &bytes, &size) ==
                  IBL_ERR_ARGUMENT &&
              test_said(&kept, "Zstandard"));
    CHECK(ibl_texture_encode(quiet, &good, IBL_CONTAINER_COUNT, &bytes,
                             &size) == IBL_ERR_ARGUMENT);
    CHECK(ibl_texture_to_cube(quiet, &cubes, &cube) == IBL_ERR_ARGUMENT &&
          test_said(&kept, "3 layers"));
    bad[0] = (ibl_texture){.pixel = IBL_PIXEL_RGBA32F,
                           .width = 1024,
                           .height = 1024,
                           .levels = 1,
                           .layers = 64,
                           .faces = 6,
                           .bytes = (size_t)384 << 24,
                           .data = &byte};
    CHECK(ibl_texture_encode(quiet, &bad[0], IBL_CONTAINER_KTX, &bytes,
                             &size) == IBL_ERR_UNSUPPORTED &&
          test_said(&kept, "4 GiB") && !bytes);
}

/* ---- files of others ----------------------------------------------------- */

/* R32G32B32_SFLOAT, as it is and by Zstandard: of four channels one is 1. */
TEST(ktx2_rgb_floats)
{
    for (int zstd = 0; zstd < 2; zstd++) {
        ibl_texture tex = make(IBL_PIXEL_RGBA32F, 3, 2, 1, 1, 1), back;
        unsigned char b[1024];
        size_t size;
        const void *file = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        NEED(size + 96 < sizeof b);
        memcpy(b, file, size);
        const size_t at = file_u32(b + 80);
        file_set_u32(b + 12, 106);
        file_set_u32(b + 88, 72);
        check_refused(b, size, IBL_ERR_FORMAT, "", "96 uncompressed");
        file_set_u32(b + 96, 72);
        b[file_u32(b + 48) + 15] = 1; /* multiplied by an alpha that is not */
        if (zstd) {
            size = ZSTD_compress(b + at, sizeof b - at, tex.data, 72, 3);
            file_set_u32(b + 44, 2);
            file_set_u32(b + 88, (uint32_t)size);
        }
        back = texture_decode(ctx, b, at + file_u32(b + 88));
        CHECK(back.pixel == IBL_PIXEL_RGBA32F && back.bytes == 96);
        CHECK(!back.premultiplied);
        for (int i = 0; i < 6; i++)
            CHECK(!memcmp(back.data + 16 * i, tex.data + 12 * i, 12) &&
                  file_u32(back.data + 16 * i + 12) == 0x3F800000);
    }
}

/* Rows of flat textures are turned over, but not inside of blocks. */
TEST(bottom_up)
{
    static const struct {
        ibl_container container;
        const char *from, *to;
        ibl_pixel pixel;
        int faces;
    } cases[] = {{IBL_CONTAINER_KTX2, "rd", "ru", IBL_PIXEL_RG32F, 1},
                 {IBL_CONTAINER_KTX2, "rd", "ru", IBL_PIXEL_RG32F, 6},
                 {IBL_CONTAINER_KTX, "T=d", "T=u", IBL_PIXEL_RG32F, 1},
                 {IBL_CONTAINER_KTX, "T=d", "T=u", IBL_PIXEL_RG32F, 6},
                 {IBL_CONTAINER_KTX, "T=d", "T=u", IBL_PIXEL_BC6H, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ibl_texture tex = make(cases[i].pixel, 3, 3, 2, 1, cases[i].faces);
        size_t size, at = 0;
        unsigned char *b = texture_encode(ctx, &tex, cases[i].container, &size);
        while (memcmp(b + at, cases[i].from, strlen(cases[i].from)))
            at++;
        memcpy(b + at, cases[i].to, strlen(cases[i].to));
        if (cases[i].faces == 6 || cases[i].pixel == IBL_PIXEL_BC6H) {
            check_refused(b, size, IBL_ERR_UNSUPPORTED, "", cases[i].to);
            continue;
        }
        const ibl_texture back = texture_decode(ctx, b, size);
        CHECK(!ibl_texture_get(&back, "KTXorientation"));
        for (size_t y = 0; y < 3; y++)
            CHECK(!memcmp(tex.data + 24 * y, back.data + 24 * (2 - y), 24));
        CHECK(!memcmp(tex.data + 72, back.data + 72, 8));
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

/* ---- what is read or not ------------------------------------------------- */

enum {
    KTX2 = IBL_CONTAINER_KTX2,
    KTX = IBL_CONTAINER_KTX,
    BEHIND = 1 << 16, /* the keys of KTX */
    DDS = IBL_CONTAINER_DDS,
    D3D9 = IBL_CONTAINER_DDS_LEGACY,
    BAD = IBL_ERR_FORMAT,
    OTHER = IBL_ERR_UNSUPPORTED
};

/* Words of the header of a cube of 4x4 RGBA16F, 2 levels; what is read as it is
 * though we write it otherwise, and what the refusal of the others says. */
TEST(words)
{
    static const struct {
        int container, layers;
        size_t at[3];
        uint32_t value[3];
        int status;
        const char *text;
    } cases[] = {
        /* arrays of one; of KTX its cube has another imageSize, or not */
        {KTX2, 1, {32}, {1}, IBL_OK, ""},
        {KTX, 1, {48}, {1}, IBL_OK, ""},
        {KTX, 1, {48, BEHIND, BEHIND + 772}, {1, 768, 192}, IBL_OK, ""},
        {D3D9, 1, {24}, {4}, IBL_OK, ""}, /* a depth that no flag tells of */
        {KTX2, 1, {12}, {37}, OTHER, "VkFormat 37"},
        {KTX2, 1, {16}, {1}, BAD, "typeSize 1"},
        {KTX2, 1, {44}, {3}, OTHER, "ZLIB"},
        {KTX2, 1, {44}, {2}, BAD, "Zstandard"},
        {KTX2, 1, {44}, {1}, OTHER, "BasisLZ"},
        {KTX2, 1, {28}, {4}, OTHER, "3D"},
        {KTX2, 1, {24}, {0}, OTHER, "1D"},
        {KTX2, 1, {24}, {3}, BAD, "square"},
        {KTX2, 1, {36}, {5}, BAD, "5 faces"},
        {KTX2, 1, {40}, {9}, BAD, "9 levels"},
        {KTX2, 1, {20}, {70000}, OTHER, "70000x4"},
        {KTX, 1, {12}, {5}, BAD, "endianness"},
        {KTX, 1, {12}, {0x01020304}, OTHER, "big endian"},
        {KTX, 1, {16}, {0}, OTHER, "compressed"},
        {KTX, 1, {28}, {0x8058}, OTHER, "0x8058"},
        {KTX, 1, {60}, {1 << 20}, BAD, "metadata"},
        {DDS, 1, {4}, {100}, BAD, "100"},
        {DDS, 1, {84}, {0x31545844}, OTHER, "DXT1"},
        {DDS, 1, {80}, {0x41}, OTHER, "integer"},
        {DDS, 1, {128}, {98}, OTHER, "DXGI format 98"},
        {DDS, 1, {132}, {4}, OTHER, "3D"},
        {DDS, 1, {140}, {0}, BAD, "no textures"},
        {D3D9, 1, {8, 24}, {0x82100F, 4}, OTHER, "3D"},
        {D3D9, 1, {112}, {0x0600}, OTHER, "faces"},
        /* layers: sums and products of them overflow */
        {KTX2, 1, {32}, {3}, BAD, "cut short"},
        {KTX2, 3, {32}, {0}, BAD, ""},
        {KTX2, 3, {32}, {2048}, BAD, "cut short"},
        {KTX2, 3, {32}, {0x2AAAAAAB}, OTHER, "the limit is 2048"},
        {KTX2, 3, {32}, {0xFFFFFFFF}, OTHER, "the limit is 2048"},
        {KTX, 3, {48}, {4}, BAD, "cut short"},
        {KTX, 3, {48}, {2}, BAD, ""},
        {KTX, 3, {48}, {1}, BAD, ""},
        {KTX, 3, {48}, {0x80000000}, OTHER, "the limit is 2048"},
        {DDS, 3, {140}, {4}, BAD, "cut short"},
        {DDS, 3, {140}, {2049}, OTHER, "the limit is 2048"},
        {DDS, 3, {140}, {0x2AAAAAAB}, OTHER, "the limit is 2048"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ibl_texture tex = make(IBL_PIXEL_RGBA16F, 4, 4, 2, cases[i].layers, 6);
        ibl_container found;
        ibl_texture back;
        size_t size;
        unsigned char *b =
            texture_encode(ctx, &tex, (ibl_container)cases[i].container, &size);
        for (int k = 0; k < 3 && cases[i].at[k]; k++)
            file_set_u32(
                b + cases[i].at[k] % BEHIND +
                    (cases[i].at[k] < BEHIND ? 0 : 64 + file_u32(b + 60)),
                cases[i].value[k]);
        if (cases[i].status) {
            check_refused(b, size, (ibl_status)cases[i].status, cases[i].text,
                          test_text("case %zu", i));
            continue;
        }
        CHECK_MSG(!ibl_texture_decode(ctx, "x", b, size, &back, &found) &&
                      (int)found == cases[i].container &&
                      texture_same(&tex, &back),
                  "case %zu", i);
        ibl_texture_free(&back);
    }
    ibl_texture back;
    const char *path = file_path("t.dds");
    CHECK(ibl_texture_read(quiet, path, &back, NULL) == IBL_ERR_IO);
    NEED(file_save(path, "GIF89a", 6));
    CHECK(ibl_texture_read(quiet, path, &back, NULL) == IBL_ERR_FORMAT &&
          test_said(&kept, "t.dds: not a texture"));
}

/* Filament's cmgen has the internal format as glType, of size 1; so does ours
 * on demand, where cmgen has such a format. */
TEST(cmgen)
{
    for (int i = 0; i < 2; i++) {
        ibl_texture tex =
            make(i ? IBL_PIXEL_RGBA16F : IBL_PIXEL_R11G11B10F, 4, 4, 3, 1, 6);
        size_t size, other;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
        tex.filament = 1;
        unsigned char *f = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &other);
        file_set_u32(b + 16, i ? file_u32(b + 16) : 0x8C3A);
        file_set_u32(b + 20, i ? file_u32(b + 20) : 1);
        const ibl_texture back = texture_decode(ctx, b, size);
        CHECK(texture_same(&tex, &back));
        file_set_u32(b + 32, i ? file_u32(b + 32) : 0x8C3A);
        CHECK(other == size && !memcmp(f, b, size));
    }
}

/* Cut everywhere, and each byte changed. */
TEST(damaged)
{
    static const struct {
        ibl_pixel pixel;
        int layers, zstd;
    } cases[] = {{IBL_PIXEL_R11G11B10F, 1, 0},
                 {IBL_PIXEL_R11G11B10F, 2, 0},
                 {IBL_PIXEL_BC6H, 1, 0},
                 {IBL_PIXEL_R11G11B10F, 1, 19},
                 {IBL_PIXEL_RG16F, 1, 0}};
    for (int i = 0; i < 5 * IBL_CONTAINER_COUNT; i++) {
        const ibl_container c = (ibl_container)(i % IBL_CONTAINER_COUNT);
        const int n = i / IBL_CONTAINER_COUNT;
        ibl_texture tex = make(cases[n].pixel, 2, 2, 2, cases[n].layers, 6);
        size_t size;
        if ((tex.zstd = cases[n].zstd))
            memset(tex.data + 10, 0, tex.bytes - 20);
        if (!ibl_container_holds(c, tex.pixel) ||
            (tex.zstd && c != IBL_CONTAINER_KTX2))
            continue;
        unsigned char *b = texture_encode(ctx, &tex, c, &size);
        texture_damage(quiet, b, size);
    }
}

/* Headers of the largest cubes and arrays, and nothing behind them: refused
 * before memory is taken, which there is not. */
TEST(boundless)
{
    static const size_t places[][4] = {
        {20, 24, 40, 32}, {36, 40, 56, 48}, {16, 12, 28, 140}};
    static const uint32_t lies[] = {65536, 65536, 17, 2048};
    for (int i = 0; i < 6; i++) {
        const int layers = 1 + i % 2;
        ibl_texture tex = make(IBL_PIXEL_RGBA32F, 4, 4, 1, layers, 6);
        size_t size;
        unsigned char *b =
            texture_encode(ctx, &tex, (ibl_container)(i / 2), &size);
        for (int k = 0; k < 2 + layers; k++)
            file_set_u32(b + places[i / 2][k], lies[k]);
        check_refused(b, size, IBL_ERR_FORMAT, "cut short", "header");
    }
}

/* ---- Zstandard of others ------------------------------------------------- */

/* The file of tex, which has one level, with these bytes as its level. */
static unsigned char *splice(const ibl_texture *tex, const void *level,
                             size_t bytes, size_t *size)
{
    const unsigned char *b = texture_encode(ctx, tex, IBL_CONTAINER_KTX2, size);
    const size_t at = *size - tex->bytes;
    unsigned char *made = test_alloc(at + bytes + 1, 1);

    memcpy(made, b, at);
    memcpy(made + at, level, bytes);
    file_set_u32(made + 44, 2);
    file_set_u32(made + 88, (uint32_t)bytes);
    *size = at + bytes;
    return made;
}

static const unsigned char skippable[] = {0x53, 0x2A, 0x4D, 0x18, 3, 0,
                                          0,    0,    1,    2,    3};

/* Frames of a level after a recipe: a a whole one, b its first third, c the
 * rest, + a byte more, - one less, s a skippable one, x no frame but the
 * texels, 0 a byte, < without the last byte, ^ that changed. flags: 1 states
 * sizes, 2 has checksums. */
static size_t cook(const char *recipe, const ibl_texture *tex, int flags,
                   unsigned char *to, size_t room)
{
    const size_t whole = tex->bytes, part = whole / 3;
    unsigned char *more = test_alloc(whole + 1, 1);
    size_t size = 0;
    ZSTD_CCtx *z = ZSTD_createCCtx();

    memcpy(more, tex->data, whole);
    ZSTD_CCtx_setParameter(z, ZSTD_c_contentSizeFlag, flags & 1);
    ZSTD_CCtx_setParameter(z, ZSTD_c_checksumFlag, flags >> 1);
    for (; *recipe; recipe++)
        if (*recipe == 's' || *recipe == 'x') {
            const size_t n = *recipe == 's' ? sizeof skippable : whole;
            memcpy(to + size, *recipe == 's' ? skippable : more, n);
            size += n;
        } else if (*recipe == '0') {
            to[size++] = 0;
        } else if (*recipe == '<') {
            size--;
        } else if (*recipe == '^') {
            to[size - 1] ^= 1;
        } else {
            const size_t from = *recipe == 'c' ? part : 0;
            const size_t end = *recipe == 'b'   ? part
                               : *recipe == '+' ? whole + 1
                               : *recipe == '-' ? whole - 1
                                                : whole;
            size += ZSTD_compress2(z, to + size, room - size, more + from,
                                   end - from);
        }
    ZSTD_freeCCtx(z);
    return size;
}

/* RFC 8878: frames may follow one another, be skippable, not state their size,
 * and have a checksum; and those that lie. */
TEST(zstd_frames)
{
    static const struct {
        const char *recipe, *words; /* NULL: are read */
    } cases[] = {{"a", NULL},       {"as", NULL},      {"sbc", NULL},
                 {"+", "level 0"},  {"-", "shorter"},  {"a0", "level 0"},
                 {"a<", "level 0"}, {"ab", "level 0"}, {"", "too short"},
                 {"s", "shorter"},  {"x", "level 0"},  {"a^", "checksum"}};
    static unsigned char level[20000];
    const ibl_texture tex = make(IBL_PIXEL_RGBA16F, 9, 9, 1, 1, 6);
    for (int i = 0; i < 4 * (int)(sizeof cases / sizeof *cases); i++) {
        const char *recipe = cases[i / 4].recipe, *words = cases[i / 4].words;
        size_t size;
        const unsigned char *b = splice(
            &tex, level, cook(recipe, &tex, i % 4, level, sizeof level), &size);
        if (!words) {
            const ibl_texture back = texture_decode(ctx, b, size);
            CHECK_MSG(texture_same(&tex, &back), "%s", recipe);
        } else if (!strchr(recipe, '^') || i % 4 > 1) {
            check_refused(b, size, IBL_ERR_FORMAT, words, recipe);
        }
    }
}

/* The largest cubes in few bytes: of a header alone, and of frames that claim
 * to hold them; a window of 2 GiB, and one of 2 TiB. */
TEST(bombs)
{
    static const unsigned char claim[] = {
        0x28, 0xB5, 0x2F, 0xFD, 0xC0, 0x58, /* magic, 8 bytes of size, window */
        0,    0,    0,    0,    0x60, 0,    0, 0, /* 6 * 65536^2 * 16 */
        3,    0,    0x10, 7};                     /* a block of 128 KiB of 7 */
    const ibl_texture tex = make(IBL_PIXEL_RGBA32F, 4, 4, 1, 1, 6);
    size_t size;
    unsigned char *b = splice(&tex, claim, sizeof claim, &size);
    file_set_u32(b + 20, 65536);
    file_set_u32(b + 24, 65536);
    file_set_u32(b + 96, 0);
    file_set_u32(b + 100, 0x60);
    check_refused(b, size, IBL_ERR_FORMAT, "too short", "claim");
    for (int i = 21; i <= 31; i += 10) {
        unsigned char head[521] = {0x28, 0xB5, 0x2F, 0xFD, 0, 0, 1, 0x10, 0};
        head[5] = (unsigned char)(i << 3);
        b = splice(&tex, head, sizeof head, &size);
        check_refused(b, size, IBL_ERR_FORMAT, "level 0", "window");
    }
}
