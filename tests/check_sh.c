/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "maps.h"
#include "test.h"
#include "truth.h"

static const double pi = 3.14159265358979323846;

static size_t count(int degree)
{
    return 3 * (size_t)(degree + 1) * (size_t)(degree + 1);
}

static double *bake(ibl_ctx *ctx, const ibl_image *env, int degree, double yaw)
{
    double *coeffs = malloc(count(degree) * sizeof *coeffs);

    if (!coeffs || ibl_bake_sh(ctx, env, degree, yaw, coeffs))
        exit(1);
    return coeffs;
}

/* Direction of a pixel in the world of a yawed bake. */
static void world_direction(const ibl_image *env, int i, int j, double yaw_deg,
                            double dir[3])
{
    const double c = cos(yaw_deg / 180 * pi), s = sin(yaw_deg / 180 * pi);
    double d[3];

    truth_latlong_direction(env->width, env->height, i, j, d);
    dir[0] = d[0] * c + d[2] * s;
    dir[1] = d[1];
    dir[2] = d[2] * c - d[0] * s;
}

/* Every coefficient up to l = 4 against the sum over all pixels of its
 * polynomial. */
static void against_truth(ibl_ctx *ctx, const ibl_image *env, int degree,
                          double yaw)
{
    double *got = bake(ctx, env, degree, yaw);

    for (int l = 0; l <= degree && l <= 4; l++) {
        for (int m = -l; m <= l; m++) {
            double want[3] = {0}, all[3] = {0};
            for (int j = 0; j < env->height; j++) {
                const double angle =
                    truth_latlong_solid_angle(env->width, env->height, j);
                for (int i = 0; i < env->width; i++) {
                    double dir[3];
                    world_direction(env, i, j, yaw, dir);
                    const double y = truth_sh(l, m, dir) * angle;
                    for (int k = 0; k < 3; k++) {
                        want[k] += y * map_pixel(env, i, j)[k];
                        all[k] += angle * map_pixel(env, i, j)[k];
                    }
                }
            }
            for (int k = 0; k < 3; k++)
                CHECK_MSG(fabs(got[3 * (l * (l + 1) + m) + k] - want[k]) <=
                              2e-14 * all[k],
                          "%dx%d degree %d yaw %g: l %d m %d: %.17g, not %.17g",
                          env->width, env->height, degree, yaw, l, m,
                          got[3 * (l * (l + 1) + m) + k], want[k]);
        }
    }
    free(got);
}

static void random_maps(void)
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
        ibl_image_free(&env);
    }
    ibl_ctx_free(ctx);
}

/* A constant has Y_00 alone; the pixels' solid angles sum to 4 pi, and every
 * order but the zonal ones of the y axis cancels along the rows. */
static void constant_map(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 512, 256, 0);

    for (int k = 0; k < 3 * 512 * 256; k++)
        env.data[k] = 2.0f;
    double *c = bake(ctx, &env, 4, 0.0);
    CHECK_NEAR(c[0], 2.0 * sqrt(4.0 * pi), 1e-12);
    for (size_t k = 3; k < count(4); k++)
        CHECK_NEAR(c[k], 0.0, 5e-4);
    free(c);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

/* The graphics convention by its nine polynomials, spelt out: radiance
 * 1 + x is DC and Y_11, and so on. */
static void nine(void)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 1024, 512, 0);
    const double one = 2.0 * sqrt(pi), linear = sqrt(4.0 * pi / 3.0);

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
    free(c);

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
    CHECK_NEAR(c[3 * 4], sqrt(4.0 * pi / 15.0), 2e-5);
    CHECK_NEAR(c[3 * 8 + 1], sqrt(16.0 * pi / 15.0), 2e-5);
    CHECK_NEAR(c[3 * 6 + 2], sqrt(16.0 * pi / 5.0), 5e-5);
    CHECK_NEAR(c[3 * 5], 0.0, 1e-6);
    CHECK_NEAR(c[3 * 4 + 1], 0.0, 1e-6);
    free(c);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static double power(const double *coeffs, int l, int a, int b)
{
    double sum = 0.0;

    for (int m = -l; m <= l; m++)
        sum += coeffs[3 * (l * (l + 1) + m) + a] *
               coeffs[3 * (l * (l + 1) + m) + b];
    return sum;
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

/*
 * The addition theorem: for two one-pixel suns, sum over m of a_lm b_lm is
 * dO_a dO_b (2l + 1) / 4pi P_l(d_a . d_b), and with itself P_l(1) = 1.
 */
static void addition_theorem(int degree, int w, int h)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, w, h, 0);
    const int at[3][2] = {{w / 3, h / 5}, {w - 1, h / 2}, {w / 2, h - 1}};
    double d[3][3], angle[3];

    for (int k = 0; k < 3; k++) {
        map_pixel(&env, at[k][0], at[k][1])[k] = 1024.0f;
        world_direction(&env, at[k][0], at[k][1], 17.0, d[k]);
        angle[k] = 1024.0 * truth_latlong_solid_angle(w, h, at[k][1]);
    }
    double *c = bake(ctx, &env, degree, 17.0);
    for (int l = 0; l <= degree; l++) {
        for (int k = 0; k < 9; k++) {
            const double *a = d[k / 3], *b = d[k % 3];
            const double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            const double full =
                (2 * l + 1) / (4 * pi) * angle[k / 3] * angle[k % 3];
            const double p = k / 3 == k % 3 ? 1.0 : legendre(l, dot);
            CHECK_NEAR(power(c, l, k / 3, k % 3) / full, p, 1e-11);
        }
    }
    free(c);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static void addition_theorem_low(void)
{
    addition_theorem(30, 64, 32);
    addition_theorem(40, 7, 5);
}

static void addition_theorem_high(void)
{
    addition_theorem(TEST_SANITIZED ? 300 : IBL_MAX_SH_DEGREE, 63, 32);
}

/* All of Y_lm, l <= 200, at one direction: from a one-pixel sun against a
 * recurrence in z, the polar axis of the convention. */
static void high_degree_values(void)
{
    enum {
        L = 200
    };
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 50, 25, 0);
    double d[3];

    map_pixel(&env, 31, 9)[0] = 1.0f;
    truth_latlong_direction(50, 25, 31, 9, d);
    const double angle = truth_latlong_solid_angle(50, 25, 9);
    double *c = bake(ctx, &env, L, 0.0);
    const double phi = atan2(d[1], d[0]), s = hypot(d[0], d[1]);
    double start = sqrt(1.0 / (4.0 * pi));
    for (int m = 0; m <= L; m++) {
        if (m)
            start *= s * sqrt((2.0 * m + 1.0) / (2.0 * m));
        double p = start, before = 0.0;
        for (int l = m; l <= L; l++) {
            const double g = m ? sqrt(2.0) * angle : angle;
            CHECK_NEAR(c[3 * (l * (l + 1) + m)], g * p * cos(m * phi),
                       1e-12 * angle * l + 1e-16);
            if (m)
                CHECK_NEAR(c[3 * (l * (l + 1) - m)], g * p * sin(m * phi),
                           1e-12 * angle * l + 1e-16);
            const double n = l + 1, n2 = n * n, m2 = (double)m * m;
            const double next =
                sqrt((4 * n2 - 1) / (n2 - m2)) *
                (d[2] * p -
                 sqrt(((double)l * l - m2) / (4.0 * l * l - 1)) * before);
            before = p;
            p = next;
        }
    }
    free(c);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

/* Several blocks of rows and of orders give what one does. */
static void tall_map(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 5, 901, 0);

    map_fill(&env, 8);
    double *low = bake(ctx, &env, 3, 5.0);
    double *high = bake(ctx, &env, TEST_SANITIZED ? 200 : 600, 5.0);
    for (size_t k = 0; k < count(3); k++)
        CHECK_NEAR(low[k], high[k], 1e-12);
    free(low);
    free(high);
    ibl_image_free(&env);
    env = map_constant(ctx, 40000, 2, 0);
    map_fill(&env, 8);
    low = bake(ctx, &env, 3, 5.0);
    high = bake(ctx, &env, 150, 5.0);
    for (size_t k = 0; k < count(3); k++)
        CHECK_NEAR(low[k], high[k], 1e-12);
    free(low);
    free(high);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static void threads_and_isa(void)
{
    static const int threads[] = {1, 2, 7};
    double *first = NULL;

    for (int isa = IBL_ISA_C; isa <= (int)ibl_isa_best(); isa++) {
        double *same = NULL;
        for (int k = 0; k < 3; k++) {
            ibl_ctx *ctx = test_ctx(threads[k], (ibl_isa)isa);
            ibl_image env = map_constant(ctx, 150, 75, 0);
            map_fill(&env, 3);
            map_pixel(&env, 17, 20)[2] = 3e5f;
            double *c = bake(ctx, &env, 50, 12.0);
            if (same)
                CHECK(!memcmp(c, same, count(50) * sizeof *c));
            else
                same = c;
            if (same != c)
                free(c);
            ibl_image_free(&env);
            ibl_ctx_free(ctx);
        }
        if (!first)
            first = same;
        for (size_t i = 0; i < count(50); i++)
            CHECK_NEAR(same[i], first[i], i % 3 == 2 ? 1e-8 : 1e-13);
        if (same != first)
            free(same);
    }
    free(first);
}

/* pi times the factor is the integral of the clamped cosine with P_l, times
 * 2 pi: Simpson's rule over the half where it is not zero. */
static void cosine_factors(void)
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

/* Irradiance from the coefficients up to l = 4 against the sum over pixels:
 * what is cut off is small. */
static void irradiance_from_coefficients(void)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 64, 32, 0);

    map_fill(&env, 4);
    for (int j = 0; j < 10; j++)
        map_pixel(&env, 20, j)[0] = 5.0f;
    double *c = bake(ctx, &env, 30, 0.0);
    double dir[3] = {0.36, 0.48, 0.8}, want[3];
    truth_irradiance(&env, dir, want);
    double got[3] = {0};
    for (int l = 0; l <= 4; l++) {
        for (int m = -l; m <= l; m++) {
            for (int k = 0; k < 3; k++)
                got[k] += ibl_sh_cosine(l) * c[3 * (l * (l + 1) + m) + k] *
                          truth_sh(l, m, dir);
        }
    }
    for (int k = 0; k < 3; k++)
        CHECK_NEAR(got[k], want[k], 0.01 * want[k]);
    free(c);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static void bad_arguments(void)
{
    test_messages kept = {{{0}}};
    double c[3] = {7, 7, 7};

    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_image env = map_constant(ctx, 4, 2, 0);
    CHECK(ibl_bake_sh(ctx, &env, -1, 0.0, c) == IBL_ERR_ARGUMENT);
    CHECK(strstr(kept.text[IBL_LOG_ERROR], "degree -1"));
    CHECK(ibl_bake_sh(ctx, &env, 1001, 0.0, c) == IBL_ERR_ARGUMENT);
    CHECK(ibl_bake_sh(ctx, &env, 0, NAN, c) == IBL_ERR_ARGUMENT);
    CHECK(c[0] == 7 && c[2] == 7);
    ibl_ctx_cancel(ctx);
    CHECK(ibl_bake_sh(ctx, &env, 0, 0.0, c) == IBL_ERR_CANCELLED);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static const test tests[] = {
    TEST(random_maps),
    TEST(constant_map),
    TEST(nine),
    TEST(addition_theorem_low),
    TEST(addition_theorem_high),
    TEST(high_degree_values),
    TEST(tall_map),
    TEST(threads_and_isa),
    TEST(cosine_factors),
    TEST(irradiance_from_coefficients),
    TEST(bad_arguments),
};
TEST_MAIN(tests)
