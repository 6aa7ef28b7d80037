/* SPDX-License-Identifier: MIT */
/*
 * Block-compressed textures, whatever their codecs do: blocks that are alike,
 * errors of any pixel format against sums in double, and other blocks.
 * check_texture judges which texels blocks have, check_codecs what they are.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
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

/* ---- blocks alike -------------------------------------------------------- */

/* Blocks alike take fewer bytes for any threads; what has no such blocks is as
 * without; the best quality has none. */
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
    const ibl_cube small = make_cube(64, 1);
    const ibl_texture best =
        encode(ctx, &small, IBL_PIXEL_UASTC_HDR, IBL_QUALITY_BEST);
    const ibl_texture same =
        encode_with(ctx, &small,
                    (ibl_texel_options){.pixel = IBL_PIXEL_UASTC_HDR,
                                        .quality = IBL_QUALITY_BEST,
                                        .alike = 1});
    CHECK(texture_same(&best, &same));
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
    CHECK(packed_bytes(&a) < 0.8 * packed_bytes(&plain));
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
