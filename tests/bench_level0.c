/* SPDX-License-Identifier: MIT */
/*
 * Level 0: CPU time on one thread and speed-up by two, medians. Rows come in
 * batches of 16 from the same memory, as from a decoder's buffer. To compare
 * two builds let theirs take turns.
 *
 *     bench_level0 [width height size yaw]
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "core/context.h"
#include "image/level0.h"
#include "test.h"

enum {
    RUNS = 9,
    ROWS = 16
};

static const struct subject {
    int width, height, size;
    double yaw;
} subjects[] = {{1024, 512, 256, 0},  {1024, 512, 256, 10},
                {1023, 512, 255, 10}, {2048, 1024, 256, 0},
                {4096, 2048, 256, 0}, {4096, 2048, 1024, 0},
                {1024, 512, 512, 0},  {16384, 8192, 256, 0}};

static void bake(ibl_ctx *ctx, const struct subject *s, const float *rows,
                 ibl_cube *cube)
{
    ibl_level0 *l;
    if (ibl_level0_create(ctx, s->width, s->height, s->yaw, cube, &l))
        exit(1);
    for (int j = 0; j < s->height; j += ROWS) {
        const int left = s->height - j;
        if (ibl_level0_add(l, left < ROWS ? left : ROWS, rows) ||
            ibl_run_end(ctx))
            exit(1);
    }
    if (ibl_level0_finish(l))
        exit(1);
    ibl_level0_free(l);
}

static void measure(const struct subject *s)
{
    double cpu[RUNS], wall[2][RUNS];
    const size_t floats = 3 * (size_t)s->width * ROWS;
    float *rows = malloc(floats * sizeof *rows);
    ibl_ctx *ctx[2] = {test_ctx(1, IBL_ISA_AUTO), test_ctx(2, IBL_ISA_AUTO)};
    test_random r = {1};
    ibl_cube cube;

    for (size_t i = 0; i < floats; i++)
        rows[i] = (float)test_random_unit(&r);
    if (ibl_cube_alloc(ctx[0], s->size, 1, &cube))
        exit(1);
    for (int run = 0; run < RUNS; run++) {
        for (int k = 0; k < 2; k++) {
            const double begin = test_ms(CLOCK_PROCESS_CPUTIME_ID);
            const double start = test_ms(CLOCK_MONOTONIC);
            bake(ctx[k], s, rows, &cube);
            wall[k][run] = test_ms(CLOCK_MONOTONIC) - start;
            if (k == 0)
                cpu[run] = test_ms(CLOCK_PROCESS_CPUTIME_ID) - begin;
        }
    }
    const double one = test_median(wall[0], RUNS);
    printf("%5dx%-5d to %4d yaw %2g: %7.2f ms of CPU, two threads %.2f times\n",
           s->width, s->height, s->size, s->yaw, test_median(cpu, RUNS),
           one / test_median(wall[1], RUNS));
    ibl_cube_free(&cube);
    ibl_ctx_free(ctx[0]);
    ibl_ctx_free(ctx[1]);
    free(rows);
}

int main(int argc, char **argv)
{
    if (argc == 5) {
        const struct subject s = {atoi(argv[1]), atoi(argv[2]), atoi(argv[3]),
                                  atof(argv[4])};
        measure(&s);
        return 0;
    }
    for (size_t i = 0; i < sizeof subjects / sizeof *subjects; i++)
        measure(&subjects[i]);
    return 0;
}
