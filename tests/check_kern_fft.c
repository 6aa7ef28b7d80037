/* SPDX-License-Identifier: MIT */
/* Fourier transforms of sixteen rows: every version against sums in double. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kern.h"
#include "kern/fft.h"

#define PI 3.1415926535897932384626433832795

enum {
    LANES = IBL_FFT_LANES
};

static float *floats(size_t n)
{
    return kern_alloc(n * sizeof(float), 64);
}

static void fill(test_random *r, float *p, size_t n)
{
    for (size_t i = 0; i < n; i++)
        p[i] = (float)test_random_between(r, -1, 1);
}

/* cos and sin of 2 pi k / n. */
static double *turns(int n)
{
    double *t = kern_alloc((size_t)n * 2 * sizeof *t, 64);
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
    float *z;        /* n x LANES: what the transforms work on */
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
    x->factor = kern_alloc(pairs * 2 * sizeof *x->factor, 64);
    x->pairs = kern_alloc(pairs * sizeof *x->pairs, 64);
    x->rows = floats((size_t)n * LANES);
    x->z = floats((size_t)n * LANES);
    x->spectrum = floats((size_t)count * 2 * LANES);
    x->where = (ibl_fft_spectrum){x->spectrum, 2 * LANES, LANES};
    x->turns = turns(n);
    if (!ibl_fft_init(&x->fft, n / 2))
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
    kern_free(x->factor);
    kern_free(x->pairs);
    kern_free(x->rows);
    kern_free(x->z);
    kern_free(x->spectrum);
    kern_free(x->turns);
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

/* Rounding of n values through log2 n stages: each adds about 0.4 epsilon;
 * the plain version's stages are of radix 2, so twice as many sums. */
static double rms_limit(int n)
{
    return FLT_EPSILON * (0.6 + 0.18 * log2(n));
}

/* Of the sums of squares of errors and of what should be. */
static void check_rms(double errors, double truths, ibl_isa isa, int n,
                      const char *what)
{
    const double rms = sqrt(errors / truths);
    CHECK_MSG(rms <= rms_limit(n), "%s %s of %d: rms error %.3g, limit %.3g",
              ibl_isa_name(isa), what, n, rms, rms_limit(n));
}

/* Sum over a step of bins and lanes (all of them: 1). */
static void compare_forward(ibl_isa isa, int n, int count, int step)
{
    double errors = 0, truths = 0;
    fixture x;
    fixture_init(&x, isa, n, count, true);
    forward(&x);
    for (int k = 0; k < count * LANES; k += step) {
        const int m = k / LANES, lane = k % LANES;
        const float *got = x.spectrum + (size_t)m * 2 * LANES + lane;
        double bin[2];
        direct_bin(&x, m, lane, bin);
        errors += pow(got[0] - bin[0], 2) + pow(got[LANES] - bin[1], 2);
        truths += bin[0] * bin[0] + bin[1] * bin[1];
    }
    check_rms(errors, truths, isa, n, "forward");
    fixture_free(&x);
}

static void compare_inverse(ibl_isa isa, int n, int count, int step)
{
    double errors = 0, truths = 0;
    fixture x;
    fixture_init(&x, isa, n, count, false);
    inverse(&x);
    for (int k = 0; k < n * LANES; k += step) {
        const int i = k / LANES, lane = k % LANES;
        const double want = direct_sample(&x, i, lane);
        errors += pow(x.z[k] - want, 2);
        truths += want * want;
    }
    check_rms(errors, truths, isa, n, "inverse");
    fixture_free(&x);
}

static void every_length_of(ibl_isa isa)
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
    /* Bins are of period n, however many are asked for. */
    compare_forward(isa, 4, 37, 1);
    compare_forward(isa, 32, 100, 1);
}

KERN_TEST(every_length)
