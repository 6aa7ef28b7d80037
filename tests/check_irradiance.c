/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

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
