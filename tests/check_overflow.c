/* SPDX-License-Identifier: MIT */
/*
 * Light that a pixel format cannot hold: kept by energy, by the cube's
 * symmetries, and in the texels that touch it. Which do is found by corners
 * that texels have in common, as whole numbers in space.
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

/* Noise over eight decades, with lights of five times the largest half in some
 * of its texels, more in red than in blue. */
static ibl_cube noisy(int n, uint64_t seed, int lights)
{
    ibl_cube cube = constant(n, 0);
    test_random r = {seed};
    for (size_t i = 0; i < cube_floats(&cube); i++)
        cube.data[i] = (float)pow(10, 8 * test_random_unit(&r) - 4);
    for (int k = 0; k < lights; k++) {
        const double v = 5 * (double)half_max * (1 + test_random_unit(&r));
        set_texel(&cube, (int)(test_random_u64(&r) % (6 * (unsigned)(n * n))),
                  v, v / 2, v / 7);
    }
    return cube;
}

static void check_kept(const ibl_cube *cube, const ibl_cube *got, double slack)
{
    for (int c = 0; c < 3; c++) {
        const double want = cube_mean(cube, 0, c), mean = cube_mean(got, 0, c);
        CHECK_MSG(fabs(mean - want) <= slack * want,
                  "size %d: channel %d has %.9g, had %.9g", cube->size, c, mean,
                  want);
    }
}

/* The mean of each channel; nothing is darker, nothing beyond. */
TEST(mean_is_kept)
{
    for (int n = 5; n < 80; n += 9) {
        ibl_cube cube = noisy(n, (uint64_t)n, n / 3);
        ibl_overflow_level level;
        ibl_cube got = settled(&cube, half_max, &level);
        check_kept(&cube, &got, 1e-6);
        CHECK(level.texels > 0 && level.moved > 0 && level.lost == 0);
        for (size_t i = 0; i < cube_floats(&cube); i++)
            CHECK(got.data[i] >= fminf(cube.data[i], half_max) &&
                  got.data[i] <= half_max);
        got = stored(&cube, IBL_PIXEL_RGBA16F, IBL_OVERFLOW_SPREAD, NULL);
        check_kept(&cube, &got, 1e-4);
    }
}

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
        check_kept(&cube, &got, 1e-2);
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
    ibl_cube cube = noisy(16, 1, 9);
    ibl_overflow_report report;
    ibl_cube got =
        stored(&cube, IBL_PIXEL_RGBA32F, IBL_OVERFLOW_SPREAD, &report);
    CHECK(!memcmp(got.data, cube.data, cube_floats(&cube) * sizeof(float)));
    CHECK(report.values == 0);
}

/* The texel whose centre looks there. */
static int texel_towards(int n, const double dir[3])
{
    int best = 0;
    double most = -1;
    for (int i = 0; i < IBL_FACES * n * n; i++) {
        double d[3];
        look(n, i, d);
        if (test_dot(d, dir) > most) {
            most = test_dot(d, dir);
            best = i;
        }
    }
    return best;
}

/* The texel where i is when axes are exchanged or turned over. map[k]: 1 + the
 * axis that k is, with a sign. */
static int moved(int n, int i, const int map[3])
{
    double d[3], e[3];
    look(n, i, d);
    for (int k = 0; k < 3; k++)
        e[k] = map[k] < 0 ? -d[-map[k] - 1] : d[map[k] - 1];
    return texel_towards(n, e);
}

/* Lights around a direction that stays where axes are exchanged or turned over:
 * so does what becomes of them, bit for bit. */
static void check_symmetry(int n, const double towards[3], const int map[3])
{
    ibl_cube cube = constant(n, 0.25f);
    ibl_overflow_level level;
    const double length = sqrt(test_dot(towards, towards));
    for (int i = 0; i < IBL_FACES * n * n; i++) {
        double d[3];
        look(n, i, d);
        if (test_dot(d, towards) > length * cos(2.0 / n))
            set_texel(&cube, i, 4e6, 7e5, 1e4);
    }
    ibl_cube got = settled(&cube, half_max, &level);
    CHECK(level.texels > 0);
    for (int i = 0; i < IBL_FACES * n * n; i++) {
        CHECK(!memcmp(got.data + 3 * i, got.data + 3 * moved(n, i, map),
                      3 * sizeof(float)));
    }
}

TEST(symmetry)
{
    for (int n = 12; n < 14; n++) {
        check_symmetry(n, (double[]){1, 1, 1}, (int[]){2, 3, 1});
        check_symmetry(n, (double[]){-1, 1, 1}, (int[]){-2, -1, 3});
        check_symmetry(n, (double[]){1, 0, -1}, (int[]){-3, 2, -1});
        check_symmetry(n, (double[]){1, 0, -1}, (int[]){1, -2, 3});
        check_symmetry(n, (double[]){0, -1, 0}, (int[]){3, 2, -1});
        check_symmetry(n, (double[]){0, 0, 1}, (int[]){2, 1, 3});
    }
}

TEST(constant_maps)
{
    const float values[] = {0, 1, half_max, 65505, 1e6f};
    for (size_t k = 0; k < 5; k++) {
        ibl_cube cube = constant(9, values[k]);
        ibl_overflow_report report;
        const float want = fminf(values[k], half_max);
        const double lost =
            values[k] > 0 ? (double)(values[k] - want) / (double)values[k] : 0;
        ibl_cube got =
            stored(&cube, IBL_PIXEL_RGBA16F, IBL_OVERFLOW_SPREAD, &report);
        for (size_t i = 0; i < cube_floats(&got); i++)
            CHECK(got.data[i] == want);
        CHECK(report.level[0].texels == (lost > 0 ? 6 * 81 : 0));
        CHECK_NEAR(report.level[0].lost, lost, 1e-6);
        CHECK(report.level[0].moved == 0);
    }
}

/* Half of the sphere is too bright; the whole has just room for it, or not. */
TEST(nearly_full)
{
    for (int k = 0; k < 2; k++) {
        ibl_cube cube = constant(48, 0);
        ibl_overflow_level level;
        const double bright = (k ? 2.1 : 1.9) * (double)half_max;
        for (int i = 0; i < 6 * 48 * 48; i++) {
            double d[3];
            look(48, i, d);
            if (d[1] > 0)
                set_texel(&cube, i, bright, bright, bright);
        }
        ibl_cube got = settled(&cube, half_max, &level);
        if (k == 0) {
            check_kept(&cube, &got, 1e-6);
            CHECK(level.lost == 0);
            CHECK_NEAR(level.moved, 0.9 / 1.9, 1e-6);
        } else {
            for (size_t i = 0; i < cube_floats(&got); i++)
                CHECK(got.data[i] == half_max);
            CHECK_NEAR(level.lost, 0.1 / 2.1, 1e-6);
            CHECK_NEAR(level.moved, 1 / 2.1, 1e-6);
        }
    }
}

/* Unlike lights that meet: which comes first is seen by how bright it is, and
 * so what becomes of them turns over as they do. */
TEST(unlike_lights)
{
    static const int maps[][3] = {{-1, 2, 3}, {1, -2, 3}, {2, 1, 3}, {3, 1, 2}};
    const int n = 12, texels = IBL_FACES * n * n;
    for (uint64_t seed = 1; seed <= 8; seed++) {
        ibl_cube cube = noisy(n, seed, 40), turned = constant(n, 0);
        ibl_overflow_level level;
        const int *map = maps[seed % 4];
        for (int i = 0; i < texels; i++)
            memcpy(turned.data + 3 * moved(n, i, map), cube.data + 3 * i,
                   3 * sizeof(float));
        ibl_cube a = settled(&cube, half_max, &level);
        ibl_cube b = settled(&turned, half_max, &level);
        for (int i = 0; i < texels; i++)
            for (int c = 0; c < 3; c++) {
                const double want = (double)a.data[3 * i + c];
                CHECK_NEAR((double)b.data[3 * moved(n, i, map) + c], want,
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

/* The largest floats in all texels of a level but one. */
TEST(largest_floats)
{
    ibl_cube cube = constant(6, 3.4e38f);
    ibl_overflow_level level;
    set_texel(&cube, 17, 0, 0, 0);
    ibl_cube got = settled(&cube, half_max, &level);
    for (size_t i = 0; i < cube_floats(&got); i++)
        CHECK(got.data[i] == half_max);
    CHECK_NEAR(level.lost, 1, 1e-9);
}

/* Clipping is what encoding does. Both have a report for each level. */
TEST(clip)
{
    ibl_cube cube = cube_alloc(ctx, 16, 3), got;
    ibl_overflow_report report;
    for (size_t i = 0; i < cube_floats(&cube); i++)
        cube.data[i] = 1;
    set_texel(&cube, 6 * 256 + 70, 655040, 1, 1);
    got = stored(&cube, IBL_PIXEL_RGBA16F, IBL_OVERFLOW_CLIP, &report);
    for (size_t i = 0; i < cube_floats(&cube); i++)
        CHECK(got.data[i] == fminf(cube.data[i], half_max));
    CHECK(report.values == 1 && report.level[1].texels == 1);
    CHECK(report.level[0].texels == 0 && report.level[2].texels == 0);
    const double angle = ibl_cube_solid_angle(8, 70 % 8, 70 / 8 % 8);
    const double all = 3 * 4 * 3.14159265358979 + 655039 * angle;
    CHECK_NEAR(report.level[1].lost, (655040 - 65504) * angle / all, 1e-9);
    CHECK(report.level[1].moved == 0);
    got = stored(&cube, IBL_PIXEL_RGBA16F, IBL_OVERFLOW_SPREAD, &report);
    CHECK_NEAR(report.level[1].moved, (655040 - 65504) * angle / all, 1e-9);
    CHECK(report.level[1].lost == 0);
    for (size_t i = 0; i < 3 * 6 * 256; i++)
        CHECK(got.data[i] == 1);
}

/* A largest value that was asked for, below the pixel's and above it. */
TEST(largest)
{
    ibl_cube cube = noisy(16, 5, 4);
    const float most = half_max / 16;
    ibl_texel_options o = {.pixel = IBL_PIXEL_RGBA32F, .largest = (double)most};
    ibl_overflow_report report;
    ibl_overflow_level level;
    ibl_texture tex = {0};
    ibl_cube got = {0};
    CHECK(ibl_texture_from_cube(ctx, &cube, &o, &tex, &report) == IBL_OK &&
          ibl_texture_to_cube(ctx, &tex, &got) == IBL_OK);
    ibl_texture_free(&tex);
    got = test_cube(got);
    ibl_cube want = settled(&cube, most, &level);
    CHECK(!memcmp(got.data, want.data, cube_floats(&cube) * sizeof(float)));
    CHECK(report.level[0].texels == level.texels && level.texels > 0);
    check_kept(&cube, &got, 1e-6);

    o = (ibl_texel_options){.pixel = IBL_PIXEL_RGBA16F, .largest = 1e9};
    CHECK(ibl_texture_from_cube(ctx, &cube, &o, &tex, NULL) == IBL_OK &&
          ibl_texture_to_cube(ctx, &tex, &got) == IBL_OK);
    ibl_texture_free(&tex);
    got = test_cube(got);
    want = stored(&cube, IBL_PIXEL_RGBA16F, IBL_OVERFLOW_SPREAD, NULL);
    CHECK(!memcmp(got.data, want.data, cube_floats(&cube) * sizeof(float)));
}

TEST(same_bytes)
{
    ibl_cube cube = noisy(60, 3, 400);
    ibl_texture first = {0};
    for (int threads = 1; threads < 4; threads++)
        for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
             isa = test_next_isa(isa)) {
            ibl_ctx *other = test_ctx(threads, isa);
            ibl_texture tex;
            NEED(!ibl_texture_from_cube(other, &cube, NULL, &tex, NULL));
            if (!first.data)
                first = tex;
            else
                CHECK(texture_same(&first, &tex));
            if (first.data != tex.data)
                ibl_texture_free(&tex);
        }
    ibl_texture_free(&first);
}

void test_setup(void)
{
    ctx = test_ctx(2, IBL_ISA_AUTO);
}
