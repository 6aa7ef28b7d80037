/* SPDX-License-Identifier: MIT */
/*
 * Level 0: each texel against the reference; the same bytes however rows come,
 * on any number of threads; memory that does not grow with the map.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/context.h"
#include "image/level0.h"
#include "reference.h"

static const double u = 0x1p-24;
static const double yaws[] = {0, 90, 45, 10, -77.7, 360.0 / 1024, 180};

/* A map, a yaw and a size. */
struct bake {
    ibl_image map;
    double yaw;
    int size;
};

static ibl_cube by_rows(ibl_ctx *ctx, const struct bake *s, test_random *r,
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

TEST(any_batch_and_threads)
{
    static const int widths[] = {512, 516, 514, 513, 8, 20, 33, 1, 1030};
    static const int threads[] = {1, 2, 7}, most[] = {1, 3, 1000};
    test_random r = {3};
    for (int k = 0; k < 24; k++) {
        ibl_ctx *one = test_ctx(1, IBL_ISA_AUTO);
        const int h = 1 + test_random_below(&r, k % 2 ? 40 : 160);
        const struct bake s = {
            map_of_kind(one, &r, MAP_NOISE, widths[k % 9], h), yaws[k % 7],
            1 + test_random_below(&r, 40)};
        const ibl_cube want = by_rows(one, &s, &r, 0);
        for (int i = 0; i < 3; i++) {
            const ibl_cube got = by_rows(test_ctx(threads[i], IBL_ISA_AUTO), &s,
                                         &r, most[(i + k) % 3]);
            CHECK_MSG(!memcmp(want.data, got.data,
                              cube_floats(&want) * sizeof *want.data),
                      "%dx%d to %d, yaw %g: other bytes by batches or threads",
                      s.map.width, s.map.height, s.size, s.yaw);
        }
    }
}

/* Noise of 0.5 to 1.5 at some texels, half of them on top and bottom, some by
 * the axes and diagonals: at most half a texel's value away from it. What a
 * border of texels is off by moves at most that much light, relative to the
 * texel's solid angle. check_levels has 1.3e-5 for pieces of a whole column;
 * rows cut them shorter. */
static void check_bake(ibl_ctx *ctx, struct bake *s, int w, int h,
                       test_random *r)
{
    enum {
        COUNT = 100
    };
    const int n = s->size;
    ibl_texel t[COUNT];
    double rgb[3 * COUNT], worst = 0;
    s->map = map_constant(ctx, w, h, 0);
    for (size_t i = 0; i < map_floats(&s->map); i++)
        s->map.data[i] = (float)(0.5 + test_random_unit(r));
    const ibl_cube cube = by_rows(ctx, s, r, 0);
    for (int i = 0; i < COUNT; i++) {
        t[i] = (ibl_texel){i % 2 ? 2 + i / 2 % 2 : test_random_below(r, 6),
                           test_random_below(r, n), test_random_below(r, n)};
        if (i % 5 == 0)
            t[i].x = i % 10 ? t[i].y : n / 2;
    }
    NEED(!ibl_reference_texels(reference_of(ctx, &s->map, s->yaw),
                               IBL_PROJECTION_CUBE, n, n, t, COUNT, rgb));
    for (int i = 0; i < 3 * COUNT; i++) {
        const ibl_texel *at = &t[i / 3];
        const float *p =
            ibl_cube_face(&cube, 0, at->face) + 3 * (at->y * n + at->x) + i % 3;
        worst = fmax(worst, fabs((double)*p / rgb[i] - 1));
    }
    CHECK_MSG(worst <= 1e-5 + u, "%dx%d to %d, yaw %g: %.3g off", w, h, n,
              s->yaw, worst);
    test_measured("near_reference", worst, 1e-5);
}

/* Larger texels than pixels, then smaller ones: down to one pixel, along an
 * axis or both. */
TEST_SLOW(near_reference)
{
    static const int widths[] = {512, 516, 514, 513, 200, 130, 73, 1024};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random r = {5};
    for (int k = 0; k < 56; k++) {
        const bool magnified = k % 2;
        const int w = magnified && k % 3 ? 1 + test_random_below(&r, 100)
                                         : widths[test_random_below(&r, 8)];
        const int some = test_random_below(&r, magnified ? 150 : w / 4);
        struct bake s = {.yaw = yaws[k % 7],
                         .size = (magnified ? w / 4 : 0) + 1 + some};
        const int tall = magnified && k % 3 != 1 ? 60 : 2 * s.size;
        check_bake(ctx, &s, w,
                   (magnified ? 1 : 2 * s.size) + test_random_below(&r, tall),
                   &r);
    }
}
