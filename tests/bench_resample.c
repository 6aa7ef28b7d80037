/* SPDX-License-Identifier: MIT */
/*
 * CPU time of the last step of a spectral level: from a grid of rings to the
 * texels of a cube, without and with 16 bright pixels, one thread. The
 * instruction sets take turns; medians. "setup" is a level of 1x1 faces.
 */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "bake/spectral/resample.h"
#include "core/context.h"
#include "core/cpu.h"
#include "core/pi.h"
#include "test.h"

enum {
    ROUNDS = 21,
    LIGHTS = 16
};

typedef struct bench {
    const char *name;
    int edge, rings, columns;
    bool lights;
    ibl_lobe lobe;
} bench;

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Lights of a map 1024 wide, anywhere. */
static ibl_bright *make_lights(ibl_ctx *ctx, ibl_lobe lobe)
{
    const ibl_lobe_shape shape = ibl_lobe_shape_of(lobe, 0.04);
    const double size = IBL_PI / 512;
    ibl_patch lights[LIGHTS];
    test_random r = {7};
    ibl_bright *bright;
    for (int i = 0; i < LIGHTS; i++) {
        const double theta = 0.1 + 2.9 * test_random_unit(&r);
        lights[i] = (ibl_patch){.theta = {theta, theta + size},
                                .phi = 6.28 * test_random_unit(&r),
                                .width = size,
                                .rgb = {1, 2, 3}};
    }
    return ibl_bright_create(ctx, lights, LIGHTS, &shape, 2e-5, 0, &bright)
               ? NULL
               : bright;
}

/* Median milliseconds of each instruction set. */
static int measure(const bench *b, double ms[IBL_ISA_AVX512 + 1])
{
    static double times[IBL_ISA_AVX512 + 1][ROUNDS];
    ibl_ctx *ctx[IBL_ISA_AVX512 + 1] = {0};
    ibl_ring_grid grid = {0};
    ibl_cube cube = {0};
    test_random r = {1};
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
        ctx[isa] = ibl_cpu_has(isa) ? test_ctx(1, isa) : NULL;
    ibl_ctx *first = ctx[IBL_ISA_C];
    ibl_bright *bright = make_lights(first, b->lobe);
    if (!bright || ibl_ring_grid_alloc(first, b->rings, b->columns, &grid) ||
        ibl_cube_alloc(first, b->edge, 1, &cube))
        return 1;
    for (size_t i = 0; i < grid.room; i++)
        grid.data[i] = (float)test_random_unit(&r);
    const ibl_level_sum sum = {.grid = &grid,
                               .degree = b->rings / 2,
                               .bright = b->lights ? bright : NULL,
                               .high = {INFINITY, INFINITY, INFINITY}};
    for (int k = 0; k < ROUNDS; k++) {
        for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
            const double start = seconds();
            if (ctx[isa] && ibl_spectral_texels(ctx[isa], NULL, &sum, &cube, 0))
                return 1;
            times[isa][k] = 1e3 * (seconds() - start);
        }
    }
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        ms[isa] = test_median(times[isa], ROUNDS);
        ibl_ctx_free(ctx[isa]);
    }
    ibl_bright_free(bright);
    ibl_ring_grid_free(&grid);
    ibl_cube_free(&cube);
    return 0;
}

int main(void)
{
    const bench benches[] = {
        {"setup", 1, 300, 1024, false, IBL_LOBE_GGX},
        {"8", 8, 32, 64, false, IBL_LOBE_GGX},
        {"64", 64, 160, 512, false, IBL_LOBE_GGX},
        {"128", 128, 320, 1024, false, IBL_LOBE_GGX},
        {"512", 512, 1280, 4096, false, IBL_LOBE_GGX},
        {"128 + 16 ggx", 128, 320, 1024, true, IBL_LOBE_GGX},
        {"128 + 16 phong", 128, 320, 1024, true, IBL_LOBE_PHONG}};
    for (size_t i = 0; i < sizeof benches / sizeof benches[0]; i++) {
        double ms[IBL_ISA_AVX512 + 1];
        if (measure(&benches[i], ms))
            return 1;
        printf("%-15s", benches[i].name);
        for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
            if (ibl_cpu_has(isa))
                printf("  %s %8.3f ms", ibl_isa_name(isa), ms[isa]);
        printf("\n");
    }
    return 0;
}
