/* SPDX-License-Identifier: MIT */
/*
 * Light that a pixel format cannot hold: laws of energy, of the cube's
 * symmetries, and of the texels that touch it, for each map of a table. Which
 * touch is found by corners that texels have in common, as whole numbers.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "ibl/io.h"
#include "image/overflow.h"
#include "maps.h"
#include "test.h"
#include "textures.h"

static const float half_max = 65504;
static ibl_ctx *ctx;

/* One level, one value everywhere. */
static ibl_cube constant(int n, float value)
{
    ibl_cube cube = cube_alloc(ctx, n, 1);
    for (size_t i = 0; i < cube_floats(&cube); i++)
        cube.data[i] = value;
    return cube;
}

static void set_texel(const ibl_cube *cube, int i, double r, double g, double b)
{
    cube->data[3 * i] = (float)r;
    cube->data[3 * i + 1] = (float)g;
    cube->data[3 * i + 2] = (float)b;
}

/* What is stored, decoded. */
static ibl_cube stored(const ibl_cube *cube, ibl_pixel pixel, ibl_overflow how,
                       ibl_overflow_report *report)
{
    ibl_texture tex = {0};
    ibl_cube back = {0};
    if (ibl_texture_from_cube(
            ctx, cube, &(ibl_texel_options){.pixel = pixel, .overflow = how},
            &tex, report) ||
        ibl_texture_to_cube(ctx, &tex, &back))
        exit(1);
    ibl_texture_free(&tex);
    return test_cube(back);
}

/* Floats without a pixel's rounding, all three channels up to max. */
static ibl_cube settled(const ibl_cube *cube, float max, ibl_overflow_level *l)
{
    const ibl_level_shape shape =
        ibl_level_shape_of(IBL_PROJECTION_CUBE, cube->size);
    float *data = NULL;
    if (ibl_overflow_settle(ctx, IBL_OVERFLOW_SPREAD, (float[]){max, max, max},
                            &shape, cube->data, &data, l) ||
        !data)
        exit(1);
    ibl_cube back = constant(cube->size, 0);
    memcpy(back.data, data, cube_floats(cube) * sizeof *data);
    ibl_free(data);
    return back;
}

/* Where texel i of 6 n n looks, and its solid angle. */
static void look(int n, int i, double dir[3])
{
    ibl_cube_direction(n, i / n / n, i % n, i / n % n, dir);
}

static double angle_of(int n, int i)
{
    return ibl_cube_solid_angle(n, i % n, i / n % n);
}

/* Corner c of texel i, in half texels from the cube's middle. */
static void corner(int n, int i, int c, int p[3])
{
    const int x = i % n + (c & 1), y = i / n % n + (c >> 1);
    const int u = 2 * x - n, v = 2 * y - n;
    const int rule[6][3] = {{n, -v, -u}, {-n, -v, u}, {u, n, v},
                            {u, -n, -v}, {u, -v, n},  {-u, -v, -n}};
    memcpy(p, rule[i / n / n], 3 * sizeof *p);
}

static bool touch(int n, int a, int b)
{
    for (int k = 0; k < 16; k++) {
        int p[3], q[3];
        corner(n, a, k % 4, p);
        corner(n, b, k / 4, q);
        if (!memcmp(p, q, sizeof p))
            return true;
    }
    return false;
}

/* A light on black, at every texel: what is over is in those that touch it, the
 * same in all of them, and no more nor less. */
TEST(one_light)
{
    static const int sizes[] = {1, 2, 3, 4, 7};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const int n = sizes[s], texels = IBL_FACES * n * n;
        for (int i = 0; i < texels; i++) {
            ibl_cube cube = constant(n, 0);
            ibl_overflow_level level;
            set_texel(&cube, i, 1.5 * (double)half_max, 0, 3);
            const double light = 0.5 * (double)half_max * angle_of(n, i);
            ibl_cube got = settled(&cube, half_max, &level);
            double angle = 0;
            for (int k = 0; k < texels; k++)
                if (k != i && touch(n, i, k))
                    angle += angle_of(n, k);
            for (int k = 0; k < texels; k++) {
                const double want = k == i           ? (double)half_max
                                    : touch(n, i, k) ? light / angle
                                                     : 0;
                CHECK_NEAR(got.data[3 * k], want, 1e-6 * want);
                CHECK(got.data[3 * k + 1] == 0 &&
                      got.data[3 * k + 2] == (k == i ? 3 : 0));
            }
            CHECK(level.texels == 1 && level.lost == 0);
        }
    }
}

/* ---- laws ---------------------------------------------------------------- */

/* Maps. values: of all texels, or the most of noise. lights: some texels of
 * five to ten times the largest half, unlike; where: those that look there, if
 * their dot product with it is above the cosine. */
static const struct {
    const char *name;
    int size;
    double values, noise; /* decades */
    int lights;
    double where[4], bright;
    double lost; /* of the light; < 0: none */
} maps[] = {
    {"black", 9, 0, 0, 0, {0}, 0, -1},
    {"the largest half", 9, 65504, 0, 0, {0}, 0, -1},
    {"above it", 9, 65505, 0, 0, {0}, 0, 1.0 / 65505},
    {"far above it", 9, 1e6, 0, 0, {0}, 0, 1 - 0.065504},
    {"the largest floats", 6, 3.4e38, 0, 0, {0}, 0, 1},
    {"few lights that meet", 5, 1e4, 8, 3, {0}, 0, -1},
    {"lights that meet", 12, 1e4, 8, 40, {0}, 0, -1},
    {"others", 13, 1e4, 8, 30, {0}, 0, -1},
    {"many texels", 77, 1e4, 8, 25, {0}, 0, -1},
    {"a corner", 12, 0.25, 0, 0, {1, 1, 1, 0.986}, 4e6, -1},
    {"an edge", 13, 0.25, 0, 0, {1, 0, -1, 0.988}, 4e6, -1},
    {"a pole", 12, 0.25, 0, 0, {0, -1, 0, 0.986}, 4e6, -1},
    {"half of the sphere, nearly full",
     48,
     0,
     0,
     0,
     {0, 1, 0, 0},
     1.9 * 65504,
     -1},
    {"half of the sphere, too much",
     48,
     0,
     0,
     0,
     {0, 1, 0, 0},
     2.1 * 65504,
     0.1 / 2.1},
};

static ibl_cube make_map(int k)
{
    const int n = maps[k].size, texels = IBL_FACES * n * n;
    const double *at = maps[k].where;
    ibl_cube cube = constant(n, (float)maps[k].values);
    test_random r = {(uint64_t)k};
    for (size_t i = 0; maps[k].noise > 0 && i < cube_floats(&cube); i++)
        cube.data[i] *= (float)pow(10, -maps[k].noise * test_random_unit(&r));
    for (int i = 0; i < maps[k].lights; i++) {
        const double v = 5 * (double)half_max * (1 + test_random_unit(&r));
        set_texel(&cube, test_random_below(&r, texels), v, v / 2, v / 7);
    }
    for (int i = 0; i < texels && maps[k].bright > 0; i++) {
        double d[3];
        look(n, i, d);
        if (test_dot(d, at) > at[3] * sqrt(test_dot(at, at)))
            set_texel(&cube, i, maps[k].bright, maps[k].bright, maps[k].bright);
    }
    return cube;
}

/* The texel where i is when axes are exchanged or turned over. map[k]: 1 + the
 * axis that k is, with a sign. */
static int moved(int n, int i, const int map[3])
{
    double d[3], e[3], most = -1;
    int best = 0;
    look(n, i, d);
    for (int k = 0; k < 3; k++)
        e[k] = map[k] < 0 ? -d[-map[k] - 1] : d[map[k] - 1];
    for (int t = 0; t < IBL_FACES * n * n; t++) {
        look(n, t, d);
        if (test_dot(d, e) > most) {
            most = test_dot(d, e);
            best = t;
        }
    }
    return best;
}

static void check_kept(const ibl_cube *cube, const ibl_cube *got, double slack,
                       const char *what)
{
    for (int c = 0; c < 3; c++) {
        const double want = cube_mean(cube, 0, c), mean = cube_mean(got, 0, c);
        CHECK_MSG(fabs(mean - want) <= slack * want,
                  "%s: channel %d has %.9g, had %.9g", what, c, mean, want);
    }
}

/* Nothing is darker or beyond; the mean of each channel stays, or all that has
 * no room is lost; which texels are over, and what they move, is told. */
TEST(energy)
{
    for (int k = 0; k < (int)(sizeof maps / sizeof *maps); k++) {
        const ibl_cube cube = make_map(k);
        const int texels = IBL_FACES * cube.size * cube.size;
        ibl_overflow_report report;
        ibl_overflow_level level;
        double over = 0, all = 0;
        int bright = 0;
        for (int i = 0; i < texels; i++) {
            bool is = false;
            for (int c = 0; c < 3; c++) {
                const double v = (double)cube.data[3 * i + c];
                over += fmax(v - (double)half_max, 0) * angle_of(cube.size, i);
                all += v * angle_of(cube.size, i);
                is |= v > (double)half_max;
            }
            bright += is;
        }
        const ibl_cube got = bright ? settled(&cube, half_max, &level)
                                    : stored(&cube, IBL_PIXEL_RGBA16F,
                                             IBL_OVERFLOW_SPREAD, &report);
        if (!bright)
            level = report.level[0];
        for (int i = 0; i < 3 * texels; i++)
            CHECK(got.data[i] >= fminf(cube.data[i], half_max) &&
                  got.data[i] <= half_max);
        CHECK(level.texels == (size_t)bright);
        CHECK_NEAR(level.moved + level.lost, bright ? over / all : 0, 1e-6);
        if (maps[k].lost < 0) {
            check_kept(&cube, &got, 1e-6, maps[k].name);
            const ibl_cube halves =
                stored(&cube, IBL_PIXEL_RGBA16F, IBL_OVERFLOW_SPREAD, &report);
            check_kept(&cube, &halves, 1e-4, maps[k].name);
        }
        CHECK_NEAR(level.lost, fmax(maps[k].lost, 0), 1e-6);
    }
}

/* Maps that are turned or mirrored become what is turned or mirrored: which
 * light comes first is seen by how bright it is. */
TEST(symmetry)
{
    static const int turns[][3] = {
        {-1, 2, 3}, {1, -2, 3}, {2, 1, 3}, {3, 1, 2}, {-3, 2, -1}};
    for (int n = 0; n < 5 * (int)(sizeof maps / sizeof *maps); n++) {
        const int k = n / 5, size = maps[k].size;
        const int texels = IBL_FACES * size * size;
        if (size > 13 || !(maps[k].lights || maps[k].bright > 0))
            continue;
        ibl_cube cube = make_map(k), turned = constant(size, 0);
        ibl_overflow_level level;
        int *to = test_alloc((size_t)texels, sizeof *to);
        for (int i = 0; i < texels; i++) {
            to[i] = moved(size, i, turns[n % 5]);
            memcpy(turned.data + 3 * to[i], cube.data + 3 * i,
                   3 * sizeof(float));
        }
        const ibl_cube a = settled(&cube, half_max, &level);
        const ibl_cube b = settled(&turned, half_max, &level);
        for (int i = 0; i < 3 * texels; i++) {
            const double want = (double)a.data[i];
            CHECK_NEAR((double)b.data[3 * to[i / 3] + i % 3], want,
                       1e-6 * want);
        }
    }
}

/* A large patch is round within a tenth: farthest texel, nearest outside. */
TEST(round_patch)
{
    const int n = 65, middle = n / 2;
    ibl_cube cube = constant(n, 0);
    ibl_overflow_level level;
    double farthest = 0, nearest = n;
    set_texel(&cube, middle * n + middle, 300 * (double)half_max, 0, 0);
    ibl_cube got = settled(&cube, half_max, &level);
    for (int i = 0; i < n * n; i++) {
        const double distance = hypot(i % n - middle, i / n - middle);
        if (got.data[3 * i] == half_max)
            farthest = fmax(farthest, distance);
        else
            nearest = fmin(nearest, distance);
    }
    CHECK_MSG(farthest > 8 && farthest < 1.1 * nearest, "%g, %g", farthest,
              nearest);
}

/* A light of fifty texels: what it is spread over is near it, centred on it. */
TEST(stays_in_place)
{
    test_random r = {5};
    for (int k = 0; k < 40; k++) {
        const int n = 32, at = (int)(test_random_u64(&r) % (6 * 32 * 32));
        ibl_cube cube = constant(n, 0);
        ibl_overflow_level level;
        double d[3], sum[3] = {0};
        set_texel(&cube, at, 50 * (double)half_max, 0, 0);
        ibl_cube got = settled(&cube, half_max, &level);
        look(n, at, d);
        for (int i = 0; i < 6 * n * n; i++) {
            double e[3];
            look(n, i, e);
            const double light = (double)got.data[3 * i] * angle_of(n, i);
            const double away = acos(fmin(test_dot(d, e), 1));
            CHECK_MSG(light <= 0 || away < 7 * 2.0 / n, "light %.3g away",
                      away);
            for (int c = 0; c < 3; c++)
                sum[c] += light * e[c];
        }
        const double aside =
            acos(fmin(test_dot(sum, d) / sqrt(test_dot(sum, sum)), 1));
        CHECK_MSG(aside < 2.0 / n, "centre %.3g texels aside", aside * n / 2);
    }
}

/* ---- pixels -------------------------------------------------------------- */

/* Largest values per channel; small ones round by the scale of large ones. */
TEST(other_pixels)
{
    const double max[IBL_PIXEL_COUNT][3] = {
        [IBL_PIXEL_RGBA16F] = {65504, 65504, 65504},
        [IBL_PIXEL_RGB9E5] = {65408, 65408, 65408},
        [IBL_PIXEL_R11G11B10F] = {65024, 65024, 64512}};
    for (int p = 0; p < IBL_PIXEL_COUNT; p++) {
        if (max[p][0] == 0)
            continue;
        ibl_cube cube = constant(64, 1); /* two jobs */
        ibl_overflow_report report;
        set_texel(&cube, 700, 5e5, 6e5, 7e5);
        ibl_cube got =
            stored(&cube, (ibl_pixel)p, IBL_OVERFLOW_SPREAD, &report);
        check_kept(&cube, &got, 1e-2, ibl_pixel_name((ibl_pixel)p));
        CHECK(report.values == 3 && report.level[0].texels == 1);
        for (int c = 0; c < 3; c++)
            CHECK((double)got.data[3 * 700 + c] == max[p][c]);
        /* A little of one channel. */
        for (int c = 0; c < 3; c++) {
            set_texel(&cube, 700, 3, 3, 3);
            cube.data[3 * 700 + c] = (float)(1.004 * max[p][c]);
            got = stored(&cube, (ibl_pixel)p, IBL_OVERFLOW_SPREAD, &report);
            CHECK(report.values == 1 && report.level[0].texels == 1);
            CHECK(got.data[3 * 701 + c] > 5 && got.data[3 * 699 + c] > 5);
        }
    }
}

/* Infinity is clipped; what is no number takes nothing. */
TEST(no_numbers)
{
    ibl_cube cube = constant(8, 2);
    ibl_overflow_level level;
    set_texel(&cube, 100, (double)INFINITY, 2, 2);
    set_texel(&cube, 200, (double)NAN, 1e6, (double)-INFINITY);
    set_texel(&cube, 201, 1e6, 2, 1e6);
    ibl_cube got = settled(&cube, half_max, &level);
    CHECK(got.data[300] == half_max && got.data[303] == 2);
    CHECK(isnan(got.data[600]) && got.data[602] == -INFINITY);
    CHECK(got.data[3 * 202] > 2 && got.data[3 * 202 + 2] > 2);
    CHECK(level.texels == 3 && level.lost == 0);
}

/* Clipping is what encoding does. Both have a report for each level. */
TEST(clip)
{
    ibl_cube cube = cube_alloc(ctx, 16, 3), got;
    ibl_overflow_report report;
    for (size_t i = 0; i < cube_floats(&cube); i++)
        cube.data[i] = 1;
    set_texel(&cube, 6 * 256 + 70, 655040, 1, 1);
    const double angle = ibl_cube_solid_angle(8, 70 % 8, 70 / 8 % 8);
    const double all = 3 * 4 * M_PI + 655039 * angle;
    got = stored(&cube, IBL_PIXEL_RGBA16F, IBL_OVERFLOW_CLIP, &report);
    for (size_t i = 0; i < cube_floats(&cube); i++)
        CHECK(got.data[i] == fminf(cube.data[i], half_max));
    CHECK(report.values == 1 && report.level[1].texels == 1);
    CHECK(report.level[0].texels == 0 && report.level[2].texels == 0);
    CHECK_NEAR(report.level[1].lost, (655040 - 65504) * angle / all, 1e-9);
    CHECK(report.level[1].moved == 0);
    got = stored(&cube, IBL_PIXEL_RGBA16F, IBL_OVERFLOW_SPREAD, &report);
    CHECK_NEAR(report.level[1].moved, (655040 - 65504) * angle / all, 1e-9);
    CHECK(report.level[1].lost == 0 && got.data[0] == 1);
}

/* A largest value that was asked for, below the pixel's and above it. */
TEST(largest)
{
    static const double largest[] = {65504.0 / 16, 1e9};
    const ibl_cube cube = make_map(6);
    for (int i = 0; i < 2; i++) {
        const ibl_texel_options o = {.pixel = i ? IBL_PIXEL_RGBA16F
                                                : IBL_PIXEL_RGBA32F,
                                     .largest = largest[i]};
        ibl_overflow_level level;
        ibl_texture tex = {0};
        ibl_cube got = {0};
        NEED(!ibl_texture_from_cube(ctx, &cube, &o, &tex, NULL) &&
             !ibl_texture_to_cube(ctx, &tex, &got));
        ibl_texture_free(&tex);
        test_cube(got);
        const ibl_cube want =
            i ? stored(&cube, o.pixel, IBL_OVERFLOW_SPREAD, NULL)
              : settled(&cube, (float)largest[i], &level);
        CHECK(!memcmp(got.data, want.data, cube_floats(&cube) * sizeof(float)));
    }
}

void test_setup(void)
{
    ctx = test_ctx(2, IBL_ISA_AUTO);
}
