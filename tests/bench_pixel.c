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

int main(void)
{
    static double ms[IBL_ISA_AVX512 + 1][RUNS];
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
                const double begin = test_ms(CLOCK_MONOTONIC);
                dsp.encode[p](src, COUNT, dst);
                ms[isa][run] = test_ms(CLOCK_MONOTONIC) - begin;
            }
        }
        printf("%-11s", ibl_pixel_name(p));
        for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
            if (!ibl_cpu_has(isa))
                continue;
            printf(" %s %.0f", ibl_isa_name(isa),
                   COUNT / test_median(ms[isa], RUNS) * 1e-3);
        }
        printf(" Mtexel/s\n");
    }
    free(src);
    free(dst);
    return 0;
}
