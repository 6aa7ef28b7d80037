/* SPDX-License-Identifier: MIT */
/* BRDF tables against the reference. */
#include <math.h>
#include <stdlib.h>

#include "reference.h"

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

/* Error of a texel against the adaptive double integral, of what is above 1. */
static double error(ibl_ctx *ctx, const ibl_lut *lut, ibl_geometry geometry,
                    int i, int j)
{
    const int n = lut->size;
    const float *p = lut->data + 2 * (j * (ptrdiff_t)n + i);
    const double nv = (i + 0.5) / n, r = (j + 0.5) / n;
    double want[2], worst = 0;

    if (lut->kind == IBL_LUT_CHARLIE)
        NEED(!ibl_reference_sheen(ctx, nv, r, want));
    else
        reference_lut(nv, r, geometry, want);
    for (int c = 0; c < 2; c++)
        worst = fmax(worst, fabs((double)p[c] - want[c]) / fmax(want[c], 1));
    return worst;
}

/* Tables with and without interpolation: corners, a grid, random texels, and
 * where the width of the lobe meets that of the grazing view. (The adaptive
 * integral needs seconds below that in large tables.) */
static void check_table(ibl_ctx *ctx, int n, ibl_lut_kind kind, ibl_geometry g,
                        double most)
{
    static const double grid[] = {0, 0.04, 0.3, 1};
    test_random rnd = {7};
    const ibl_lut lut = bake(ctx, n, kind, g, 0);
    double worst = 0;

    NEED(lut.size == n && lut.kind == kind && ibl_lut_channels(kind) == 2);
    for (int k = 0; k < 32; k++) {
        const double top = k % 2 ? n : fmin(n, 8);
        int i = (int)(test_random_unit(&rnd) * n);
        int j = (int)(test_random_unit(&rnd) * n);
        if (k < 16) {
            i = (int)((n - 1) * grid[k / 4]);
            j = (int)((n - 1) * grid[k % 4]);
        } else if (kind == IBL_LUT_CHARLIE) { /* the smoothest grazing texels */
            i = (int)(test_random_unit(&rnd) * top);
            j = (int)(test_random_unit(&rnd) * top);
        } else if (k > 26 && (k > 28 || n < 1000)) {
            i = 0;
            j = (int)(sqrt(n) * (k - 26) / 2) % n;
        }
        if (n < 1000 || i || j || kind == IBL_LUT_CHARLIE)
            worst = fmax(worst, error(ctx, &lut, g, i, j));
    }
    CHECK_MSG(worst <= most, "%s, kind %d, %s, size %d: worst error %g",
              ibl_isa_name(ibl_ctx_isa(ctx)), kind, ibl_geometry_name(g), n,
              worst);
    test_measured("table", worst, most);
}

TEST_OF(tables, "tables", TEST_RACES)
{
    static const int sizes[] = {1, 2, 3, 17, 28, 29, 64, 100, 511, 4096};
    static const int sheen[] = {1, 60, 256, 1024};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int k = 0; k < 10; k++)
        check_table(ctx, sizes[k], IBL_LUT_SPLIT, geometries[k % 2], 3e-5);
    for (int k = 0; k < 4; k++)
        check_table(ctx, sheen[k], IBL_LUT_CHARLIE, geometries[0], 5e-5);
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT; isa = test_next_isa(isa))
        for (int g = 0; g < 2; g++)
            check_table(test_ctx(2, isa), 256, IBL_LUT_SPLIT, geometries[g],
                        1.5e-5);
}

/* The published algorithm comes to the same integrals, as fast as its
 * points allow, and its limits are finite. */
TEST_OF(samples, "samples", TEST_RACES)
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
