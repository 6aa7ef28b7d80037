/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "maps.h"
#include "test.h"
#include "truth.h"

static size_t count(int degree)
{
    return 3 * (size_t)(degree + 1) * (size_t)(degree + 1);
}

static double *bake(ibl_ctx *ctx, const ibl_image *env, int degree, double yaw)
{
    double *coeffs = test_alloc(count(degree), sizeof *coeffs);

    if (ibl_bake_sh(ctx, env, degree, yaw, coeffs))
        exit(1);
    return coeffs;
}

/* A few float roundings a row of the sum of L |Y_lm| dO, on average Y_00's. */
static const double floats = 1e-6;

/* Every coefficient against the sum over all pixels. */
static void against_truth(ibl_ctx *ctx, const ibl_image *env, int degree,
                          double yaw)
{
    double *got = bake(ctx, env, degree, yaw);
    double *want = test_alloc(count(degree), sizeof *want);

    if (!want)
        exit(1);
    truth_harmonics(env, degree, yaw, want);
    for (size_t i = 0; i < count(degree); i++)
        CHECK_MSG(fabs(got[i] - want[i]) <= floats * want[i % 3],
                  "%dx%d degree %d yaw %g: %zu: %.9g, not %.9g", env->width,
                  env->height, degree, yaw, i, got[i], want[i]);
}

TEST_SLOW(random_maps)
{
    static const int sizes[][2] = {{1, 1},   {2, 1},   {1, 2},  {3, 2},
                                   {4, 2},   {5, 3},   {7, 4},  {17, 9},
                                   {32, 16}, {61, 31}, {8, 70}, {64, 3}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        ibl_image env = map_constant(ctx, sizes[k][0], sizes[k][1], 0);
        map_fill(&env, k + 1);
        for (int degree = 0; degree <= 5; degree++)
            against_truth(ctx, &env, degree, 0.0);
        against_truth(ctx, &env, 4, 90.0);
        against_truth(ctx, &env, 12, 1234.5);
        against_truth(ctx, &env, 3, -20.0);
    }
}

/* The graphics convention's nine polynomials: radiance 1 + x is DC and Y_11. */
TEST(nine)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 1024, 512, 0);
    const double one = 2.0 * sqrt(M_PI), linear = sqrt(4.0 * M_PI / 3.0);

    for (int j = 0; j < 512; j++) {
        for (int i = 0; i < 1024; i++) {
            double d[3];
            truth_latlong_direction(1024, 512, i, j, d);
            for (int k = 0; k < 3; k++)
                map_pixel(&env, i, j)[k] = (float)(1.0 + d[k]);
        }
    }
    double *c = bake(ctx, &env, 2, 0.0);
    static const int index[3] = {3, 1, 2}; /* x, y, z */
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(c[k], one, 1e-5);
        for (int i = 1; i < 9; i++)
            CHECK_NEAR(c[3 * i + k], i == index[k] ? linear : 0.0, 2e-5);
    }

    for (int j = 0; j < 512; j++) {
        for (int i = 0; i < 1024; i++) {
            double d[3];
            truth_latlong_direction(1024, 512, i, j, d);
            map_pixel(&env, i, j)[0] = (float)(1.0 + d[0] * d[1]);
            map_pixel(&env, i, j)[1] = (float)(1.0 + d[0] * d[0] - d[1] * d[1]);
            map_pixel(&env, i, j)[2] = (float)(1.0 + 3.0 * d[2] * d[2]);
        }
    }
    c = bake(ctx, &env, 2, 0.0);
    CHECK_NEAR(c[3 * 4], sqrt(4.0 * M_PI / 15.0), 2e-5);
    CHECK_NEAR(c[3 * 8 + 1], sqrt(16.0 * M_PI / 15.0), 2e-5);
    CHECK_NEAR(c[3 * 6 + 2], sqrt(16.0 * M_PI / 5.0), 5e-5);
    CHECK_NEAR(c[3 * 5], 0.0, 1e-6);
    CHECK_NEAR(c[3 * 4 + 1], 0.0, 1e-6);
}

static double legendre(int l, double x)
{
    double before = 0.0, p = 1.0;

    for (int k = 1; k <= l; k++) {
        const double next = ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k;
        before = p;
        p = next;
    }
    return p;
}

/* One pixel at high degrees, where nothing averages: within what floats keep
 * of the largest value of any Y_lm, sqrt((2l + 1) / 2 pi). */
static void one_pixel(int degree, int w, int h)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, w, h, 0);
    double *want = test_alloc(count(degree), sizeof *want);

    if (!want)
        exit(1);
    map_set(&env, w / 3, h / 5, 1024, 1, 0);
    truth_harmonics(&env, degree, 17.0, want);
    double *got = bake(ctx, &env, degree, 17.0);
    double worst = 0;
    for (size_t i = 0; i < count(degree); i++) {
        const double most = want[i % 3] * sqrt(4.0 * degree + 2.0);
        worst =
            fmax(worst, most > 0 ? fabs(got[i] - want[i]) / most : got[i] != 0);
    }
    CHECK_MSG(worst <= floats, "%dx%d, degree %d: %.3g", w, h, degree, worst);
}

TEST(one_pixel_low)
{
    one_pixel(30, 64, 32);
    one_pixel(40, 7, 5);
}

TEST(one_pixel_high)
{
    one_pixel(IBL_MAX_SH_DEGREE, 50, 25);
    one_pixel(IBL_MAX_SH_DEGREE, 4096, 2048);
}

/* Several blocks of rows and of orders give what one does. */
TEST(tall_map)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 5, 901, 0);

    map_fill(&env, 8);
    double *low = bake(ctx, &env, 3, 5.0);
    double *high = bake(ctx, &env, IBL_MAX_SH_DEGREE, 5.0);
    for (size_t k = 0; k < count(3); k++)
        CHECK_NEAR(low[k], high[k], floats * low[k % 3]);
}

TEST(threads_and_isa)
{
    static const int threads[] = {1, 2, 7};
    double *first = NULL;

    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        double *same = NULL;
        for (int k = 0; k < 3; k++) {
            ibl_ctx *ctx = test_ctx(threads[k], isa);
            ibl_image env = map_constant(ctx, 150, 75, 0);
            map_fill(&env, 3);
            map_pixel(&env, 17, 20)[2] = 3e5f;
            double *c = bake(ctx, &env, 50, 12.0);
            if (same)
                CHECK(!memcmp(c, same, count(50) * sizeof *c));
            else
                same = c;
        }
        if (!first)
            first = same;
        for (size_t i = 0; i < count(50); i++)
            CHECK_NEAR(same[i], first[i], floats * first[i % 3]);
    }
}

/* pi times the factor is the integral of the clamped cosine with P_l, times
 * 2 pi: Simpson's rule over the half where it is not zero. */
TEST(cosine_factors)
{
    CHECK_NEAR(ibl_sh_cosine(0), 1.0, 1e-15);
    CHECK_NEAR(ibl_sh_cosine(1), 2.0 / 3.0, 1e-15);
    CHECK_NEAR(ibl_sh_cosine(2), 0.25, 1e-15);
    CHECK(ibl_sh_cosine(3) == 0.0);
    CHECK_NEAR(ibl_sh_cosine(4), -1.0 / 24.0, 1e-15);
    for (int l = 0; l <= 30; l++) {
        const int n = 4000;
        double sum = 0.0;
        for (int i = 0; i <= n; i++) {
            const double x = (double)i / n;
            const double weight = i == 0 || i == n ? 1 : i % 2 ? 4 : 2;
            sum += weight * x * legendre(l, x);
        }
        CHECK_NEAR(ibl_sh_cosine(l), 2.0 * sum / (3.0 * n), 1e-9);
    }
    CHECK(isfinite(ibl_sh_cosine(IBL_MAX_SH_DEGREE)));
}

TEST(bad_arguments)
{
    test_messages kept = {{{0}}};
    double c[3] = {7, 7, 7};

    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_image env = map_constant(ctx, 4, 2, 0);
    CHECK(ibl_bake_sh(ctx, &env, -1, 0.0, c) == IBL_ERR_ARGUMENT);
    CHECK(strstr(kept.text[IBL_LOG_ERROR], "degree -1"));
    CHECK(ibl_bake_sh(ctx, &env, 65, 0.0, c) == IBL_ERR_ARGUMENT);
    CHECK(ibl_bake_sh(ctx, &env, 0, NAN, c) == IBL_ERR_ARGUMENT);
    CHECK(c[0] == 7 && c[2] == 7);
    ibl_ctx_cancel(ctx);
    CHECK(ibl_bake_sh(ctx, &env, 0, 0.0, c) == IBL_ERR_CANCELLED);
}
