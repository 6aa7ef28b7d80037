/* SPDX-License-Identifier: MIT */
/*
 * The hard cases of values: constants, pixel formats at both ends, pixels of
 * .hdr files without an exponent.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/io.h"
#include "maps.h"

/* Half a unit in the last place of a pixel format, at f > 0. */
static double half_unit(ibl_pixel pixel, int channel, double largest, double f)
{
    const int mantissa = pixel == IBL_PIXEL_RGBA16F ? 10 : channel < 2 ? 6 : 5;
    if (pixel == IBL_PIXEL_RGBA32F)
        return 0;
    if (pixel == IBL_PIXEL_RGB9E5) {
        /* 9 bits for the largest of three, the next power if they round up */
        const int e = (int)fmax(floor(log2(largest)), -16) + 1;
        return ldexp(1, e - 10 + (largest >= ldexp(511.5, e - 9)));
    }
    return ldexp(1, (int)fmax(floor(log2(f)), -14) - mantissa - 1);
}

static void check_encoded(ibl_ctx *ctx, const ibl_cube *cube, ibl_pixel pixel)
{
    ibl_texture tex = {0};
    ibl_cube back = {0};
    ibl_overflow_report report;
    size_t over = 0;
    const double top = ibl_pixel_max(pixel);
    NEED(!ibl_texture_from_cube(
        ctx, cube,
        &(ibl_texel_options){.struct_size = sizeof(ibl_texel_options),
                             .pixel = pixel,
                             .overflow = IBL_OVERFLOW_CLIP},
        &tex, &report));
    NEED(!ibl_texture_to_cube(ctx, &tex, &back));
    for (size_t i = 0; i < cube_floats(cube); i++) {
        const float *p = cube->data + i / 3 * 3;
        const double largest = fmax(fmax(p[0], p[1]), p[2]);
        const double max =
            pixel == IBL_PIXEL_R11G11B10F && i % 3 == 2 ? 64512 : top;
        const double want = fmin(cube->data[i], max), got = back.data[i];
        over += cube->data[i] > (float)max;
        CHECK_MSG(fabs(got - want) <=
                      half_unit(pixel, (int)(i % 3), fmin(largest, max), want),
                  "%s: %.9g comes back as %.9g", ibl_pixel_name(pixel), want,
                  got);
    }
    CHECK_MSG(report.values == over, "%s: %zu saturated, not %zu",
              ibl_pixel_name(pixel), report.values, over);
    ibl_cube_free(&back);
    ibl_texture_free(&tex);
}

static void check_formats(ibl_ctx *ctx, const ibl_cube *cube)
{
    check_encoded(ctx, cube, IBL_PIXEL_RGBA16F);
    check_encoded(ctx, cube, IBL_PIXEL_RGBA32F);
    check_encoded(ctx, cube, IBL_PIXEL_RGB9E5);
    check_encoded(ctx, cube, IBL_PIXEL_R11G11B10F);
}

/* Every output of a constant map is that constant, to the last bit of the
 * floats, so that each format holds the nearest that it has: quotients of the
 * same sums, and lookups above the smallest value, which is all there is. */
TEST(constant)
{
    static const float values[][3] = {
        {0.3f, 1, 0.7f},          {65504, 65024, 64512}, {7e4f, 1e6f, 3e38f},
        {0x1p-24f, 3e-6f, 1e-7f}, {1e-40f, 1e-45f, 0},   {0, 0, 0}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    for (size_t k = 0; k < sizeof values / sizeof values[0]; k++) {
        ibl_image map = map_constant(ctx, 37 << k % 2, 18, 0);
        for (size_t i = 0; i < map_floats(&map); i++)
            map.data[i] = values[k][i % 3];
        ibl_cube cubes[] = {cube_specular(ctx, &map, 0, 24, 5, 100),
                            cube_irradiance(ctx, &map, 0, 5)};
        for (int j = 0; j < 2; j++) {
            size_t off = 0;
            for (size_t i = 0; i < cube_floats(&cubes[j]); i++)
                off += cubes[j].data[i] != values[k][i % 3];
            CHECK_MSG(off == 0, "%g: %zu floats off", (double)values[k][0],
                      off);
            check_formats(ctx, &cubes[j]);
        }
    }
}

/* A sun that no format but floats can hold: every component beyond is the
 * largest finite one and counted, every other rounded to nearest. */
TEST(overflow)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_constant(ctx, 64, 32, 0.5f);
    for (int i = 0; i < 6; i++)
        map_set(&map, 20 + i, 9 + i, 1e6f, 8e4f * (float)i, 65504);
    ibl_cube cube = cube_specular(ctx, &map, 0, 64, 6, 64);
    double low, high;
    cube_range(&cube, 0, 0, &low, &high);
    CHECK(high > 65504);
    check_formats(ctx, &cube);
}

/* A map of denormal halves bakes to what a float has of it, and halves keep
 * what is above half of their smallest. Scaled by 2^20 it is normal, and the
 * same (check_levels: scaled), so nothing is lost on the way. */
TEST(denormal_halves)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_constant(ctx, 64, 32, 0);
    for (size_t i = 0; i < map_floats(&map); i++)
        map.data[i] = ldexpf((float)(i * 2654435761u % 1024), -24);
    ibl_image scaled = map_scaled(ctx, &map, 0x1p20f);
    ibl_cube a = cube_specular(ctx, &map, 0, 32, 6, 256);
    ibl_cube b = cube_specular(ctx, &scaled, 0, 32, 6, 256);
    for (size_t i = 0; i < cube_floats(&a); i++)
        CHECK(a.data[i] * 0x1p20f == b.data[i] && a.data[i] > 0x1p-25f);
    check_formats(ctx, &a);
}

/* An exponent byte of 0 is black whatever the mantissas hold; 1 is the
 * smallest: 255 / 256 2^-127, a denormal float. */
TEST(rgbe_without_exponent)
{
    static const unsigned char pixels[8] = {255, 128, 1, 0, 255, 128, 1, 1};
    unsigned char file[80];
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image map = {0};
    const int n = sprintf((char *)file, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"
                                        "-Y 1 +X 2\n");
    memcpy(file + n, pixels, sizeof pixels);
    NEED(!ibl_image_decode(ctx, "x.hdr", file, (size_t)n + sizeof pixels, NULL,
                           &map, NULL));
    for (int c = 0; c < 3; c++) {
        CHECK(map.data[c] == 0 && !signbit(map.data[c]));
        CHECK(map.data[3 + c] == ldexpf(pixels[c], 1 - 136));
    }
    ibl_image_free(&map);
}
