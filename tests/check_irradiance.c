/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "maps.h"
#include "truth.h"

static ibl_cube bake(ibl_ctx *ctx, const ibl_image *env, int size, double yaw)
{
    ibl_irradiance_options opts = ibl_irradiance_options_default();
    ibl_cube cube = {0};

    opts.size = size;
    opts.yaw_deg = yaw;
    if (ibl_bake_irradiance(ctx, env, &opts, &cube))
        exit(1);
    return test_cube(cube);
}

static const float *texel(const ibl_cube *cube, int face, int x, int y)
{
    return ibl_cube_face(cube, 0, face) +
           3 * ((size_t)y * (size_t)cube->size + (size_t)x);
}

static size_t floats(const ibl_cube *cube)
{
    return 3 * ibl_cube_texels(cube->size, cube->levels);
}

/* Every stride-th texel of the cube against the sum over all pixels, within the
 * tolerance of the bake, in parts of the mean where it is dark; the world's
 * normal is turned by +yaw into the map. */
static void against_truth(const ibl_image *env, const ibl_cube *cube,
                          double yaw_deg, int stride)
{
    const int n = cube->size;
    const double c = cos(yaw_deg / 180 * M_PI), s = sin(yaw_deg / 180 * M_PI);
    double mean[3];

    truth_mean(env, mean);
    for (int k = 0; k < IBL_FACES * n * n; k += stride) {
        double dir[3], map[3], rgb[3];
        const int face = k / (n * n), y = k / n % n, x = k % n;
        truth_cube_direction(n, face, x, y, dir);
        map[0] = dir[0] * c - dir[2] * s;
        map[1] = dir[1];
        map[2] = dir[2] * c + dir[0] * s;
        truth_irradiance(env, map, rgb);
        for (int ch = 0; ch < 3; ch++) {
            const double got = texel(cube, face, x, y)[ch];
            CHECK_MSG(fabs(got - rgb[ch]) <=
                          3 * IBL_TOLERANCE_DEFAULT * fmax(rgb[ch], mean[ch]),
                      "%dx%d yaw %g, face %d (%d, %d): %.9g, not %.9g",
                      env->width, env->height, yaw_deg, face, x, y, got,
                      rgb[ch]);
        }
    }
}

TEST_SLOW(random_maps)
{
    static const int sizes[][2] = {{3, 2},   {4, 2},   {5, 3},  {7, 4}, {17, 9},
                                   {32, 16}, {61, 31}, {8, 64}, {64, 3}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        ibl_image env = map_constant(ctx, sizes[k][0], sizes[k][1], 0);
        map_fill(&env, k + 1);
        for (int size = 1; size <= 10; size += 3) {
            ibl_cube cube = bake(ctx, &env, size, 0.0);
            against_truth(&env, &cube, 0.0, 7);
            cube = bake(ctx, &env, size, -412.3);
            against_truth(&env, &cube, -412.3, 7);
        }
    }
}

/* More families of texels than fit one round, and more rows. */
TEST(large_cube)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 90, 45, 0);

    map_fill(&env, 5);
    ibl_cube cube = bake(ctx, &env, 101, 10.0);
    against_truth(&env, &cube, 10.0, 97);
}

/* The integral of the direction over a pixel. */
static void direction_integral(int w, int h, int i, int j, double sum[3])
{
    const double a = M_PI * j / h, b = M_PI * (j + 1) / h;
    const double c = 2 * M_PI * ((double)i / w - 0.5), d = c + 2 * M_PI / w;
    const double across = (b - a) / 2 - (sin(2 * b) - sin(2 * a)) / 4;

    sum[0] = across * (sin(d) - sin(c));
    sum[1] = (d - c) * (sin(b) * sin(b) - sin(a) * sin(a)) / 2;
    sum[2] = across * (cos(c) - cos(d));
}

/* One pixel of 1e6 gives the integral of L N.L / pi over it where it is whole
 * above the horizon; at most what its highest corner would where the horizon
 * crosses it, and normals that face away from all of it stay exactly black. */
TEST(one_pixel_sun)
{
    static const int suns[][2] = {{0, 0},    {5, 0},    {0, 127}, {0, 64},
                                  {255, 64}, {128, 63}, {77, 30}};
    const double reach = hypot(M_PI / 256, M_PI / 256);
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (size_t k = 0; k < sizeof suns / sizeof suns[0]; k++) {
        ibl_image env = map_constant(ctx, 256, 128, 0);
        double sun[3], sum[3];
        truth_latlong_direction(256, 128, suns[k][0], suns[k][1], sun);
        direction_integral(256, 128, suns[k][0], suns[k][1], sum);
        const double up =
            1e6 / M_PI * truth_latlong_solid_angle(256, 128, suns[k][1]);
        map_pixel(&env, suns[k][0], suns[k][1])[1] = 1e6f;
        ibl_cube cube = bake(ctx, &env, 16, 0.0);
        for (int t = 0; t < IBL_FACES * 256; t++) {
            double d[3];
            const float *got = texel(&cube, t / 256, t % 16, t / 16 % 16);
            truth_cube_direction(16, t / 256, t % 16, t / 16 % 16, d);
            const double c = d[0] * sun[0] + d[1] * sun[1] + d[2] * sun[2];
            const double want =
                1e6 / M_PI * (d[0] * sum[0] + d[1] * sum[1] + d[2] * sum[2]);
            CHECK(got[0] == 0.0f && got[2] == 0.0f);
            if (c >= reach)
                CHECK_NEAR(got[1], want, IBL_TOLERANCE_DEFAULT * want);
            else
                CHECK(got[1] >= 0 &&
                      (double)got[1] <= fmax(0, up * (c + reach)));
        }
    }
}

/* Radiance max(L.Y, 0): irradiance / pi is 2/3 looking up, 0 looking down and
 * 2/(3 pi) at the horizon (integrals of cos^2, and of cos over a quarter
 * sphere times sin^2). */
TEST(cosine_lobe)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 512, 256, 0);

    for (int j = 0; j < 128; j++) {
        for (int i = 0; i < 512; i++)
            map_pixel(&env, i, j)[0] = (float)cos(M_PI * (j + 0.5) / 256);
    }
    ibl_cube cube = bake(ctx, &env, 1, 0.0);
    CHECK_NEAR(texel(&cube, 2, 0, 0)[0], 2.0 / 3.0, 1e-4);
    CHECK(texel(&cube, 3, 0, 0)[0] < 1e-15f);
    CHECK_NEAR(texel(&cube, 0, 0, 0)[0], 2.0 / (3.0 * M_PI), 1e-4);
    CHECK_NEAR(texel(&cube, 5, 0, 0)[0], 2.0 / (3.0 * M_PI), 1e-4);
}

/* The grid over the hemisphere comes to the same sum as its step falls, from
 * the same side of the same yaw, and keeps a constant. */
static void check_grid(ibl_ctx *ctx, int w, int h)
{
    static const double steps[] = {0.5, 0.1, 0.025},
                        limits[] = {0.1, 1e-2, 2e-3};
    ibl_image env = map_constant(ctx, w, h, 0);
    ibl_irradiance_options opts = ibl_irradiance_options_default();
    ibl_cube grid = {0};

    for (int j = 0; j < h; j++) {
        for (int i = 0; i < w; i++) {
            double d[3];
            truth_latlong_direction(w, h, i, j, d);
            map_pixel(&env, i, j)[0] = (float)(1.0 + d[0]);
            map_pixel(&env, i, j)[1] = (float)(1.0 + d[1] * d[2]);
            map_pixel(&env, i, j)[2] = (float)exp(2.0 * d[2]);
        }
    }
    opts.size = 8;
    opts.yaw_deg = 50.0;
    ibl_cube exact = bake(ctx, &env, 8, 50.0);
    for (int k = 0; k < 3; k++) {
        opts.step = steps[k];
        NEED(!ibl_bake_irradiance(ctx, &env, &opts, &grid));
        test_cube(grid);
        double worst = 0.0;
        for (size_t i = 0; i < floats(&exact); i++)
            worst = fmax(worst, fabs((double)grid.data[i] / exact.data[i] - 1));
        CHECK_MSG(worst < limits[k] * (w == 2 * h ? 1 : 3),
                  "%dx%d, step %g: worst %g", w, h, steps[k], worst);
        CHECK_MSG(worst > 0, "step %g did nothing", steps[k]);
    }
    for (int k = 0; k < 3 * w * h; k++)
        env.data[k] = 3.0f;
    NEED(!ibl_bake_irradiance(ctx, &env, &opts, &grid));
    test_cube(grid);
    for (size_t i = 0; i < floats(&grid); i++)
        CHECK_NEAR(grid.data[i], 3.0, 1e-6);
}

TEST(hemisphere_grid)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    check_grid(ctx, 128, 64);
    if (TEST_RACES)
        return;
    check_grid(ctx, 32, 128);
    check_grid(ctx, 256, 16);
}

TEST(bad_options)
{
    test_messages kept = {{{0}}};
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_image env = map_constant(ctx, 4, 2, 0);
    ibl_cube cube = {0};
    ibl_irradiance_options opts = ibl_irradiance_options_default();

    CHECK(opts.size == 32 && opts.step == 0.0 && opts.yaw_deg == 0.0);
    opts.size = 0;
    CHECK(ibl_bake_irradiance(ctx, &env, &opts, &cube) == IBL_ERR_ARGUMENT);
    CHECK(strstr(kept.text[IBL_LOG_ERROR], "size 0"));
    opts.size = IBL_MAX_CUBE_SIZE + 1;
    CHECK(ibl_bake_irradiance(ctx, &env, &opts, &cube) == IBL_ERR_ARGUMENT);
    opts = ibl_irradiance_options_default();
    opts.step = 0.6;
    CHECK(ibl_bake_irradiance(ctx, &env, &opts, &cube) == IBL_ERR_ARGUMENT);
    opts.step = NAN;
    CHECK(ibl_bake_irradiance(ctx, &env, &opts, &cube) == IBL_ERR_ARGUMENT);
    opts.step = 1e-9;
    CHECK(ibl_bake_irradiance(ctx, &env, &opts, &cube) == IBL_ERR_MEMORY);
    CHECK(test_said(&kept, "hemisphere"));
    opts.step = -0.1;
    CHECK(ibl_bake_irradiance(ctx, &env, &opts, &cube) == IBL_ERR_ARGUMENT);
    opts = ibl_irradiance_options_default();
    opts.yaw_deg = INFINITY;
    CHECK(ibl_bake_irradiance(ctx, &env, &opts, &cube) == IBL_ERR_ARGUMENT);
    CHECK(!cube.data);
    ibl_ctx_cancel(ctx);
    CHECK(ibl_bake_irradiance(ctx, &env, NULL, &cube) == IBL_ERR_CANCELLED);
    CHECK(!cube.data);
}
