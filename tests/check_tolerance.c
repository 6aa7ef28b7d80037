/* SPDX-License-Identifier: MIT */
/*
 * What a tolerance promises, against the reference, and the levels of parts of
 * the range of roughness.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reference.h"

enum {
    SIZE = 64,
    LEVELS = 4
};

/* A sky that brightens upwards, a dim ground, and a small sun. */
static ibl_image made_map(ibl_ctx *ctx, int w, int h)
{
    ibl_image env = map_constant(ctx, w, h, 0);
    for (int i = 0; i < w * h; i++) {
        const int x = i % w, y = i / w;
        const float v = y < h / 2 ? 1 - (float)y / (float)h
                                  : 0.05f + 0.01f * (float)(x % 7);
        const bool sun = x * 3 / w == 2 && x * 3 % w < 4 && y == h / 4;
        env.data[3 * i] = sun ? 3000 : v;
        env.data[3 * i + 1] = sun ? 2500 : v;
        env.data[3 * i + 2] = sun ? 2000 : 1.2f * v;
    }
    return env;
}

/* ---- the tolerance ------------------------------------------------------ */

/* A larger one never takes a higher degree, and every one is kept. */
static void check_kept(int width)
{
    static const double tolerance[] = {1e-6, 5e-5, 1e-3, 0.02, 0.1, 0.3};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_specular_options o = ibl_specular_options_default();
    ibl_image env = made_map(ctx, width, width / 2);
    ibl_reference *ref = reference_of(ctx, &env, 0);
    int before[LEVELS] = {1 << 20, 1 << 20, 1 << 20, 1 << 20};

    o.size = SIZE;
    o.levels = LEVELS;
    for (size_t k = width > 128 ? 3 : 0;
         k < sizeof tolerance / sizeof *tolerance; k++) {
        ibl_specular_report report;
        ibl_cube cube = {0};
        o.tolerance = tolerance[k];
        NEED(!ibl_bake_specular_report(ctx, &env, &o, &cube, &report));
        for (int l = 1; l < LEVELS; l++) {
            const double p95 = percentile_95(
                ref, o.lobe, report.layout.roughness[l], &cube, l, NULL);
            /* Floats leave about 1e-5. */
            CHECK_MSG(p95 <= fmax(tolerance[k], 2e-5),
                      "%d wide, tolerance %g, level %d: %.2g", width,
                      tolerance[k], l, p95);
            CHECK_MSG(p95 <= report.level[l].error,
                      "%d wide, tolerance %g, level %d: %.2g, not %.2g", width,
                      tolerance[k], l, p95, report.level[l].error);
            CHECK(report.level[l].degree <= before[l]);
            before[l] = report.level[l].degree;
        }
        CHECK(k < 3 || before[1] < 200);
        ibl_cube_free(&cube);
    }
}

TEST_SLOW(kept)
{
    check_kept(128);
    check_kept(512);
}

/* A narrow lobe on a map most of which is much darker than its mean: the level
 * is made twice. Where the tolerance is not reached a warning says so. */
static void check_narrow(ibl_lobe lobe, double tolerance, int width,
                         double roughness, float dark)
{
    test_messages said = {0};
    ibl_ctx *ctx = test_keeping_ctx(2, &said);
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_report report;
    ibl_image env = made_map(ctx, width, width / 2);
    ibl_cube cube = {0};
    bool missed = false;

    for (int i = 0; i < 3 * width * width / 2; i++)
        env.data[i] *= i / 3 % width < 24 && i / 3 % 7 < 3 ? 10 : dark;
    ibl_reference *ref = reference_of(ctx, &env, 37);
    o.size = SIZE;
    o.levels = 2;
    o.yaw_deg = 37;
    o.lobe = lobe;
    o.tolerance = tolerance;
    o.roughness_min = roughness;
    o.roughness_max = 1.5 * roughness;
    NEED(!ibl_bake_specular_report(ctx, &env, &o, &cube, &report));
    for (int l = 0; l < 2; l++) {
        double worst;
        const double p95 = percentile_95(ref, lobe, report.layout.roughness[l],
                                         &cube, l, &worst);
        const double error = report.level[l].error;
        missed |= error > tolerance;
        CHECK_MSG(dark < 0.01f || (p95 <= 1e-3 && worst <= 1e-2),
                  "%s, %d wide, level %d: %.2g, worst %.2g",
                  ibl_lobe_name(lobe), width, l, p95, worst);
    }
    const bool told = strstr(said.text[IBL_LOG_WARNING], "is not reached");
    CHECK(told == (missed && tolerance > IBL_TOLERANCE_DEFAULT));
    CHECK(missed || dark > 0.01f);
    ibl_cube_free(&cube);
}

TEST_SLOW(narrow_and_dark)
{
    check_narrow(IBL_LOBE_GGX, IBL_TOLERANCE_DEFAULT, 256, 0.04, 0.1f);
    if (TEST_SANITIZED)
        return;
    check_narrow(IBL_LOBE_GGX, 6e-5, 256, 0.04, 1e-4f);
    check_narrow(IBL_LOBE_PHONG, IBL_TOLERANCE_DEFAULT, 256, 0.04, 0.1f);
    /* rows in batches */
    check_narrow(IBL_LOBE_PHONG, IBL_TOLERANCE_DEFAULT, 1024, 0.027, 0.1f);
}

/* ---- layouts ------------------------------------------------------------ */

static ibl_specular_layout layout_of(int size, int levels, double low,
                                     double high, ibl_roughness_map map)
{
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_layout l = {0};
    o.method = IBL_METHOD_SAMPLED;
    o.size = size;
    o.levels = levels;
    o.mapping = map;
    o.roughness_min = low;
    o.roughness_max = high;
    CHECK(!ibl_specular_layout_of(&o, &l));
    return l;
}

TEST(whole_range_is_the_chain)
{
    for (int map = 0; map < 2; map++) {
        for (int size = 1; size < 600; size++) {
            const ibl_specular_layout l =
                layout_of(size, 0, 0, 1, (ibl_roughness_map)map);
            CHECK(l.size == size && l.levels == ibl_default_levels(size));
            for (int i = 0; i < l.levels; i++)
                CHECK(l.roughness[i] ==
                      ibl_level_roughness((ibl_roughness_map)map, i, l.levels));
        }
    }
}

TEST(layouts_follow_their_lod)
{
    test_random random = {8};
    for (int i = 0; i < 3000; i++) {
        const int map = i % 2, size = 1 << (4 + i % 9);
        double a = test_random_unit(&random), b = test_random_unit(&random);
        if (a > b || i % 5 == 0) {
            const double c = b;
            b = a;
            a = i % 5 ? c : 0;
        }
        const ibl_specular_layout l =
            layout_of(size, 0, a, b, (ibl_roughness_map)map);
        const int last = ibl_cube_edge(l.size, l.levels - 1);
        const double need = 5 * 3.14159265358979 / 2;
        CHECK(l.size <= size && l.size >= 1 << (l.levels - 1));
        CHECK(a > 0 ? l.size <= need / (a * a) + (1 << (l.levels - 1))
                    : l.size == size);
        CHECK(l.levels == 2 || last >= 0.7 * need / (b * b) - 1 ||
              last >= 0.7 * size *
                              exp2(-(map ? b * (2 - b) : b) *
                                   (ibl_default_levels(size) - 1)) -
                          1);
        /* Half an octave up or down, and a texel of rounding. */
        CHECK(last <=
              1 + sqrt(2) * fmin(need / (b * b),
                                 size * exp2(-(map ? b * (2 - b) : b) *
                                             (ibl_default_levels(size) - 1))));
        CHECK(l.lod_offset <= 0 && (a > 0 || !signbit(l.lod_offset)));
        CHECK_NEAR(l.roughness[0], a, 1e-12);
        CHECK_NEAR(l.roughness[l.levels - 1], b, 1e-12);
        for (int k = 0; k < l.levels; k++) {
            const double r = l.roughness[k], x = map ? r * (2 - r) : r;
            CHECK_NEAR(x * l.lod_scale + l.lod_offset, k, 1e-6);
        }
        if (a > 0)
            CHECK(l.size % (1 << (l.levels - 1)) == 0 || l.size == size);
    }
    /* What the whole chain has for these roughnesses. */
    const ibl_specular_layout l = layout_of(256, 0, 0.2, 1, 0);
    CHECK(l.size == 128 && l.levels == 5);
    const ibl_specular_layout m = layout_of(4096, 0, 0.5, 1, 0);
    CHECK(m.size == 32 && m.levels == 3);
    const ibl_specular_layout one = layout_of(256, 0, 0.5, 0.5, 0);
    CHECK(one.levels == 1 && one.roughness[0] == 0.5 && one.lod_scale == 0);
}

TEST(bad_options)
{
    static const double ranges[][2] = {
        {-0.1, 1}, {0, 1.1}, {0.6, 0.5}, {(double)NAN, 1}, {0, (double)NAN}};
    test_messages kept = {0};
    ibl_ctx *ctx = test_keeping_ctx(1, &kept);
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_layout layout;
    ibl_cube cube = {0};
    ibl_image env = made_map(ctx, 8, 4);
    o.method = IBL_METHOD_SAMPLED;
    o.size = 16;
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        o.roughness_min = ranges[i][0];
        o.roughness_max = ranges[i][1];
        CHECK(ibl_bake_specular(ctx, &env, &o, &cube) == IBL_ERR_ARGUMENT);
        CHECK(strstr(kept.text[IBL_LOG_ERROR], "roughness range"));
        CHECK(ibl_specular_layout_of(&o, &layout) == IBL_ERR_ARGUMENT);
    }
    o.roughness_min = o.roughness_max = 0.5;
    o.levels = 2;
    CHECK(ibl_bake_specular(ctx, &env, &o, &cube) == IBL_ERR_ARGUMENT);
    o = ibl_specular_options_default();
    o.method = IBL_METHOD_SAMPLED;
    o.tolerance = 2;
    CHECK(ibl_bake_specular(ctx, &env, &o, &cube) == IBL_ERR_ARGUMENT);
    CHECK(strstr(kept.text[IBL_LOG_ERROR], "tolerance of 2"));
    o.tolerance = (double)NAN;
    CHECK(ibl_bake_specular(ctx, &env, &o, &cube) == IBL_ERR_ARGUMENT);
    CHECK(!cube.data);
}
