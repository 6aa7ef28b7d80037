/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "test.h"
#include "truth.h"

static const ibl_geometry geometries[] = {IBL_GEOMETRY_SMITH,
                                          IBL_GEOMETRY_SCHLICK_IBL};

static void free_lut(void *lut)
{
    ibl_lut_free(lut);
}

static ibl_lut bake(ibl_ctx *ctx, int size, ibl_geometry geometry, int samples)
{
    ibl_lut_options opts = ibl_lut_options_default();
    ibl_lut lut = {0};

    opts.size = size;
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

    truth_lut((i + 0.5) / n, (j + 0.5) / n, geometry, want);
    return fmax(fabs(texel(lut, i, j)[0] - want[0]),
                fabs(texel(lut, i, j)[1] - want[1]));
}

/* The default size: the four edges, the corners and a grid between. */
TEST(default_size)
{
    static const int at[] = {0, 1, 4, 12, 18, 36, 70, 128, 200, 255};
    const int count = sizeof at / sizeof at[0];
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int g = 0; g < 2; g++) {
        ibl_lut lut = bake(ctx, 256, geometries[g], 0);
        NEED(lut.size == 256);
        double worst = 0.0;
        for (int a = 0; a < count; a++) {
            for (int b = 0; b < count; b++)
                worst = fmax(worst, error(&lut, geometries[g], at[a], at[b]));
        }
        CHECK_MSG(worst <= 1.5e-5, "%s: worst error %g",
                  ibl_geometry_name(geometries[g]), worst);
    }
}

/* Corners and random texels, of sizes with and without interpolation. */
TEST(other_sizes)
{
    static const int sizes[] = {1, 2, 3, 17, 28, 29, 64, 100, 511, 4096};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {7};

    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        const int n = sizes[k];
        const ibl_geometry g = geometries[k % 2];
        ibl_lut lut = bake(ctx, n, g, 0);
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

/* A mirror: scale 1 - (1 - N.V)^5, bias (1 - N.V)^5. */
TEST(smooth_limit)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);

    for (int g = 0; g < 2; g++) {
        ibl_lut lut = bake(ctx, 256, geometries[g], 0);
        for (int i = 1; i < 256; i++) {
            const double f = pow(1.0 - (i + 0.5) / 256, 5.0);
            /* Schlick's k makes 1 - G of alpha / N.V. */
            CHECK_NEAR(texel(&lut, i, 0)[0], 1.0 - f, 3e-3 / (i + 0.5));
            CHECK_NEAR(texel(&lut, i, 0)[1], f, 3e-3 / (i + 0.5));
        }
    }
}

/*
 * The white furnace, F = 1: scale + bias is the share of light that leaves
 * after one bounce. At alpha = 1, D = 1 / pi and with m = N.L
 *     Smith    integral of m / (m + N.V) dm = 1 - N.V ln(1 + 1 / N.V)
 *     Schlick  2 / (1 + N.V) integral of m / (1 + m) dm
 * reached by extrapolating from the last three rows. Nowhere more than 1.
 */
TEST(white_furnace)
{
    const int n = 512;
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int g = 0; g < 2; g++) {
        ibl_lut lut = bake(ctx, n, geometries[g], 0);
        for (int i = 0; i < n; i++) {
            const double v = (i + 0.5) / n;
            const double want = g == 0 ? 1.0 - v * log(1.0 + 1.0 / v)
                                       : 2.0 * (1.0 - log(2.0)) / (1.0 + v);
            double row[3];
            for (int k = 0; k < 3; k++)
                row[k] = (double)texel(&lut, i, n - 1 - k)[0] +
                         texel(&lut, i, n - 1 - k)[1];
            CHECK_NEAR((15 * row[0] - 10 * row[1] + 3 * row[2]) / 8, want,
                       2e-5);
        }
        for (int k = 0; k < n * n; k++) {
            const float *t = lut.data + 2 * (size_t)k;
            CHECK(t[0] >= 0.0f && t[1] >= 0.0f);
            CHECK((double)t[0] + t[1] <= 1.0 + 1e-5);
        }
    }
}

/* The published algorithm comes to the same integrals, as fast as its
 * points allow, and its limits are finite. */
TEST(samples)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int g = 0; g < 2; g++) {
        ibl_lut exact = bake(ctx, 24, geometries[g], 0);
        double mean[3], last = 1.0;
        for (int k = 0; k < 3; k++) {
            ibl_lut lut = bake(ctx, 24, geometries[g], 64 << (4 * k));
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
        ibl_lut lut = bake(ctx, 24, geometries[g], 1);
        for (int t = 0; t < 2 * 24 * 24; t++)
            CHECK(isfinite(lut.data[t]) && lut.data[t] >= 0.0f);
    }
    /* Jobs of two texels and of one in a row. */
    ibl_lut exact = bake(ctx, 3, IBL_GEOMETRY_SMITH, 0);
    ibl_lut lut = bake(ctx, 3, IBL_GEOMETRY_SMITH, 400000);
    for (int t = 0; t < 2 * 9; t++)
        CHECK_NEAR(lut.data[t], exact.data[t], 1e-4);
}

TEST(threads)
{
    static const int counts[] = {1, 2, 7};
    static const int sizes[] = {20, 90}, points[] = {0, 100};

    for (int k = 0; k < 4; k++) {
        const size_t n = (size_t)sizes[k % 2];
        ibl_lut first = {0};
        for (int t = 0; t < 3; t++) {
            ibl_ctx *ctx = test_ctx(counts[t], IBL_ISA_AUTO);
            ibl_lut lut = bake(ctx, (int)n, IBL_GEOMETRY_SMITH, points[k / 2]);
            if (!t)
                first = lut;
            CHECK(!memcmp(lut.data, first.data, 2 * n * n * sizeof *lut.data));
        }
    }
}

TEST(bad_options)
{
    test_messages kept = {{{0}}};
    ibl_lut lut = {0};

    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_lut_options opts = ibl_lut_options_default();
    CHECK(opts.size == 256 && opts.samples == 0);
    CHECK(opts.geometry == IBL_GEOMETRY_SMITH);
    opts.size = 0;
    CHECK(ibl_bake_lut(ctx, &opts, &lut) == IBL_ERR_ARGUMENT);
    CHECK(strstr(kept.text[IBL_LOG_ERROR], "size 0"));
    opts.size = 4097;
    CHECK(ibl_bake_lut(ctx, &opts, &lut) == IBL_ERR_ARGUMENT);
    opts = ibl_lut_options_default();
    opts.samples = -1;
    CHECK(ibl_bake_lut(ctx, &opts, &lut) == IBL_ERR_ARGUMENT);
    opts.samples = 1048577;
    CHECK(ibl_bake_lut(ctx, &opts, &lut) == IBL_ERR_ARGUMENT);
    opts = ibl_lut_options_default();
    opts.geometry = (ibl_geometry)9;
    CHECK(ibl_bake_lut(ctx, &opts, &lut) == IBL_ERR_ARGUMENT);
    CHECK(!lut.data);
    ibl_ctx_cancel(ctx);
    CHECK(ibl_bake_lut(ctx, NULL, &lut) == IBL_ERR_CANCELLED);
    CHECK(!lut.data);
    ibl_lut_free(&lut);
    ibl_lut_free(NULL);
    CHECK(!strcmp(ibl_geometry_name(IBL_GEOMETRY_SMITH), "smith"));
    CHECK(!strcmp(ibl_geometry_name(IBL_GEOMETRY_SCHLICK_IBL), "schlick-ibl"));
}
