/* SPDX-License-Identifier: MIT */
/* The error to expect of a distribution of materials. */
#include <math.h>
#include <string.h>

#include "ibl/ibl.h"
#include "test.h"

enum {
    LAST = 256
};

static const double pi = 3.14159265358979323846;

static void fill_power(double fall, double power[LAST + 1])
{
    power[0] = 30;
    for (int l = 1; l <= LAST; l++)
        power[l] = pow(l, -fall);
}

static void free_expectation(void *e)
{
    ibl_expectation_free(*(ibl_expectation **)e);
}

static ibl_expectation *expect(ibl_ctx *ctx, const ibl_materials *m,
                               const double *power)
{
    ibl_expectation *e;
    NEED(!ibl_expectation_create(ctx, m, power, LAST, 512, &e));
    test_defer_copy(free_expectation, &e, sizeof e);
    return e;
}

static double error_of(const ibl_expectation *e, const ibl_expected_set *set)
{
    double nrmse;
    NEED(!ibl_expectation_of(e, set, &nrmse));
    return nrmse;
}

static ibl_expected_set usual_set(ibl_lookup lookup)
{
    const ibl_lobe_table_options o = ibl_lobe_table_options_default();
    return (ibl_expected_set){
        .layout = o.layout, .lookup = lookup, .irradiance = -1};
}

/* One roughness without diffuse light is ibl_bake_expected_error, but for what
 * lookups between texels add. */
TEST(of_one_roughness)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_lobe_table_options o = ibl_lobe_table_options_default();
    double power[LAST + 1];
    fill_power(1.2, power);
    o.power = power;
    o.power_degree = LAST;
    for (int bin = 16; bin <= 64; bin += 24)
        for (int f = 0; f < 2; f++) {
            const double r = bin / 64.0;
            ibl_materials m = {.weight = {{0}}};
            ibl_expected_error want;
            m.weight[bin][f] = 3;
            NEED(!ibl_bake_expected_error(ctx, &o, NULL, &r, 1, &want));
            const ibl_expected_set set = usual_set(IBL_LOOKUP_SPLIT);
            CHECK_NEAR(error_of(expect(ctx, &m, power), &set) /
                           want.nrmse[f][IBL_LOOKUP_SPLIT],
                       1, 0.01);
        }
}

/* Of a white surface of roughness 1 without levels, nothing is off but the
 * reflection, of which irradiance takes the place; harmonics of degree 2 lack
 * what sum (2 l + 1) C_l k_l^2 / 4 pi says, k_4 = -1/24 of k_0 and so on. */
TEST(of_diffuse_light)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const double albedo = 1000; /* so that nothing else counts */
    ibl_materials m = {.weight = {{0}}};
    double power[LAST + 1], lacks = 0, all = 0;
    fill_power(0.5, power);
    m.weight[64][1] = 1;
    m.diffuse[64][1] = albedo;
    for (int l = 0; l <= LAST; l++) {
        const double k = ibl_sh_cosine(l);
        const double part = (2 * l + 1) * power[l] * k * k;
        all += part;
        lacks += l > 2 ? part : 0;
    }
    const ibl_expectation *e = expect(ctx, &m, power);
    ibl_expected_set set = {.irradiance = 0};
    CHECK_NEAR(error_of(e, &set) / sqrt(lacks / all), 1, 0.02);
    set.irradiance = -1;
    CHECK(error_of(e, &set) < 1e-4);
    double before = 1;
    for (int edge = 2; edge <= 64; edge *= 2) {
        set.irradiance = edge;
        const double now = error_of(e, &set);
        CHECK(now < before);
        before = now;
    }
    set.step = 0.01; /* four ninths of its square are left */
    CHECK_NEAR(error_of(e, &set), 0.01 * 2 / 3, 1e-3);
}

/* A mirror sees the map's mean square but for what texels blur: with coarse
 * ones it lacks the degrees beyond them, and with fine ones only some of the
 * steps between the map's pixels, of which each pixel is the mean: those have
 * C_l / sinc^2 - C_l of a wave's power, and fine texels all but a few. */
TEST(of_a_mirror)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_materials m = {.weight = {{1, 0}}};
    double power[LAST + 1];
    fill_power(1.6, power);
    const ibl_expectation *e = expect(ctx, &m, power);
    double before = 1;
    for (int size = 16; size <= 4096; size *= 4) {
        const ibl_expected_set set = {
            .layout = {.size = size, .levels = 1, .roughness = {0}},
            .lookup = IBL_LOOKUP_SPLIT};
        double lacks = 0, all = 0;
        for (int l = 0; l <= 512; l++) {
            const double c = (2 * l + 1) * (l ? pow(l, -1.6) : power[0]);
            const double x = pi * l / 512 / 2;
            all += c * (l ? x * x / pow(sin(x), 2) : 1);
            lacks += l > 2 * size ? c : 0;
        }
        const double now = error_of(e, &set);
        CHECK(now < before && now * now > lacks / all);
        before = now;
    }
    CHECK(before < 0.01);
}

/* A table of few texels is off by more; a fitted ladder serves its materials
 * better than the usual levels of more bytes. */
TEST(ladders)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_materials m = {.weight = {{0}}};
    ibl_specular_layout layout;
    double power[LAST + 1], nrmse, before = 1;
    fill_power(1.2, power);
    for (int i = 24; i < 36; i++)
        m.weight[i][0] = 1;
    ibl_expectation *e = expect(ctx, &m, power);
    const ibl_expected_set usual = usual_set(IBL_LOOKUP_TABLE);
    for (int levels = 1; levels <= 4; levels++) {
        NEED(!ibl_expectation_fit(e, 64, levels, &layout, &nrmse));
        CHECK(nrmse < before * 1.001);
        before = nrmse;
        for (int l = 1; l < levels; l++)
            CHECK(layout.roughness[l] > layout.roughness[l - 1]);
        const ibl_expected_set set = {
            .layout = layout, .lookup = IBL_LOOKUP_TABLE, .irradiance = -1};
        CHECK_NEAR(error_of(e, &set) / nrmse, 1, 0.01);
        /* no step of two levels lessens it */
        for (int l = 0; l < levels && levels == 2; l++)
            for (int way = -1; way <= 1; way += 2) {
                ibl_expected_set other = set;
                other.layout.roughness[l] += way * 2 / 128.0;
                CHECK(error_of(e, &other) > nrmse * 0.999);
            }
    }
    CHECK(before < error_of(e, &usual));
}

TEST(refused)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_materials none = {.weight = {{0}}}, all = ibl_materials_all();
    double power[LAST + 1], nrmse;
    ibl_specular_layout layout;
    ibl_expectation *e;
    fill_power(1, power);
    CHECK(ibl_expectation_create(ctx, &none, power, LAST, 64, &e) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_expectation_create(ctx, &all, power, 0, 64, &e) ==
          IBL_ERR_ARGUMENT);
    e = expect(ctx, &all, power);
    ibl_expected_set set = {.irradiance = -2};
    CHECK(ibl_expectation_of(e, &set, &nrmse) == IBL_ERR_ARGUMENT);
    set = usual_set(IBL_LOOKUP_TWO_TAPS);
    CHECK(ibl_expectation_of(e, &set, &nrmse) == IBL_ERR_ARGUMENT);
    set.layout.levels = 99;
    set.lookup = IBL_LOOKUP_SPLIT;
    CHECK(ibl_expectation_of(e, &set, &nrmse) == IBL_ERR_ARGUMENT);
    CHECK(ibl_expectation_fit(e, 8, 5, &layout, &nrmse) == IBL_ERR_ARGUMENT);
}
