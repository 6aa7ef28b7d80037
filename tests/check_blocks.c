/* SPDX-License-Identifier: MIT */
/*
 * Block-compressed textures, whatever their codecs do: how many blocks there
 * are and which texels they have, in memory and in containers. check_kern_*
 * judge the codecs.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/half.h"
#include "files.h"
#include "kern/astc_hdr.h"
#include "kern/bc6h.h"
#include "maps.h"
#include "test.h"
#include "textures.h"

static ibl_ctx *ctx;
static ibl_ctx *quiet;
static test_messages kept;

static const ibl_pixel pixels[] = {IBL_PIXEL_BC6H, IBL_PIXEL_UASTC_HDR,
                                   IBL_PIXEL_ASTC4X4HDR};
enum {
    PIXELS = sizeof pixels / sizeof pixels[0]
};

void test_setup(void)
{
    ctx = test_ctx(2, IBL_ISA_AUTO);
    quiet = test_keeping_ctx(1, &kept);
}

static ibl_decode_block_fn *decoder_of(ibl_pixel pixel)
{
    return pixel == IBL_PIXEL_BC6H ? ibl_bc6h_decode_block
                                   : ibl_astc_hdr_decode_block;
}

/* Smooth and bright in places, as a sky is. */
static ibl_cube make_cube(int size, int levels)
{
    ibl_cube cube = cube_alloc(ctx, size, levels);
    test_random r = {(uint64_t)(size * 100 + levels)};

    for (size_t i = 0; i < 3 * ibl_cube_texels(size, levels); i++)
        cube.data[i] =
            (float)(0.2 + 0.1 * test_random_unit(&r) + (i % 97 == 0 ? 900 : 0));
    return cube;
}

/* Clips what is too bright. */
static ibl_texture encode_with(ibl_ctx *by, const ibl_cube *cube,
                               ibl_texel_options opts)
{
    ibl_texture tex;

    opts.overflow = IBL_OVERFLOW_CLIP;
    if (ibl_texture_from_cube(by, cube, &opts, &tex, NULL))
        exit(1);
    return texture_owned(tex);
}

static ibl_texture encode(ibl_ctx *by, const ibl_cube *cube, ibl_pixel pixel,
                          ibl_quality quality)
{
    return encode_with(by, cube,
                       (ibl_texel_options){.pixel = pixel, .quality = quality});
}

/* Of a file with Zstandard 19. */
static double packed_bytes(const ibl_texture *tex)
{
    ibl_texture packed = *tex;
    size_t size;

    packed.zstd = 19;
    texture_encode(ctx, &packed, IBL_CONTAINER_KTX2, &size);
    return (double)size;
}

static ibl_cube decode(const ibl_texture *tex)
{
    ibl_cube cube;

    if (ibl_texture_to_cube(ctx, tex, &cube))
        exit(1);
    return test_cube(cube);
}

/* ---- how many blocks ---------------------------------------------------- */

/* ceil(n / 4)^2 blocks of 16 bytes a face, in every container. */
TEST(sizes)
{
    for (int n = 1; n <= 17; n++) {
        int levels = 1;
        while (n >> levels)
            levels++;
        const ibl_cube cube = make_cube(n, levels);
        size_t total = 0;
        for (int l = 0; l < levels; l++) {
            const int edge = n >> l, blocks = (edge + 3) / 4;
            total += 6 * 16 * (size_t)(blocks * blocks);
        }
        for (int i = 0; i < PIXELS; i++) {
            const ibl_texture tex =
                encode(ctx, &cube, pixels[i], IBL_QUALITY_FAST);
            CHECK(tex.bytes == total);
            CHECK(ibl_texture_offset(&tex, levels, 0) == total);
            for (ibl_container c = 0; c < IBL_CONTAINER_COUNT; c++) {
                if (!ibl_container_holds(c, pixels[i]))
                    continue;
                size_t size;
                unsigned char *b = texture_encode(ctx, &tex, c, &size);
                const ibl_texture back = texture_decode(ctx, b, size);
                CHECK(texture_same(&tex, &back));
                CHECK(c != IBL_CONTAINER_DDS || size == 148 + total);
            }
        }
    }
}

/* UASTC HDR and ASTC have one number in Vulkan, and two colour models. */
TEST(holders)
{
    static const struct {
        ibl_container container;
        ibl_pixel pixel;
    } refused[] = {{IBL_CONTAINER_KTX, IBL_PIXEL_UASTC_HDR},
                   {IBL_CONTAINER_DDS, IBL_PIXEL_UASTC_HDR},
                   {IBL_CONTAINER_DDS_LEGACY, IBL_PIXEL_BC6H},
                   {IBL_CONTAINER_DDS, IBL_PIXEL_ASTC4X4HDR}};
    const ibl_cube cube = make_cube(4, 1);
    for (int i = 0; i < 4; i++) {
        const ibl_texture tex =
            encode(ctx, &cube, refused[i].pixel, IBL_QUALITY_FAST);
        void *bytes;
        size_t size;
        CHECK(ibl_texture_encode(quiet, &tex, refused[i].container, &bytes,
                                 &size) == IBL_ERR_UNSUPPORTED);
        CHECK(test_said(&kept, ibl_pixel_name(refused[i].pixel)) &&
              test_said(&kept, "KTX2"));
    }
    const ibl_texture a =
        encode(ctx, &cube, IBL_PIXEL_UASTC_HDR, IBL_QUALITY_FAST);
    const ibl_texture b =
        encode(ctx, &cube, IBL_PIXEL_ASTC4X4HDR, IBL_QUALITY_FAST);
    CHECK(a.bytes == b.bytes && !memcmp(a.data, b.data, a.bytes));
}

/* ---- which texels ------------------------------------------------------- */

/* Texel by texel, from the block that has it. */
TEST(texels)
{
    for (int n = 1; n <= 9; n += 2) {
        const ibl_cube cube = make_cube(n, 1);
        const int row = (n + 3) / 4;
        for (int i = 0; i < PIXELS; i++) {
            const ibl_texture tex =
                encode(ctx, &cube, pixels[i], IBL_QUALITY_NORMAL);
            const ibl_cube back = decode(&tex);
            for (int k = 0; k < 6 * n * n; k++) {
                const int face = k / (n * n), y = k / n % n, x = k % n;
                const int block = (face * row + y / 4) * row + x / 4;
                uint16_t half[16][3];
                decoder_of(pixels[i])(tex.data + 16 * block, half);
                for (int c = 0; c < 3; c++)
                    CHECK(back.data[3 * k + c] ==
                          ibl_half_to_float(half[y % 4 * 4 + x % 4][c]));
            }
        }
    }
}

/* Beyond the edges blocks repeat the last texels: a cube of 4 whose texels do
 * so has the blocks of a smaller one. */
TEST(edges)
{
    for (int n = 1; n < 4; n++) {
        const ibl_cube small = make_cube(n, 1);
        ibl_cube whole = cube_alloc(ctx, 4, 1);
        for (int k = 0; k < 6 * 16; k++) {
            const int y = k / 4 % 4 < n ? k / 4 % 4 : n - 1;
            const int x = k % 4 < n ? k % 4 : n - 1;
            memcpy(whole.data + 3 * k,
                   small.data + 3 * ((k / 16 * n + y) * n + x),
                   3 * sizeof(float));
        }
        for (int i = 0; i < PIXELS; i++) {
            const ibl_texture a =
                encode(ctx, &small, pixels[i], IBL_QUALITY_NORMAL);
            const ibl_texture b =
                encode(ctx, &whole, pixels[i], IBL_QUALITY_NORMAL);
            CHECK(a.bytes == b.bytes && !memcmp(a.data, b.data, a.bytes));
        }
    }
}

/* What is no radiance, and what lies beyond: counted once, not for the texels
 * that repeat it. */
TEST(limits)
{
    for (int i = 0; i < PIXELS; i++) {
        ibl_cube cube = make_cube(5, 1);
        const ibl_texel_options opts = {.pixel = pixels[i],
                                        .overflow = IBL_OVERFLOW_CLIP};
        ibl_overflow_report report;
        ibl_texture tex;
        cube.data[3 * 24] = 1e6f; /* at a corner of face 0 */
        for (size_t k = 3 * 25; k < 3 * 75; k++)
            cube.data[k] = k < 3 * 50 ? NAN : -5;
        NEED(!ibl_texture_from_cube(ctx, &cube, &opts, &tex, &report));
        texture_owned(tex);
        CHECK(report.values == 1 && report.level[0].texels == 1);
        const ibl_cube back = decode(&tex);
        for (size_t k = 0; k < cube_floats(&back); k++)
            CHECK(back.data[k] >= 0 &&
                  back.data[k] <= ibl_pixel_max(pixels[i]));
        CHECK_NEAR((double)back.data[3 * 24], (double)ibl_pixel_max(pixels[i]),
                   0.02 * (double)ibl_pixel_max(pixels[i]));
        for (size_t k = 3 * 25; k < 3 * 75; k++)
            CHECK(back.data[k] == 0);
    }
}

/* Blocks alike take fewer bytes for any threads; what has no such blocks is as
 * without. */
TEST(alike)
{
    const ibl_cube cube = make_cube(64, 2);
    const ibl_quality normal = IBL_QUALITY_NORMAL;
    for (int i = 0; i < PIXELS; i++) {
        ibl_texel_options opts = {
            .pixel = pixels[i], .quality = normal, .alike = 1};
        const ibl_texture plain = encode(ctx, &cube, pixels[i], normal);
        const ibl_texture a = encode_with(ctx, &cube, opts);
        const ibl_texture b = encode_with(test_ctx(7, IBL_ISA_C), &cube, opts);
        const size_t last = ibl_texture_offset(&a, 1, 0);
        CHECK(texture_same(&a, &b));
        CHECK(!memcmp(a.data + last, plain.data + last,
                      6 * ibl_texture_face_bytes(&a, 1)));
        if (pixels[i] == IBL_PIXEL_BC6H)
            CHECK(texture_same(&a, &plain));
        else
            CHECK(packed_bytes(&a) < 0.95 * packed_bytes(&plain));
    }
}

/* Blocks are nearly those four rows of blocks above, an octave brighter. */
static ibl_cube four_rows(int size)
{
    ibl_cube cube = cube_alloc(ctx, size, 1);
    test_random r = {3};

    for (int y = 0; y < 6 * size; y++)
        for (int x = 0; x < 3 * size; x++) {
            float *v = cube.data + (size_t)y * 3 * (size_t)size + x;
            const double near = 1 + 0.01 * test_random_unit(&r);
            *v = (float)(y % size < 16 ? 0.2 + 0.1 * test_random_unit(&r)
                                       : 2 * near * (double)v[-48 * size]);
        }
    return cube;
}

/* Those are found, which a call of the encoder does not reach. */
TEST(alike_beyond_calls)
{
    const ibl_cube cube = four_rows(128);
    ibl_texel_options opts = ibl_texel_options_default();
    opts.pixel = IBL_PIXEL_UASTC_HDR;
    opts.quality = IBL_QUALITY_NORMAL;
    const ibl_texture plain = encode_with(ctx, &cube, opts);
    opts.alike = 1;
    const ibl_texture a = encode_with(ctx, &cube, opts);
    CHECK(packed_bytes(&a) < 0.9 * packed_bytes(&plain));
}

/* The best quality has none. */
TEST_SLOW(best_is_not_alike)
{
    ibl_texel_options opts = {.pixel = IBL_PIXEL_UASTC_HDR,
                              .quality = IBL_QUALITY_BEST};
    const ibl_cube cube = make_cube(64, 1);
    const ibl_texture plain = encode_with(ctx, &cube, opts);
    opts.alike = 1;
    const ibl_texture best = encode_with(ctx, &cube, opts);
    CHECK(texture_same(&plain, &best));
}

TEST(qualities)
{
    const ibl_cube cube = make_cube(4, 1);
    for (size_t p = 0; p < PIXELS; p++) {
        ibl_texel_options opts = ibl_texel_options_default();
        ibl_texture tex = {0};
        opts.pixel = pixels[p];
        opts.quality = IBL_QUALITY_BEST + 1;
        CHECK(ibl_texture_from_cube(quiet, &cube, &opts, &tex, NULL) ==
              IBL_ERR_ARGUMENT);
        CHECK(!tex.data);
    }
}

TEST(unblocked)
{
    const ibl_cube cube = make_cube(37, 4);
    for (int i = 0; i < PIXELS; i++) {
        const ibl_texture tex = encode(ctx, &cube, pixels[i], IBL_QUALITY_FAST);
        const ibl_cube want = decode(&tex);
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &size);
        ibl_texture open;
        NEED(!ibl_texture_decode(ctx, "x", b, size, &open, NULL));
        NEED(!ibl_texture_unblock(ctx, &open));
        const ibl_texture plain = texture_owned(open);
        const ibl_cube got = decode(&plain);
        CHECK(plain.pixel == IBL_PIXEL_RGBA16F && plain.levels == 4);
        CHECK(!memcmp(got.data, want.data, cube_floats(&got) * sizeof(float)));
        ibl_cube alpha;
        NEED(!ibl_texture_get_alpha(ctx, &plain, &alpha));
        CHECK(alpha.data[0] == 1 && alpha.data[3 * 37] == 1);
        ibl_cube_free(&alpha);
        NEED(!ibl_texture_unblock(ctx, &open));
        CHECK(open.data == plain.data);
    }
}

/* ---- errors -------------------------------------------------------------- */

TEST(errors)
{
    ibl_cube cube = make_cube(21, 3);
    ibl_pixel_error error[IBL_MAX_LEVELS], again[IBL_MAX_LEVELS];
    for (size_t k = 0; k < 30; k++)
        cube.data[k] = 0;
    for (ibl_pixel p = 0; p <= IBL_PIXEL_ASTC4X4HDR; p++) {
        const ibl_texture tex = encode(ctx, &cube, p, IBL_QUALITY_FAST);
        const ibl_cube back = decode(&tex);
        NEED(!ibl_texture_errors(ctx, &tex, &cube, error));
        NEED(!ibl_texture_errors(test_ctx(5, IBL_ISA_C), &tex, &cube, again));
        CHECK(!memcmp(error, again, 3 * sizeof *error));
        for (int l = 0; l < 3; l++) {
            const size_t n = 21 >> l, from = ibl_cube_texels(21, l);
            double wrong = 0, truth = 0, relative = 0;
            for (size_t i = from; i < from + 6 * n * n; i++) {
                double w = 0, t = 0;
                for (size_t c = 3 * i; c < 3 * i + 3; c++) {
                    w += pow((double)back.data[c] - (double)cube.data[c], 2);
                    t += pow((double)cube.data[c], 2);
                }
                wrong += w;
                truth += t;
                relative += t > 0 ? sqrt(w / t) : w > 0;
            }
            /* Squares of floats: 4 roundings, and the root halves them. */
            CHECK_NEAR(error[l].nrmse, sqrt(wrong / truth), 0x1p-22);
            CHECK_NEAR(error[l].relative, relative / (double)(6 * n * n),
                       0x1p-22);
            CHECK((error[l].nrmse > 0) == (p != IBL_PIXEL_RGBA32F));
        }
    }
}

/* |t|^2 is a denormal float here, and |d - t|^2 / |t|^2 beyond all floats. */
TEST(errors_of_the_dark)
{
    ibl_cube bright = cube_alloc(ctx, 4, 1), dark = cube_alloc(ctx, 4, 1);
    ibl_pixel_error error[IBL_MAX_LEVELS];
    for (size_t i = 0; i < 3 * ibl_cube_texels(4, 1); i++) {
        bright.data[i] = 1;
        dark.data[i] = 1e-20F;
    }
    const ibl_texture tex =
        encode(ctx, &bright, IBL_PIXEL_RGBA32F, IBL_QUALITY_FAST);
    for (ibl_isa isa = IBL_ISA_AUTO; isa <= IBL_ISA_C; isa++) {
        NEED(!ibl_texture_errors(test_ctx(1, isa), &tex, &dark, error));
        CHECK_NEAR(error->relative / 1e20, 1, 1e-5);
        CHECK_NEAR(error->nrmse / 1e20, 1, 1e-5);
    }
}

TEST(errors_refused)
{
    const ibl_cube cube = make_cube(8, 2), other = make_cube(8, 1);
    const ibl_texture tex =
        encode(ctx, &cube, IBL_PIXEL_BC6H, IBL_QUALITY_FAST);
    ibl_pixel_error error[IBL_MAX_LEVELS];
    CHECK(ibl_texture_errors(quiet, &tex, &other, error) == IBL_ERR_ARGUMENT);
    const ibl_texture *const two[] = {&tex, &tex};
    const ibl_texture array = texture_array(ctx, two, 2);
    CHECK(ibl_texture_errors(quiet, &array, &cube, error) == IBL_ERR_ARGUMENT);
    CHECK(ibl_texture_errors(quiet, &tex, &cube, NULL) == IBL_ERR_ARGUMENT);
}

/* ---- files of others ----------------------------------------------------- */

/* VkFormat 144, DXGI 96 and GL's 0x8E8E become halves. */
TEST(signed_blocks)
{
    static const struct {
        size_t at;
        uint32_t number;
    } names[] = {{12, 144}, {28, 0x8E8E}, {128, 96}};
    for (ibl_container c = 0; c < IBL_CONTAINER_DDS_LEGACY; c++) {
        ibl_texture tex = texture_owned(
            texture_random(ctx, IBL_PIXEL_BC6H, (int[]){10, 7, 2, 1}, 1));
        size_t size;
        unsigned char *b = texture_encode(ctx, &tex, c, &size);
        file_set_u32(b + names[c].at, names[c].number);
        const ibl_texture back = texture_decode(ctx, b, size);
        CHECK(back.pixel == IBL_PIXEL_RGBA16F && back.width == 10 &&
              back.height == 7 && back.levels == 2);
        for (int l = 0; l < 2; l++)
            for (int y = 0; y < 7 >> l; y++)
                for (int x = 0; x < 10 >> l; x++) {
                    const int row = ((10 >> l) + 3) / 4;
                    uint16_t want[16][3], got[4];
                    ibl_bc6h_decode_signed_block(
                        tex.data + ibl_texture_offset(&tex, l, 0) +
                            16 * (y / 4 * row + x / 4),
                        want);
                    memcpy(got,
                           back.data + ibl_texture_offset(&back, l, 0) +
                               8 * (y * (10 >> l) + x),
                           8);
                    CHECK(!memcmp(got, want[y % 4 * 4 + x % 4], 6));
                    CHECK(got[3] == 0x3C00);
                }
    }
}

/* Of ASTC only what UASTC HDR has is read: here a block of 4x4 weights and LDR
 * colours is among its blocks, and others are named. */
TEST(other_astc)
{
    const ibl_cube cube = make_cube(16, 2);
    ibl_texture tex =
        encode(ctx, &cube, IBL_PIXEL_ASTC4X4HDR, IBL_QUALITY_FAST);
    ibl_cube back;
    tex.data[16 * 5] = 0x42;
    tex.data[16 * 5 + 1] = 0;
    CHECK(ibl_texture_to_cube(quiet, &tex, &back) == IBL_ERR_UNSUPPORTED);
    CHECK(test_said(&kept, "UASTC HDR") && !back.data);
    CHECK(ibl_texture_unblock(quiet, &tex) == IBL_ERR_UNSUPPORTED);
    CHECK(tex.pixel == IBL_PIXEL_ASTC4X4HDR);
}

/* Rows cannot be turned over inside of blocks. */
TEST(bottom_up)
{
    ibl_texture tex = texture_owned(texture_random(ctx, IBL_PIXEL_BC6H,
                                                   (int[]){8, 8, 1, 1}, 1)),
                back;
    size_t size;
    unsigned char *b = texture_encode(ctx, &tex, IBL_CONTAINER_KTX, &size);
    for (size_t i = 64; i < 100; i++)
        if (!memcmp(b + i, "T=d", 3))
            b[i + 2] = 'u';
    CHECK(ibl_texture_decode(quiet, "x", b, size, &back, NULL) ==
          IBL_ERR_UNSUPPORTED);
    CHECK(test_said(&kept, "bottom"));
}

TEST(damaged)
{
    for (ibl_container c = 0; c < IBL_CONTAINER_DDS_LEGACY; c++) {
        ibl_texture tex = texture_owned(
            texture_random(ctx, IBL_PIXEL_BC6H, (int[]){5, 5, 2, 6}, 1));
        size_t places[60], size;
        unsigned char *b = texture_encode(ctx, &tex, c, &size);
        texture_damage(quiet, b, size);
        for (size_t k = 0; k < 60; k++)
            places[k] = 12 + k * 4 % (size - 16);
        texture_damage_words(quiet, b, size, places, 60, 19);
    }
}
