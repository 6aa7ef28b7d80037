/* SPDX-License-Identifier: MIT */
/*
 * The hard cases of maps: one bright pixel at every kind of place, odd sizes,
 * a checkerboard. tests/README.md has the table of all cases. Bounds follow
 * from the arithmetic, beside each test; u is the unit roundoff of float, v
 * that of double.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "maps.h"
#include "truth.h"

static const double u = 0x1p-24;
/* ---- one bright pixel -------------------------------------------------- */

/* Maps of even and odd size: a direction that is on the border of pixels in
 * one, half a pixel off, is at the centre of a pixel in the other. */
static const int sun_maps[][2] = {{128, 64}, {127, 63}};

static const struct {
    const char *name;
    double direction[3];
} suns[] = {{"zenith", {1e-9, 1, 1e-9}},
            {"nadir", {-1e-9, -1, 1e-9}},
            {"seam", {-1, 0.02, 1e-9}},
            {"other side of the seam", {-1, -0.02, -1e-9}},
            {"face centre +X", {1, 0, 0}},
            {"face centre +Z", {0, 0, 1}},
            {"edge of sides", {1, 0.3, 1}},
            {"edge of the top", {0.2, 1, 1}},
            {"edge of the bottom", {1, -1, -0.1}},
            {"corner", {1, 1, 1}},
            {"other corner", {-1, -1, 1}},
            {"anywhere", {0.3, -0.5, -0.8}}};

enum {
    SUNS = sizeof suns / sizeof suns[0]
};

/* A pixel of 1e6, 5e5 and 0 on a map of the same in sky. */
static ibl_image sun_map(ibl_ctx *ctx, const int size[2], int sun, float sky,
                         int at[2])
{
    const double *d = suns[sun].direction;
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const double unit[3] = {d[0] / length, d[1] / length, d[2] / length};
    ibl_image map = map_constant(ctx, size[0], size[1], sky);
    truth_latlong_pixel(size[0], size[1], unit, &at[0], &at[1]);
    map_set(&map, at[0], at[1], 1e6f, 5e5f, sky);
    return map;
}

/* cos(theta) from *low to *high where the meridian phi is in a texel, by the
 * rule of ibl/ibl.h; false: nowhere. */
static bool on_meridian(int n, int face, int x, int y, double phi, double *low,
                        double *high)
{
    const double right[2] = {2.0 * x / n - 1, 2.0 * (x + 1) / n - 1};
    const double down[2] = {2.0 * y / n - 1, 2.0 * (y + 1) / n - 1};
    const double c = cos(phi), s = sin(phi);
    double from = 0, to = INFINITY;
    if (face == 2 || face == 3) {
        /* u = c / k, v = +-s / k, k = |cot(theta)|: in 1 / k two slabs. */
        const double along[2] = {c, face == 2 ? s : -s};
        const double *range[2] = {right, down};
        for (int k = 0; k < 2; k++) {
            const double a = range[k][0] / along[k], b = range[k][1] / along[k];
            from = fmax(from, fmin(a, b));
            to = fmin(to, fmax(a, b));
        }
        if (!(from < to))
            return false;
        *high = 1 / sqrt(1 + from * from);
        *low = 1 / sqrt(1 + to * to);
        if (face == 3) {
            const double swap = -*low;
            *low = -*high;
            *high = swap;
        }
        return true;
    }
    const double q = face == 0 ? c : face == 1 ? -c : face == 4 ? s : -s;
    const double across = face == 0 ? -s : face == 1 ? s : face == 4 ? c : -c;
    if (!(q > 0) || across < right[0] * q || across >= right[1] * q)
        return false;
    *high = -down[0] * q / sqrt(1 + down[0] * q * down[0] * q);
    *low = -down[1] * q / sqrt(1 + down[1] * q * down[1] * q);
    return true;
}

enum {
    MERIDIANS = 512 /* of a pixel */
};

/* Solid angle that a pixel and a texel share: midpoints in phi, exact along
 * each meridian. Where a side of the texel cuts a pixel in phi the sum is off
 * by up to half a step of the pixel's height. */
static double shared(const ibl_image *map, const int at[2], int n, int face,
                     int x, int y)
{
    const double top = cos(M_PI * at[1] / map->height);
    const double bottom = cos(M_PI * (at[1] + 1) / map->height);
    const double width = 2 * M_PI / map->width;
    double sum = 0;
    for (int k = 0; k < MERIDIANS; k++) {
        const double phi = (at[0] + (k + 0.5) / MERIDIANS) * width - M_PI;
        double low, high;
        if (on_meridian(n, face, x, y, phi, &low, &high))
            sum += fmax(0, fmin(high, top) - fmax(low, bottom));
    }
    return sum * width / MERIDIANS;
}

/* Every texel of level 0 against the share of it that the bright pixel
 * covers: the solid angles of both (check_property, energy_of_level0: 1e-5 of
 * them), the meridians of the truth, one float. */
TEST(sun_in_level0)
{
    enum {
        N = 16
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    double most = 0;
    for (int k = 0; k < 2 * SUNS; k++) {
        int at[2];
        ibl_image map = sun_map(ctx, sun_maps[k % 2], k / 2, 0, at);
        ibl_cube cube = cube_level0(ctx, &map, 0, N);
        const double width = 2 * M_PI / map.width;
        const double height = cos(M_PI * at[1] / map.height) -
                              cos(M_PI * (at[1] + 1) / map.height);
        for (int i = 0; i < IBL_FACES * N * N; i++) {
            const int face = i / (N * N), x = i % N, y = i / N % N;
            const double angle = ibl_cube_solid_angle(N, x, y);
            const double want = 1e6 * shared(&map, at, N, face, x, y) / angle;
            /* A texel's two ends in phi and the pixel's own. */
            const double slack = 1e6 / angle * width * 2 * height / MERIDIANS +
                                 (1e-5 + u) * want;
            const double got = cube.data[3 * i];
            CHECK_MSG(fabs(got - want) <= slack,
                      "%s in %dx%d: face %d (%d, %d) is %g, not %g +- %g",
                      suns[k / 2].name, map.width, map.height, face, x, y, got,
                      want, slack);
            CHECK(cube.data[3 * i + 2] == 0 &&
                  cube.data[3 * i + 1] == cube.data[3 * i] / 2);
            most = fmax(most, fabs(got - want) / (slack + 1e-9));
        }
    }
    test_measured("sun_in_level0, worst share of the bound", most, 1);
}

/* ---- sizes ------------------------------------------------------------- */

/* Large, and 1600 is no power of two times 2: the energy of level 0
 * (check_property has its bound) and irradiance to a float. */
static void check_large(int w, int h)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_constant(ctx, w, h, 0);
    for (size_t i = 0; i < map_floats(&map); i++)
        map.data[i] = (float)(i * 2654435761u % 4096) / 4096;
    map_set(&map, 0, 0, 1e6f, 1e6f, 1e6f);
    map_set(&map, w - 1, h / 2, 1e6f, 1e6f, 1e6f);
    ibl_cube a = cube_level0(ctx, &map, 0, 16),
             b = cube_irradiance(ctx, &map, 0, 1);
    double mean[3], sum[3] = {0, 0, 0};
    truth_mean(&map, mean);
    for (int c = 0; c < 3; c++)
        CHECK_NEAR(cube_mean(&a, 0, c), mean[c], (1.1e-5 + u) * mean[c]);
    for (int face = 0; face < (w > 8000 ? 1 : 6); face++) {
        double d[3];
        truth_cube_direction(1, face, 0, 0, d);
        truth_irradiance(&map, d, sum);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(b.data[3 * face + c], sum[c],
                       IBL_TOLERANCE_DEFAULT * sum[c]);
    }
}

TEST(size_1600)
{
    check_large(1600, 800);
}

TEST(size_16384)
{
    const char *large = getenv("IBL_TEST_LARGE");
    if (!large || !*large || *large == '0') {
        test_skip("needs 1.6 GB and ten seconds; make check LARGE=1 runs it");
        return;
    }
    check_large(16384, 8192);
}

/*
 * A checkerboard of pixels, 8 and more to a texel's edge: gray. Along a line
 * the pixels that it cuts alternate, and the shares it cuts off change slowly,
 * so that neighbours cancel: what is left of an edge is the ends and one for
 * each row it crosses, at most 1 + rows of half a pixel, 1/64 of a texel
 * each. The levels below are averages of a cube of such texels: no worse.
 */
TEST(checkerboard)
{
    enum {
        N = 32
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_of_kind(ctx, NULL, MAP_CHECKERBOARD, 1024, 512);
    ibl_cube cube = cube_specular(ctx, &map, 0, N, 4, 256),
             b = cube_irradiance(ctx, &map, 0, 4);
    double worst[5] = {0};
    for (int l = 0; l < 4; l++) {
        for (int c = 0; c < 3; c++) {
            double low, high;
            cube_range(&cube, l, c, &low, &high);
            worst[l] = fmax(worst[l], fmax(high - 0.5, 0.5 - low));
        }
    }
    CHECK_MSG(worst[0] <= 4 * (1 + 8) * 0.5 / 64, "level 0: %g", worst[0]);
    for (int l = 1; l < 4; l++)
        CHECK_MSG(worst[l] <= worst[0] + 8 * 256 * u, "level %d: %g", l,
                  worst[l]);
    for (int i = 0; i < IBL_FACES * 16; i += 5) {
        double d[3], want[3];
        truth_cube_direction(4, i / 16, i % 4, i / 4 % 4, d);
        truth_irradiance(&map, d, want);
        CHECK_NEAR(b.data[3 * i], want[0], 1.01 * u * want[0]);
        worst[4] = fmax(worst[4], fabs((double)b.data[3 * i] - 0.5));
    }
    test_measured("checkerboard, level 0", worst[0], 4 * 9 * 0.5 / 64);
    test_measured("checkerboard, level 3", worst[3], worst[0]);
    test_measured("checkerboard, irradiance", worst[4], worst[0]);
}
