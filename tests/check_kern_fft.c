/* SPDX-License-Identifier: MIT */
/*
 * The Fourier transforms of sixteen rows: every version against direct sums
 * in double, and the vector versions of the strip kernels against the plain
 * ones.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/cpu.h"
#include "kern/fft.h"
#include "kern/row_block.h"
#include "test.h"

#define PI 3.1415926535897932384626433832795

enum {
    LANES = IBL_FFT_LANES,
    GUARD = 64 /* floats that must stay as they are */
};

static const float marker = 1234567;

/* n floats between guards, which guarded_free checks. */
static float *guarded(size_t n)
{
    float *p = ibl_alloc_array(n + 2 * GUARD, sizeof *p);
    if (!p)
        exit(1);
    for (size_t i = 0; i < n + 2 * GUARD; i++)
        p[i] = marker;
    return p + GUARD;
}

static void guarded_free(float *p, size_t n)
{
    for (size_t i = 0; i < GUARD; i++) {
        CHECK(p[(ptrdiff_t)i - GUARD] == marker);
        CHECK(p[n + i] == marker);
    }
    ibl_free(p - GUARD);
}

static void fill(test_random *r, float *p, size_t n)
{
    for (size_t i = 0; i < n; i++)
        p[i] = (float)(2 * test_random_unit(r) - 1);
}

/* cos and sin of 2 pi k / n. */
static double *turns(int n)
{
    double *t = ibl_alloc_array((size_t)n, 2 * sizeof *t);
    if (!t)
        exit(1);
    for (int k = 0; k < n; k++) {
        t[2 * k] = cos(2 * PI * k / n);
        t[2 * k + 1] = sin(2 * PI * k / n);
    }
    return t;
}

/* ---- one real transform, with everything around it -------------------- */

typedef struct fixture {
    ibl_fft_dsp dsp;
    ibl_fft fft;
    int n;     /* real values of a row */
    int count; /* bins */
    double *factor;
    ibl_fft_pair *pairs;
    float *rows;     /* n x LANES */
    float *z;        /* n x LANES, guarded: what the transforms work on */
    float *spectrum; /* count x 2 x LANES */
    ibl_fft_spectrum where;
    double *turns;
} fixture;

static void fixture_init(fixture *x, ibl_isa isa, int n, int count,
                         bool forward)
{
    test_random r = {(uint64_t)(n * 10 + count)};
    *x = (fixture){.n = n, .count = count};
    ibl_fft_dsp_init(&x->dsp, isa);
    const size_t pairs = (size_t)(forward ? count : n / 2);
    x->factor = ibl_alloc_array(pairs, 2 * sizeof *x->factor);
    x->pairs = ibl_alloc_array(pairs, sizeof *x->pairs);
    x->rows = ibl_alloc_array((size_t)n * LANES, sizeof *x->rows);
    x->z = guarded((size_t)n * LANES);
    x->spectrum = guarded((size_t)count * 2 * LANES);
    x->where = (ibl_fft_spectrum){x->spectrum, 2 * LANES, LANES};
    x->turns = turns(n);
    if (!x->factor || !x->pairs || !x->rows || !ibl_fft_init(&x->fft, n / 2))
        exit(1);
    for (int m = 0; m < count; m++) {
        const double a = m ? 6.3 * test_random_unit(&r) : 0;
        const double size = 0.5 + test_random_unit(&r);
        x->factor[2 * m] = size * cos(a);
        x->factor[2 * m + 1] = size * sin(a);
    }
    for (size_t m = (size_t)count; m < pairs; m++) /* there are none */
        x->factor[2 * m] = x->factor[2 * m + 1] = NAN;
    if (forward)
        ibl_fft_real_pairs(n / 2, x->factor, count, x->pairs);
    else
        ibl_fft_real_pairs_inverse(n / 2, x->factor, count, x->pairs);
    fill(&r, x->rows, (size_t)n * LANES);
    fill(&r, x->spectrum, (size_t)count * 2 * LANES);
}

static void fixture_free(fixture *x)
{
    ibl_fft_free(&x->fft);
    ibl_free(x->factor);
    ibl_free(x->pairs);
    ibl_free(x->rows);
    guarded_free(x->z, (size_t)x->n * LANES);
    guarded_free(x->spectrum, (size_t)x->count * 2 * LANES);
    ibl_free(x->turns);
}

static void forward(fixture *x)
{
    memcpy(x->z, x->rows, (size_t)x->n * LANES * sizeof *x->z);
    x->dsp.forward(&x->fft, x->z);
    x->dsp.split(x->z, x->pairs, x->count, &x->where);
}

static void inverse(fixture *x)
{
    x->dsp.merge(&x->where, x->pairs, x->fft.size, x->z);
    x->dsp.inverse(&x->fft, x->z);
}

static void direct_bin(const fixture *x, int m, int lane, double bin[2])
{
    double re = 0, im = 0;
    for (int i = 0; i < x->n; i++) {
        const double *t = x->turns + 2 * ((int64_t)m * i % x->n);
        const double v = x->rows[(size_t)i * LANES + (size_t)lane];
        re += v * t[0];
        im -= v * t[1];
    }
    const double *f = x->factor + (ptrdiff_t)2 * m;
    bin[0] = re * f[0] - im * f[1];
    bin[1] = re * f[1] + im * f[0];
}

static double direct_sample(const fixture *x, int i, int lane)
{
    double sum = 0;
    for (int m = 0; m < x->count; m++) {
        const float *g = x->spectrum + (size_t)m * 2 * LANES + lane;
        const double *f = x->factor + (ptrdiff_t)2 * m;
        const double re = g[0] * f[0] - g[LANES] * f[1];
        const double im = g[0] * f[1] + g[LANES] * f[0];
        const double *t = x->turns + 2 * ((int64_t)m * i % x->n);
        sum += m ? 2 * (re * t[0] - im * t[1]) : re;
    }
    return sum;
}

typedef struct error_sum {
    double error, truth;
} error_sum;

static void add_error(error_sum *e, double got, double truth)
{
    e->error += (got - truth) * (got - truth);
    e->truth += truth * truth;
}

/* Rounding of n values through log2 n stages: each adds about 0.4 epsilon;
 * the plain version's stages are of radix 2, so twice as many sums. */
static double rms_limit(int n)
{
    return FLT_EPSILON * (0.6 + 0.18 * log2(n));
}

static void check_rms(const error_sum *e, ibl_isa isa, int n, const char *what)
{
    const double rms = sqrt(e->error / e->truth);
    CHECK_MSG(rms <= rms_limit(n), "%s %s of %d: rms error %.3g, limit %.3g",
              ibl_isa_name(isa), what, n, rms, rms_limit(n));
    if (getenv("IBL_TEST_PRINT"))
        printf("%-6s %-7s %6d  %.3g\n", ibl_isa_name(isa), what, n, rms);
}

/* Sum over a step of bins and lanes (all of them: 1). */
static void compare_forward(ibl_isa isa, int n, int count, int step)
{
    error_sum e = {0, 0};
    fixture x;
    fixture_init(&x, isa, n, count, true);
    forward(&x);
    for (int k = 0; k < count * LANES; k += step) {
        const int m = k / LANES, lane = k % LANES;
        const float *got = x.spectrum + (size_t)m * 2 * LANES + lane;
        double bin[2];
        direct_bin(&x, m, lane, bin);
        add_error(&e, got[0], bin[0]);
        add_error(&e, got[LANES], bin[1]);
    }
    check_rms(&e, isa, n, "forward");
    fixture_free(&x);
}

static void compare_inverse(ibl_isa isa, int n, int count, int step)
{
    error_sum e = {0, 0};
    fixture x;
    fixture_init(&x, isa, n, count, false);
    inverse(&x);
    for (int k = 0; k < n * LANES; k += step) {
        const int i = k / LANES, lane = k % LANES;
        add_error(&e, x.z[k], direct_sample(&x, i, lane));
    }
    check_rms(&e, isa, n, "inverse");
    fixture_free(&x);
}

static void each_isa(void (*run)(ibl_isa isa))
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
        if (ibl_cpu_has(isa))
            run(isa);
}

static void lengths(ibl_isa isa)
{
    for (int n = 4; n <= 1024; n *= 2) {
        /* Primes, so that a step goes through every lane. */
        const int step = n <= 64 ? 1 : n <= 256 ? 7 : 53;
        compare_forward(isa, n, n / 2 + 1, step);
        compare_forward(isa, n, 1, 1);
        compare_inverse(isa, n, n / 2, step);
        compare_inverse(isa, n, n / 4, step);
        compare_inverse(isa, n, 1, step);
    }
    for (int n = 2048; n <= 65536; n *= 2) {
        compare_forward(isa, n, n / 2 + 1, n * 8 / 24 + 1);
        compare_inverse(isa, n, n / 8, n * 16 / 24 + 1);
    }
}

static void every_length_against_direct_sums(void)
{
    each_isa(lengths);
}

/* Bins are of period n, however many are asked for. */
static void periodic(ibl_isa isa)
{
    compare_forward(isa, 4, 37, 1);
    compare_forward(isa, 8, 29, 1);
    compare_forward(isa, 32, 100, 1);
}

static void bins_beyond_the_length(void)
{
    each_isa(periodic);
}

/* ---- properties ------------------------------------------------------- */

/* Impulses: every bin of size 1, of the phase of the place. */
static void impulses(ibl_isa isa)
{
    enum {
        N = 512,
        BINS = N / 2 + 1
    };
    fixture x;
    fixture_init(&x, isa, N, BINS, true);
    for (int m = 0; m < BINS; m++) {
        x.factor[2 * m] = 1;
        x.factor[2 * m + 1] = 0;
    }
    ibl_fft_real_pairs(N / 2, x.factor, BINS, x.pairs);
    for (int from = 0; from < N; from += LANES) {
        memset(x.rows, 0, N * LANES * sizeof *x.rows);
        for (int l = 0; l < LANES; l++)
            x.rows[(from + l) * LANES + l] = 1;
        forward(&x);
        for (int k = 0; k < BINS * LANES; k++) {
            const int m = k / LANES, l = k % LANES;
            const double *t = x.turns + (ptrdiff_t)2 * (m * (from + l) % N);
            const float *got = x.spectrum + (ptrdiff_t)m * 2 * LANES + l;
            CHECK_NEAR(got[0], t[0], 4 * FLT_EPSILON);
            CHECK_NEAR(got[LANES], -t[1], 4 * FLT_EPSILON);
        }
    }
    fixture_free(&x);
}

static void impulse_response(void)
{
    each_isa(impulses);
}

static double energy(const float *p, size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += (double)p[i] * p[i];
    return sum;
}

/* The complex transform keeps the energy, and the inverse undoes it. */
static void parseval(ibl_isa isa)
{
    for (int size = 2; size <= 8192; size *= 2) {
        const size_t floats = (size_t)size * IBL_FFT_VALUE;
        fixture x;
        fixture_init(&x, isa, 2 * size, 1, true);
        memcpy(x.z, x.rows, floats * sizeof *x.z);
        x.dsp.forward(&x.fft, x.z);
        const double ratio =
            energy(x.z, floats) / (size * energy(x.rows, floats));
        CHECK_NEAR(ratio, 1, 20 * FLT_EPSILON);
        x.dsp.inverse(&x.fft, x.z);
        error_sum e = {0, 0};
        for (size_t i = 0; i < floats; i++)
            add_error(&e, (double)x.z[i] / size, x.rows[i]);
        check_rms(&e, isa, 4 * size, "round trip");
        fixture_free(&x);
    }
}

static void energy_and_round_trip(void)
{
    each_isa(parseval);
}

/* Lane l is a sum of lanes of another run: so are its bins; and twice the
 * rows give exactly twice the bins. */
static void linear(ibl_isa isa)
{
    enum {
        N = 1024,
        BINS = N / 2 + 1
    };
    fixture x, y;
    error_sum e = {0, 0};
    fixture_init(&x, isa, N, BINS, true);
    fixture_init(&y, isa, N, BINS, true);
    for (int k = 0; k < N * LANES; k += LANES) {
        y.rows[k] = x.rows[k] + x.rows[k + 1];
        y.rows[k + 1] = 2 * x.rows[k + 2];
    }
    forward(&x);
    forward(&y);
    for (int k = 0; k < BINS * 2 * LANES; k += LANES) {
        add_error(&e, y.spectrum[k], (double)x.spectrum[k] + x.spectrum[k + 1]);
        CHECK(y.spectrum[k + 1] == 2 * x.spectrum[k + 2]);
    }
    check_rms(&e, isa, N, "sum");
    fixture_free(&x);
    fixture_free(&y);
}

static void sums_of_rows(void)
{
    each_isa(linear);
}

/* Lanes know nothing of each other: infinite ones spoil themselves alone. */
static void lane_alone(ibl_isa isa)
{
    enum {
        N = 256,
        BINS = N / 2 + 1
    };
    fixture x, y;
    fixture_init(&x, isa, N, BINS, true);
    fixture_init(&y, isa, N, BINS, true);
    for (int i = 0; i < N; i++) {
        y.rows[i * LANES + 3] = INFINITY;
        y.rows[i * LANES + 4] = 0;
    }
    forward(&x);
    forward(&y);
    for (int k = 0; k < BINS * 2 * LANES; k++) {
        if (k % LANES == 4)
            CHECK(y.spectrum[k] == 0);
        else if (k % LANES != 3)
            CHECK(x.spectrum[k] == y.spectrum[k]);
    }
    fixture_free(&x);
    fixture_free(&y);
}

static void lanes_are_independent(void)
{
    each_isa(lane_alone);
}

/* ---- strips ----------------------------------------------------------- */

enum {
    MAX_PIXELS = 70
};

/* Rows with different alignments, each between guards. */
typedef struct row_set {
    float *memory[LANES];
    float *rows[LANES];
    size_t floats;
} row_set;

static void rows_init(row_set *s, size_t floats, test_random *r)
{
    s->floats = floats;
    for (int l = 0; l < LANES; l++) {
        s->memory[l] = guarded(floats + 3);
        s->rows[l] = s->memory[l] + l % 4;
        if (r)
            fill(r, s->rows[l], floats);
    }
}

static void rows_free(row_set *s)
{
    for (int l = 0; l < LANES; l++) {
        for (int k = 0; k < l % 4; k++)
            CHECK(s->memory[l][k] == marker);
        for (int k = l % 4; k < 3; k++)
            CHECK(s->memory[l][s->floats + (size_t)k] == marker);
        guarded_free(s->memory[l], s->floats + 3);
    }
}

static void loads(ibl_isa isa)
{
    const ibl_row_block_change change = {{0.25f, -3, 0}, 0.5f};
    const size_t channel = (MAX_PIXELS + 2) * LANES;
    ibl_row_block_dsp dsp;
    test_random r = {5};
    ibl_row_block_dsp_init(&dsp, isa);
    for (int count = 0; count <= MAX_PIXELS; count++) {
        float *lanes = guarded(3 * channel);
        row_set in;
        rows_init(&in, (size_t)count * 3, &r);
        dsp.load((const float *const *)in.rows, count, &change, lanes, channel);
        for (size_t c = 0; c < 3; c++)
            for (size_t k = 0; k < channel; k++) {
                const size_t i = k / LANES, l = k % LANES;
                const float want =
                    i < (size_t)count
                        ? (in.rows[l][3 * i + c] - change.subtract[c]) *
                              change.scale
                        : marker;
                CHECK(lanes[c * channel + k] == want);
            }
        rows_free(&in);
        guarded_free(lanes, 3 * channel);
    }
}

static void rows_to_lanes(void)
{
    each_isa(loads);
}

static void stores(ibl_isa isa)
{
    const size_t channel = (MAX_PIXELS + 2) * LANES;
    ibl_row_block_dsp dsp;
    test_random r = {6};
    float *lanes = guarded(3 * channel);
    fill(&r, lanes, 3 * channel);
    ibl_row_block_dsp_init(&dsp, isa);
    for (int count = 0; count <= MAX_PIXELS; count++) {
        const int used = count % 3 ? LANES : 1 + count % LANES;
        row_set out;
        rows_init(&out, (size_t)count * 4, NULL);
        dsp.store(lanes, channel, count, out.rows, used);
        for (size_t l = 0; l < LANES; l++)
            for (size_t k = 0; k < 4 * (size_t)count; k++) {
                const size_t i = k / 4, c = k % 4;
                const float want =
                    c == 3 ? 0 : lanes[c * channel + i * LANES + l];
                CHECK(out.rows[l][k] == (l < (size_t)used ? want : marker));
            }
        rows_free(&out);
    }
    guarded_free(lanes, 3 * channel);
}

static void lanes_to_rows(void)
{
    each_isa(stores);
}

/* Random taps, firsts that stand, step and jump; blocks of every length. */
static void spreads(ibl_isa isa)
{
    enum {
        PERIOD = 5,
        STEP = 23,
        PIXELS = 64,
        SAMPLES = (PIXELS / PERIOD + 1) * STEP + IBL_ROW_BLOCK_TAPS
    };
    int32_t first[PERIOD] = {0, 0, 1, 2, 22};
    float taps[PERIOD * IBL_ROW_BLOCK_TAPS];
    float *pixels = guarded(PIXELS * LANES);
    test_random r = {7};
    ibl_row_block_dsp dsp;
    fill(&r, taps, PERIOD * IBL_ROW_BLOCK_TAPS);
    fill(&r, pixels, PIXELS * LANES);
    ibl_row_block_dsp_init(&dsp, isa);
    const ibl_row_block_spread spread = {PERIOD, STEP, first, taps};
    const size_t used =
        (size_t)ibl_row_block_first(&spread, PIXELS - 1) + IBL_ROW_BLOCK_TAPS;
    for (int block = 1; block <= PIXELS; block++) {
        float *samples = guarded(used * LANES);
        double truth[SAMPLES * LANES] = {0};
        for (int i = 0; i < PIXELS; i += block) {
            const int left = PIXELS - i;
            dsp.spread(&spread, pixels + (ptrdiff_t)i * LANES, i,
                       left < block ? left : block, samples);
        }
        for (int i = 0; i < PIXELS; i++)
            for (int k = 0; k < IBL_ROW_BLOCK_TAPS * LANES; k++)
                truth[(first[i % PERIOD] + i / PERIOD * STEP) * LANES + k] +=
                    (double)taps[i % PERIOD * IBL_ROW_BLOCK_TAPS + k / LANES] *
                    pixels[i * LANES + k % LANES];
        for (size_t k = 0; k < used * LANES; k++)
            CHECK_NEAR(samples[k], truth[k], 20 * FLT_EPSILON);
        guarded_free(samples, used * LANES);
    }
    guarded_free(pixels, PIXELS * LANES);
}

static void pixels_to_samples(void)
{
    each_isa(spreads);
}

static const test tests[] = {
    TEST(every_length_against_direct_sums),
    TEST(bins_beyond_the_length),
    TEST(impulse_response),
    TEST(energy_and_round_trip),
    TEST(sums_of_rows),
    TEST(lanes_are_independent),
    TEST(rows_to_lanes),
    TEST(lanes_to_rows),
    TEST(pixels_to_samples),
};
TEST_MAIN(tests)
