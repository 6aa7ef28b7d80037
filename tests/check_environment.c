/* SPDX-License-Identifier: MIT */
/* One reading of an environment, by rows or from memory: the same bytes in all
 * ways, the memory that it takes, progress, and what errors do. The truth is a
 * bake from memory by one thread, bakes of one thing alone, and the reference.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "files.h"
#include "reference.h"

/* A map that is handed out row by row, once. */
typedef struct feeder {
    const ibl_image *map;
    int row;
    int fail_at;       /* row before which it fails; 0: never */
    const float *last; /* where the last rows went */
    ibl_ctx *cancel;
} feeder;

static ibl_status feed(void *cookie, int rows, float *rgb)
{
    feeder *f = cookie;
    const size_t row = 3 * (size_t)f->map->width;
    if (f->fail_at && f->row + rows > f->fail_at)
        return IBL_ERR_IO;
    if (f->cancel)
        ibl_ctx_cancel(f->cancel);
    CHECK(rgb != f->last); /* they may still be in use */
    f->last = rgb;
    memcpy(rgb, f->map->data + row * (size_t)f->row,
           row * (size_t)rows * sizeof *rgb);
    f->row += rows;
    return IBL_OK;
}

static ibl_environment by_rows(feeder *f)
{
    return (ibl_environment){.width = f->map->width,
                             .height = f->map->height,
                             .read = feed,
                             .cookie = f};
}

static ibl_bake_options options(int size)
{
    ibl_bake_options o = ibl_bake_options_default();
    o.skybox = size;
    o.specular_options.size = size;
    o.irradiance_options.size = 8;
    o.yaw_deg = 33;
    return o;
}

static bool same_cube(const ibl_cube *a, const ibl_cube *b)
{
    return a->size == b->size && a->levels == b->levels &&
           !memcmp(a->data, b->data, cube_floats(a) * sizeof *a->data);
}

static bool same(const ibl_bake_result *a, const ibl_bake_result *b)
{
    return same_cube(&a->skybox, &b->skybox) &&
           same_cube(&a->specular, &b->specular) &&
           same_cube(&a->irradiance, &b->irradiance) &&
           a->irradiance_degree == b->irradiance_degree &&
           !memcmp(a->sh, b->sh, 27 * sizeof *a->sh) &&
           !memcmp(&a->report.level, &b->report.level, sizeof a->report.level);
}

/* ---- the same bytes ---------------------------------------------------- */

/* Of one method, from memory with one thread and by rows with some. */
static void compare(const ibl_image *map, ibl_method method)
{
    static const int threads[] = {1, 2, 3, 7};
    ibl_bake_options o = options(32);
    ibl_bake_result first, other = {0};
    o.specular_options.method = method;
    o.specular_options.samples = 16;
    for (int i = 0; i < 4; i += TEST_SANITIZED ? 3 : 1) {
        ibl_ctx *ctx = test_ctx(threads[i], IBL_ISA_AUTO);
        feeder f = {.map = map};
        const ibl_environment env =
            i ? by_rows(&f) : (ibl_environment){.image = map};
        ibl_bake_result *result = i ? &other : &first;
        NEED(!ibl_bake_environment(ctx, &env, &o, result));
        CHECK(f.row == (i ? map->height : 0));
        CHECK_MSG(same(result, &first), "%dx%d, method %d, %d threads differ",
                  map->width, map->height, (int)method, threads[i]);
        ibl_bake_result_free(&other);
    }
    ibl_bake_result_free(&first);
}

TEST(rows_and_threads)
{
    static const int sizes[][2] = {
        {256, 128}, {200, 77}, {64, 530}, {9, 5}, {1024, 291}};
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    test_random r = {11};
    for (int i = 0; i < 5; i += TEST_RACES ? 2 : 1) {
        ibl_image map =
            map_of_kind(ctx, &r, MAP_SUNNY, sizes[i][0], sizes[i][1]);
        for (int m = IBL_METHOD_SPECTRAL; m <= IBL_METHOD_SAMPLED; m++)
            compare(&map, (ibl_method)m);
    }
}

/* The pieces by themselves are those of the whole; nothing is nothing; the size
 * of an image is its own, whatever else is said of it; a level 0 that is given
 * is that of the chain, and all else is the same. */
TEST(pieces)
{
    static const int lies[][2] = {{4096, 2048}, {8, 4}, {-1, 0}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random r = {12};
    ibl_image map = map_of_kind(ctx, &r, MAP_SUNNY, 128, 64);
    ibl_bake_options o = options(32);
    const size_t first = 3 * ibl_cube_texels(32, 1);
    ibl_cube specular = {0}, sky = cube_alloc(ctx, 32, 6);
    ibl_cube given = cube_alloc(ctx, 32, 1);
    ibl_specular_report report;

    const ibl_bake_result all = map_bake(ctx, &map, &o);
    for (int i = 0; i < 3; i++) {
        const ibl_environment env = {
            .image = &map, .width = lies[i][0], .height = lies[i][1]};
        ibl_bake_result made;
        NEED(!ibl_bake_environment(ctx, &env, &o, &made));
        CHECK_MSG(same(&made, &all), "called %dx%d", env.width, env.height);
        ibl_bake_result_free(&made);
    }
    o.specular_options.yaw_deg = o.yaw_deg;
    NEED(
        !ibl_bake_specular(ctx, &map, &o.specular_options, &specular, &report));
    test_cube(specular);
    CHECK(same_cube(&specular, &all.specular));
    CHECK(!memcmp(report.level, all.report.level, sizeof report.level));
    NEED(!ibl_cube_from_latlong(ctx, &map, o.yaw_deg, &sky));
    NEED(!ibl_cube_build_mips(ctx, &sky));
    CHECK(same_cube(&sky, &all.skybox));

    o.specular_options.method = IBL_METHOD_SPECTRAL;
    for (size_t i = 0; i < first; i++)
        given.data[i] = (float)test_random_unit(&r);
    const ibl_bake_result a = map_bake(ctx, &map, &o);
    o.level0 = &given;
    const ibl_bake_result b = map_bake(ctx, &map, &o);
    CHECK(!memcmp(b.specular.data, given.data, first * sizeof(float)));
    memcpy(b.specular.data, a.specular.data, first * sizeof(float));
    CHECK(same(&a, &b));

    o.skybox = o.specular = o.irradiance = 0;
    o.sh_degree = -1;
    o.level0 = NULL;
    const ibl_bake_result none = map_bake(ctx, &map, &o);
    CHECK(!none.skybox.data && !none.specular.data && !none.irradiance.data &&
          !none.sh);
}

/* ---- coefficients ------------------------------------------------------ */

/* Those of the analysis are the integrals over the pixels, lights and constant
 * and all, within what floats keep of the mean. */
TEST(harmonics)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random r = {13};
    ibl_image map = map_of_kind(ctx, &r, MAP_SUNNY, 100, 50);
    ibl_bake_options o = options(16);
    double want[3 * 121];

    NEED(!ibl_reference_sh(reference_of(ctx, &map, o.yaw_deg), 10, want));
    for (int k = 0; k < 5; k++) {
        const double factor = k < 2 || k == 4 ? 1 : k == 2 ? 0x1p70 : 0x1p-90;
        ibl_image scaled = map_scaled(ctx, &map, (float)factor);
        /* By which nothing but these would need each pixel. */
        o.specular_options.tolerance = k == 1   ? 0.4
                                       : k == 4 ? 1
                                                : IBL_TOLERANCE_DEFAULT;
        /* and the mean is kept by 2 x 2 that are one */
        o.sh_degree = k == 4 ? 0 : 10;
        o.specular = o.irradiance = k == 0;
        const ibl_bake_result made = map_bake(ctx, &scaled, &o);
        for (int i = 0; i < (k == 4 ? 3 : 3 * 121); i++)
            CHECK_NEAR(made.sh[i] / factor, want[i], 1e-6 * want[i % 3]);
    }
}

/* ---- memory ------------------------------------------------------------ */

/* The peak growth of memory in MiB where a file is read and baked, of a map
 * that brightens from 0 to 1 downwards; 255 if that fails, or its mean is
 * wrong. */
static int growth(const char *path)
{
    const ibl_bake_options o = ibl_bake_options_default();
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_bake_result made = {0};
    struct rusage before, after;
    ibl_source *s;

    getrusage(RUSAGE_SELF, &before);
    if (ibl_source_open(ctx, path, NULL, &s))
        return 255;
    const ibl_environment env = ibl_source_environment(s);
    if (ibl_bake_environment(ctx, &env, &o, &made) ||
        fabs(made.sh[0] / sqrt(4 * M_PI) - 0.5) > 1e-3)
        return 255;
    getrusage(RUSAGE_SELF, &after);
    return (int)((after.ru_maxrss - before.ru_maxrss) / 1024);
}

/* Floats of the map would take 96 MiB, or 1.5 GiB. In a process of its own,
 * whose memory is what it starts with. Huge pages would count whole, however
 * little of them is used. */
TEST_SLOW(memory)
{
    const char *large = getenv("IBL_TEST_LARGE");
    const bool is_large = large && *large && *large != '0';
    const int width = is_large ? 16384 : 4096, most = is_large ? 250 : 60;
    int code;

    if (TEST_SANITIZED)
        test_skip("sanitizers need memory of their own");
    file_need_oiio();
    NEED(file_run("oiiotool --create %dx%d 3 --fill:top=0,0,0:bottom=1,1,1 "
                  "%dx%d -d half --compression zip -o large.exr",
                  width, width / 2, width, width / 2));
    const pid_t child = fork();
    if (!child) {
        prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0);
        const int mib = growth(file_path("large.exr"));
        _exit(mib < 255 ? mib : 255);
    }
    NEED(child > 0 && waitpid(child, &code, 0) == child);
    const int mib = WIFEXITED(code) ? WEXITSTATUS(code) : 255;
    test_measured("MiB", mib, most);
    CHECK_MSG(mib <= most, "%d columns: %d MiB, more than %d", width, mib,
              most);
}

/* ---- progress ---------------------------------------------------------- */

typedef struct stages {
    char name[16][24];
    double first[16], last[16];
    int count;
    double whole, step; /* the last, and the largest step */
} stages;

static void note_stage(void *cookie, const char *stage, double done,
                       double whole)
{
    stages *s = cookie;
    int i = 0;

    CHECK_MSG(whole >= s->whole && whole <= 1, "%s %g: %g after %g", stage,
              done, whole, s->whole);
    s->step = fmax(s->step, whole - s->whole);
    s->whole = whole;
    while (i < s->count && strcmp(s->name[i], stage))
        i++;
    NEED(i < 16);
    if (i == s->count) {
        snprintf(s->name[i], sizeof s->name[i], "%s", stage);
        s->first[i] = done;
        s->count++;
    }
    s->last[i] = done;
}

/* Every stage tells of its start and its end, and the whole rises by steps;
 * also of two chains. What is no bake has no whole. */
TEST(progress)
{
    stages seen;
    ibl_ctx_options with = ibl_ctx_options_default();
    test_random r = {16};
    with.progress = note_stage;
    with.progress_cookie = &seen;
    ibl_ctx *ctx = test_ctx_of(&with);
    seen = (stages){.whole = -1};
    ibl_image map = map_of_kind(ctx, &r, MAP_SUNNY, 128, 640);
    cube_level0(ctx, &map, 0, 16);
    CHECK_NEAR(seen.whole, -1, 0);
    CHECK(seen.count == 1 && seen.last[0] >= 1);
    ibl_bake_options o = options(32);
    o.specular_options.method = IBL_METHOD_SPECTRAL;
    o.more = &o.specular_options;
    for (; o.more_count < 2; o.more_count++) {
        feeder f = {.map = &map};
        const ibl_environment env = by_rows(&f);
        ibl_bake_result made;
        seen = (stages){0};
        NEED(!ibl_bake_environment(ctx, &env, &o, &made));
        ibl_bake_result_free(&made);
        CHECK(seen.count >= 6);
        for (int i = 0; i < seen.count; i++)
            CHECK_MSG(seen.first[i] <= 0 && seen.last[i] >= 1,
                      "stage %s goes from %g to %g", seen.name[i],
                      seen.first[i], seen.last[i]);
        CHECK_NEAR(seen.whole, 1, 0);
        CHECK_MSG(seen.step < 0.5, "a step of %g", seen.step);
    }
    /* No stage of what is not made. */
    o.specular = false;
    o.skybox = 0;
    o.more_count = 0;
    seen = (stages){0};
    map_bake(ctx, &map, &o);
    for (int i = 0; i < seen.count; i++)
        CHECK_MSG(strcmp(seen.name[i], "level 0") != 0, "%s", seen.name[i]);
    CHECK_NEAR(seen.whole, 1, 0);
}

/* ---- errors ------------------------------------------------------------ */

TEST(failures)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random r = {15};
    ibl_image map = map_of_kind(ctx, &r, MAP_NOISE, 64, 700);
    ibl_bake_options o = options(16);
    ibl_bake_result made = {0};

    for (int fail = 1; fail < 700; fail += 111) {
        feeder f = {.map = &map, .fail_at = fail};
        const ibl_environment env = by_rows(&f);
        CHECK(ibl_bake_environment(ctx, &env, &o, &made) == IBL_ERR_IO);
        CHECK(!made.specular.data && !made.sh);
    }
    feeder f = {.map = &map, .cancel = ctx};
    const ibl_environment env = by_rows(&f);
    CHECK(ibl_bake_environment(ctx, &env, &o, &made) == IBL_ERR_CANCELLED);
}

/* What a bake is planned to take has room for each of its results: two levels
 * of specular, and more of it, irradiance, a skybox. */
TEST(memory_of_results)
{
    static const double cubes[] = {1.25, 2.5, 3.5, 4.5}; /* of 1024 texels */
    ibl_bake_options o = ibl_bake_options_default();
    size_t bytes;

    o.specular_options.size = o.irradiance_options.size = 1024;
    o.specular_options.levels = 2;
    o.more = &o.specular_options;
    for (int i = 0; i < 4; i++) {
        o.more_count = i >= 1;
        o.irradiance = i >= 2;
        o.skybox = i >= 3 ? 1024 : 0;
        NEED(!ibl_bake_memory(test_ctx(1, IBL_ISA_AUTO), 64, 32, &o, &bytes));
        CHECK((double)bytes >= cubes[i] * 12 * 6 * 1024 * 1024);
    }
}

/* ---- several chains --------------------------------------------------- */

static void check_chain(const ibl_bake_result *alone, const ibl_cube *cube,
                        const ibl_specular_report *report, double tolerance)
{
    const ibl_specular_layout *l = &alone->report.layout;
    NEED(cube->size == l->size && cube->levels == l->levels);
    CHECK(!memcmp(report->layout.roughness, l->roughness,
                  (size_t)l->levels * sizeof *l->roughness));
    if (tolerance <= 0) {
        CHECK(!memcmp(cube->data, alone->specular.data,
                      cube_floats(cube) * sizeof(float)));
        CHECK(!memcmp(report, &alone->report, sizeof *report));
    }
    for (int i = 0; i < l->levels; i++)
        CHECK_NEAR(cube_nrmse(cube, &alone->specular, i), 0, tolerance);
}

/* Chains of one reading are those of bakes of their own within the tolerance,
 * and in every byte if no other needs more degrees. */
TEST(chains)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random r = {21};
    ibl_image map = map_of_kind(ctx, &r, MAP_SUNNY, 96, 48);
    ibl_bake_options o = ibl_bake_options_default(), one = o;
    ibl_specular_options more[5];
    o.specular_options.size = 32;
    for (int i = 0; i < 5; i++)
        more[i] = o.specular_options;
    more[0].mapping = IBL_ROUGHNESS_LINEAR; /* shares level 0 and the cosine */
    more[1].mapping = IBL_ROUGHNESS_BABYLON;
    more[2].size = 17;
    more[2].lobe = IBL_LOBE_PHONG;
    more[3].method = IBL_METHOD_SAMPLED;
    more[3].samples = 16;
    more[4].levels = 4;
    more[4].roughness_max = 0.8;
    o.yaw_deg = one.yaw_deg = 20;
    o.more = more;
    o.more_count = 5;
    ibl_bake_result all = map_bake(ctx, &map, &o);
    NEED(all.more_count == 5);
    one.specular_options = o.specular_options;
    ibl_bake_result first = map_bake(ctx, &map, &one);
    check_chain(&first, &all.specular, &all.report, IBL_TOLERANCE_DEFAULT);
    for (int i = 0; i < 5; i++) {
        one.specular_options = more[i];
        ibl_bake_result alone = map_bake(ctx, &map, &one);
        check_chain(&alone, &all.more[i], &all.more_report[i],
                    i == 3 ? 0 : IBL_TOLERANCE_DEFAULT);
    }
    o.more_count = 1;
    ibl_bake_result two = map_bake(ctx, &map, &o);
    check_chain(&first, &two.specular, &two.report, 0);
}
