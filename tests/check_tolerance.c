/* SPDX-License-Identifier: MIT */
/*
 * The error that a tolerance promises, against the truth; parts of the range
 * of roughness; and the tree of the source that the estimate stands on.
 *
 * The promise is kept where the estimate is not below the 95th percentile of
 * the relative error. That is counted over the environments of data/ and of
 * ../shared/data, sizes and tolerances: in the suite few of them, with
 * IBL_TEST_FULL in the environment all (minutes), one line each.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/tolerance.h"
#include "bake/tree.h"
#include "ibl/ibl.h"
#include "ibl/io.h"
#include "test.h"
#include "truth.h"

enum {
    MAX_TEXELS = 6 * 16 * 16
};

static ibl_ctx *context(int threads, test_messages *kept)
{
    ibl_ctx_options o = ibl_ctx_options_default();
    ibl_ctx *ctx = NULL;
    o.threads = threads;
    o.bridge = "build/libiblbridge.so";
    o.log = kept ? test_keep : test_log;
    o.log_cookie = kept;
    if (ibl_ctx_create(&o, &ctx))
        exit(1);
    return ctx;
}

/* A sky that brightens upwards, a dim ground, and a small sun. */
static void made_map(ibl_ctx *ctx, int w, int h, ibl_image *env)
{
    if (ibl_image_alloc(ctx, w, h, env))
        exit(1);
    for (int i = 0; i < w * h; i++) {
        const int x = i % w, y = i / w;
        const float v = y < h / 2 ? 1 - (float)y / (float)h
                                  : 0.05f + 0.01f * (float)(x % 7);
        const bool sun = x * 3 / w == 2 && x * 3 % w < 4 && y == h / 4;
        env->data[3 * i] = sun ? 3000 : v;
        env->data[3 * i + 1] = sun ? 2500 : v;
        env->data[3 * i + 2] = sun ? 2000 : 1.2f * v;
    }
}

static int rising(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* ---- the tree ---------------------------------------------------------- */

static void tree_is_right_with(ibl_lobe which)
{
    static const double roughness[] = {0.25, 0.4, 0.6, 0.8, 1};
    static const int shapes[][2] = {{128, 64}, {97, 53}, {5, 3}, {1, 1}};
    ibl_ctx *ctx = context(2, NULL);
    test_random random = {3};
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
        ibl_image env;
        ibl_tree *tree = NULL;
        made_map(ctx, shapes[s][0], shapes[s][1], &env);
        NEED(!ibl_tree_create(ctx, &env, 0, &tree));
        /* Few pixels stand for patches, not for points. */
        for (size_t k = shapes[s][0] < 64 ? 5 : 1; k < 5; k++) {
            const ibl_lobe_shape lobe =
                ibl_lobe_shape_of(which, roughness[k] * roughness[k]);
            double worst[3] = {0};
            for (int i = 0; i < 40; i++) {
                static const double accuracy[] = {1e-2, 1e-3, 1e-4};
                double d[3], want[3], got[3];
                truth_cube_direction(8, i % 6, 8 * test_random_unit(&random),
                                     8 * test_random_unit(&random), d);
                truth_lobe(&env, d, which, roughness[k], want);
                for (int a = 0; a < 3; a++) {
                    ibl_tree_specular(tree, &lobe, d, accuracy[a], got);
                    worst[a] =
                        fmax(worst[a], ibl_relative_error(got, want, want));
                }
            }
            /* The midpoint sum over pixels of the truth is not the integral:
             * about (pixel / alpha)^2 / 24. */
            const double pixel = 3.15 / shapes[s][1];
            const double alpha = roughness[k] * roughness[k];
            const double rule = pixel * pixel / (alpha * alpha) / 24;
            CHECK_MSG(worst[0] < 2e-2 + rule && worst[1] < 2.5e-3 + rule &&
                          worst[2] < 1e-3 + rule,
                      "%s %dx%d r %.2f: %.1e %.1e %.1e, rule %.1e",
                      ibl_lobe_name(which), env.width, env.height, roughness[k],
                      worst[0], worst[1], worst[2], rule);
        }
        ibl_tree_free(tree);
        ibl_image_free(&env);
    }
    ibl_ctx_free(ctx);
}

static void tree_is_right(void)
{
    tree_is_right_with(IBL_LOBE_GGX);
    tree_is_right_with(IBL_LOBE_CHARLIE);
    tree_is_right_with(IBL_LOBE_PHONG);
}

/* A few pixels of the largest float, whose light with their solid angle is
 * beyond it, and of denormals, whose light is below. */
static void tree_has_no_scale(void)
{
    static const float scale[] = {1, FLT_MAX / 3000, 0x1p-149f};
    const ibl_lobe_shape lobe = ibl_lobe_shape_of(IBL_LOBE_GGX, 0.5);
    const double d[3] = {0.36, 0.48, -0.8};
    ibl_ctx *ctx = context(1, NULL);
    double first[3] = {0};
    for (size_t k = 0; k < sizeof scale / sizeof *scale; k++) {
        ibl_image env;
        ibl_tree *tree = NULL;
        double got[3], mean[3];
        NEED(!ibl_image_alloc(ctx, 9, 5, &env));
        /* Whole numbers, so that denormals hold them as well. */
        for (int i = 0; i < 3 * 9 * 5; i++)
            env.data[i] =
                (float)(i * 37 % 101 * (i % 9 < 4 ? 30 : 1)) * scale[k];
        NEED(!ibl_tree_create(ctx, &env, 0, &tree));
        ibl_tree_mean(tree, mean);
        ibl_tree_specular(tree, &lobe, d, 1e-4, got);
        for (int c = 0; c < 3; c++) {
            if (k == 0)
                first[c] = got[c] / mean[c];
            CHECK_MSG(fabs(got[c] / mean[c] - first[c]) <= 1e-5 * first[c] &&
                          mean[c] > 0 && mean[c] < 3000 * (double)scale[k],
                      "times %g: %g of a mean of %g, not %g", (double)scale[k],
                      got[c], mean[c], first[c]);
        }
        ibl_tree_free(tree);
        ibl_image_free(&env);
    }
    ibl_ctx_free(ctx);
}

/* ---- the estimate ------------------------------------------------------ */

static double relative(const double got[3], const double want[3],
                       const double mean[3])
{
    double d = 0, w = 0, m = 0;
    for (int c = 0; c < 3; c++) {
        d += (got[c] - want[c]) * (got[c] - want[c]);
        w += want[c] * want[c];
        m += mean[c] * mean[c];
    }
    return sqrt(d) / fmax(sqrt(w), 1e-3 * sqrt(m));
}

/* What is looked at of a level, and the truth there. */
typedef struct looked {
    int count, edge;
    double roughness;
    int texels[MAX_TEXELS];
    double want[MAX_TEXELS][3];
} looked;

static void look(const ibl_image *env, int edge, ibl_lobe lobe,
                 double roughness, int cells, looked *l)
{
    test_random random = {(uint64_t)edge + 99};
    l->edge = edge;
    l->roughness = roughness;
    l->count = 0;
    cells = cells < edge ? cells : edge;
    for (int i = 0; i < 6 * cells * cells; i++) {
        double d[3];
        int x = i % cells, y = i / cells % cells;
        if (cells < edge) {
            x = (int)((x + test_random_unit(&random)) * edge / cells);
            y = (int)((y + test_random_unit(&random)) * edge / cells);
        }
        const int face = i / (cells * cells);
        truth_cube_direction(edge, face, x, y, d);
        truth_lobe(env, d, lobe, roughness, l->want[l->count]);
        l->texels[l->count++] = (face * edge + y) * edge + x;
    }
}

/* 95th percentile of a level. */
static double measured(const ibl_cube *cube, int level, const looked *l,
                       const double mean[3])
{
    static double errors[MAX_TEXELS];
    const float *p = ibl_cube_face(cube, level, 0);
    for (int i = 0; i < l->count; i++) {
        const float *f = p + 3 * l->texels[i];
        const double got[3] = {(double)f[0], (double)f[1], (double)f[2]};
        errors[i] = relative(got, l->want[i], mean);
    }
    qsort(errors, (size_t)l->count, sizeof *errors, rising);
    return errors[(int)ceil(0.95 * l->count) - 1];
}

/* Levels judged, and those whose estimate is below the measured. */
typedef struct tally {
    int judged, broken, missed;
} tally;

static void judge(ibl_ctx *ctx, const char *name, const ibl_image *env,
                  ibl_lobe lobe, int size, const double *tolerances, int count,
                  int cells, tally *t)
{
    const bool full = getenv("IBL_TEST_FULL");
    looked *at = calloc(IBL_MAX_LEVELS, sizeof *at);
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_layout layout;
    double mean[3];
    o.method = IBL_METHOD_SAMPLED;
    o.lobe = lobe;
    o.size = size;
    o.samples = TEST_SANITIZED ? 8192 : 65536;
    NEED(at && !ibl_specular_layout_of(&o, &layout));
    truth_mean(env, mean);
    for (int l = 1; l < layout.levels; l++)
        look(env, ibl_cube_edge(size, l), lobe, layout.roughness[l], cells,
             &at[l]);
    for (int k = 0; k < count; k++) {
        ibl_specular_report report;
        ibl_cube cube = {0};
        o.tolerance = tolerances[k];
        NEED(!ibl_bake_specular_report(ctx, env, &o, &cube, &report));
        for (int l = 1; l < layout.levels; l++) {
            const double p95 = measured(&cube, l, &at[l], mean);
            const double error = report.level[l].error;
            t->judged++;
            t->broken += error < p95;
            t->missed += error > o.tolerance;
            if (full)
                printf("%-12.12s %3d r %.2f tolerance %.3f: %5d samples, cube "
                       "%4d, estimate %.4f, measured %.4f, ratio %.2f%s\n",
                       name, size, layout.roughness[l], o.tolerance,
                       report.level[l].samples, report.lookup_size, error, p95,
                       error / p95, error < p95 ? " BROKEN" : "");
        }
        ibl_cube_free(&cube);
    }
    free(at);
}

static void estimate_bounds_error(void)
{
    static const char *const names[] = {
        "sky.exr",   "studio.exr",       "forest.exr",
        "night.exr", "quarry_01_1k.hdr", "royal_esplanade_1k.hdr"};
    static const double all[] = {0.1, 0.05, 0.02, 0.01}, some[] = {0.1, 0.03};
    static const int sizes[] = {64, 128, 256};
    const bool full = getenv("IBL_TEST_FULL");
    const int wanted = TEST_SANITIZED && !full ? 1 : 6;
    test_messages kept = {0};
    ibl_ctx *ctx = context(2, &kept);
    tally t = {0};
    int used = 0;
    for (int e = 0; e < wanted; e++) {
        const ibl_read_options ro = ibl_read_options_default();
        const char *path =
            e < 2 ? test_data(names[e]) : test_shared_data(names[e]);
        ibl_image env;
        if (!path || ibl_image_read(ctx, path, &ro, &env, NULL))
            continue;
        used++;
        for (int s = 0; s < (full ? 3 : 1); s++)
            judge(ctx, names[e], &env, IBL_LOBE_GGX, sizes[s],
                  full ? all : some, full ? 4 : (TEST_SANITIZED ? 1 : 2),
                  full ? 7 : 4, &t);
        for (int lobe = TEST_SANITIZED ? IBL_LOBE_PHONG : IBL_LOBE_CHARLIE;
             lobe <= (int)IBL_LOBE_PHONG; lobe++)
            if ((!e && !TEST_RACES) || full)
                judge(ctx, ibl_lobe_name((ibl_lobe)lobe), &env, (ibl_lobe)lobe,
                      64, some, full ? 2 : 1, full ? 7 : 4, &t);
        ibl_image_free(&env);
    }
    CHECK(used >= (wanted < 2 ? wanted : 2));
    if (used < wanted)
        printf("%d of %d environments: the others are in ../shared/data and "
               "need the image bridge\n",
               used, wanted);
    CHECK_MSG(t.broken <= 0.05 * t.judged,
              "%d of %d levels exceed their estimate", t.broken, t.judged);
    if (full)
        printf("%d levels, %d exceed their estimate, %d their tolerance\n",
               t.judged, t.broken, t.missed);
    ibl_ctx_free(ctx);
}

static void threads_choose_the_same(void)
{
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_report reports[2];
    ibl_cube cubes[2] = {{0}};
    o.method = IBL_METHOD_SAMPLED;
    o.size = 32;
    o.samples = 8192;
    o.tolerance = 0.05;
    memset(reports, 0, sizeof reports);
    for (int i = 0; i < 2; i++) {
        ibl_ctx *ctx = context(i ? 5 : 1, NULL);
        ibl_image env;
        made_map(ctx, 128, 64, &env);
        CHECK(!ibl_bake_specular_report(ctx, &env, &o, &cubes[i], &reports[i]));
        ibl_image_free(&env);
        ibl_ctx_free(ctx);
    }
    NEED(cubes[0].data && cubes[1].data);
    CHECK(!memcmp(cubes[0].data, cubes[1].data,
                  3 * sizeof(float) *
                      ibl_cube_texels(cubes[0].size, cubes[0].levels)));
    for (int l = 0; l < reports[0].layout.levels; l++) {
        const ibl_specular_level *a = &reports[0].level[l];
        CHECK(a->samples == reports[1].level[l].samples);
        CHECK(a->error == reports[1].level[l].error);
        CHECK(l ? a->error > 0 && a->error <= 0.05 && a->samples > 0
                : a->error == -1 && !a->samples);
    }
    ibl_cube_free(&cubes[0]);
    ibl_cube_free(&cubes[1]);
}

/* A tolerance out of reach is said; a level's own samples stay. */
static void missing_is_said(void)
{
    test_messages kept = {0};
    ibl_ctx *ctx = context(2, &kept);
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_report report;
    ibl_cube cube = {0};
    ibl_image env;
    made_map(ctx, 128, 64, &env);
    o.method = IBL_METHOD_SAMPLED;
    o.size = 32;
    o.samples = 100;
    o.level_samples[2] = 77;
    o.tolerance = 1e-4;
    NEED(!ibl_bake_specular_report(ctx, &env, &o, &cube, &report));
    CHECK(strstr(kept.text[IBL_LOG_WARNING], "0.0001"));
    CHECK(strstr(kept.text[IBL_LOG_WARNING], "77 samples"));
    CHECK(report.level[1].samples <= 100 && report.level[1].error > 1e-4);
    CHECK(report.level[2].samples == 77 && report.level[2].error > 1e-4);
    ibl_cube_free(&cube);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

/* Binomial tails, from a table: of 216 with 0.05, P(<= 3) = 0.0041 and
 * P(<= 4) = 0.0131. */
static void ranks(void)
{
    CHECK(ibl_tolerance_rank(6) == 0);
    CHECK(ibl_tolerance_rank(216) == 3);
    for (int n = 1; n < 400; n++) {
        CHECK(ibl_tolerance_rank(n) <= ibl_tolerance_rank(n + 1));
        CHECK(ibl_tolerance_rank(n) <= n / 20);
    }
}

/* ---- parts of the range ------------------------------------------------ */

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

static void whole_range_is_the_chain(void)
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

static void layouts_follow_their_lod(void)
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

static void parts_are_right(void)
{
    ibl_ctx *ctx = context(2, NULL);
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_report report;
    ibl_cube cube = {0};
    ibl_image env;
    double mean[3];
    made_map(ctx, 128, 64, &env);
    truth_mean(&env, mean);
    o.method = IBL_METHOD_SAMPLED;
    o.size = 64;
    o.samples = 4096;
    o.roughness_min = 0.4;
    o.roughness_max = 0.8;
    NEED(!ibl_bake_specular_report(ctx, &env, &o, &cube, &report));
    CHECK(cube.size == report.layout.size && cube.size < 64);
    CHECK(cube.levels == report.layout.levels);
    looked *at = calloc(1, sizeof *at);
    for (int l = 0; at && l < cube.levels; l++) {
        look(&env, ibl_cube_edge(cube.size, l), IBL_LOBE_GGX,
             report.layout.roughness[l], 4, at);
        const double p95 = measured(&cube, l, at, mean);
        CHECK_MSG(p95 < 0.06, "level %d: %.3f", l, p95);
        CHECK(report.level[l].samples == 4096 && report.level[l].error == -1);
    }
    free(at);
    ibl_cube_free(&cube);
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static void bad_options(void)
{
    static const double ranges[][2] = {
        {-0.1, 1}, {0, 1.1}, {0.6, 0.5}, {(double)NAN, 1}, {0, (double)NAN}};
    test_messages kept = {0};
    ibl_ctx *ctx = context(1, &kept);
    ibl_specular_options o = ibl_specular_options_default();
    ibl_specular_layout layout;
    ibl_cube cube = {0};
    ibl_image env;
    made_map(ctx, 8, 4, &env);
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
    ibl_image_free(&env);
    ibl_ctx_free(ctx);
}

static const test tests[] = {
    TEST(tree_is_right),
    TEST(tree_has_no_scale),
    TEST(estimate_bounds_error),
    TEST(threads_choose_the_same),
    TEST(missing_is_said),
    TEST(ranks),
    TEST(whole_range_is_the_chain),
    TEST(layouts_follow_their_lod),
    TEST(parts_are_right),
    TEST(bad_options),
};
TEST_MAIN(tests)
