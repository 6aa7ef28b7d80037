/* SPDX-License-Identifier: MIT */
/*
 * The transforms along the rows, one thread, CPU time, in turns, medians:
 * against kissfft (package libkissfft-dev, where it is there), the steps of
 * one batch, straight against spread, and whole maps.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bake/spectral/azimuth.h"
#include "bake/spectral/spread.h"
#include "core/alloc.h"
#include "core/cpu.h"
#include "kern/fft.h"
#include "kern/row_block.h"
#include "test.h"

#ifdef IBL_KISS
#define HAVE_KISS 1
#include <kiss_fftr.h>
#else
#define HAVE_KISS 0
#endif

enum {
    LANES = IBL_FFT_LANES,
    ROUNDS = 21,
    ORDERS = 257,
    HELD = 128 /* rows that the maps repeat: a decoder's output in a cache */
};

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static float *noise(size_t n)
{
    test_random r = {n};
    float *p = ibl_alloc_array(n, sizeof *p);
    if (!p)
        exit(1);
    for (size_t i = 0; i < n; i++)
        p[i] = (float)test_random_unit(&r);
    return p;
}

/* ---- transforms alone ------------------------------------------------- */

enum {
    LENGTH = 1024,
    TRANSFORMS = 3 * 512
};

/* All bins of TRANSFORMS rows, each time from the same rows. */
static double time_ours(ibl_isa isa, const float *rows, bool back)
{
    static float *z, *spectrum;
    const size_t floats = (size_t)LENGTH * LANES;
    ibl_fft_dsp dsp;
    ibl_fft fft;
    ibl_fft_pair *pairs;
    const int count = LENGTH / 2 + !back;
    double *factor = ibl_alloc_zeroed((size_t)count, 2 * sizeof *factor);
    pairs = ibl_alloc_array((size_t)count, sizeof *pairs);
    if (!z) {
        z = noise(floats);
        spectrum = noise(2 * floats);
    }
    if (!factor || !pairs || !ibl_fft_init(&fft, LENGTH / 2))
        exit(1);
    for (int m = 0; m < count; m++)
        factor[2 * m] = 1;
    if (back)
        ibl_fft_real_pairs_inverse(LENGTH / 2, factor, count, pairs);
    else
        ibl_fft_real_pairs(LENGTH / 2, factor, count, pairs);
    ibl_fft_dsp_init(&dsp, isa);
    const ibl_fft_spectrum where = {spectrum, 2 * LANES, LANES};
    const double start = seconds();
    for (int i = 0; i < TRANSFORMS / LANES; i++) {
        if (back) {
            dsp.merge(&where, pairs, LENGTH / 2, z);
            dsp.inverse(&fft, z);
        } else {
            memcpy(z, rows + (size_t)i * floats, floats * sizeof *z);
            dsp.forward(&fft, z);
            dsp.split(z, pairs, count, &where);
        }
    }
    const double time = seconds() - start;
    ibl_fft_free(&fft);
    ibl_free(factor);
    ibl_free(pairs);
    return time;
}

#if HAVE_KISS
static double time_kiss(const float *rows, bool back)
{
    static kiss_fft_cpx bins[LENGTH / 2 + 1];
    static float samples[LENGTH];
    kiss_fftr_cfg plan = kiss_fftr_alloc(LENGTH, back, NULL, NULL);
    if (!plan)
        exit(1);
    const double start = seconds();
    for (int i = 0; i < TRANSFORMS; i++) {
        if (back)
            kiss_fftri(plan, bins, samples);
        else
            kiss_fftr(plan, rows + (size_t)i * LENGTH, bins);
    }
    const double time = seconds() - start;
    kiss_fftr_free(plan);
    return time;
}
#endif

static void transforms(bool back)
{
    static double times[IBL_ISA_AVX512 + 2][ROUNDS];
    float *rows = noise((size_t)TRANSFORMS * LENGTH);
    double kiss = 0;
    for (int k = 0; k < ROUNDS; k++) {
        for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
            if (ibl_cpu_has(isa))
                times[isa][k] = time_ours(isa, rows, back);
#if HAVE_KISS
        times[0][k] = time_kiss(rows, back);
#endif
    }
    printf("%d real rows of %d, %s, ms\n", TRANSFORMS, LENGTH,
           back ? "inverse" : "forward");
    if (HAVE_KISS) {
        kiss = test_median(times[0], ROUNDS);
        printf("  kissfft %7.3f\n", 1e3 * kiss);
    } else {
        printf("  no kissfft: package libkissfft-dev is missing\n");
    }
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
        if (ibl_cpu_has(isa)) {
            const double t = test_median(times[isa], ROUNDS);
            printf("  %-7s %7.3f", ibl_isa_name(isa), 1e3 * t);
            if (HAVE_KISS)
                printf("  (%.1f times kissfft)", kiss / t);
            printf("\n");
        }
    ibl_free(rows);
}

/* ---- one batch -------------------------------------------------------- */

/* Steps of one batch of LANES rows, three channels. */
typedef struct steps {
    double load, spread, transform, split, store;
} steps;

typedef struct batch {
    ibl_fft_dsp fft_dsp;
    ibl_row_block_dsp strip_dsp;
    int width, ring;
    float *rgb, *rgba, *ring_data, *pixels, *spectrum;
    ibl_fft fft;
    ibl_fft_pair *pairs;
    ibl_row_block_spread spread;
} batch;

static void batch_init(batch *b, ibl_isa isa, int width, int ring)
{
    static double factor[2 * ORDERS];
    int origin;
    *b = (batch){.width = width, .ring = ring};
    ibl_fft_dsp_init(&b->fft_dsp, isa);
    ibl_row_block_dsp_init(&b->strip_dsp, isa);
    b->rgb = noise((size_t)width * 3 * LANES);
    b->rgba = noise((size_t)width * 4 * LANES);
    b->ring_data = noise((size_t)(ring + LANES) * 3 * LANES);
    b->pixels = noise((size_t)width * 3 * LANES);
    b->spectrum = noise((size_t)ORDERS * 6 * LANES);
    b->pairs = ibl_alloc_array(ORDERS, sizeof *b->pairs);
    const ibl_spread_window window = ibl_spread_window_of(ring, ORDERS);
    for (int m = 0; m < ORDERS; m++)
        factor[2 * m] = 1;
    if (!b->pairs || !ibl_fft_init(&b->fft, ring / 2) ||
        !ibl_spread_init(&b->spread, width, ring, &window, &origin))
        exit(1);
    ibl_fft_real_pairs(ring / 2, factor, ORDERS, b->pairs);
}

static void batch_free(batch *b)
{
    ibl_free(b->rgb);
    ibl_free(b->rgba);
    ibl_free(b->ring_data);
    ibl_free(b->pixels);
    ibl_free(b->spectrum);
    ibl_free(b->pairs);
    ibl_fft_free(&b->fft);
    ibl_spread_free(&b->spread);
}

/* Time of each step of one batch, the mean of some. */
static steps time_batch(batch *b)
{
    enum {
        REPEATS = 8,
        BLOCK = 64
    };
    const ibl_row_block_change same = {.scale = 1};
    const size_t channel = (size_t)(b->ring + LANES) * LANES;
    const bool straight = b->width == b->ring;
    steps t = {0, 0, 0, 0, 0};
    for (int k = 0; k < REPEATS; k++) {
        const float *in[LANES];
        float *out[LANES];
        for (int r = 0; r < LANES; r++) {
            in[r] = b->rgb + (size_t)r * (size_t)b->width * 3;
            out[r] = b->rgba + (size_t)r * (size_t)b->width * 4;
        }
        double now = seconds(), then = now;
        if (straight)
            b->strip_dsp.load(in, b->width, &same, b->ring_data, channel);
        now = seconds();
        t.load += now - then;
        if (!straight)
            for (int i = 0; i < b->width; i += BLOCK) {
                const int left = b->width - i;
                const int count = left < BLOCK ? left : BLOCK;
                b->strip_dsp.load(in, count, &same, b->pixels,
                                  (size_t)BLOCK * LANES);
                for (size_t c = 0; c < 3; c++)
                    b->strip_dsp.spread(&b->spread,
                                        b->pixels + c * BLOCK * LANES, i, count,
                                        b->ring_data + c * channel);
                for (int r = 0; r < LANES; r++)
                    in[r] += 3 * count;
            }
        then = seconds();
        t.spread += then - now;
        for (size_t c = 0; c < 3; c++)
            b->fft_dsp.forward(&b->fft, b->ring_data + c * channel);
        now = seconds();
        t.transform += now - then;
        for (size_t c = 0; c < 3; c++) {
            const ibl_fft_spectrum where = {b->spectrum + 2 * c * LANES,
                                            (size_t)6 * LANES, LANES};
            b->fft_dsp.split(b->ring_data + c * channel, b->pairs, ORDERS,
                             &where);
        }
        then = seconds();
        t.split += then - now;
        if (straight)
            b->strip_dsp.store(b->ring_data, channel, b->width, out, LANES);
        t.store += seconds() - then;
    }
    return (steps){t.load / REPEATS, t.spread / REPEATS, t.transform / REPEATS,
                   t.split / REPEATS, t.store / REPEATS};
}

static double steps_of(ibl_isa isa, int width, int ring)
{
    static double t[5][ROUNDS];
    batch b;
    batch_init(&b, isa, width, ring);
    for (int k = 0; k < ROUNDS; k++) {
        const steps s = time_batch(&b);
        t[0][k] = s.load;
        t[1][k] = s.spread;
        t[2][k] = s.transform;
        t[3][k] = s.split;
        t[4][k] = s.store;
    }
    batch_free(&b);
    double m[5];
    for (int i = 0; i < 5; i++)
        m[i] = 1e6 * test_median(t[i], ROUNDS);
    const double sum = m[0] + m[1] + m[2] + m[3];
    printf("  %-7s %5d on %5d: %7.1f = load %6.1f, load and spread %6.1f, "
           "transform %6.1f, split %5.1f (store %5.1f)\n",
           ibl_isa_name(isa), width, ring, sum, m[0], m[1], m[2], m[3], m[4]);
    return sum;
}

static void straight_or_spread(void)
{
    const ibl_isa best = ibl_isa_best();
    printf("a batch of %d rows, %d orders, microseconds\n", LANES, ORDERS);
    for (int width = 1024; width <= 16384; width *= 2) {
        steps_of(best, width, width);
        for (int ring = 1024; ring < width; ring *= 2)
            if (ring * 8 >= width)
                steps_of(best, width, ring);
    }
    for (ibl_isa isa = IBL_ISA_C; isa < best; isa++)
        if (ibl_cpu_has(isa)) {
            steps_of(isa, 1024, 1024);
            steps_of(isa, 2048, 2048);
            steps_of(isa, 2048, 1024);
            steps_of(isa, 4096, 4096);
            steps_of(isa, 4096, 1024);
        }
}

/* ---- maps ------------------------------------------------------------- */

static void time_map(ibl_ctx *ctx, int width, int height, bool back)
{
    ibl_azimuth *plan;
    ibl_ring_spectra spectra;
    const size_t stride = (size_t)width * (back ? 4 : 3);
    float *rows = noise(stride * HELD);
    static double t[ROUNDS], made[ROUNDS];
    if (ibl_ring_spectra_alloc(ctx, height, ORDERS, &spectra))
        exit(1);
    memset(spectra.data, 0,
           (size_t)ORDERS * 6 * spectra.stride * sizeof *spectra.data);
    for (int k = 0; k < ROUNDS; k++) {
        const double start = seconds();
        if (back ? ibl_azimuth_create_inverse(ctx, width, ORDERS, &plan)
                 : ibl_azimuth_create(ctx, width, ORDERS, 0, &plan))
            exit(1);
        made[k] = seconds() - start;
        float *scratch = noise(ibl_azimuth_scratch(plan));
        const double begin = seconds();
        for (int j = 0; j < height; j += LANES) {
            float *at = rows + (size_t)(j % HELD) * stride;
            const ibl_azimuth_rows in = {at, stride, LANES, {{0, 0, 0}, 1}};
            const ibl_azimuth_samples out = {at, stride, LANES};
            if (back)
                ibl_azimuth_inverse(plan, &spectra, j, scratch, &out);
            else
                ibl_azimuth_forward(plan, &in, scratch, &spectra, j);
        }
        t[k] = seconds() - begin;
        ibl_free(scratch);
        ibl_azimuth_free(plan);
    }
    printf("  %5d x %5d %s %-7s: %8.3f, and the plan %.3f\n", width, height,
           back ? "inverse" : "forward", ibl_isa_name(ibl_ctx_isa(ctx)),
           1e3 * test_median(t, ROUNDS), 1e3 * test_median(made, ROUNDS));
    ibl_ring_spectra_free(&spectra);
    ibl_free(rows);
}

static void maps(void)
{
    printf("maps of three channels, %d orders, ms\n", ORDERS);
    for (ibl_isa isa = IBL_ISA_SSE2; isa <= IBL_ISA_AVX512; isa++) {
        if (!ibl_cpu_has(isa))
            continue;
        ibl_ctx *ctx = test_ctx(1, isa);
        time_map(ctx, 1024, 512, false);
        time_map(ctx, 1000, 500, false);
        time_map(ctx, 4096, 2048, false);
        time_map(ctx, 1024, 512, true);
        ibl_ctx_free(ctx);
    }
}

/* Any argument: the maps alone. */
int main(int argc, char **argv)
{
    (void)argv;
    if (argc == 1) {
        transforms(false);
        transforms(true);
        straight_or_spread();
    }
    maps();
    return 0;
}
