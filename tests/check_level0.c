/* SPDX-License-Identifier: MIT */
/*
 * Level 0: each texel against the reference; the same bytes however rows come,
 * on any number of threads; memory that does not grow with the map.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/context.h"
#include "core/pi.h"
#include "ibl/reference.h"
#include "image/level0.h"
#include "maps.h"
#include "truth.h"

static const double u = 0x1p-24;

/* A map, a yaw and a size: of every kind that the geometry tells apart. */
struct subject {
    ibl_image map;
    double yaw;
    int size;
};

static struct subject make(ibl_ctx *ctx, test_random *r)
{
    static const int widths[] = {512, 516, 514, 513, 8, 20, 33, 1, 1030};
    static const double yaws[] = {0, 90, 45, 10, -77.7, 360.0 / 1024, 180};
    const int w = widths[test_random_below(r, 9)];
    const int h = 1 + test_random_below(r, test_random_below(r, 2) ? 40 : 160);
    struct subject s = {.yaw = yaws[test_random_below(r, 7)],
                        .size = 1 + test_random_below(r, 40)};
    s.map = map_of_kind(ctx, r, MAP_NOISE, w, h);
    return s;
}

static ibl_cube by_rows(ibl_ctx *ctx, const struct subject *s, test_random *r,
                        int most)
{
    const ibl_image *map = &s->map;
    ibl_level0 *l;
    ibl_cube cube = cube_alloc(ctx, s->size, 1);
    if (ibl_level0_create(ctx, map->width, map->height, s->yaw, &cube, &l))
        exit(1);
    for (int j = 0; j < map->height;) {
        const int left = map->height - j;
        const int rows =
            most ? 1 + test_random_below(r, most < left ? most : left) : left;
        const size_t floats = 3 * (size_t)rows * (size_t)map->width;
        /* Of its own size, so that reading beyond it is seen. */
        float *batch = malloc(floats * sizeof *batch);
        memcpy(batch, map->data + 3 * (size_t)j * (size_t)map->width,
               floats * sizeof *batch);
        CHECK(!ibl_level0_add(l, rows, batch));
        CHECK(!ibl_run_end(ctx));
        free(batch);
        j += rows;
    }
    CHECK(!ibl_level0_finish(l));
    ibl_level0_free(l);
    return cube;
}

static void same_bytes(const struct subject *s, const ibl_cube *a,
                       const ibl_cube *b, const char *what)
{
    CHECK_MSG(!memcmp(a->data, b->data, 12 * ibl_cube_texels(a->size, 1)),
              "%dx%d to %d, yaw %g: other bytes %s", s->map.width,
              s->map.height, s->size, s->yaw, what);
}

TEST(any_batch_and_threads)
{
    ibl_ctx *ctx[] = {test_ctx(1, IBL_ISA_AUTO), test_ctx(2, IBL_ISA_AUTO),
                      test_ctx(7, IBL_ISA_AUTO)};
    test_random r = {3};
    for (int k = 0; k < 24; k++) {
        const int most[] = {1, 3, 1000};
        struct subject s = make(ctx[0], &r);
        ibl_cube want = by_rows(ctx[0], &s, &r, 0);
        for (int i = 0; i < 3; i++) {
            ibl_cube got = by_rows(ctx[i], &s, &r, most[(i + k) % 3]);
            same_bytes(&s, &want, &got, "by batches or threads");
        }
    }
}

/* The largest relative difference to the reference at some texels. */
static double worst_texel(ibl_ctx *ctx, const struct subject *s, test_random *r)
{
    enum {
        COUNT = 120
    };
    ibl_texel t[COUNT];
    static double rgb[3 * COUNT];
    ibl_reference *ref;
    double worst = 0;
    const int n = s->size;
    ibl_cube cube = by_rows(ctx, s, r, 0);
    for (int i = 0; i < COUNT; i++) {
        /* Half of them on top and bottom, some by the axes and diagonals. */
        t[i] = (ibl_texel){i % 2 ? 2 + i / 2 % 2 : test_random_below(r, 6),
                           test_random_below(r, n), test_random_below(r, n)};
        if (i % 5 == 0)
            t[i].x = i % 10 ? t[i].y : n / 2;
    }
    if (ibl_reference_create(ctx, &s->map, s->yaw, &ref) ||
        ibl_reference_texels(ref, IBL_PROJECTION_CUBE, n, n, t, COUNT, rgb))
        exit(1);
    for (int i = 0; i < COUNT; i++) {
        const float *p =
            ibl_cube_face(&cube, 0, t[i].face) + 3 * (t[i].y * n + t[i].x);
        for (int c = 0; c < 3; c++)
            worst = fmax(worst,
                         fabs((double)p[c] - rgb[3 * i + c]) / rgb[3 * i + c]);
    }
    ibl_reference_free(ref);
    return worst;
}

/* Noise of 0.5 to 1.5, at most half a texel's value away from it: what a border
 * of texels is off by moves at most that much light, relative to the texel's
 * solid angle. check_levels has 1.3e-5 for pieces of a whole column;
 * rows cut them shorter. */
static double off_reference(ibl_ctx *ctx, struct subject *s, int w, int h,
                            test_random *r)
{
    s->map = map_constant(ctx, w, h, 0);
    for (size_t i = 0; i < map_floats(&s->map); i++)
        s->map.data[i] = (float)(0.5 + test_random_unit(r));
    const double off = worst_texel(ctx, s, r);
    CHECK_MSG(off <= 1e-5 + u, "%dx%d to %d, yaw %g: %.3g off", w, h, s->size,
              s->yaw, off);
    return off;
}

TEST_SLOW(near_reference)
{
    static const int widths[] = {512, 516, 514, 513, 200, 130, 73, 1024};
    static const double yaws[] = {0, 90, 45, 10, -77.7, 360.0 / 1024};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random r = {5};
    double most = 0, magnified = 0;
    for (int k = 0; k < 40; k++) {
        const int w = widths[test_random_below(&r, 8)];
        struct subject s = {.yaw = yaws[test_random_below(&r, 6)],
                            .size = 1 + test_random_below(&r, w / 4)};
        const int h = 2 * s.size + test_random_below(&r, 2 * s.size);
        most = fmax(most, off_reference(ctx, &s, w, h, &r));
    }
    /* Larger pixels than texels: down to one pixel, along an axis or both. */
    for (int k = 0; k < 60; k++) {
        const int w = k % 3 ? 1 + test_random_below(&r, 100)
                            : widths[test_random_below(&r, 8)];
        struct subject s = {.yaw = yaws[test_random_below(&r, 6)],
                            .size = w / 4 + 1 + test_random_below(&r, 150)};
        const int h = 1 + test_random_below(&r, k % 3 == 1 ? 4 * s.size : 60);
        magnified = fmax(magnified, off_reference(ctx, &s, w, h, &r));
    }
    if (getenv("IBL_TEST_VERBOSE"))
        printf("near_reference: %.3g and, magnified, %.3g of 1e-5\n", most,
               magnified);
}

/* Peak memory in KiB that a process of its own needs more for such a map. */
static long growth(int w, int h, double yaw, int n)
{
    enum {
        ROWS = 16
    };
    int ends[2];
    long kib = -1;
    if (pipe(ends))
        return -1;
    const pid_t child = fork();
    if (child == 0) {
        struct rusage before, after;
        ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
        const size_t floats = 3 * (size_t)w * ROWS;
        float *batch = malloc(floats * sizeof *batch);
        ibl_level0 *l;
        ibl_cube cube;
        for (size_t i = 0; i < floats; i++)
            batch[i] = 1;
        if (ibl_cube_alloc(ctx, n, 1, &cube))
            _exit(1);
        memset(cube.data, 0, 12 * ibl_cube_texels(n, 1));
        getrusage(RUSAGE_SELF, &before);
        if (ibl_level0_create(ctx, w, h, yaw, &cube, &l))
            _exit(1);
        for (int j = 0; j < h; j += ROWS)
            if (ibl_level0_add(l, h - j < ROWS ? h - j : ROWS, batch) ||
                ibl_run_end(ctx))
                _exit(1);
        if (ibl_level0_finish(l))
            _exit(1);
        getrusage(RUSAGE_SELF, &after);
        kib = after.ru_maxrss - before.ru_maxrss;
        _exit(write(ends[1], &kib, sizeof kib) != sizeof kib);
    }
    close(ends[1]);
    if (child < 0 || read(ends[0], &kib, sizeof kib) != sizeof kib)
        kib = -1;
    close(ends[0]);
    if (child > 0)
        waitpid(child, NULL, 0);
    return kib;
}

/* Sums are kept of the lines of texels that a row crosses: at the cube's
 * corners 0.3 n / 2 of the 2 n from pole to pole. In double, and with room for
 * texels beyond the diagonal of a pole's face, that is a fifth of the cube.
 * Tables are of the size of a row. */
TEST(memory)
{
    if (TEST_SANITIZED)
        test_skip("a sanitizer has memory of its own");
    const long tall = growth(2048, 8192, 10, 64);
    const long small = growth(2048, 1024, 10, 64);
    const long large = growth(4096, 2048, 0, 1024);
    const long cube = (long)(12 * ibl_cube_texels(1024, 1) / 1024);
    if (getenv("IBL_TEST_VERBOSE"))
        printf("memory: %ld, %ld; %ld KiB of %ld\n", small, tall, large, cube);
    NEED(tall >= 0 && small >= 0 && large >= 0);
    /* A row is of 24 KiB; the kernel counts pages roughly. */
    CHECK_MSG(tall <= small + 2048, "%ld KiB for 1024 rows, %ld for 8192",
              small, tall);
    CHECK_MSG(large <= cube / 2, "%ld KiB for a cube of %ld", large, cube);
}

TEST(arguments)
{
    test_messages said = {0};
    ibl_ctx *ctx = test_keeping_ctx(0, &said);
    ibl_image map = map_constant(ctx, 8, 4, 1);
    ibl_cube cube = cube_level0(ctx, &map, 0, 4);
    CHECK(ibl_cube_from_latlong(ctx, &map, INFINITY, &cube) ==
          IBL_ERR_ARGUMENT);
    CHECK(test_said(&said, "finite"));
    ibl_level0_free(NULL);
}

/* ---- conventions -------------------------------------------------------- */

/* Solid angles cover the sphere; directions are those of the conventions. */
TEST(cube_geometry)
{
    for (int n = 1; n < 40; n += 3) {
        double sum = 0;
        for (int i = 0; i < n * n; i++)
            sum += 6 * ibl_cube_solid_angle(n, i % n, i / n);
        CHECK_NEAR(sum, 4 * IBL_PI, 1e-12);
        for (int i = 0; i < 6 * n * n; i++) {
            double a[3], b[3];
            ibl_cube_direction(n, i / (n * n), i % n, i / n % n, a);
            truth_cube_direction(n, i / (n * n), i % n, i / n % n, b);
            CHECK_NEAR(hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]), 0,
                       1e-14);
        }
    }
}

typedef struct told {
    char stage[32];
    double done;
    int calls;
} told;

static void keep_progress(void *cookie, const char *stage, double done,
                          double whole)
{
    CHECK(whole < 0);
    told *t = cookie;
    const bool same = !strcmp(t->stage, stage);
    CHECK_MSG(done >= (same ? t->done : 0) && done <= 1, "%s: %g after %g",
              stage, done, t->done);
    snprintf(t->stage, sizeof t->stage, "%s", stage);
    t->done = done;
    t->calls++;
}

/* Each call's progress ends with 1. */
TEST(progress)
{
    ibl_ctx_options options = ibl_ctx_options_default();
    told last = {.stage = ""};
    options.progress = keep_progress;
    options.progress_cookie = &last;
    ibl_ctx *other = test_ctx_of(&options);
    ibl_image img = map_constant(other, 64, 32, 1);
    ibl_image back = map_constant(other, 64, 32, 0);
    ibl_cube cube = cube_alloc(other, 16, 5);
    CHECK(!ibl_cube_from_latlong(other, &img, 0, &cube));
    CHECK(!strcmp(last.stage, "level 0") && last.done == 1 && last.calls > 9);
    CHECK(!ibl_cube_build_mips(other, &cube));
    CHECK(!strcmp(last.stage, "mips") && last.done == 1);
    CHECK(!ibl_latlong_from_cube(other, &cube, &back));
    CHECK(!strcmp(last.stage, "map") && last.done == 1);
}
