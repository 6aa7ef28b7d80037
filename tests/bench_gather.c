/* SPDX-License-Identifier: MIT */
/*
 * Time of the gather kernels a sample, one thread, on a sample set and a cube
 * as level 1 of a 256 cube with Filament's mapping has them. The instruction
 * sets take turns; medians.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bake/samples.h"
#include "core/cpu.h"
#include "ibl/ibl.h"
#include "image/pyramid.h"
#include "test.h"

enum {
    SIZE = 256,
    LEVELS = 9,
    TEXELS = 2000,
    ROUNDS = 15
};

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double run(ibl_isa isa, const ibl_samples *samples,
                  const ibl_gather_level *levels)
{
    ibl_gather_dsp dsp;
    double sum = 0;
    ibl_gather_dsp_init(&dsp, isa);
    const double start = seconds();
    for (int i = 0; i < TEXELS; i++) {
        float frame[9];
        double rgb[3];
        ibl_texel_frame(128, i / 400 % 6, i % 128, 40 + i / 128, 0, frame);
        dsp.gather(&samples->set, levels, frame, rgb);
        sum += rgb[0];
    }
    const double time = seconds() - start;
    /* Positive by construction; keeps the loop. */
    return sum > 0 ? 1e9 * time / TEXELS / samples->count : -1;
}

int main(void)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_sampling lobe = {.shape = ibl_lobe_shape_of(IBL_LOBE_GGX, 0.018),
                               .count = 1024,
                               .edge = SIZE,
                               .levels = LEVELS,
                               .lod_bias = 1,
                               .pdf_mip = true,
                               .footprint = 1e-5};
    double times[IBL_ISA_AVX512 + 1][ROUNDS];
    ibl_gather_level levels[LEVELS];
    test_random r = {1};
    ibl_samples samples;
    ibl_pyramid pyramid;
    ibl_cube cube;
    if (ibl_cube_alloc(ctx, SIZE, 1, &cube))
        return 1;
    for (size_t i = 0; i < 3 * ibl_cube_texels(SIZE, 1); i++)
        cube.data[i] = (float)test_random_unit(&r);
    if (ibl_pyramid_create(ctx, &cube, LEVELS, &pyramid) ||
        ibl_samples_specular(ctx, &lobe, &samples))
        return 1;
    for (int l = 0; l < LEVELS; l++)
        levels[l] = (ibl_gather_level){pyramid.texels[l], SIZE >> l};

    for (int k = 0; k < ROUNDS; k++) {
        for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
            if (ibl_cpu_has(isa))
                times[isa][k] = run(isa, &samples, levels);
    }
    printf("gather: %d samples in %d groups, ns a sample\n", samples.count,
           samples.set.group_count);
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        if (!ibl_cpu_has(isa))
            continue;
        qsort(times[isa], ROUNDS, sizeof(double), by_value);
        printf("  %-7s %6.2f  (%.1f times the plain version)\n",
               ibl_isa_name(isa), times[isa][ROUNDS / 2],
               times[IBL_ISA_C][ROUNDS / 2] / times[isa][ROUNDS / 2]);
    }
    ibl_samples_free(&samples);
    ibl_pyramid_free(&pyramid);
    ibl_cube_free(&cube);
    ibl_ctx_free(ctx);
    return 0;
}
