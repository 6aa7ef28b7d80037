/* SPDX-License-Identifier: MIT */
/*
 * Times bakes of a map of 64x32 pixels in one process, by one thread: medians
 * of 200 turns with faces of several sizes.
 *
 *     bench_small
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "ibl/ibl.h"

enum {
    TURNS = 200,
    WIDE = 64,
    HIGH = 32
};

static double now_ms(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec / 1e6;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(void)
{
    static const int sizes[] = {16, 32, 64, 128, 256};
    enum {
        SIZES = sizeof sizes / sizeof *sizes
    };
    static float texels[3 * WIDE * HIGH];
    static double took[SIZES][TURNS];
    const ibl_image map = {WIDE, HIGH, texels};
    const ibl_environment env = {.image = &map};
    ibl_ctx_options with = ibl_ctx_options_default();
    ibl_ctx *ctx;

    with.threads = 1;
    if (ibl_ctx_create(&with, &ctx))
        return 1;
    for (int i = 0; i < 3 * WIDE * HIGH; i++)
        texels[i] = (float)(i * 7919 % 1013) / 100;
    for (int turn = 0; turn < TURNS; turn++)
        for (int i = 0; i < SIZES; i++) {
            ibl_bake_options o = ibl_bake_options_default();
            ibl_bake_result made;
            o.specular_options.size = sizes[i];
            const double since = now_ms();
            if (ibl_bake_environment(ctx, &env, &o, &made))
                return 1;
            ibl_bake_result_free(&made);
            took[i][turn] = now_ms() - since;
        }
    for (int i = 0; i < SIZES; i++) {
        qsort(took[i], TURNS, sizeof **took, by_value);
        printf("faces of %3d: %6.2f ms\n", sizes[i], took[i][TURNS / 2]);
    }
    ibl_ctx_free(ctx);
    return 0;
}
