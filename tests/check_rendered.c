/* SPDX-License-Identifier: MIT */
/*
 * Lookups as a GPU does them, and what verify --rendered measures, against
 * second implementations that are written here from the definitions.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/rendered.h"
#include "cli/verify_files.h"
#include "maps.h"
#include "test.h"

/* The console of the program, which this test is not. */
void ibl_console_progress(ibl_console *console, const char *stage, double done)
{
    (void)console;
    (void)stage;
    (void)done;
}

static char said[256];

bool ibl_console_fail(ibl_console *c, const char *fmt, ...)
{
    va_list args;
    (void)c;
    va_start(args, fmt);
    vsnprintf(said, sizeof said, fmt, args);
    va_end(args);
    return false;
}

/* ---- lookups ----------------------------------------------------------- */

static ibl_cube random_cube(ibl_ctx *ctx, int n, uint64_t seed)
{
    test_random r = {seed};
    ibl_cube cube = cube_alloc(ctx, n, 1);

    for (size_t i = 0; i < cube_floats(&cube); i++)
        cube.data[i] = (float)test_random_unit(&r);
    return cube;
}

static void random_dir(test_random *r, double d[3])
{
    do {
        for (int k = 0; k < 3; k++)
            d[k] = test_random_between(r, -1, 1);
    } while (test_dot(d, d) < 0.01);
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
        const ibl_cube cube = random_cube(ctx, n, 3);
        for (int i = 0; i < IBL_FACES * n * n; i++) {
            double d[3], got[3];
            ibl_cube_direction(n, i / (n * n), i % n, i / n % n, d);
            ibl_lookup_cube(&cube, d, got);
            for (int c = 0; c < 3; c++)
                CHECK_NEAR(got[c], (double)cube.data[3 * i + c], 1e-12);
        }
    }
}

/* On a face, the four texels around by their distances. */
TEST(lookup_inside_a_face)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_cube cube = random_cube(ctx, 8, 4);
    test_random r = {1};

    for (int k = 0; k < 500; k++) {
        const double x = test_random_between(&r, 0.5, 7.5);
        const double y = test_random_between(&r, 0.5, 7.5);
        const double d[3] = {-1, 1 - y / 4, x / 4 - 1}; /* -X: (-1, -v, u) */
        const int i = (int)(x - 0.5), j = (int)(y - 0.5);
        double got[3];
        ibl_lookup_cube(&cube, d, got);
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
    const ibl_cube cube = random_cube(ctx, n, 5);
    double got[3], other[3];

    for (int i = 0; i < n; i++) {
        const double v = (2 * i + 1.0) / n - 1;
        const double edge[3] = {1, v, 1}, x[3] = {1, v, 0.75},
                     z[3] = {0.75, v, 1};
        const float *a = nearest(&cube, x), *b = nearest(&cube, z);
        ibl_lookup_cube(&cube, edge, got);
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
        ibl_lookup_cube(&cube, d, got);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c], want[c], 1e-12);
    }
    test_random r = {2};
    for (int k = 0; k < 500; k++) {
        double d[3];
        random_dir(&r, d);
        const int axis = test_random_below(&r, 3), next = (axis + 1) % 3;
        d[next] = d[axis];
        ibl_lookup_cube(&cube, d, got);
        d[next] *= 1 + 1e-12;
        ibl_lookup_cube(&cube, d, other);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c], other[c], 1e-9);
    }
}

TEST(lookup_between_levels)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_cube chain[3] = {random_cube(ctx, 4, 1), random_cube(ctx, 2, 2),
                               random_cube(ctx, 1, 3)};
    const double d[3] = {0.3, -1, 0.4};
    double level[3][3], got[3];

    for (int l = 0; l < 3; l++)
        ibl_lookup_cube(&chain[l], d, level[l]);
    for (int k = -2; k < 12; k++) {
        const double lod = 0.25 * k, at = fmin(fmax(lod, 0), 2);
        const int l = at < 1 ? 0 : 1;
        ibl_lookup_chain(chain, 3, d, lod, got);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c],
                       level[l][c] + (at - l) * (level[l + 1][c] - level[l][c]),
                       1e-12);
    }
}

TEST(lods)
{
    const ibl_lod filament = {.layout = {.levels = 6,
                                         .mapping = IBL_ROUGHNESS_FILAMENT,
                                         .lod_scale = 5}};
    const ibl_lod curve = {
        .count = 3, .roughness = {0.2, 0.4, 1}, .lod = {1, 2, 6}};

    CHECK_NEAR(ibl_lod_of(&filament, 0.5), 0.75 * 5, 1e-15);
    CHECK_NEAR(ibl_lod_of(&curve, 0.1), 1, 1e-15);
    CHECK_NEAR(ibl_lod_of(&curve, 0.3), 1.5, 1e-15);
    CHECK_NEAR(ibl_lod_of(&curve, 0.7), 4, 1e-15);
    CHECK_NEAR(ibl_lod_of(&curve, 1), 6, 1e-15);
}

/* ---- what is rendered -------------------------------------------------- */

enum {
    LEVELS = 4,
    FEW = TEST_SANITIZED ? 6 : 24, /* directions, where none is off */
    MANY = TEST_SANITIZED ? 20 : 60
};

/* A bake, as verify reads it. */
typedef struct bake {
    ibl_ctx *ctx;
    ibl_image env;
    ibl_verify_files files;
    ibl_lut lut;
    ibl_specular_layout layout;
    double *power; /* the result's */
    int power_degree;
} bake;

static void free_lut(void *lut)
{
    ibl_lut_free(lut);
}

static bake *bake_of_size(ibl_ctx *ctx, ibl_image env, int size)
{
    bake *b = test_alloc(1, sizeof *b);
    ibl_bake_options o = ibl_bake_options_default();
    ibl_lut_options table = ibl_lut_options_default();

    *b = (bake){.ctx = ctx, .env = env};
    o.specular_options.size = size;
    o.specular_options.levels = LEVELS;
    o.irradiance_options.size = size / 2;
    o.power = 256;
    table.size = 64;
    const ibl_bake_result made = map_bake(ctx, &b->env, &o);
    b->layout = made.report.layout;
    b->power = made.power;
    b->power_degree = made.power_degree;
    NEED(!ibl_bake_lut(ctx, &table, &b->files.lut));
    b->lut = b->files.lut;
    test_defer(free_lut, &b->lut);
    for (int l = 0; l <= LEVELS; l++) {
        ibl_cube *cube = &b->files.cube[l];
        if (l == LEVELS) {
            *cube = made.irradiance;
        } else {
            *cube = cube_alloc(ctx, size >> l, 1);
            memcpy(cube->data, ibl_cube_face(&made.specular, l, 0),
                   cube_floats(cube) * sizeof(float));
        }
        b->files.level[l] = (ibl_judge_level){
            .content = l < LEVELS ? IBL_OUTPUT_SPECULAR : IBL_OUTPUT_IRRADIANCE,
            .lobe = IBL_LOBE_GGX,
            .roughness = made.report.layout.roughness[l < LEVELS ? l : 0],
            .scale = 1,
            .size = cube->size,
            .texels = cube->data};
    }
    b->files.count = LEVELS + 1;
    b->files.lod = (ibl_lod){.layout = {.levels = LEVELS,
                                        .mapping = IBL_ROUGHNESS_LINEAR,
                                        .lod_scale = LEVELS - 1}};
    return b;
}

static bake *bake_of(ibl_ctx *ctx, ibl_image env)
{
    return bake_of_size(ctx, env, 16);
}

static ibl_rendered *rendered(const bake *b, ibl_shader shader, int directions)
{
    ibl_rendered *out = test_alloc(1, sizeof *out);
    ibl_rendered_options o = ibl_rendered_options_default();

    o.shader = shader;
    o.directions = directions;
    o.roughness_count = 3;
    o.roughness[1] = 0.45;
    o.roughness[2] = 1;
    CHECK_MSG(ibl_rendered_judge(&b->files, b->ctx,
                                 &(ibl_judged_map){.env = b->env}, &o, NULL,
                                 out),
              "%s", said);
    return out;
}

/* Nothing but the table is wrong then, whatever is looked up. */
TEST(constant_map)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    bake *b = bake_of(ctx, map_constant(ctx, 16, 8, 0.5f));

    for (int shader = IBL_SHADER_SPLIT; shader <= IBL_SHADER_FIT; shader++)
        for (int table = 0; table < 2; table++) {
            b->files.lut = table ? b->lut : (ibl_lut){0};
            const ibl_rendered *r = rendered(b, (ibl_shader)shader, FEW);
            for (int i = 0; i < r->count; i++) {
                const ibl_rendered_row *row = &r->rows[i];
                const double most = table ? 5e-2 : 1e-6;
                CHECK_NEAR(row->nrmse, 0, most);
                CHECK_NEAR(row->p95, 0, most);
                CHECK_NEAR(row->ratio, 1, most);
                CHECK_NEAR(row->part[IBL_PART_VIEW], 0, 1e-6);
                CHECK_NEAR(row->part[IBL_PART_LEVELS], 0, 1e-6);
                CHECK_NEAR(row->part[IBL_PART_TEXELS], 0, 1e-6);
                CHECK_NEAR(row->part[IBL_PART_TABLE], row->nrmse,
                           1e-6 + 0.2 * row->nrmse);
            }
        }
}

/* A table that floods everything with irradiance, or looks nowhere else. */
TEST(constant_map_by_a_lobe_table)
{
    static float lobes[IBL_LOBE_LAYERS * 4];
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    bake *b = bake_of(ctx, map_constant(ctx, 16, 8, 0.5f));

    b->files.lut = (ibl_lut){0};
    for (int k = 0; k < 16; k++)
        lobes[k] = k % 4 < 3 ? 0.1f * (float)(k % 7) : k > 7 ? 0.2f : 0;
    b->files.lobes = (ibl_lobe_table){1, lobes, IBL_LOBE_LAYERS};
    for (int shader = IBL_SHADER_TABLE; shader <= IBL_SHADER_TWO_TAPS;
         shader++) {
        const ibl_rendered *r = rendered(b, (ibl_shader)shader, FEW);
        for (int i = 0; i < r->count; i++)
            CHECK_NEAR(r->rows[i].nrmse, 0, 1e-6);
    }
    CHECK(rendered(b, IBL_SHADER_AUTO, FEW)->options.shader ==
          IBL_SHADER_TABLE);
    b->files.lobes = (ibl_lobe_table){0};
    CHECK(rendered(b, IBL_SHADER_AUTO, FEW)->options.shader ==
          IBL_SHADER_SPLIT);
}

/* A lobe table that says what the split sum does: the same colours. */
TEST(split_by_a_lobe_table)
{
    enum {
        N = 64
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {4};
    bake *b = bake_of(ctx, map_of_kind(ctx, &rnd, MAP_SMOOTH, 16, 8));
    float *lobes = test_alloc(IBL_LOBE_LAYERS * N * N * 4, sizeof *lobes);

    for (int i = 0; i < IBL_LOBE_LAYERS * N * N; i++)
        lobes[4 * i + 1] = (float)((i / N % N + 0.5) / N);
    b->files.lobes = (ibl_lobe_table){N, lobes, IBL_LOBE_LAYERS};
    const ibl_rendered *split = rendered(b, IBL_SHADER_SPLIT, FEW);
    const ibl_rendered *table = rendered(b, IBL_SHADER_TABLE, FEW);
    /* Roughness 1 is beyond the centre of the last row. */
    for (int i = 0; i < 2; i++) {
        CHECK_NEAR(table->rows[i].nrmse, split->rows[i].nrmse, 1e-6);
        CHECK_NEAR(table->rows[i].ratio, split->rows[i].ratio, 1e-6);
    }
}

/* ---- brute force ------------------------------------------------------- */

static double squared(double x)
{
    return x * x;
}

/* f N.L dO over the pixels in 3 x 3 parts. */
static void truth_of(const ibl_image *env, const double n[3], const double v[3],
                     double r, double f0, double rgb[4])
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

/* A shader that looks at the nearest texel of a level, which is what the other
 * does if every face has one value. */
static void shade(const bake *b, const double n[3], const double v[3], double r,
                  double exact, double rgb[3])
{
    const double lod = r * (LEVELS - 1);
    const int l = lod < LEVELS - 1 ? (int)lod : LEVELS - 2;
    double reflected[3];

    for (int k = 0; k < 3; k++)
        reflected[k] = 2 * test_dot(n, v) * n[k] - v[k];
    for (int c = 0; c < 3; c++) {
        double got[2][3];
        for (int k = 0; k < 2; k++)
            ibl_lookup_cube(&b->files.cube[l + k], reflected, got[k]);
        rgb[c] = exact * (got[0][c] + (lod - l) * (got[1][c] - got[0][c]));
    }
}

/* No direction is more likely than another. */
static void random_in_ball(test_random *r, double d[3])
{
    do
        random_dir(r, d);
    while (test_dot(d, d) > 1);
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
    static const double roughness[2] = {0.7, 1};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {11};
    const ibl_image map = map_of_kind(ctx, &rnd, MAP_SMOOTH, 16, 8);
    map_set(&map, 3, 2, 5, 5, 3);
    bake *b = bake_of(ctx, map);
    ibl_rendered_options o = {.shader = IBL_SHADER_SPLIT,
                              .directions = TEST_SANITIZED ? 96 : 1536,
                              .seed = 3,
                              .roughness_count = 2,
                              .roughness = {roughness[0], roughness[1]},
                              .f0_count = 1,
                              .f0 = {0.3}};
    ibl_rendered out;

    b->files.lut = (ibl_lut){0};
    CHECK(ibl_rendered_judge(&b->files, ctx, &(ibl_judged_map){.env = b->env},
                             &o, NULL, &out));
    for (int k = 0; k < 2; k++) {
        double wrong = 0, all = 0, light[2] = {0};
        for (int i = 0; i < PAIRS; i++) {
            double n[3], t[3], v[3], truth[4], rgb[3];
            random_in_ball(&rnd, n);
            const double length = sqrt(test_dot(n, n));
            for (int c = 0; c < 3; c++)
                n[c] /= length;
            do {
                random_in_ball(&rnd, t);
                const double along = test_dot(t, n);
                for (int c = 0; c < 3; c++)
                    t[c] -= along * n[c];
            } while (test_dot(t, t) < 0.01);
            const double nv = sqrt(test_random_unit(&rnd));
            for (int c = 0; c < 3; c++)
                v[c] = nv * n[c] + sqrt((1 - nv * nv) / test_dot(t, t)) * t[c];
            truth_of(&b->env, n, v, roughness[k], 0.3, truth);
            shade(b, n, v, roughness[k], truth[3], rgb);
            for (int c = 0; c < 3; c++) {
                wrong += squared(rgb[c] - truth[c]);
                all += squared(truth[c]);
                light[0] += truth[c];
                light[1] += rgb[c];
            }
        }
        CHECK_NEAR(out.rows[k].nrmse, sqrt(wrong / all),
                   CHANCE * 0.05 * sqrt(wrong / all));
        CHECK_NEAR(out.rows[k].ratio, light[1] / light[0],
                   CHANCE * 0.03 * light[1] / light[0]);
    }
}

/* ---- as expected ------------------------------------------------------- */

static void free_table(void *table)
{
    ibl_lobe_table_free(table);
}

/* Of surfaces of roughness bin / 64, F0 = 1 (0) or .04 (1). */
static double expected(ibl_ctx *ctx, const bake *b, int bin, int f,
                       const ibl_expected_set *set)
{
    ibl_materials m = {.weight = {{0}}};
    ibl_expectation *e;
    double nrmse;
    m.weight[bin][f] = 1;
    NEED(
        !ibl_expectation_create(ctx, &m, b->power, b->power_degree, 16, 0, &e));
    NEED(!ibl_expectation_of(e, set, &nrmse));
    ibl_expectation_free(e);
    return nrmse;
}

/* Random pairs of a normal and a view are all rotations of the map. What is
 * left is chance, most of it with small suns (up to 1.35 in five seeds; 3,000
 * directions leave 1.05, and take half a minute), and texels, of which only the
 * mean blur is expected. */
static void as_expected(map_kind kind, double chance)
{
    if (TEST_RACES)
        test_skip("takes minutes, and has no threads of its own");
    if (TEST_SANITIZED) /* an eighth of the directions */
        chance = 1 + 4 * (chance - 1);
    static const int bins[3] = {29, 45, 64};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {5};
    bake *b = bake_of_size(ctx, map_of_kind(ctx, &rnd, kind, 32, 16), 64);
    ibl_rendered_options o = ibl_rendered_options_default();
    const ibl_lobe_table_options of = {.struct_size = sizeof of,
                                       .size = 16,
                                       .layout = b->layout,
                                       .power = b->power,
                                       .power_degree = b->power_degree};
    ibl_lobe_table table = {0};

    NEED(!ibl_bake_lobe_table(ctx, &of, &table));
    test_defer_copy(free_table, &table, sizeof table);
    b->files.lut = (ibl_lut){0}; /* exact */
    b->files.lobes = table;
    b->files.lod.layout.mapping = IBL_ROUGHNESS_FILAMENT;
    o.directions = TEST_SANITIZED ? 50 : 400;
    o.roughness_count = 3;
    for (int i = 0; i < 3; i++)
        o.roughness[i] = bins[i] / 64.0;
    for (int way = 0; way < IBL_LOOKUP_COUNT; way++) {
        static const ibl_shader shaders[] = {IBL_SHADER_SPLIT, IBL_SHADER_TABLE,
                                             IBL_SHADER_TWO_TAPS};
        ibl_rendered out;
        o.shader = shaders[way];
        NEED(ibl_rendered_judge(
            &b->files, ctx, &(ibl_judged_map){.env = b->env}, &o, NULL, &out));
        for (int i = 0; i < 2 * 4; i++) {
            if (i % 4 == 3)
                continue; /* the mean */
            const double want =
                expected(ctx, b, bins[i % 4], i / 4,
                         &(ibl_expected_set){.layout = b->layout,
                                             .lookup = (ibl_lookup)way,
                                             .lobes = way ? &table : NULL,
                                             .irradiance = -1});
            const double share = out.rows[i].nrmse / want;
            test_measured("nRMSE over or under the expected",
                          fmax(share, 1 / share), chance);
            CHECK_MSG(fmax(share, 1 / share) < chance,
                      "way %d F0 %g r %g: nRMSE %g, expected %g", way,
                      out.rows[i].f0, out.rows[i].roughness, out.rows[i].nrmse,
                      want);
        }
    }
}

TEST_SLOW(as_expected_of_noise)
{
    as_expected(MAP_NOISE, 1.12);
}

TEST_SLOW(as_expected_under_suns)
{
    as_expected(MAP_SUNS, 1.45);
}

/* ---- parts ------------------------------------------------------------- */

/* Each damage shows in its part, and in none before it. */
TEST(damage_shows_in_its_part)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {6};
    bake *b = bake_of(ctx, map_of_kind(ctx, &rnd, MAP_SMOOTH, 32, 16));
    const ibl_rendered_row before =
        *ibl_rendered_mean(rendered(b, IBL_SHADER_SPLIT, MANY), 0);
    ibl_rendered_row row;

    for (size_t i = 0; i < 2 * 64 * 64; i++)
        b->files.lut.data[i] *= 1.2f;
    row = *ibl_rendered_mean(rendered(b, IBL_SHADER_SPLIT, MANY), 0);
    CHECK(!memcmp(row.part, before.part, 3 * sizeof *row.part));
    CHECK_NEAR(row.part[IBL_PART_TABLE], 0.2, 0.05);

    for (int l = 0; l < LEVELS; l++) {
        ibl_cube *cube = &b->files.cube[l];
        const size_t face = cube_floats(cube) / 6;
        for (size_t i = 0; i < face; i++) {
            const float kept = cube->data[i];
            cube->data[i] = cube->data[face + i];
            cube->data[face + i] = kept;
        }
    }
    row = *ibl_rendered_mean(rendered(b, IBL_SHADER_SPLIT, MANY), 0);
    CHECK(!memcmp(row.part, before.part, 2 * sizeof *row.part));
    CHECK(row.part[IBL_PART_TEXELS] > 3 * before.part[IBL_PART_TEXELS]);

    b->files.lod.layout.lod_scale *= 0.5;
    row = *ibl_rendered_mean(rendered(b, IBL_SHADER_SPLIT, MANY), 0);
    CHECK(row.part[IBL_PART_VIEW] == before.part[IBL_PART_VIEW]);
    CHECK(row.part[IBL_PART_LEVELS] > 1.5 * before.part[IBL_PART_LEVELS]);
}

/* N = V = R of one map is wrong at the limb, where the formula is better. */
TEST(bent_is_nearer)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {8};
    const bake *b = bake_of(ctx, map_of_kind(ctx, &rnd, MAP_SMOOTH, 32, 16));
    const ibl_rendered *split = rendered(b, IBL_SHADER_SPLIT, MANY);
    const ibl_rendered *bent = rendered(b, IBL_SHADER_BENT, MANY);
    const ibl_rendered *fit = rendered(b, IBL_SHADER_FIT, MANY);

    CHECK(ibl_rendered_mean(bent, 0)->part[IBL_PART_LEVELS] >
          0.3 * ibl_rendered_mean(split, 0)->part[IBL_PART_LEVELS]);
    CHECK(ibl_rendered_mean(bent, 0)->nrmse <
          0.7 * ibl_rendered_mean(split, 0)->nrmse);
    CHECK(ibl_rendered_mean(fit, 0)->nrmse <
          0.5 * ibl_rendered_mean(split, 0)->nrmse);
    CHECK(ibl_rendered_mean(fit, 1)->nrmse <
          0.8 * ibl_rendered_mean(bent, 1)->nrmse);
}

/* Whether judging fails with these words. */
static bool fails(const bake *b, ibl_shader shader, const char *words)
{
    const ibl_judged_map map = {.env = b->env};
    ibl_rendered_options o = ibl_rendered_options_default();
    ibl_rendered out;

    o.shader = shader;
    return !ibl_rendered_judge(&b->files, b->ctx, &map, &o, NULL, &out) &&
           strstr(said, words);
}

TEST(refuses)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    bake *b = bake_of(ctx, map_constant(ctx, 8, 4, 1));

    CHECK(fails(b, IBL_SHADER_TWO_TAPS, "no lobe table"));
    b->files.count = LEVELS;
    CHECK(fails(b, IBL_SHADER_FIT, "no irradiance map"));
    b->files.level[0].lobe = IBL_LOBE_PHONG;
    CHECK(fails(b, IBL_SHADER_SPLIT, "of the lobe phong"));
    b->files.count = 0;
    CHECK(fails(b, IBL_SHADER_SPLIT, "no specular cube"));
}
