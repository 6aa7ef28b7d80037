/* SPDX-License-Identifier: MIT */
/*
 * What must be the same by the spectral method, whatever the map: constants,
 * turned and mirrored worlds, other scales, instruction sets.
 * check_environment has threads and maps that are read row by row.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "ibl/ibl.h"
#include "maps.h"

enum {
    LOBES = 3,
    WIDE = 256,
    HIGH = 128
};

static ibl_bake_options options(ibl_lobe lobe, double yaw)
{
    ibl_bake_options o = ibl_bake_options_default();
    o.specular_options.method = IBL_METHOD_SPECTRAL;
    o.specular_options.mapping = IBL_ROUGHNESS_LINEAR;
    o.specular_options.lobe = lobe;
    o.specular_options.size = 64;
    o.specular_options.levels = 4; /* alpha 1/9, 4/9, 1 */
    o.irradiance_options.size = 16;
    o.sh_degree = 4;
    o.yaw_deg = yaw;
    return o;
}

static ibl_image sunny(ibl_ctx *ctx, int width, int height, uint64_t seed)
{
    test_random r = {seed};
    return map_of_kind(ctx, &r, MAP_SUNNY, width, height);
}

/* ---- constants --------------------------------------------------------- */

/* Each value of each output is the map's, all its bits. */
TEST(constant_maps)
{
    static const int sizes[][2] = {{WIDE, HIGH}, {512, 256}, {100, 50},
                                   {37, 19},     {3, 2},     {1, 1}};
    static const float values[] = {1, 0.1f, 1e6f, 3e-5f, 0, 65504};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int k = 0; k < 6; k += TEST_RACES ? 2 : 1)
        for (int lobe = TEST_SANITIZED ? k % LOBES : 0; lobe < LOBES;
             lobe += TEST_SANITIZED ? LOBES : 1) {
            const ibl_bake_options o = options((ibl_lobe)lobe, 20);
            ibl_image map =
                map_constant(ctx, sizes[k][0], sizes[k][1], values[k]);
            ibl_bake_result r = map_bake(ctx, &map, &o);
            size_t bad = 0;
            for (size_t i = 0; i < cube_floats(&r.specular); i++)
                bad += memcmp(r.specular.data + i, &values[k], 4) != 0;
            for (size_t i = 0; i < cube_floats(&r.irradiance); i++)
                bad += memcmp(r.irradiance.data + i, &values[k], 4) != 0;
            CHECK_MSG(!bad, "%dx%d, %s: %zu values are not %g", map.width,
                      map.height, ibl_lobe_name((ibl_lobe)lobe), bad,
                      (double)values[k]);
        }
}

/* Channels have nothing to do with each other: a constant one stays that
 * beside suns in the others. */
TEST(constant_channel)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = sunny(ctx, WIDE, HIGH, 3);

    for (int i = 0; i < WIDE * HIGH; i++)
        map.data[3 * i + 1] = 0.3f;
    for (int k = 0; k < 2 * LOBES; k += TEST_SANITIZED ? 3 : 1) {
        ibl_bake_options o = options((ibl_lobe)(k / 2), 0);
        double worst = 0;
        o.specular_options.roughness_min = k % 2 ? 0.04 : 0;
        ibl_bake_result r = map_bake(ctx, &map, &o);
        for (size_t i = 1; i < cube_floats(&r.specular); i += 3)
            worst = fmax(worst, fabs((double)r.specular.data[i] / 0.3f - 1));
        /* Texels go by sums of 8 x 8 weights that are 1 to a rounding each. */
        CHECK_MSG(worst <= 64 * 0x1p-24, "%s from %g: off by %g",
                  ibl_lobe_name(o.specular_options.lobe),
                  o.specular_options.roughness_min, worst);
    }
}

/* ---- turned, mirrored, scaled ------------------------------------------ */

/* sqrt(sum |a(from(i)) - b(i)|^2 / sum b^2) over a level, and the largest
 * difference in parts of the brightest texel of the other. */
static double differ(const ibl_cube *a, const ibl_cube *b, int level,
                     int (*from)(int n, int i))
{
    const int n = ibl_cube_edge(a->size, level);
    const float *x = ibl_cube_face(a, level, 0),
                *y = ibl_cube_face(b, level, 0);
    double off = 0, all = 0;

    for (int i = 0; i < 6 * n * n; i++)
        for (int c = 0; c < 3; c++) {
            const double t = x[3 * (from ? from(n, i) : i) + c];
            off += pow(y[3 * i + c] - t, 2);
            all += t * t;
        }
    return all > 0 ? sqrt(off / all) : 0;
}

/* Both are within the tolerance of the same truth, 5e-5 of a texel; what is
 * cut off is the same in both, so they differ by rounding: floats of the
 * transforms and the texels, and the filter along rows, 1e-7. */
static const double same_bound = 5e-6;

static void check_same(const ibl_bake_result *a, const ibl_bake_result *b,
                       int (*from)(int n, int i), const char *what)
{
    for (int l = 1; l < a->specular.levels; l++) {
        const double off = differ(&a->specular, &b->specular, l, from);
        CHECK_MSG(off <= same_bound, "%s, level %d: %g", what, l, off);
        test_measured(what, off, same_bound);
    }
    const double off = differ(&a->irradiance, &b->irradiance, 0, from);
    CHECK_MSG(off <= same_bound, "%s, irradiance: %g", what, off);
    test_measured(what, off, same_bound);
}

/* By moving columns, and by yaw. */
TEST(turned)
{
    static const int sizes[][2] = {{WIDE, HIGH}, {300, 150}, {212, 101}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const ibl_bake_options o = options(IBL_LOBE_GGX, 0);
    const ibl_bake_options yawed = options(IBL_LOBE_GGX, 90);

    for (int k = 0; k < 3; k += TEST_SANITIZED ? 2 : 1) {
        ibl_image map = sunny(ctx, sizes[k][0], sizes[k][1], 5);
        ibl_image moved = map_turned(ctx, &map, map.width / 4);
        ibl_bake_result a = map_bake(ctx, &map, &o),
                        b = map_bake(ctx, &moved, &o);
        ibl_bake_result c = map_bake(ctx, &map, &yawed);
        check_same(&a, &b, cube_turned_from, "columns");
        check_same(&a, &c, cube_turned_from, "yaw");
    }
}

TEST(mirrored)
{
    static const int widths[] = {WIDE, 301};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const ibl_bake_options o = options(IBL_LOBE_PHONG, 0);

    for (int k = TEST_SANITIZED; k < 2; k++) {
        ibl_image map = sunny(ctx, widths[k], 150, 6);
        ibl_image other = map_mirrored(ctx, &map);
        ibl_bake_result a = map_bake(ctx, &map, &o),
                        b = map_bake(ctx, &other, &o);
        check_same(&a, &b, cube_mirrored_from, "mirrored");
    }
}

/* Nothing is measured in absolute radiance: powers of two change no bits. */
TEST(scaled)
{
    static const float factors[] = {0x1p-20f, 0x1p10f, 0x1p60f};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const ibl_bake_options o = options(IBL_LOBE_GGX, 0);
    ibl_image map = sunny(ctx, WIDE, HIGH, 7);
    ibl_bake_result a = map_bake(ctx, &map, &o);

    for (int k = 0; k < 3; k += TEST_SANITIZED ? 2 : 1) {
        ibl_image other = map_scaled(ctx, &map, factors[k]);
        ibl_bake_result b = map_bake(ctx, &other, &o);
        size_t bad = 0;
        for (size_t i = 0; i < cube_floats(&a.specular); i++)
            bad += a.specular.data[i] * factors[k] > b.specular.data[i] ||
                   a.specular.data[i] * factors[k] < b.specular.data[i];
        CHECK_MSG(!bad, "times %g: %zu values", (double)factors[k], bad);
    }
}

static size_t outside(const float *p, size_t floats, float low, float high)
{
    size_t bad = 0;

    for (size_t i = 0; i < floats; i++)
        bad += !(p[i] >= low && p[i] <= high);
    return bad;
}

/* The ends of what floats hold give no NaN and stay within the map. */
TEST(ends_of_floats)
{
    static const float ends[] = {FLT_MAX, 1e37f, FLT_MIN, 1e-42f};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const ibl_bake_options o = options(IBL_LOBE_GGX, 0);

    for (int k = 0; k < 4; k += TEST_SANITIZED ? 3 : 1) {
        ibl_image map = sunny(ctx, WIDE, HIGH, 8);
        for (size_t i = 0; i < map_floats(&map); i++)
            map.data[i] = fminf(map.data[i], 1) * ends[k];
        ibl_bake_result r = map_bake(ctx, &map, &o);
        const size_t bad =
            outside(r.specular.data, cube_floats(&r.specular), 0, ends[k]);
        CHECK_MSG(!bad, "up to %g: %zu values", (double)ends[k], bad);
    }
}

/* Above the horizon all is 1 and below it 2: away from it a series that is cut
 * off swings about these, a mean of them does not. */
TEST(within_the_range)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_constant(ctx, WIDE, HIGH, 1);

    for (size_t i = map_floats(&map) / 2; i < map_floats(&map); i++)
        map.data[i] = 2;
    for (int lobe = 0; lobe < (TEST_RACES ? 1 : LOBES); lobe++) {
        const ibl_bake_options o = options((ibl_lobe)lobe, 0);
        ibl_bake_result r = map_bake(ctx, &map, &o);
        const size_t bad =
            outside(r.specular.data, cube_floats(&r.specular), 1, 2) +
            outside(r.irradiance.data, cube_floats(&r.irradiance), 1, 2);
        CHECK_MSG(!bad, "%s: %zu values", ibl_lobe_name((ibl_lobe)lobe), bad);
    }
}

/* ---- instruction sets --------------------------------------------------- */

TEST(every_isa)
{
    static const int sizes[][2] = {{WIDE, HIGH}, {301, 150}};

    for (int s = TEST_SANITIZED; s < 2; s++)
        for (int lobe = 0; lobe < (TEST_SANITIZED ? 1 : LOBES); lobe++) {
            const ibl_bake_options o = options((ibl_lobe)lobe, 0);
            ibl_ctx *plain = test_ctx(2, IBL_ISA_C);
            ibl_image map = sunny(plain, sizes[s][0], sizes[s][1], 10);
            ibl_bake_result a = map_bake(plain, &map, &o);
            for (ibl_isa isa = test_next_isa(IBL_ISA_C); isa < IBL_ISA_COUNT;
                 isa = test_next_isa(isa)) {
                ibl_ctx *ctx = test_ctx(2, isa);
                ibl_bake_result b = map_bake(ctx, &map, &o);
                check_same(&a, &b, NULL, ibl_isa_name(isa));
            }
        }
}

/* ---- memory ------------------------------------------------------------ */

/* A sky with small lights that no file has to hold; cookie is its width. */
static ibl_status make_rows(void *cookie, int rows, float *rgb)
{
    const int *width = cookie;

    for (size_t i = 0; i < 3 * (size_t)*width * (size_t)rows; i++)
        rgb[i] = i % 100003 ? 0.5f + (float)(i % 7) / 8 : 1e5f;
    return IBL_OK;
}

/* The peak growth of memory of a default bake of that size, in MiB, or -1. */
static int bake_made_rows(int width, int height)
{
    const ibl_bake_options o = ibl_bake_options_default();
    const ibl_environment env = {
        .width = width, .height = height, .read = make_rows, .cookie = &width};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_bake_result r = {0};
    struct rusage before, after;

    getrusage(RUSAGE_SELF, &before);
    if (ibl_bake_environment(ctx, &env, &o, &r))
        return -1;
    getrusage(RUSAGE_SELF, &after);
    return (int)((after.ru_maxrss - before.ru_maxrss) / 1024);
}

/* In a process of its own, whose memory is what it starts with. Huge pages
 * would count whole, however little of them is used. */
static void within(int width, int height, int most)
{
    int code;
    const pid_t child = fork();

    if (!child) {
        prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0);
        const int mib = bake_made_rows(width, height);
        _exit(mib >= 0 && mib < 255 ? mib : 255);
    }
    NEED(child > 0 && waitpid(child, &code, 0) == child);
    const int mib = WIFEXITED(code) ? WEXITSTATUS(code) : 255;
    test_measured("MiB", mib, most);
    CHECK_MSG(mib <= most, "%dx%d: %d MiB, more than %d", width, height, mib,
              most);
}

/* The map as floats would take 96 MiB. */
TEST(memory)
{
    if (TEST_SANITIZED)
        test_skip("sanitizers need memory of their own");
    else
        within(4096, 2048, 64);
}

/* 1.5 GiB. */
TEST(memory_large)
{
    const char *large = getenv("IBL_TEST_LARGE");

    if (TEST_SANITIZED || !large || !*large || *large == '0')
        test_skip("16384x8192: make check LARGE=1 bakes it");
    else
        within(16384, 8192, 200);
}
