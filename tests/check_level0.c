/* SPDX-License-Identifier: MIT */
/*
 * Level 0: each texel against the reference; the same bytes however rows come,
 * on any number of threads; memory that does not grow with the map.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
