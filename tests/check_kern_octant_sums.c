/* SPDX-License-Identifier: MIT */
/* Sums for eight images: every version gives the bytes of the plain one. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/cpu.h"
#include "kern/octant_sums.h"
#include "test.h"

enum {
    WIDTH = 61,
    MAX = 40, /* pixels, spans, sums */
    GUARD = 32
};

static const ibl_isa levels[] = {IBL_ISA_SSE2, IBL_ISA_AVX2, IBL_ISA_AVX512};
static test_random rng = {8};

static int below(int n)
{
    return (int)(test_random_u64(&rng) % (uint64_t)n);
}

/* Ordinary, huge, tiny and denormal. */
static float value(void)
{
    const float unit = (float)test_random_unit(&rng);
    const float of[] = {unit, unit * 1e6f,   FLT_MAX,
                        0,    unit * 1e-38f, 0x1p-149f};
    return of[below(6)];
}

/* An array that ends, or would, in guard bytes. */
static double *doubles(int count)
{
    double *p = ibl_alloc_array((size_t)count + GUARD, sizeof *p);
    for (int i = 0; i < count + GUARD; i++)
        p[i] = i < count ? (double)value() : -77;
    return p;
}

static void same(const void *a, const void *b, size_t bytes, ibl_isa isa,
                 const char *what, int count)
{
    CHECK_MSG(!memcmp(a, b, bytes), "%s of %d by %s: other bytes", what, count,
              ibl_isa_name(isa));
}

/* The last pixel of a row is the last of the memory, too. */
static void collect(void)
{
    const size_t bytes = (MAX * IBL_OCTANT_RGB + GUARD) * sizeof(double);
    float *row = malloc(3 * WIDTH * sizeof *row);
    int offset[MAX * IBL_OCTANTS];
    for (int i = 0; i < 3 * WIDTH; i++)
        row[i] = value();
    for (int i = 0; i < MAX * IBL_OCTANTS; i++)
        offset[i] = 3 * (i % 5 ? below(WIDTH) : WIDTH - 1);
    for (size_t l = 0; l < sizeof levels / sizeof *levels; l++) {
        ibl_octants_dsp dsp;
        if (!ibl_cpu_has(levels[l]))
            continue;
        ibl_octants_dsp_init(&dsp, levels[l]);
        for (int n = 0; n <= MAX; n++) {
            double *want = doubles(MAX * IBL_OCTANT_RGB);
            double *got = ibl_alloc_array(bytes, 1);
            memcpy(got, want, bytes);
            ibl_octants_collect_c(row, offset, n, want);
            dsp.collect(row, offset, n, got);
            same(want, got, bytes, levels[l], "collect", n);
            for (int i = 0; i < n * IBL_OCTANT_RGB; i++) {
                const int pixel = i / IBL_OCTANT_RGB, m = i % IBL_OCTANTS;
                const int c = i / IBL_OCTANTS % 3;
                CHECK(got[i] ==
                      (double)row[offset[pixel * IBL_OCTANTS + m] + c]);
            }
            ibl_free(want);
            ibl_free(got);
        }
    }
    free(row);
}

/* Pixels between those of two rows, which turn, and some lanes only. */
static void blend(void)
{
    const size_t bytes = (MAX * IBL_OCTANT_RGB + GUARD) * sizeof(double);
    const int fine = 2 * WIDTH;
    float *source[2];
    ibl_octant_tap taps[2 * WIDTH];
    int column[MAX * IBL_OCTANTS];
    for (int k = 0; k < 2; k++) {
        source[k] = malloc(3 * WIDTH * sizeof *source[k]);
        for (int i = 0; i < 3 * WIDTH; i++)
            source[k][i] = value();
    }
    for (int i = 0; i < fine; i++)
        taps[i] = (ibl_octant_tap){{3 * below(WIDTH), 3 * (WIDTH - 1)},
                                   test_random_unit(&rng)};
    for (int i = 0; i < MAX * IBL_OCTANTS; i++)
        column[i] = below(fine);
    for (int n = 0; n <= MAX; n++) {
        const int lanes = 1 + n % IBL_OCTANTS;
        const double t = test_random_unit(&rng);
        const ibl_octant_blend row = {.source = {source[0], source[1]},
                                      .weight = {1 - t, t},
                                      .turn = {n % 2 * WIDTH, below(fine)},
                                      .columns = fine,
                                      .taps = taps};
        double *before = doubles(MAX * IBL_OCTANT_RGB);
        double *want = ibl_alloc_array(bytes, 1);
        double *got = ibl_alloc_array(bytes, 1);
        memcpy(want, before, bytes);
        ibl_octants_blend_c(&row, column, n, lanes, want);
        for (size_t l = 0; l < sizeof levels / sizeof *levels; l++) {
            ibl_octants_dsp dsp;
            if (!ibl_cpu_has(levels[l]))
                continue;
            ibl_octants_dsp_init(&dsp, levels[l]);
            memcpy(got, before, bytes);
            dsp.blend(&row, column, n, lanes, got);
            same(want, got, bytes, levels[l], "blend", n);
        }
        for (int i = 0; i < MAX * IBL_OCTANT_RGB; i++) {
            const int pixel = i / IBL_OCTANT_RGB, m = i % IBL_OCTANTS;
            const int c = i / IBL_OCTANTS % 3;
            double sum = 0, most = 0;
            for (int k = 0; k < 4 && pixel < n && m < lanes; k++) {
                const int x = column[pixel * IBL_OCTANTS + m];
                const ibl_octant_tap *tap = &taps[(x + row.turn[k / 2]) % fine];
                const double part = k % 2 ? tap->weight : 1 - tap->weight;
                const double v = (double)source[k / 2][tap->at[k % 2] + c];
                sum += row.weight[k / 2] * part * v;
                most = fmax(most, v);
            }
            if (pixel < n && m < lanes)
                CHECK_NEAR(want[i], sum, 1e-15 * most);
            else
                CHECK(!memcmp(&want[i], &before[i], sizeof *want));
        }
        ibl_free(before);
        ibl_free(want);
        ibl_free(got);
    }
    free(source[0]);
    free(source[1]);
}

/* Runs of every length, spans that follow each other in a sum. */
static void add(void)
{
    const size_t bytes = (MAX * IBL_OCTANT_RGB + GUARD) * sizeof(double);
    double *pixels = doubles(MAX * IBL_OCTANT_RGB);
    ibl_octant_span spans[MAX];
    for (size_t l = 0; l < sizeof levels / sizeof *levels; l++) {
        ibl_octants_dsp dsp;
        if (!ibl_cpu_has(levels[l]))
            continue;
        ibl_octants_dsp_init(&dsp, levels[l]);
        for (int n = 0; n <= MAX; n++) {
            double *want = doubles(MAX * IBL_OCTANT_RGB);
            double *got = ibl_alloc_array(bytes, 1);
            for (int i = 0; i < n; i++) {
                const int count = 1 + below(below(3) ? 2 : MAX);
                spans[i] = (ibl_octant_span){
                    test_random_unit(&rng), below(3) ? i : below(MAX),
                    (uint16_t)below(MAX - count + 1), (uint16_t)count};
            }
            memcpy(got, want, bytes);
            ibl_octants_add_c(spans, n, pixels, want);
            dsp.add(spans, n, pixels, got);
            same(want, got, bytes, levels[l], "add", n);
            ibl_free(want);
            ibl_free(got);
        }
    }
    ibl_free(pixels);
}

/* Texels of eight places, forwards and backwards, near each other. */
static void write(void)
{
    enum {
        PLACE = 4 * MAX + 8
    };
    static float want[IBL_OCTANTS * PLACE], got[IBL_OCTANTS * PLACE];
    double weights[MAX];
    double *sums = doubles(MAX * IBL_OCTANT_RGB);
    for (int i = 0; i < MAX; i++)
        weights[i] = test_random_unit(&rng) + 0.1;
    for (size_t l = 0; l < sizeof levels / sizeof *levels; l++) {
        ibl_octants_dsp dsp;
        if (!ibl_cpu_has(levels[l]))
            continue;
        ibl_octants_dsp_init(&dsp, levels[l]);
        for (int n = 0; n <= MAX; n++) {
            float *to[2][IBL_OCTANTS];
            ptrdiff_t step[IBL_OCTANTS];
            for (int m = 0; m < IBL_OCTANTS; m++) {
                step[m] = (m % 2 ? -1 : 1) * (3 + m / 2 % 2);
                const ptrdiff_t at = m * PLACE + (m % 2 ? PLACE - 4 : 1);
                to[0][m] = want + at;
                to[1][m] = got + at;
            }
            for (int i = 0; i < IBL_OCTANTS * PLACE; i++)
                want[i] = got[i] = -5;
            ibl_octants_write_c(sums, weights, n, to[0], step);
            dsp.write(sums, weights, n, to[1], step);
            same(want, got, sizeof want, levels[l], "write", n);
        }
    }
    ibl_free(sums);
}

static const test tests[] = {TEST(collect), TEST(blend), TEST(add),
                             TEST(write)};
TEST_MAIN(tests)
