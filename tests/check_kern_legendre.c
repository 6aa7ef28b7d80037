/* SPDX-License-Identifier: MIT */
/*
 * Legendre sums of one order: the values of P_lm themselves and sums with
 * them against long double, and every instruction set against the plain
 * version. A ring that is 1 and all else 0 makes the analysis tell P_lm in
 * double.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/cpu.h"
#include "kern/legendre.h"
#include "test.h"

enum {
    PARTS = 6
};

static const long double pi = 3.141592653589793238462643383279502884L;

/* ---- truth ---------------------------------------------------------- */

/*
 * P_lm(cos theta_j), l = m..degree, by the recurrence in l of the functions
 * without normalisation divided by (2m - 1)!! sin^m,
 *     (l - m) Q_l = (2l - 1) x Q_l-1 - (l + m - 1) Q_l-2,   Q_m = 1,
 * times sqrt((2l + 1) / 4 pi (l - m)! / (l + m)!) (2m - 1)!! sin^m, whose
 * logarithm is kept. Q is scaled as it grows.
 */
static void true_legendre(int rings, int j, int m, int degree, long double *p)
{
    const long double half = pi / 2 / rings;
    const long double x = sinl(half * (rings - 1 - 2 * j));
    const long double s = sinl(half * (2 * j + 1));
    long double q = 1, last = 0, shift = 0, scale = m * log2l(s);

    /* (2m - 1)!!^2 / (2m)! = (2m - 1)!! / (2m)!! */
    for (int i = 1; i <= m; i++)
        scale += log2l((2 * i - 1) / (2.0L * i)) / 2;
    for (int l = m; l <= degree; l++) {
        if (l > m) {
            const long double next =
                ((2 * l - 1) * x * q - (l + m - 1) * last) / (l - m);
            last = q;
            q = next;
            scale += log2l((long double)(l - m) / (l + m)) / 2;
        }
        if (fabsl(q) > 0x1p1000L) {
            q *= 0x1p-1000L;
            last *= 0x1p-1000L;
            shift += 1000;
        }
        p[l - m] = q * exp2l(scale + shift) * sqrtl((2 * l + 1) / (4 * pi));
    }
}

/* ---- fixture -------------------------------------------------------- */

static void *memory(size_t n, size_t size)
{
    void *p = ibl_alloc_zeroed(n, size);

    if (!p)
        exit(1);
    return p;
}

typedef struct fixture {
    ibl_legendre_rings rings;
    ibl_legendre_order order;
    size_t stride, terms;
    float *f; /* PARTS rings with NaN beyond */
    double *weight, *a;
} fixture;

static fixture make(int rings, int degree, int m)
{
    fixture x = {.stride = ((size_t)rings + 15) / 16 * 16 + 16,
                 .terms = (size_t)(degree - m) + 1};

    x.f = memory(PARTS * x.stride, sizeof *x.f);
    x.weight = memory((size_t)rings, sizeof *x.weight);
    x.a = memory(PARTS * x.terms + PARTS, sizeof *x.a);
    for (int j = 0; j < rings; j++)
        x.weight[j] = 1.0;
    for (int part = 0; part < PARTS; part++) {
        for (size_t j = (size_t)rings; j < x.stride; j++)
            x.f[part * x.stride + j] = NAN;
    }
    for (size_t i = 0; i < PARTS; i++)
        x.a[PARTS * x.terms + i] = 12345.0;
    return x;
}

static void bind(fixture *x, int rings, int degree, int m)
{
    double *scratch = memory(ibl_legendre_scratch(degree), sizeof *scratch);

    for (size_t i = 0; i < ibl_legendre_scratch(degree); i++)
        scratch[i] = NAN;
    if (!ibl_legendre_rings_init(&x->rings, rings, degree, x->weight))
        exit(1);
    x->order = (ibl_legendre_order){&x->rings, m, degree, scratch};
}

static void drop(fixture *x)
{
    ibl_legendre_rings_free(&x->rings);
    ibl_free(x->order.scratch);
    ibl_free(x->f);
    ibl_free(x->weight);
    ibl_free(x->a);
}

static bool guards_hold(const fixture *x)
{
    for (int part = 0; part < PARTS; part++) {
        for (size_t j = (size_t)x->rings.count; j < x->stride; j++) {
            if (!isnan(x->f[part * x->stride + j]))
                return false;
        }
    }
    for (size_t i = 0; i < PARTS; i++) {
        if (x->a[PARTS * x->terms + i] != 12345.0)
            return false;
    }
    return true;
}

static const ibl_isa isas[] = {IBL_ISA_C, IBL_ISA_SSE2, IBL_ISA_AVX2,
                               IBL_ISA_AVX512};

/* Runs check(dsp, name) for every instruction set that is here. */
static void for_each_isa(void (*check)(const ibl_legendre_dsp *, ibl_isa))
{
    for (size_t i = 0; i < sizeof isas / sizeof isas[0]; i++) {
        ibl_legendre_dsp dsp;
        if (!ibl_cpu_has(isas[i]))
            continue;
        ibl_legendre_dsp_init(&dsp, isas[i]);
        check(&dsp, isas[i]);
    }
}

/* ---- values --------------------------------------------------------- */

static double worst; /* error of the running test, in units of its bound */

/*
 * The bound of legendre.h. P_lm is at most about sqrt(l); the rounding of
 * cos theta moves theta by eps / sin theta and P_lm by l times that; near a
 * pole, where P_lm is even or odd in theta, by no more than l^2 eps.
 */
static double value_bound(int rings, int ring, int l)
{
    const double s = sin((double)pi * (ring + 0.5) / rings), n = l + 1.0;

    return DBL_EPSILON * n * sqrt(n) * fmin(n, 2.0 / s) + IBL_LEGENDRE_NOTHING;
}

/* P_lm of six rings at once, against long double. */
static void check_values(const ibl_legendre_dsp *dsp, ibl_isa isa, int rings,
                         const int ring[PARTS], int m, int degree)
{
    fixture x = make(rings, degree, m);
    long double *p = memory(x.terms, sizeof *p);

    bind(&x, rings, degree, m);
    for (int part = 0; part < PARTS; part++)
        x.f[(size_t)part * x.stride + (size_t)ring[part]] = 1.0f;
    dsp->analyse(&x.order, x.f, x.stride, x.a);
    for (int part = 0; part < PARTS; part++) {
        true_legendre(rings, ring[part], m, degree, p);
        for (int l = m; l <= degree; l++) {
            const double got = x.a[PARTS * (l - m) + part];
            const double error = (double)fabsl(got - p[l - m]);
            const double bound = value_bound(rings, ring[part], l);
            worst = fmax(worst, error / bound);
            CHECK_MSG(error <= bound,
                      "%s: P_%d,%d on ring %d of %d is %.17g, not %.17Lg",
                      ibl_isa_name(isa), l, m, ring[part], rings, got,
                      p[l - m]);
            if (error > bound)
                break;
        }
    }
    CHECK(guards_hold(&x));
    ibl_free(p);
    drop(&x);
}

static void check_small_values(const ibl_legendre_dsp *dsp, ibl_isa isa)
{
    static const int counts[] = {1, 2, 3, 4, 5, 31, 64, 257};

    worst = 0.0;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        const int n = counts[i];
        const int ring[PARTS] = {0, n / 7, n / 4, (n - 1) / 2, n / 2, n - 1};
        for (int m = 0; m <= 64; m++)
            check_values(dsp, isa, n, ring, m, 64);
    }
    printf("%-6s P_lm to 64: %.2g of the bound\n", ibl_isa_name(isa), worst);
}

static void every_value_to_64(void)
{
    for_each_isa(check_small_values);
}

static void check_large_values(const ibl_legendre_dsp *dsp, ibl_isa isa)
{
    test_random rnd = {17};

    worst = 0.0;
    for (int i = 0; i < 60; i++) {
        const int rings = 1 << test_random_u64(&rnd) % 15;
        const int degree = (int)(test_random_u64(&rnd) % 2049);
        const int m = (int)(degree * pow(test_random_unit(&rnd), 2.0));
        int ring[PARTS];
        for (int k = 0; k < PARTS; k++)
            ring[k] = (int)(rings * pow(test_random_unit(&rnd), 3.0));
        check_values(dsp, isa, rings, ring, m, degree);
    }
    printf("%-6s P_lm to 2048: %.2g of the bound\n", ibl_isa_name(isa), worst);
}

static void random_values_to_2048(void)
{
    for_each_isa(check_large_values);
}

/* Next to the poles of the finest grid, and where P_mm is 2^-60000. */
static void check_extreme_values(const ibl_legendre_dsp *dsp, ibl_isa isa)
{
    static const int ring[PARTS] = {0, 1, 15, 100, 5000, 32767};

    worst = 0.0;
    check_values(dsp, isa, 65536, ring, 0, 4096);
    check_values(dsp, isa, 65536, ring, 1, 4096);
    check_values(dsp, isa, 65535, ring, 1000, 4096);
    check_values(dsp, isa, 65536, ring, 4090, 4097);
    check_values(dsp, isa, 40000, ring, 16000, 16384);
    printf("%-6s P_lm to 16384: %.2g of the bound\n", ibl_isa_name(isa), worst);
}

static void extreme_values(void)
{
    for_each_isa(check_extreme_values);
}

static const test tests[] = {TEST(every_value_to_64),
                             TEST(random_values_to_2048), TEST(extreme_values)};
TEST_MAIN(tests)
