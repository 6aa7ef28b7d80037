/* SPDX-License-Identifier: MIT */
/* Texels encoded per second, by format and instruction set. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "kern/pixel.h"
#include "test.h"

enum {
    COUNT = 256 * 256 * 8, /* about a cube of 256 with its levels */
    RUNS = 15
};

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(void)
{
    static double seconds[IBL_ISA_AVX512 + 1][RUNS];
    float *src = malloc(3 * COUNT * sizeof *src);
    char *dst = malloc(16 * COUNT);
    test_random r = {1};

    for (int i = 0; i < 3 * COUNT; i++)
        src[i] = (float)test_random_unit(&r);
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        /* The sets take turns, so that a busy machine is busy for all. */
        for (int run = 0; run < RUNS; run++) {
            for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
                ibl_pixel_dsp dsp;
                if (!ibl_cpu_has(isa))
                    continue;
                ibl_pixel_dsp_init(&dsp, isa);
                const double begin = now();
                dsp.encode[p](src, COUNT, dst);
                seconds[isa][run] = now() - begin;
            }
        }
        printf("%-11s", ibl_pixel_name(p));
        for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
            if (!ibl_cpu_has(isa))
                continue;
            qsort(seconds[isa], RUNS, sizeof seconds[isa][0], compare);
            printf(" %s %.0f", ibl_isa_name(isa),
                   COUNT / seconds[isa][RUNS / 2] * 1e-6);
        }
        printf(" Mtexel/s\n");
    }
    free(src);
    free(dst);
    return 0;
}
