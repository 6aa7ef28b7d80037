/* SPDX-License-Identifier: MIT */
/* Levels fitted to the power of a map. */
#include <math.h>
#include <string.h>

#include "bake/ladder.c"
#include "ibl/reference.h"
#include "maps.h"
#include "test.h"
#include "truth.h"

enum {
    LAST = 256
};

/* C_l of photographs, of a soft sky and of a small sun. */
static const double falls[] = {1.2, 2.5, 0};

static void fill_spectrum(double fall, double power[LAST + 1])
{
    power[0] = 30;
    for (int l = 1; l <= LAST; l++)
        power[l] = pow(l, -fall);
}

static ibl_specular_layout layout_of(int size, int levels)
{
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_layout layout;
    o.size = size;
    o.levels = levels;
    o.mapping = IBL_ROUGHNESS_BEST;
    NEED(!ibl_specular_layout_of(&o, &layout));
    return layout;
}

/* Before the fit the roughnesses are Filament's. After it the ends are, and all
 * rise. */
static void check_ladder(const ibl_specular_layout *before,
                         const ibl_specular_layout *after)
{
    const int last = after->levels - 1;
    for (int l = 0; l <= last; l++) {
        const double usual =
            ibl_level_roughness(IBL_ROUGHNESS_FILAMENT, l, last + 1);
        CHECK_NEAR(before->roughness[l], usual, 1e-12);
        if (!l || l == last)
            CHECK_NEAR(after->roughness[l], usual, 1e-12);
        CHECK(!l || after->roughness[l] > after->roughness[l - 1]);
    }
    CHECK(last < 1 || after->roughness[1] > before->roughness[1] - 1e-9);
}

TEST(ends_stay)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    double power[LAST + 1];
    fill_spectrum(1.2, power);
    for (int levels = 1; levels <= 9; levels += levels == 3 ? 3 : 1) {
        const ibl_specular_layout before = layout_of(256, levels);
        ibl_specular_layout after = before;
        NEED(!ibl_ladder_fit(ctx, power, LAST, &after));
        check_ladder(&before, &after);
    }
}

/* ---- the least sum --------------------------------------------------------
 */

static void free_fit(void *f)
{
    ibl_free(f);
}

/* Of all ladders of four levels that the knots have. */
TEST(least_of_all_ladders)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    for (int i = 0; i < 3; i++) {
        ibl_specular_layout layout = layout_of(64, 4);
        double power[LAST + 1], least = HUGE_VAL;
        int best[2] = {0, 0};
        struct fit *f = ibl_alloc_zeroed(1, sizeof *f);
        NEED(f);
        test_defer(free_fit, f);
        f->layout = &layout;
        fill_spectrum(falls[i], power);
        ibl_lobe_power(power, LAST, f->weight);
        NEED(!fit(ctx, f));
        NEED(f->count == 61 && f->fine == 20);
        for (int a = 20; a < 59; a++)
            for (int b = a + 1; b < 60; b++) {
                const double sum = segment(f, 0, 0, a) + segment(f, 1, a, b) +
                                   segment(f, 2, b, 60);
                if (sum < least)
                    least = sum, best[0] = a, best[1] = b;
            }
        CHECK_MSG(f->ladder[1] == best[0] && f->ladder[2] == best[1],
                  "fall %g: knots %d %d, best %d %d", falls[i], f->ladder[1],
                  f->ladder[2], best[0], best[1]);
    }
}

/* What is rendered: the mean of the expected errors with a table that is fitted
 * to the same spectrum. */
static double rendered(ibl_ctx *ctx, const ibl_specular_layout *layout,
                       const double *power)
{
    static const int bins[] = {7, 13, 19, 32, 45};
    const ibl_lobe_table_options o = {.struct_size = sizeof o,
                                      .size = 16,
                                      .layout = *layout,
                                      .power = power,
                                      .power_degree = LAST};
    ibl_lobe_table table = {0};
    double sum = 0;
    NEED(!ibl_bake_lobe_table(ctx, &o, &table));
    for (int i = 0; i < 10; i++) {
        const ibl_expected_set set = {.layout = *layout,
                                      .lookup = IBL_LOOKUP_TABLE,
                                      .lobes = &table,
                                      .irradiance = -1};
        ibl_materials m = {.weight = {{0}}};
        ibl_expectation *e;
        double error;
        m.weight[bins[i / 2]][i % 2] = 1;
        NEED(!ibl_expectation_create(ctx, &m, power, LAST, 512, 0, &e));
        NEED(!ibl_expectation_of(e, &set, &error));
        ibl_expectation_free(e);
        sum += error / 10;
    }
    ibl_lobe_table_free(&table);
    return sum;
}

TEST_SLOW(no_worse_than_filament)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    for (int i = 0; i < 3; i++)
        for (int levels = 4; levels <= 6; levels++) {
            const ibl_specular_layout usual = layout_of(256, levels);
            ibl_specular_layout best = usual;
            double power[LAST + 1];
            fill_spectrum(falls[i], power);
            NEED(!ibl_ladder_fit(ctx, power, LAST, &best));
            const double was = rendered(ctx, &usual, power);
            const double is = rendered(ctx, &best, power);
            test_measured("error, best over Filament's", is / was, 1.002);
            CHECK_MSG(is <= 1.002 * was, "fall %g, %d levels: %g, was %g",
                      falls[i], levels, is, was);
        }
}

/* ---- the lod --------------------------------------------------------------
 */

TEST(lod)
{
    ibl_specular_layout layout = layout_of(64, 4);
    layout.roughness[1] = 0.2;
    layout.roughness[2] = 0.5;
    for (int i = 0; i <= 20; i++) {
        const double r = i / 20.0;
        const double want = r < 0.2   ? r / 0.2
                            : r < 0.5 ? 1 + (r - 0.2) / 0.3
                                      : 2 + (r - 0.5) / 0.5;
        CHECK_NEAR(ibl_lod_of_roughness(&layout, r), want, 1e-12);
    }
    CHECK_NEAR(ibl_lod_of_roughness(&layout, -1), 0, 0);
    CHECK_NEAR(ibl_lod_of_roughness(&layout, 2), 3, 0);
    ibl_specular_options o = ibl_specular_options_default();
    for (int map = 0; map < 2; map++) {
        o.mapping = (ibl_roughness_map)map;
        o.roughness_min = 0.2;
        o.roughness_max = 0.8;
        NEED(!ibl_specular_layout_of(&o, &layout));
        for (int l = 0; l < layout.levels; l++)
            CHECK_NEAR(ibl_lod_of_roughness(&layout, layout.roughness[l]), l,
                       1e-9);
        CHECK_NEAR(ibl_lod_of_roughness(&layout, 0), 0, 0);
    }
}

/* ---- bakes ----------------------------------------------------------------
 */

static void free_result(void *result)
{
    ibl_bake_result_free(result);
}

static ibl_bake_result *bake(ibl_ctx *ctx, const ibl_image *map,
                             ibl_roughness_map mapping)
{
    const ibl_environment env = {.image = map};
    ibl_bake_options o = ibl_bake_options_default();
    ibl_bake_result *r = test_alloc(1, sizeof *r);
    o.specular_options.size = 64;
    o.specular_options.mapping = mapping;
    NEED(!ibl_bake_environment(ctx, &env, &o, r));
    test_defer(free_result, r);
    return r;
}

/* Levels are those of the roughnesses in the report. */
TEST(levels_of_a_map)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map;
    ibl_reference *ref = NULL;
    NEED(!ibl_image_alloc(ctx, 96, 48, &map));
    map = test_image(map);
    map_fill(&map, 5);
    map_set(&map, 31, 20, 2e3f, 1e3f, 1e2f);
    const ibl_bake_result *best = bake(ctx, &map, IBL_ROUGHNESS_BEST);
    const ibl_bake_result *usual = bake(ctx, &map, IBL_ROUGHNESS_FILAMENT);
    const ibl_specular_layout *layout = &best->report.layout;
    CHECK(best->power && !usual->power);
    check_ladder(&usual->report.layout, layout);
    CHECK(memcmp(layout->roughness, usual->report.layout.roughness,
                 sizeof layout->roughness) != 0);
    NEED(!ibl_reference_create(ctx, &map, 0, &ref));
    for (int l = 1; l < layout->levels; l++) {
        const int n = 64 >> l;
        for (int i = 0; i < 6 * n * n; i += n * n / 2 + 1) {
            const float *p = ibl_cube_face(&best->specular, l, 0) + 3 * i;
            double d[3], want[3];
            truth_cube_direction(n, i / (n * n), i % n, i / n % n, d);
            NEED(
                !ibl_reference_specular(ref, layout->roughness[l], d, 1, want));
            for (int c = 0; c < 3; c++)
                CHECK_NEAR((double)p[c] / want[c], 1, 2e-3);
        }
    }
    ibl_reference_free(ref);
}

TEST(same_with_any_threads)
{
    ibl_ctx *ctx = test_ctx(0, IBL_ISA_AUTO), *other = test_ctx(3, IBL_ISA_C);
    ibl_specular_layout a = layout_of(256, 6), b = a;
    double power[LAST + 1];
    fill_spectrum(0.4, power);
    NEED(!ibl_ladder_fit(ctx, power, LAST, &a));
    NEED(!ibl_ladder_fit(other, power, LAST, &b));
    CHECK(!memcmp(a.roughness, b.roughness, sizeof a.roughness));
}

TEST(bad_options)
{
    test_messages kept = {0};
    ibl_ctx *ctx = test_keeping_ctx(0, &kept);
    const ibl_image map = map_constant(ctx, 4, 2, 1);
    static const char *const words[] = {"0.2 to 1", "0 to 0.7", "phong"};
    for (int k = 0; k < 3; k++) {
        ibl_specular_options o = ibl_specular_options_default();
        ibl_cube cube = {0};
        o.size = 16;
        o.mapping = IBL_ROUGHNESS_BEST;
        o.roughness_min = k == 0 ? 0.2 : 0;
        o.roughness_max = k == 1 ? 0.7 : 1;
        o.lobe = k == 2 ? IBL_LOBE_PHONG : IBL_LOBE_GGX;
        CHECK(ibl_bake_specular(ctx, &map, &o, &cube) == IBL_ERR_ARGUMENT);
        CHECK(!cube.data);
        CHECK_MSG(test_said(&kept, words[k]), "no \"%s\" in: %s", words[k],
                  kept.text[IBL_LOG_ERROR]);
    }
    /* A constant map has no spectrum but its mean. */
    ibl_specular_options o = ibl_specular_options_default();
    ibl_cube cube = {0};
    o.size = 16;
    o.mapping = IBL_ROUGHNESS_BEST;
    NEED(!ibl_bake_specular(ctx, &map, &o, &cube));
    for (size_t i = 0; i < cube_floats(&cube); i++)
        CHECK_NEAR((double)cube.data[i], 1, 1e-6);
    ibl_cube_free(&cube);
}
