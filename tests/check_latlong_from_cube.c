/* SPDX-License-Identifier: MIT */
/* Cubes as equirectangular maps. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/pi.h"
#include "ibl/ibl.h"
#include "maps.h"

static ibl_ctx *ctx;

static ibl_cube make_cube(int n)
{
    ibl_cube cube = cube_alloc(ctx, n, 1);
    memset(cube.data, 0, 3 * sizeof(float) * ibl_cube_texels(n, 1));
    return cube;
}

static ibl_image make_map(const ibl_cube *cube)
{
    const int width = ibl_latlong_width(cube->size);
    ibl_image map = map_constant(ctx, width, width / 2, 0);
    if (ibl_latlong_from_cube(ctx, cube, &map))
        exit(1);
    return map;
}

static double map_energy(const ibl_image *map, int channel)
{
    double sum = 0;
    for (int y = 0; y < map->height; y++) {
        const double omega = 2 * IBL_PI / map->width *
                             (cos(IBL_PI * y / map->height) -
                              cos(IBL_PI * (y + 1) / map->height));
        for (int x = 0; x < map->width; x++)
            sum +=
                omega * (double)map->data[3 * (y * map->width + x) + channel];
    }
    return sum;
}

TEST(constant_stays)
{
    static const int sizes[] = {1, 2, 3, 7, 32, 33};

    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        ibl_cube cube = make_cube(sizes[i]);
        for (size_t k = 0; k < 3 * ibl_cube_texels(sizes[i], 1); k++)
            cube.data[k] = 0.7f;
        ibl_image map = make_map(&cube);
        for (int k = 0; k < 3 * map.width * map.height; k++)
            CHECK_NEAR((double)map.data[k], 0.7, 1e-6);
    }
}

static double lost_energy(ibl_cube *cube, int face, int x, int y)
{
    const int n = cube->size;
    float *texel = ibl_cube_face(cube, 0, face) + 3 * (y * n + x);

    texel[1] = 1000;
    ibl_image map = make_map(cube);
    texel[1] = 0;
    const double want = 1000 * ibl_cube_solid_angle(n, x, y);
    const double got = map_energy(&map, 1);
    return fabs(got / want - 1);
}

/* Each texel alone: what the map has of it is its solid angle. */
TEST(each_texel_keeps_its_energy)
{
    static const int sizes[] = {1, 2, 5, 33};
    double worst = 0;

    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const int n = sizes[i], step = 1 + n / 4;
        ibl_cube cube = make_cube(n);
        for (int f = 0; f < IBL_FACES; f++)
            for (int y = 0; y < n; y += step)
                for (int x = 0; x < n; x += step)
                    worst = fmax(worst, lost_energy(&cube, f, x, y));
    }
    CHECK_MSG(worst < 1e-6, "off by %g", worst);
}

/* Texels hold their directions, so a pixel from the wrong place is seen. */
static double worst_look(int n)
{
    ibl_cube cube = make_cube(n);
    double worst = 0;

    for (int f = 0; f < IBL_FACES; f++)
        for (int y = 0; y < n; y++)
            for (int x = 0; x < n; x++) {
                double d[3];
                ibl_cube_direction(n, f, x, y, d);
                for (int k = 0; k < 3; k++)
                    ibl_cube_face(&cube, 0, f)[3 * (y * n + x) + k] =
                        (float)(d[k] + 1);
            }
    ibl_image map = make_map(&cube);
    for (int y = 0; y < map.height; y++)
        for (int x = 0; x < map.width; x++) {
            const double theta = IBL_PI * (y + 0.5) / map.height;
            const double phi = 2 * IBL_PI * (x + 0.5) / map.width - IBL_PI;
            const double d[3] = {sin(theta) * cos(phi), cos(theta),
                                 sin(theta) * sin(phi)};
            for (int k = 0; k < 3; k++)
                worst = fmax(
                    worst, fabs((double)map.data[3 * (y * map.width + x) + k] -
                                1 - d[k]));
        }
    return worst;
}

TEST(pixels_look_where_texels_do)
{
    CHECK(worst_look(32) < 2.0 / 32);
    CHECK(worst_look(33) < 2.0 / 33);
}

TEST(shapes_that_do_not_fit)
{
    static const int shapes[][2] = {{4, 2}, {12, 6}, {16, 7}, {8, 1}};
    ibl_ctx *quiet = test_ctx_of(NULL);
    ibl_cube cube = make_cube(2);

    for (int i = 0; i < 4; i++) {
        ibl_image map = map_constant(ctx, shapes[i][0], shapes[i][1], 0);
        CHECK(ibl_latlong_from_cube(quiet, &cube, &map) == IBL_ERR_ARGUMENT);
    }
}

void test_setup(void)
{
    ctx = test_ctx(0, IBL_ISA_AUTO);
}
