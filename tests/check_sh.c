/* SPDX-License-Identifier: MIT */
/* Harmonics against the reference, and irradiance by steps against that
 * without. */
#include <math.h>
#include <stdlib.h>

#include "reference.h"
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

/* Every coefficient, by every instruction set, against the reference's sum over
 * all pixels. */
static void against_truth(const ibl_image *env, int degree, double yaw)
{
    double *want = test_alloc(count(degree), sizeof *want);

    NEED(!ibl_reference_sh(reference_of(test_ctx(2, IBL_ISA_AUTO), env, yaw),
                           degree, want));
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        double *got = bake(test_ctx(2, isa), env, degree, yaw);
        for (size_t i = 0; i < count(degree); i++)
            CHECK_MSG(fabs(got[i] - want[i]) <= floats * want[i % 3],
                      "%s: %dx%d degree %d yaw %g: %zu: %.9g, not %.9g",
                      ibl_isa_name(isa), env->width, env->height, degree, yaw,
                      i, got[i], want[i]);
    }
}

TEST(random_maps)
{
    static const int sizes[][2] = {{1, 1},   {2, 1},   {1, 2},  {3, 2},
                                   {4, 2},   {5, 3},   {7, 4},  {17, 9},
                                   {32, 16}, {61, 31}, {8, 70}, {64, 3}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        ibl_image env = map_constant(ctx, sizes[k][0], sizes[k][1], 0);
        map_fill(&env, k + 1);
        against_truth(&env, 0, 0.0);
        against_truth(&env, 5, 1234.5);
        if (k % 4 == 3 && k < 8)
            against_truth(&env, 12, -20.0);
    }
}

/* One pixel at the highest degree, where nothing averages: within what floats
 * keep of the largest value of any Y_lm, sqrt((2l + 1) / 2 pi). By Gauss's nine
 * points. */
TEST(one_pixel_high)
{
    enum {
        DEGREE = IBL_MAX_SH_DEGREE,
        H = 512
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image env = map_constant(ctx, 2 * H, H, 0);
    double *want = test_alloc(count(DEGREE), sizeof *want), worst = 0;
    const double node[3] = {-sqrt(0.15), 0, sqrt(0.15)};

    map_set(&env, 301, 99, 1024, 1, 0);
    double *got = bake(ctx, &env, DEGREE, 17.0);
    for (int n = 0; n < 9; n++) {
        const double theta = M_PI / H * (99.5 + node[n / 3]);
        const double phi = M_PI / H * (301.5 + node[n % 3]) - M_PI;
        const double mass = (n / 3 == 1 ? 8 : 5) * (n % 3 == 1 ? 8 : 5) / 324.0;
        double d[3];
        polar_direction(theta, phi - 17 * M_PI / 180, d);
        for (int l = 0; l <= DEGREE; l++)
            for (int m = -l; m <= l; m++)
                want[l * l + l + m] +=
                    mass * pow(M_PI / H, 2) * sin(theta) * truth_sh(l, m, d);
    }
    for (size_t i = 0; i < count(DEGREE); i++) {
        const double size[3] = {1024, 1, 0};
        const double most = want[0] * sqrt(4.0 * DEGREE + 2.0);
        const double off = fabs(got[i] - size[i % 3] * want[i / 3]);
        worst = fmax(worst, off / fmax(size[i % 3] * most, 1e-300));
    }
    CHECK_MSG(worst <= floats, "%.3g", worst);
}

/* ---- irradiance by steps ---------------------------------------------------
 */

/* The grid over the hemisphere comes to the same sum as its step falls, from
 * the same side of the same yaw, and keeps a constant. */
static void check_grid(ibl_ctx *ctx, int w, int h)
{
    static const double steps[] = {0.5, 0.1, 0.025},
                        limits[] = {0.1, 1e-2, 2e-3};
    ibl_image env = map_constant(ctx, w, h, 0);
    ibl_irradiance_options opts = ibl_irradiance_options_default();
    ibl_cube grid = {0}, exact = {0};

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
    NEED(!ibl_bake_irradiance(ctx, &env, &opts, &exact));
    test_cube(exact);
    for (int k = 0; k < 3; k++) {
        opts.step = steps[k];
        NEED(!ibl_bake_irradiance(ctx, &env, &opts, &grid));
        test_cube(grid);
        double worst = 0.0;
        for (size_t i = 0; i < cube_floats(&exact); i++)
            worst = fmax(worst, fabs((double)grid.data[i] / exact.data[i] - 1));
        CHECK_MSG(worst < limits[k] * (w == 2 * h ? 1 : 3),
                  "%dx%d, step %g: worst %g", w, h, steps[k], worst);
        CHECK_MSG(worst > 0, "step %g did nothing", steps[k]);
    }
    for (int k = 0; k < 3 * w * h; k++)
        env.data[k] = 3.0f;
    NEED(!ibl_bake_irradiance(ctx, &env, &opts, &grid));
    test_cube(grid);
    for (size_t i = 0; i < cube_floats(&grid); i++)
        CHECK_NEAR(grid.data[i], 3.0, 1e-6);
}

TEST(hemisphere_grid)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    check_grid(ctx, 32, 128);
    check_grid(ctx, 256, 16);
}
