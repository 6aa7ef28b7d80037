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

/* The texel whose centre is nearest to a direction. */
static const float *nearest(const ibl_cube *cube, const double dir[3])
{
    const int n = cube->size;
    double best = -2;
    int at = 0;

    for (int i = 0; i < IBL_FACES * n * n; i++) {
        double d[3];
        ibl_cube_direction(n, i / (n * n), i % n, i / n % n, d);
        if (test_dot(d, dir) > best)
            best = test_dot(d, dir), at = i;
    }
    return cube->data + 3 * (size_t)at;
}

TEST(lookup_at_centres)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);

    for (int n = 1; n < 6; n++) {
        const ibl_cube cube = random_chain(ctx, n, 1, 3);
        for (int i = 0; i < IBL_FACES * n * n; i++) {
            double d[3], got[3];
            ibl_cube_direction(n, i / (n * n), i % n, i / n % n, d);
            ibl_lookup_cube(&cube, 0, d, got);
            for (int c = 0; c < 3; c++)
                CHECK_NEAR(got[c], (double)cube.data[3 * i + c], 1e-12);
        }
    }
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

/* At an edge the two texels on either side have the same share, and at a corner
 * the three. Nothing jumps from face to face. */
TEST(lookup_across_edges)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const int n = 4;
    const ibl_cube cube = random_chain(ctx, n, 1, 5);
    double got[3], other[3];

    for (int i = 0; i < n; i++) {
        const double v = (2 * i + 1.0) / n - 1;
        const double edge[3] = {1, v, 1}, x[3] = {1, v, 0.75},
                     z[3] = {0.75, v, 1};
        const float *a = nearest(&cube, x), *b = nearest(&cube, z);
        ibl_lookup_cube(&cube, 0, edge, got);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c], ((double)a[c] + (double)b[c]) / 2, 1e-12);
    }
    for (int k = 0; k < 8; k++) {
        const double d[3] = {k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1};
        double want[3] = {0};
        for (int axis = 0; axis < 3; axis++) {
            double in[3];
            for (int c = 0; c < 3; c++)
                in[c] = d[c] * (c == axis ? 1 : 0.75);
            for (int c = 0; c < 3; c++)
                want[c] += (double)nearest(&cube, in)[c] / 3;
        }
        ibl_lookup_cube(&cube, 0, d, got);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c], want[c], 1e-12);
    }
    test_random r = {2};
    for (int k = 0; k < 500; k++) {
        double d[3];
        random_direction(&r, d);
        const int axis = test_random_below(&r, 3), next = (axis + 1) % 3;
        d[next] = d[axis];
        ibl_lookup_cube(&cube, 0, d, got);
        d[next] *= 1 + 1e-12;
        ibl_lookup_cube(&cube, 0, d, other);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c], other[c], 1e-9);
    }
}

TEST(lookup_between_levels)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_cube chain = random_chain(ctx, 4, 3, 1);
    const double d[3] = {0.3, -1, 0.4};
    double level[3][3], got[3];

    for (int l = 0; l < 3; l++)
        ibl_lookup_cube(&chain, l, d, level[l]);
    for (int k = -2; k < 12; k++) {
        const double lod = 0.25 * k, at = fmin(fmax(lod, 0), 2);
        const int l = at < 1 ? 0 : 1;
        ibl_lookup_chain(&chain, d, lod, got);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c],
                       level[l][c] + (at - l) * (level[l + 1][c] - level[l][c]),
                       1e-12);
    }
}

/* Radiance 1 + y + x^2: irradiance / pi is known in closed form. */
TEST(lookup_of_harmonics)
{
    static double sh[3 * 25];
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    test_random r = {7};
    double want[3], got[3], d[3];

    for (int c = 0; c < 3; c++) {
        sh[c] = sqrt(4 * M_PI) * (1 + 1 / 3.0);
        sh[3 + c] = sqrt(4 * M_PI / 3);
        sh[3 * 6 + c] = -sqrt(16 * M_PI / 5) / 6; /* x^2 - 1/3, in 3 z^2 - 1 */
        sh[3 * 8 + c] = sqrt(16 * M_PI / 15) / 2; /* and in x^2 - y^2 */
    }
    for (int k = 0; k < 50; k++) {
        random_direction(&r, d);
        ibl_lookup_sh(sh, 4, d, got);
        CHECK_NEAR(got[1],
                   1 + 2 * d[1] / 3 + 1 / 3.0 + (d[0] * d[0] - 1 / 3.0) / 4,
                   1e-12);
    }
    /* All degrees of a sun, far from its horizon, against the integral. */
    const ibl_image sun = map_constant(ctx, 16, 8, 0);
    static double all[3 * 65 * 65];
    ibl_reference *ref;
    map_set(&sun, 3, 2, 1, 2, 3);
    NEED(!ibl_bake_sh(ctx, &sun, 64, 0, all));
    NEED(!ibl_reference_create(ctx, &sun, 0, &ref));
    for (int k = 0; k < 50; k++) {
        random_direction(&r, d);
        CHECK(!ibl_reference_irradiance(ref, d, 1, want));
        ibl_lookup_sh(all, 64, d, got);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c], want[c], 2e-4);
    }
    ibl_reference_free(ref);
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

static void measure(const ibl_truth *truth, const bake *b,
                    ibl_measured rows[ROWS])
{
    ibl_measure(truth, &b->set, rows);
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
            measure(&truth, &b, rows);
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
    measure(&truth, &b, rows);
    for (int i = 0; i < ROWS; i++)
        for (int f = 0; f < IBL_FIGURES; f++) {
            CHECK_NEAR(rows[i].value[f], 0.25, 1e-5);
            CHECK_NEAR(rows[i].error[f], 0, 1e-5);
        }
}

/* A lobe table that says what the split sum does: the same colours. */
TEST(split_by_a_lobe_table)
{
    enum {
        N = 64
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {4};
    bake b = bake_of(ctx, map_of_kind(ctx, &rnd, MAP_SMOOTH, 16, 8));
    const ibl_truth truth = truth_of(&b, FEW);
    float *lobes = test_alloc(IBL_LOBE_LAYERS * N * N * 4, sizeof *lobes);
    ibl_measured split[ROWS], table[ROWS];

    for (int i = 0; i < IBL_LOBE_LAYERS * N * N; i++)
        lobes[4 * i + 1] =
            (float)ibl_set_lod(&b.set.chain, i / N % N / (N - 1.0)) /
            (LEVELS - 1);
    b.set.lobes = (ibl_lobe_table){N, lobes, IBL_LOBE_LAYERS};
    measure(&truth, &b, split);
    b.set.shader = IBL_SHADER_TABLE;
    measure(&truth, &b, table);
    for (int i = 0; i < ROWS; i++)
        for (int f = 0; f < IBL_FIGURES; f++)
            CHECK_NEAR(table[i].value[f], split[i].value[f], 2e-4);
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

/* The fit and the table are nowhere worse than the split sum, and several taps
 * are nearer than one. */
static void compare_lookups(const char *name, ibl_ctx *ctx, ibl_image env,
                            int directions)
{
    const ibl_bake_options all = ibl_bake_options_default();
    ibl_truth_options o = ibl_truth_options_default();
    ibl_measured rows[IBL_SHADER_FOUR_TAPS + 1][16], mean[2];
    const ibl_bake_result made = map_bake(ctx, &env, &all);
    bake b = {.ctx = ctx, .env = env};
    double error;

    ibl_drawn_chain(&b.set, &made.specular, &made.report.layout);
    b.set.irradiance = made.irradiance;
    NEED(!ibl_bake_lobe_table(ctx, NULL, &b.set.lobes));
    test_defer_copy(free_lobes, &b.set.lobes, sizeof b.set.lobes);
    o.directions = directions;
    const ibl_truth truth = truth_by(ctx, &env, &o);
    for (int s = IBL_SHADER_SPLIT; s <= IBL_SHADER_FOUR_TAPS; s++) {
        b.set.shader = (ibl_shader)s;
        ibl_measure(&truth, &b.set, rows[s]);
    }
    for (int i = 0; i < truth.rows; i++)
        for (int s = IBL_SHADER_FIT; s <= IBL_SHADER_TABLE; s++)
            for (int f = IBL_FIGURE_NRMSE; f <= IBL_FIGURE_MEDIAN; f++) {
                const double share = share_of(
                    &rows[s][i], &rows[IBL_SHADER_SPLIT][i], f, &error);
                const double small = rows[s][i].value[f];
                CHECK_MSG(share <= 1.02 + 2 * error || small < 1e-3,
                          "%s, shader %d, r %g: figure %d %.3f +- %.3f of %g",
                          name, s, o.roughness[i % o.roughness_count], f, share,
                          error, small);
            }
    for (int f0 = 0; f0 < 2; f0++)
        for (int s = IBL_SHADER_TWO_TAPS; s <= IBL_SHADER_FOUR_TAPS; s++) {
            for (int k = 0; k < 2; k++)
                mean[k] = ibl_measured_mean(
                    rows[s - k] + f0 * o.roughness_count, o.roughness_count);
            const double share =
                share_of(&mean[0], &mean[1], IBL_FIGURE_NRMSE, &error);
            CHECK_MSG(share <= (s < IBL_SHADER_FOUR_TAPS ? 0.97 : 1.01),
                      "%s: %d taps have %.3f of the error", name,
                      s - IBL_SHADER_TABLE + 1, share);
        }
}

TEST_SLOW(nearer_than_the_split_sum)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const int directions = 512;
    const char *path = test_shared_data("quarry_01_1k.hdr");
    ibl_image env = map_constant(ctx, 256, 128, 0.5f);

    if (TEST_SANITIZED)
        test_skip("its figures need many directions");
    for (int c = 0; c < 3; c++) /* a lamp */
        env.data[3 * (40 * 256 + 30) + c] = 3e4f;
    compare_lookups("lamp", ctx, env, directions);
    if (!path)
        return;
    NEED(!ibl_image_read(ctx, path, NULL, &env, NULL));
    compare_lookups("quarry", ctx, test_image(env), directions);
}

/* ---- brute force ------------------------------------------------------- */

static double squared(double x)
{
    return x * x;
}

/* f N.L dO over the pixels in 3 x 3 parts. */
static void truth_of_pair(const ibl_image *env, const double n[3],
                          const double v[3], double r, double f0, double rgb[4])
{
    const int w = 3 * env->width, h = 3 * env->height;
    const double a2 = pow(r, 4), nv = test_dot(n, v);

    memset(rgb, 0, 4 * sizeof *rgb);
    for (int i = 0; i < w * h; i++) {
        const double theta = M_PI * (i / w + 0.5) / h;
        const double phi = 2 * M_PI * ((i % w + 0.5) / w - 0.5);
        const double l[3] = {sin(theta) * cos(phi), cos(theta),
                             sin(theta) * sin(phi)};
        const double nl = test_dot(n, l);
        if (nl <= 0)
            continue;
        const double hh[3] = {v[0] + l[0], v[1] + l[1], v[2] + l[2]};
        const double length = sqrt(test_dot(hh, hh));
        const double nh = test_dot(n, hh) / length;
        const double vh = test_dot(v, hh) / length;
        const double d = a2 / (M_PI * squared(squared(nh) * (a2 - 1) + 1));
        const double g = 2 / (nl * sqrt(a2 + (1 - a2) * squared(nv)) +
                              nv * sqrt(a2 + (1 - a2) * squared(nl)));
        const double f = f0 + (1 - f0) * pow(1 - vh, 5);
        const double weight =
            d * g * f / 4 * nl * 2 * M_PI / w *
            (cos(M_PI * (i / w) / h) - cos(M_PI * (i / w + 1) / h));
        const float *p = map_pixel(env, i % w / 3, i / w / 3);
        for (int c = 0; c < 3; c++)
            rgb[c] += weight * (double)p[c];
        rgb[3] += weight;
    }
}

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

/* A normal and a view, uniform and with the density 2 N.V. */
static void random_pair(test_random *rnd, double n[3], double v[3])
{
    double t[3];

    random_direction(rnd, n);
    do {
        random_direction(rnd, t);
        const double along = test_dot(t, n);
        for (int c = 0; c < 3; c++)
            t[c] -= along * n[c];
    } while (test_dot(t, t) < 0.01);
    const double nv = sqrt(test_random_unit(rnd));
    for (int c = 0; c < 3; c++)
        v[c] = nv * n[c] + sqrt((1 - nv * nv) / test_dot(t, t)) * t[c];
}

/* Plain random pairs without weights, as many as make the difference of the two
 * estimates a few percent. */
TEST_SLOW(by_brute_force)
{
    /* With fewer, chance is larger. */
    enum {
        PAIRS = TEST_SANITIZED ? 250 : 4000,
        CHANCE = TEST_SANITIZED ? 4 : 1
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {11};
    const ibl_image map = map_of_kind(ctx, &rnd, MAP_SMOOTH, 16, 8);
    map_set(&map, 3, 2, 5, 5, 3);
    bake b = bake_of(ctx, map);
    const ibl_truth_options o = {.directions = TEST_SANITIZED ? 96 : 1536,
                                 .seed = 3,
                                 .roughness_count = 2,
                                 .roughness = {0.7, 1},
                                 .f0_count = 1,
                                 .f0 = {0.3}};
    const ibl_truth truth_made = truth_by(ctx, &map, &o);
    ibl_measured rows[2];

    b.set.lut = (ibl_lut){0};
    ibl_measure(&truth_made, &b.set, rows);
    for (int k = 0; k < 2; k++) {
        double wrong = 0, all = 0, light[2] = {0};
        for (int i = 0; i < PAIRS; i++) {
            double n[3], v[3], truth[4], rgb[3];
            random_pair(&rnd, n, v);
            truth_of_pair(&b.env, n, v, o.roughness[k], 0.3, truth);
            shade(&b, n, v, o.roughness[k], truth[3], rgb);
            for (int c = 0; c < 3; c++) {
                wrong += squared(rgb[c] - truth[c]);
                all += squared(truth[c]);
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

/* ---- damage ------------------------------------------------------------ */

/* A table whose scale and bias are a fifth too large, and a face that is
 * black. */
TEST(damage_shows)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {6};
    bake b = bake_of(ctx, map_of_kind(ctx, &rnd, MAP_SMOOTH, 32, 16));
    const ibl_truth truth = truth_of(&b, MANY);
    ibl_measured before[ROWS], now[ROWS];

    measure(&truth, &b, before);
    for (size_t i = 0; i < 2 * 64 * 64; i++)
        b.set.lut.data[i] *= 1.2f;
    measure(&truth, &b, now);
    for (int i = 0; i < ROWS; i++)
        CHECK_NEAR(now[i].value[IBL_FIGURE_BIAS],
                   1.2 * (before[i].value[IBL_FIGURE_BIAS] + 1) - 1, 1e-6);
    for (size_t i = 0; i < 2 * 64 * 64; i++)
        b.set.lut.data[i] /= 1.2f;
    for (int l = 0; l < LEVELS; l++) {
        const int n = ibl_cube_edge(b.set.specular.size, l);
        memset(ibl_cube_face(&b.set.specular, l, 0), 0,
               3 * sizeof(float) * (size_t)(n * n));
    }
    measure(&truth, &b, now);
    for (int i = 0; i < ROWS; i++)
        CHECK(now[i].value[IBL_FIGURE_NRMSE] >
              1.05 * before[i].value[IBL_FIGURE_NRMSE]);
}

/* N = V = R of one map is wrong at the limb, where the formula is better. */
TEST(bent_is_nearer)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {8};
    bake b = bake_of(ctx, map_of_kind(ctx, &rnd, MAP_SMOOTH, 32, 16));
    const ibl_truth truth = truth_of(&b, MANY);
    double error[3][2];

    for (int k = 0; k < 3; k++) {
        ibl_measured rows[ROWS];
        b.set.shader = (ibl_shader)(IBL_SHADER_SPLIT + k);
        ibl_measure(&truth, &b.set, rows);
        for (int f = 0; f < 2; f++)
            error[k][f] = ibl_measured_mean(rows + f * ROWS / 2, ROWS / 2)
                              .value[IBL_FIGURE_NRMSE];
    }
    CHECK(error[1][0] < 0.7 * error[0][0]);
    CHECK(error[2][0] < 0.5 * error[0][0]);
    CHECK(error[2][1] < 0.8 * error[1][1]);
}

/* ---- materials ----------------------------------------------------------- */

/* One material is a row of a grid, whatever its steps; its diffuse light is
 * found, too, also in harmonics. Of two, each has its share. */
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
    /* Without diffuse light, half of the surfaces in view are metals. */
    m.diffuse[32][1] = 0;
    m.weight[32][0] = 3;
    o.directions = 8 * MANY;
    const ibl_truth both = truth_by(ctx, &b.env, &o);
    double weight[2] = {0};
    for (int i = 0; i < o.directions; i++)
        weight[both.sample[i].f0 < 1] += both.sample[i].weight;
    CHECK_NEAR(weight[0] / weight[1], 1, 0.3);
}

/* ---- standard errors ------------------------------------------------------
 */

/* Doubles the directions while a row is vague. */
static ibl_measured measured_by(const bake *b, int directions, int most,
                                int seed)
{
    ibl_truth_options o = ibl_truth_options_default();
    ibl_truth truth = {.rows = 0};
    ibl_measured rows[2];
    bool vague = true;

    o.seed = seed;
    o.roughness_count = 1;
    o.roughness[0] = 0.4;
    for (o.directions = directions; o.directions <= most && vague;
         o.directions *= 2) {
        NEED(ibl_truth_make(b->ctx, &b->env, 0, &o, &truth));
        ibl_measure(&truth, &b->set, rows);
        vague = false;
        for (int i = 0; i < 2; i++)
            vague |= ibl_is_vague(rows[i].value[IBL_FIGURE_NRMSE],
                                  rows[i].error[IBL_FIGURE_NRMSE]);
    }
    ibl_truth_free(&truth);
    return ibl_measured_mean(rows, 2);
}

/* Of maps, suns among them, and seeds nine of ten figures are within two
 * standard errors of what many directions give, and all within six, also where
 * directions are added until errors are small. */
TEST_SLOW(standard_errors)
{
    enum {
        MAPS = TEST_SANITIZED ? 2 : 5,
        SEEDS = 8
    };
    static const map_kind kinds[] = {MAP_SUNS, MAP_SUNNY, MAP_NOISE,
                                     MAP_BLACK_ROWS, MAP_CHECKERBOARD};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    double within = 0, most = 0;

    for (int m = 0; m < MAPS; m++) {
        test_random rnd = {(uint64_t)m};
        bake b = bake_of(ctx, map_of_kind(ctx, &rnd, kinds[m % 5], 16, 8));
        const ibl_measured all = measured_by(&b, 1200, 1200, 99);
        for (int seed = 1; seed <= SEEDS; seed++) {
            const ibl_measured some = measured_by(&b, 48, 384, seed);
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
