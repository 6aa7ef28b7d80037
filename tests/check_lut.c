/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/io.h"
#include "ibl/reference.h"
#include "reference.h"
#include "test.h"

static const ibl_geometry geometries[] = {IBL_GEOMETRY_SMITH,
                                          IBL_GEOMETRY_SCHLICK_IBL};

static void free_lut(void *lut)
{
    ibl_lut_free(lut);
}

static ibl_lut bake(ibl_ctx *ctx, int size, ibl_lut_kind kind,
                    ibl_geometry geometry, int samples)
{
    ibl_lut_options opts = ibl_lut_options_default();
    ibl_lut lut = {0};

    opts.size = size;
    opts.kind = kind;
    opts.geometry = geometry;
    opts.samples = samples;
    if (ibl_bake_lut(ctx, &opts, &lut))
        exit(1);
    test_defer_copy(free_lut, &lut, sizeof lut);
    return lut;
}

static const float *texel(const ibl_lut *lut, int i, int j)
{
    return lut->data + 2 * ((size_t)j * (size_t)lut->size + (size_t)i);
}

/* Error of a texel against the adaptive double integral. */
static double error(const ibl_lut *lut, ibl_geometry geometry, int i, int j)
{
    const double n = lut->size;
    double want[2];

    reference_lut((i + 0.5) / n, (j + 0.5) / n, geometry, want);
    return fmax(fabs(texel(lut, i, j)[0] - want[0]),
                fabs(texel(lut, i, j)[1] - want[1]));
}

/* The default size, by each instruction set: the four edges, the corners and a
 * grid between. */
TEST(default_size)
{
    static const int at[] = {0, 1, 8, 18, 70, 160, 255};

    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT; isa = test_next_isa(isa))
        for (int g = 0; g < 2; g++) {
            ibl_lut lut =
                bake(test_ctx(2, isa), 256, IBL_LUT_SPLIT, geometries[g], 0);
            NEED(lut.size == 256);
            double worst = 0.0;
            for (int k = 0; k < 49; k++)
                worst = fmax(worst,
                             error(&lut, geometries[g], at[k / 7], at[k % 7]));
            CHECK_MSG(worst <= 1.5e-5, "%s, %s: worst error %g",
                      ibl_geometry_name(geometries[g]), ibl_isa_name(isa),
                      worst);
        }
}

/* Corners and random texels, of sizes with and without interpolation. */
TEST_OF(other_sizes, "other_sizes", TEST_RACES || !TEST_SANITIZED)
{
    static const int sizes[] = {1, 2, 3, 17, 28, 29, 64, 100, 511, 4096};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {7};

    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        const int n = sizes[k];
        const ibl_geometry g = geometries[k % 2];
        ibl_lut lut = bake(ctx, n, IBL_LUT_SPLIT, g, 0);
        double worst = 0.0;
        for (int c = 0; c < 4; c++)
            worst = fmax(worst,
                         error(&lut, g, c & 1 ? n - 1 : 0, c & 2 ? n - 1 : 0));
        for (int c = 0; c < 8; c++)
            worst =
                fmax(worst, error(&lut, g, (int)(test_random_unit(&rnd) * n),
                                  (int)(test_random_unit(&rnd) * n)));
        /* Where the width of the lobe meets that of the grazing view. (The
         * adaptive integral needs seconds below that in large tables.) */
        for (int c = n > 1000 ? 3 : 1; c < 6; c++)
            worst = fmax(worst, error(&lut, g, 0, (int)(sqrt(n) * c / 2) % n));
        CHECK_MSG(worst <= 3e-5, "size %d, %s: worst error %g", n,
                  ibl_geometry_name(g), worst);
    }
}

/* The published algorithm comes to the same integrals, as fast as its
 * points allow, and its limits are finite. */
TEST(samples)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int g = 0; g < 2; g++) {
        ibl_lut exact = bake(ctx, 24, IBL_LUT_SPLIT, geometries[g], 0);
        double mean[3], last = 1.0;
        for (int k = 0; k < 3; k++) {
            ibl_lut lut =
                bake(ctx, 24, IBL_LUT_SPLIT, geometries[g], 64 << (4 * k));
            mean[k] = 0.0;
            for (int t = 0; t < 2 * 24 * 24; t++) {
                CHECK(isfinite(lut.data[t]));
                mean[k] += fabs((double)lut.data[t] - exact.data[t]);
            }
            mean[k] /= 2 * 24 * 24;
            CHECK_MSG(mean[k] < 0.25 * last, "%d samples: mean error %g",
                      64 << (4 * k), mean[k]);
            last = mean[k];
        }
        CHECK(mean[2] < 3e-4);
        ibl_lut lut = bake(ctx, 24, IBL_LUT_SPLIT, geometries[g], 1);
        for (int t = 0; t < 2 * 24 * 24; t++)
            CHECK(isfinite(lut.data[t]) && lut.data[t] >= 0.0f);
    }
    /* Jobs of two texels and of one in a row. */
    ibl_lut exact = bake(ctx, 3, IBL_LUT_SPLIT, IBL_GEOMETRY_SMITH, 0);
    ibl_lut lut = bake(ctx, 3, IBL_LUT_SPLIT, IBL_GEOMETRY_SMITH, 400000);
    for (int t = 0; t < 2 * 9; t++)
        CHECK_NEAR(lut.data[t], exact.data[t], 1e-4);
}

/* ---- the other kinds -------------------------------------------------- */

/* Sizes with and without interpolation. */
TEST(charlie)
{
    static const int sizes[] = {1, 60, 256, 1024};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {7};

    for (int k = 0; k < 4; k++) {
        const int n = sizes[k];
        ibl_lut lut = bake(ctx, n, IBL_LUT_CHARLIE, IBL_GEOMETRY_SMITH, 0);
        double worst = 0, e[2];
        NEED(lut.size == n && ibl_lut_channels(lut.kind) == 2);
        for (int p = 0; p < 24; p++) {
            /* every second point near the smoothest grazing texel */
            const double top = p % 2 ? n : n < 8 ? n : 8;
            const int i = p ? (int)(test_random_unit(&rnd) * top) : 0;
            const int j = p ? (int)(test_random_unit(&rnd) * top) : 0;
            NEED(!ibl_reference_sheen(ctx, (i + 0.5) / n, (j + 0.5) / n, e));
            for (int c = 0; c < 2; c++)
                worst = fmax(worst,
                             fabs(texel(&lut, i, j)[c] - e[c]) / fmax(e[c], 1));
        }
        CHECK_MSG(worst <= 5e-5, "size %d: worst error %g", n, worst);
    }
}

/* The channels of other tables; a white metal's furnace, where F0 = 1 and
 * G (1 + F0 (1 / G - 1)) = 1, and a black one's bias. */
TEST(multiscatter)
{
    enum {
        N = 96
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_lut split = bake(ctx, N, IBL_LUT_SPLIT, IBL_GEOMETRY_SMITH, 0);
    ibl_lut sheen = bake(ctx, N, IBL_LUT_CHARLIE, IBL_GEOMETRY_SMITH, 0);
    ibl_lut lut = bake(ctx, N, IBL_LUT_MULTISCATTER, IBL_GEOMETRY_SMITH, 0);

    NEED(ibl_lut_channels(lut.kind) == 3 && lut.size == N);
    for (size_t i = 0; i < N * N; i++) {
        const float *t = lut.data + 3 * i;
        const double f0 = 1, single = (1 - f0) * t[0] + f0 * (double)t[1];
        CHECK(t[0] == split.data[2 * i + 1]);
        CHECK(t[1] == split.data[2 * i] + split.data[2 * i + 1]);
        CHECK(t[2] == sheen.data[2 * i]);
        CHECK_NEAR(single * (1 + f0 * (1.0 / t[1] - 1)), 1, 1e-6);
        CHECK(t[1] > 0.3f && t[1] <= 1.0f + 1e-5f && t[0] <= t[1]);
    }
}

/* Through a texture and back: the key tells the kind. */
TEST(kinds_in_textures)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);

    for (int kind = 0; kind <= IBL_LUT_CHARLIE; kind++) {
        ibl_lut lut = bake(ctx, 4, (ibl_lut_kind)kind, IBL_GEOMETRY_SMITH, 0),
                back = {0};
        ibl_texture tex = {0};
        const size_t count = 16 * (size_t)ibl_lut_channels(lut.kind);
        const ibl_pixel pixel =
            kind == IBL_LUT_MULTISCATTER ? IBL_PIXEL_RGBA32F : IBL_PIXEL_RG32F;
        CHECK(ibl_texture_from_lut(ctx, &lut,
                                   kind == IBL_LUT_MULTISCATTER
                                       ? IBL_PIXEL_RG32F
                                       : IBL_PIXEL_RGBA32F,
                                   &tex, NULL) == IBL_ERR_ARGUMENT);
        NEED(!ibl_texture_from_lut(ctx, &lut, pixel, &tex, NULL));
        NEED(!ibl_texture_to_lut(ctx, &tex, &back));
        CHECK(back.kind == lut.kind && back.size == 4);
        CHECK(!memcmp(back.data, lut.data, count * sizeof *lut.data));
        ibl_lut_free(&back);
        ibl_texture_free(&tex);
    }
}
