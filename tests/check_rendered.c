/* SPDX-License-Identifier: MIT */
/*
 * Lookups as a GPU does them, and what verify --rendered measures, against
 * second implementations that are written here from the definitions.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/rendered.h"
#include "common/option.h"
#include "ibl/io.h"
#include "reference.h"

const ibl_program ibl_this_program = {.name = "check_rendered"};

/* ---- lookups ----------------------------------------------------------- */

static ibl_cube random_chain(ibl_ctx *ctx, int n, int levels, uint64_t seed)
{
    test_random r = {seed};
    ibl_cube cube = cube_alloc(ctx, n, levels);

    for (size_t i = 0; i < cube_floats(&cube); i++)
        cube.data[i] = (float)test_random_unit(&r);
    return cube;
}

/* On a face, the four texels around by their distances. */
TEST(lookup_inside_a_face)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_cube cube = random_chain(ctx, 8, 1, 4);
    test_random r = {1};

    for (int k = 0; k < 500; k++) {
        const double x = test_random_between(&r, 0.5, 7.5);
        const double y = test_random_between(&r, 0.5, 7.5);
        const double d[3] = {-1, 1 - y / 4, x / 4 - 1}; /* -X: (-1, -v, u) */
        const int i = (int)(x - 0.5), j = (int)(y - 0.5);
        double got[3];
        ibl_lookup_cube(&cube, 0, d, got);
        for (int c = 0; c < 3; c++) {
            const float *t = ibl_cube_face(&cube, 0, 1) + 3 * (8 * j + i) + c;
            const double p = x - 0.5 - i, q = y - 0.5 - j;
            const double want =
                (1 - q) * ((1 - p) * (double)t[0] + p * (double)t[3]) +
                q * ((1 - p) * (double)t[24] + p * (double)t[27]);
            CHECK_NEAR(got[c], want, 1e-12);
        }
    }
}

/* Nothing jumps from face to face, or around a corner: texels beyond an edge
 * are those of the other face. */
TEST(lookup_across_edges)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_cube cube = random_chain(ctx, 4, 1, 5);
    test_random r = {2};

    for (int k = 0; k < 600; k++) {
        double d[3], got[3], other[3];
        random_direction(&r, d);
        const int axis = test_random_below(&r, 3), next = (axis + 1) % 3;
        d[next] = d[axis];
        if (k % 3 == 0)
            d[(axis + 2) % 3] = d[axis] * (1 - 1e-10);
        ibl_lookup_cube(&cube, 0, d, got);
        d[next] *= 1 + 1e-12;
        ibl_lookup_cube(&cube, 0, d, other);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c], other[c], 1e-9);
    }
}

/* All degrees of a sun, far from its horizon, against the integral. */
TEST(lookup_of_harmonics)
{
    static double all[3 * 65 * 65];
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_image sun = map_constant(ctx, 16, 8, 0);
    test_random r = {7};

    map_set(&sun, 3, 2, 1, 2, 3);
    NEED(!ibl_bake_sh(ctx, &sun, 64, 0, all));
    for (int k = 0; k < 20; k++) {
        double d[3], want[3], got[3];
        random_direction(&r, d);
        reference_irradiance(&sun, d, want);
        ibl_lookup_sh(all, 64, d, got);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c], want[c], 2e-4);
    }
}

/* ---- what is rendered -------------------------------------------------- */

enum {
    LEVELS = 4,
    FEW = TEST_SANITIZED ? 24 : 48, /* directions, where none is off */
    MANY = TEST_SANITIZED ? 48 : 96,
    ROWS = 6
};

/* A baked map, as a shader has it. */
typedef struct bake {
    ibl_ctx *ctx;
    ibl_image env;
    ibl_drawn set;
} bake;

static void free_lut(void *lut)
{
    ibl_lut_free(lut);
}

static bake bake_of(ibl_ctx *ctx, ibl_image env)
{
    bake b = {.ctx = ctx, .env = env};
    ibl_bake_options o = ibl_bake_options_default();
    ibl_lut_options table = ibl_lut_options_default();

    o.specular_options.size = 16;
    o.specular_options.levels = LEVELS;
    o.irradiance_options.size = 8;
    table.size = 64;
    const ibl_bake_result made = map_bake(ctx, &b.env, &o);
    ibl_drawn_chain(&b.set, &made.specular, &made.report.layout);
    b.set.shader = IBL_SHADER_SPLIT;
    b.set.irradiance = made.irradiance;
    NEED(!ibl_bake_lut(ctx, &table, &b.set.lut));
    test_defer_copy(free_lut, &b.set.lut, sizeof b.set.lut);
    return b;
}

static void free_truth(void *truth)
{
    ibl_truth_free(truth);
}

static ibl_truth truth_by(ibl_ctx *ctx, const ibl_image *env,
                          const ibl_truth_options *o)
{
    ibl_truth truth = {.rows = 0};

    NEED(ibl_truth_make(ctx, env, 0, o, &truth));
    test_defer_copy(free_truth, &truth, sizeof truth);
    return truth;
}

/* Roughness .1, .45 and 1 of F0 1 and .04. */
static ibl_truth truth_of(const bake *b, int directions)
{
    ibl_truth_options o = ibl_truth_options_default();

    o.directions = directions;
    o.roughness_count = ROWS / 2;
    o.roughness[1] = 0.45;
    o.roughness[2] = 1;
    return truth_by(b->ctx, &b->env, &o);
}

/* Nothing but the table is wrong then, whatever is looked up. All that is found
 * times 1.25 is an error of .25. */
TEST(constant_map)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    bake b = bake_of(ctx, map_constant(ctx, 16, 8, 0.5f));
    const ibl_truth truth = truth_of(&b, FEW);
    static float lobes[IBL_LOBE_LAYERS * 4];
    ibl_measured rows[ROWS];

    /* A table that floods everything with irradiance, or looks nowhere else. */
    for (int k = 0; k < 16; k++)
        lobes[k] = k % 4 < 3 ? 0.1f * (float)(k % 7) : k > 7 ? 0.2f : 0;
    b.set.lobes = (ibl_lobe_table){1, lobes, IBL_LOBE_LAYERS};
    const ibl_lut lut = b.set.lut;
    for (int shader = IBL_SHADER_SPLIT; shader <= IBL_SHADER_FOUR_TAPS;
         shader++)
        for (int table = 0; table < 2; table++) {
            b.set.shader = (ibl_shader)shader;
            b.set.lut = table ? lut : (ibl_lut){0};
            ibl_measure(&truth, &b.set, rows);
            for (int i = 0; i < ROWS; i++) {
                const double *v = rows[i].value, most = table ? 5e-2 : 1e-5;
                CHECK_NEAR(v[IBL_FIGURE_NRMSE], 0, most);
                CHECK_NEAR(v[IBL_FIGURE_P95], 0, most);
                CHECK_NEAR(v[IBL_FIGURE_BIAS], 0, most);
            }
        }
    for (size_t i = 0; i < cube_floats(&b.set.specular); i++)
        b.set.specular.data[i] *= 1.25f;
    b.set.shader = IBL_SHADER_SPLIT;
    b.set.lut = (ibl_lut){0};
    ibl_measure(&truth, &b.set, rows);
    for (int i = 0; i < ROWS; i++)
        for (int f = 0; f < IBL_FIGURES; f++) {
            CHECK_NEAR(rows[i].value[f], 0.25, 1e-5);
            CHECK_NEAR(rows[i].error[f], 0, 1e-5);
        }
}

/* ---- lookups against the split sum ----------------------------------------
 */

/* A figure of one lookup over that of another, and the share's error. */
static double share_of(const ibl_measured *a, const ibl_measured *b, int figure,
                       double *error)
{
    double without[IBL_BATCHES];

    for (int i = 0; i < IBL_BATCHES; i++)
        without[i] = a->without[i][figure] / b->without[i][figure];
    *error = ibl_jackknife(without);
    return a->value[figure] / b->value[figure];
}

static void free_lobes(void *table)
{
    ibl_lobe_table_free(table);
}

/* With a lamp, the fit and the table are nowhere worse than the split sum, and
 * several taps are nearer than one. */
TEST_SLOW(nearer_than_the_split_sum)
{
    const ibl_bake_options all = ibl_bake_options_default();
    ibl_truth_options o = ibl_truth_options_default();
    ibl_measured rows[IBL_SHADER_FOUR_TAPS + 1][16], mean[2];
    bake b = {.ctx = test_ctx(2, IBL_ISA_AUTO)};
    double error;

    b.env = map_constant(b.ctx, 256, 128, 0.5f);
    map_set(&b.env, 30, 40, 3e4f, 3e4f, 3e4f);
    const ibl_bake_result made = map_bake(b.ctx, &b.env, &all);
    ibl_drawn_chain(&b.set, &made.specular, &made.report.layout);
    b.set.irradiance = made.irradiance;
    NEED(!ibl_bake_lobe_table(b.ctx, NULL, &b.set.lobes));
    test_defer_copy(free_lobes, &b.set.lobes, sizeof b.set.lobes);
    o.directions = 384;
    const ibl_truth truth = truth_by(b.ctx, &b.env, &o);
    for (int s = IBL_SHADER_SPLIT; s <= IBL_SHADER_FOUR_TAPS; s++) {
        b.set.shader = (ibl_shader)s;
        ibl_measure(&truth, &b.set, rows[s]);
    }
    for (int k = 0; k < 6 * truth.rows; k++) {
        const int i = k / 6, s = k % 2 ? IBL_SHADER_TABLE : IBL_SHADER_FIT;
        const int f = IBL_FIGURE_NRMSE + k / 2 % 3;
        const double share =
            share_of(&rows[s][i], &rows[IBL_SHADER_SPLIT][i], f, &error);
        const double small = rows[s][i].value[f];
        CHECK_MSG(share <= 1.02 + 2 * error || small < 1e-3,
                  "shader %d, r %g: figure %d %.3f +- %.3f of %g", s,
                  o.roughness[i % o.roughness_count], f, share, error, small);
    }
    for (int k = 0; k < 4; k++) {
        const int s = k % 2 ? IBL_SHADER_FOUR_TAPS : IBL_SHADER_TWO_TAPS;
        for (int i = 0; i < 2; i++)
            mean[i] = ibl_measured_mean(rows[s - i] + k / 2 * o.roughness_count,
                                        o.roughness_count);
        const double share =
            share_of(&mean[0], &mean[1], IBL_FIGURE_NRMSE, &error);
        CHECK_MSG(share <= (k % 2 ? 1.01 : 0.97), "%d taps have %.3f",
                  s - IBL_SHADER_TABLE + 1, share);
    }
}

/* ---- brute force ------------------------------------------------------- */

/* A shader that looks up a level, or between two, with its lod. */
static void shade(const bake *b, const double n[3], const double v[3], double r,
                  double exact, double rgb[3])
{
    const double lod = r * (2 - r) * (LEVELS - 1);
    double reflected[3];

    for (int k = 0; k < 3; k++)
        reflected[k] = 2 * test_dot(n, v) * n[k] - v[k];
    ibl_lookup_chain(&b->set.specular, reflected, lod, rgb);
    for (int c = 0; c < 3; c++)
        rgb[c] *= exact;
}

/* Plain random pairs without weights, as many as make the difference of the two
 * estimates a few percent. */
TEST_SLOW(by_brute_force)
{
    /* With fewer, chance is larger. */
    enum {
        PAIRS = TEST_SANITIZED ? 250 : 2000,
        CHANCE = TEST_SANITIZED ? 4 : 1
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {11};
    const ibl_image map = map_of_kind(ctx, &rnd, MAP_SMOOTH, 16, 8);
    map_set(&map, 3, 2, 5, 5, 3);
    bake b = bake_of(ctx, map);
    const ibl_truth_options o = {.directions = TEST_SANITIZED ? 96 : 1024,
                                 .seed = 3,
                                 .roughness_count = 2,
                                 .roughness = {0.7, 1},
                                 .f0_count = 1,
                                 .f0 = {0.3}};
    const ibl_truth truth_made = truth_by(ctx, &map, &o);
    ibl_measured rows[2];

    const ibl_reference *ref = reference_of(ctx, &map, 0);
    b.set.lut = (ibl_lut){0};
    ibl_measure(&truth_made, &b.set, rows);
    for (int k = 0; k < 2; k++) {
        double wrong = 0, all = 0, light[2] = {0};
        for (int i = 0; i < PAIRS; i++) {
            double n[3], v[3], truth[4], rgb[3], sums[IBL_REFERENCE_BRDF];
            random_direction(&rnd, n);
            random_view(&rnd, n, sqrt(test_random_unit(&rnd)), v);
            NEED(!ibl_reference_brdf(ref, IBL_GEOMETRY_SMITH, &o.roughness[k],
                                     1, n, v, 1, sums));
            for (int c = 0; c < 4; c++)
                truth[c] = 0.3 * sums[c] + sums[4 + c];
            shade(&b, n, v, o.roughness[k], truth[3], rgb);
            for (int c = 0; c < 3; c++) {
                wrong += pow(rgb[c] - truth[c], 2);
                all += truth[c] * truth[c];
                light[0] += truth[c];
                light[1] += rgb[c];
            }
        }
        CHECK_NEAR(rows[k].value[IBL_FIGURE_NRMSE], sqrt(wrong / all),
                   CHANCE * 0.05 * sqrt(wrong / all));
        CHECK_NEAR(rows[k].value[IBL_FIGURE_BIAS], light[1] / light[0] - 1,
                   CHANCE * 0.03);
    }
}

/* ---- materials ----------------------------------------------------------- */

/* One material is a row of a grid, whatever its steps; its diffuse light is
 * found, too, also in harmonics. */
TEST(materials)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {9};
    bake b = bake_of(ctx, map_of_kind(ctx, &rnd, MAP_SMOOTH, 16, 8));
    ibl_materials m = {.weight = {{0}}};
    ibl_truth_options o = {.directions = MANY,
                           .seed = 5,
                           .roughness_count = 1,
                           .roughness = {0.5},
                           .f0_count = 2,
                           .f0 = {1, 0.04}};
    const ibl_truth grid = truth_by(ctx, &b.env, &o);
    ibl_measured want[2], got;
    double sh[3 * 25];

    ibl_measure(&grid, &b.set, want);
    o.materials = &m;
    for (int f = 0; f < 2; f++) {
        memset(m.weight, 0, sizeof m.weight);
        m.weight[32][f] = 3;
        const ibl_truth one = truth_by(ctx, &b.env, &o);
        ibl_measure(&one, &b.set, &got);
        for (int k = 0; k <= IBL_FIGURE_BIAS; k++) {
            CHECK_NEAR(got.value[k], want[f].value[k], 1e-9);
            CHECK_NEAR(got.error[k], want[f].error[k], 1e-9);
        }
    }
    m.diffuse[32][1] = 1; /* now most light is diffuse, and found */
    const ibl_truth lit = truth_by(ctx, &b.env, &o);
    ibl_measure(&lit, &b.set, &got);
    CHECK(got.value[IBL_FIGURE_NRMSE] < 0.3 * want[1].value[IBL_FIGURE_NRMSE]);
    const double by_cube = got.value[IBL_FIGURE_NRMSE];
    CHECK(!ibl_bake_sh(ctx, &b.env, 4, 0, sh));
    b.set.irradiance = (ibl_cube){0};
    b.set.sh = sh;
    b.set.sh_degree = 4;
    ibl_measure(&lit, &b.set, &got);
    CHECK_NEAR(got.value[IBL_FIGURE_NRMSE], by_cube, 0.2 * by_cube);
}

/* ---- standard errors ------------------------------------------------------
 */

static ibl_measured measured_by(const bake *b, int directions, int seed)
{
    ibl_truth_options o = ibl_truth_options_default();
    ibl_measured rows[2];

    o.directions = directions;
    o.seed = seed;
    o.roughness_count = 1;
    o.roughness[0] = 0.4;
    const ibl_truth truth = truth_by(b->ctx, &b->env, &o);
    ibl_measure(&truth, &b->set, rows);
    return ibl_measured_mean(rows, 2);
}

/* Of maps, suns among them, and seeds nine of ten figures are within two
 * standard errors of what many directions give, and all within six. */
TEST_SLOW(standard_errors)
{
    enum {
        MAPS = TEST_SANITIZED ? 2 : 3,
        SEEDS = 6
    };
    static const map_kind kinds[] = {MAP_SUNS, MAP_SUNNY, MAP_NOISE,
                                     MAP_BLACK_ROWS, MAP_CHECKERBOARD};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    double within = 0, most = 0;

    for (int m = 0; m < MAPS; m++) {
        test_random rnd = {(uint64_t)m};
        bake b = bake_of(ctx, map_of_kind(ctx, &rnd, kinds[m % 5], 16, 8));
        const ibl_measured all = measured_by(&b, 600, 99);
        for (int seed = 1; seed <= SEEDS; seed++) {
            const ibl_measured some = measured_by(&b, 96, seed);
            for (int f = 0; f <= IBL_FIGURE_BIAS; f++) {
                const double error = hypot(some.error[f], all.error[f]);
                const double off = fabs(some.value[f] - all.value[f]) / error;
                within += off <= 2;
                most = fmax(most, off);
            }
        }
    }
    within /= MAPS * SEEDS * 4;
    CHECK_MSG(within >= 0.88 && most <= 6, "%.3f within 2, most %g", within,
              most);
}
