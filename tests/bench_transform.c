/* SPDX-License-Identifier: MIT */
/*
 * Time of spherical harmonic transforms on one thread, by instruction set:
 * the least and the median of some runs. The GFLOP/s count 14 fused
 * multiply-adds for two degrees and a pair of rings, rings that are skipped
 * next to the poles as well: they may exceed what the CPU can do.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bake/spectral/transform.h"
#include "core/alloc.h"
#include "core/cpu.h"
#include "test.h"

enum {
    RUNS = 41
};

static const struct shape {
    const char *what;
    int degree, rings;
} shapes[] = {
    {"analyse", 256, 512},    {"analyse", 256, 2048},
    {"analyse", 64, 512},     {"analyse", 1000, 2048},
    {"synthesise", 230, 512}, {"synthesise", 128, 256},
    {"synthesise", 40, 96},   {"synthesise", 1000, 2048},
};

static double now_ms(void)
{
    struct timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static double flops(const struct shape *s)
{
    double pairs_of_degrees = 0.0;

    for (int m = 0; m <= s->degree; m++)
        pairs_of_degrees += (s->degree - m) / 2 + 1;
    return 28.0 * pairs_of_degrees * ((s->rings + 1) / 2);
}

static void run(ibl_ctx *ctx, const struct shape *s, ibl_ring_spectra *spectra,
                ibl_harmonics *h, const double *ones)
{
    ibl_status status;

    if (!strcmp(s->what, "analyse"))
        status = ibl_sht_analyse(ctx, NULL, spectra, ones, h);
    else
        status = ibl_sht_synthesise(ctx, NULL, h, ones, s->degree, spectra);
    if (status)
        exit(1);
}

static void measure(const struct shape *s, ibl_isa isa)
{
    ibl_ctx *ctx = test_ctx(1, isa);
    const size_t n = (size_t)(s->rings > s->degree ? s->rings : s->degree) + 1;
    double *ones = ibl_alloc_array(n, sizeof *ones), ms[RUNS];
    ibl_ring_spectra spectra;
    ibl_harmonics h;
    int runs = 0;

    if (!ones ||
        ibl_ring_spectra_alloc(ctx, s->rings, s->degree + 1, &spectra) ||
        ibl_harmonics_alloc(ctx, s->degree, &h))
        exit(1);
    for (size_t i = 0; i < n; i++)
        ones[i] = 1.0;
    for (int i = 0; i < 6 * spectra.orders; i++) {
        for (int j = 0; j < s->rings; j++)
            spectra.data[(size_t)i * spectra.stride + (size_t)j] =
                (float)((i * 7 + j * 13) % 29) / 29.0f;
    }
    run(ctx, &(struct shape){"analyse", s->degree, s->rings}, &spectra, &h,
        ones);
    const double start = now_ms();
    while (runs < RUNS && now_ms() - start < 400.0) {
        const double before = now_ms();
        run(ctx, s, &spectra, &h, ones);
        ms[runs++] = now_ms() - before;
    }
    qsort(ms, (size_t)runs, sizeof *ms, by_value);
    printf("%-10s degree %4d, %4d rings  %-6s  %8.3f ms  median %8.3f  "
           "%6.1f GFLOP/s\n",
           s->what, s->degree, s->rings, ibl_isa_name(isa), ms[0], ms[runs / 2],
           1e-6 * flops(s) / ms[0]);
    ibl_ring_spectra_free(&spectra);
    ibl_harmonics_free(&h);
    ibl_free(ones);
    ibl_ctx_free(ctx);
}

int main(void)
{
    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; i++) {
        for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
            if (ibl_cpu_has(isa))
                measure(&shapes[i], isa);
        }
    }
    return 0;
}
