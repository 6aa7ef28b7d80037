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
#include "truth.h"

enum {
    PARTS = 6
};

static const long double pi = 3.141592653589793238462643383279502884L;

/* ---- truth ---------------------------------------------------------- */

static void true_legendre(int rings, int j, int m, int degree, long double *p)
{
    const long double half = pi / 2 / rings;

    truth_legendre(sinl(half * (rings - 1 - 2 * j)), sinl(half * (2 * j + 1)),
                   m, degree, p);
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
    if (!ibl_legendre_rings_init(&x->rings, IBL_RINGS_CENTRES, rings, degree,
                                 x->weight))
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
    for (int i = 0; i < (TEST_SANITIZED ? 15 : 60); i++) {
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
    static const int ring[PARTS] = {0, 1, 15, 100, 499, 1999};

    worst = 0.0;
    check_values(dsp, isa, 65536, ring, 0, 1024);
    if (!TEST_SANITIZED) {
        check_values(dsp, isa, 65535, ring, 1, 4096);
        check_values(dsp, isa, 65536, ring, 3000, 4096);
    }
    check_values(dsp, isa, 65536, ring, 4090, 4097);
    check_values(dsp, isa, 4000, ring, 16000, 16384);
    printf("%-6s P_lm to 16384: %.2g of the bound\n", ibl_isa_name(isa), worst);
}

static void extreme_values(void)
{
    for_each_isa(check_extreme_values);
}

/* ---- sums ----------------------------------------------------------- */

/* Values as maps have them, and others. */
static double hostile(test_random *rnd)
{
    static const double values[] = {0.0, -0.0, 1e-45, 1e-30, 65504.0, 1e30};
    const uint64_t pick = test_random_u64(rnd) % 40;

    return pick < 6 ? values[pick] : 2.0 * test_random_unit(rnd) - 1.0;
}

/* A sum, and what its error may be. */
typedef struct sums {
    double value, bound;
} sums;

/* a_lm of a part by the direct sum in long double, from true_legendre. */
static void true_analysis(const fixture *x, int part, sums *to)
{
    const ibl_legendre_order *o = &x->order;
    const int rings = o->rings->count;
    long double *p = memory(x->terms, sizeof *p);
    long double *sum = memory(x->terms, sizeof *sum);

    for (size_t l = 0; l < x->terms; l++)
        to[l].bound = 0.0;
    for (int j = 0; j < rings; j++) {
        const long double f =
            x->weight[j] *
            (long double)x->f[(size_t)part * x->stride + (size_t)j];
        true_legendre(rings, j, o->m, o->degree, p);
        for (size_t l = 0; l < x->terms; l++) {
            sum[l] += f * p[l];
            to[l].bound +=
                (double)fabsl(f) * value_bound(rings, j, o->m + (int)l);
        }
    }
    for (size_t l = 0; l < x->terms; l++)
        to[l].value = (double)sum[l];
    ibl_free(p);
    ibl_free(sum);
}

static const int shapes[][3] = {
    /* rings, degree, m */
    {1, 0, 0},        {1, 5, 2},     {2, 0, 0},      {2, 1, 1},
    {3, 7, 0},        {3, 64, 3},    {4, 2, 1},      {5, 64, 17},
    {15, 16, 15},     {16, 15, 0},   {17, 16, 1},    {18, 14, 14},
    {31, 30, 0},      {32, 31, 4},   {33, 32, 31},   {34, 33, 2},
    {47, 10, 9},      {63, 62, 20},  {64, 64, 0},    {65, 63, 5},
    {66, 64, 64},     {130, 61, 7},  {257, 64, 30},  {511, 100, 60},
    {512, 64, 1},     {514, 64, 50}, {545, 129, 64}, {1026, 90, 45},
    {1100, 300, 200},
};

static void check_analysis(const ibl_legendre_dsp *dsp, ibl_isa isa)
{
    test_random rnd = {5};

    worst = 0.0;
    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; i++) {
        const int rings = shapes[i][0], degree = shapes[i][1];
        fixture x = make(rings, degree, shapes[i][2]);
        sums *truth = memory(x.terms, sizeof *truth);
        for (int j = 0; j < rings; j++) {
            x.weight[j] = test_random_unit(&rnd);
            for (int part = 0; part < PARTS; part++)
                x.f[(size_t)part * x.stride + (size_t)j] = (float)hostile(&rnd);
        }
        bind(&x, rings, degree, shapes[i][2]);
        dsp->analyse(&x.order, x.f, x.stride, x.a);
        for (int part = 0; part < PARTS; part++) {
            true_analysis(&x, part, truth);
            for (size_t l = 0; l < x.terms; l++) {
                const double error =
                    fabs(x.a[PARTS * l + (size_t)part] - truth[l].value);
                const double bound = truth[l].bound;
                worst = fmax(worst, error / bound);
                CHECK_MSG(error <= bound,
                          "%s: %d rings, degree %d, m %d, l - m %zu: %g, "
                          "not %g",
                          ibl_isa_name(isa), rings, degree, shapes[i][2], l,
                          x.a[PARTS * l + (size_t)part], truth[l].value);
            }
        }
        CHECK(guards_hold(&x));
        ibl_free(truth);
        drop(&x);
    }
    printf("%-6s analysis: %.2g of the bound\n", ibl_isa_name(isa), worst);
}

static void analysis_is_the_direct_sum(void)
{
    for_each_isa(check_analysis);
}

/* The direct sum for ring j and a part, and its bound, with the result's
 * rounding to float. */
static sums true_synthesis(const fixture *x, const double *factor, int j,
                           int part, const long double *p)
{
    const ibl_legendre_order *o = &x->order;
    long double sum = 0.0L;
    double bound = 0.0;

    for (size_t l = 0; l < x->terms; l++) {
        const double c =
            factor[(size_t)o->m + l] * x->a[PARTS * l + (size_t)part];
        sum += c * p[l];
        bound += fabs(c) * value_bound(o->rings->count, j, o->m + (int)l);
    }
    bound += FLT_EPSILON / 2 * (double)fabsl(sum) + 1e-45;
    return (sums){(double)sum, bound};
}

static void check_synthesis(const ibl_legendre_dsp *dsp, ibl_isa isa)
{
    test_random rnd = {6};

    worst = 0.0;
    for (size_t i = 0; i < sizeof shapes / sizeof shapes[0]; i++) {
        const int rings = shapes[i][0], degree = shapes[i][1];
        fixture x = make(rings, degree, shapes[i][2]);
        long double *p = memory(x.terms, sizeof *p);
        double *factor = memory((size_t)degree + 1, sizeof *factor);
        for (int l = 0; l <= degree; l++)
            factor[l] = hostile(&rnd);
        for (size_t l = 0; l < PARTS * x.terms; l++)
            x.a[l] = test_random_unit(&rnd) - 0.5;
        bind(&x, rings, degree, shapes[i][2]);
        dsp->synthesise(&x.order, x.a, factor, x.f, x.stride);
        for (int j = 0; j < rings; j++) {
            true_legendre(rings, j, shapes[i][2], degree, p);
            for (int part = 0; part < PARTS; part++) {
                const sums truth = true_synthesis(&x, factor, j, part, p);
                const double got = x.f[(size_t)part * x.stride + (size_t)j];
                const double error = fabs(got - truth.value);
                worst = fmax(worst, error / truth.bound);
                CHECK_MSG(error <= truth.bound,
                          "%s: ring %d of %d, degree %d, m %d: %g, not %g",
                          ibl_isa_name(isa), j, rings, degree, shapes[i][2],
                          got, truth.value);
            }
        }
        CHECK(guards_hold(&x));
        ibl_free(p);
        ibl_free(factor);
        drop(&x);
    }
    printf("%-6s synthesis: %.2g of the bound\n", ibl_isa_name(isa), worst);
}

static void synthesis_is_the_direct_sum(void)
{
    for_each_isa(check_synthesis);
}

/* ---- orthonormality ------------------------------------------------- */

enum {
    TOP = 64,
    NODES = 2 * TOP + 4 /* Fejer's rule is exact for polynomials below it */
};

/* Weights for the integral over x of values at the rings' centres (Fejer
 * 1933, the first rule). */
static void fejer(int rings, double *weight)
{
    for (int j = 0; j < rings; j++) {
        const double theta = (double)pi * (j + 0.5) / rings;
        double sum = 1.0;
        for (int k = 1; k <= rings / 2; k++)
            sum -= 2.0 * cos(2.0 * k * theta) / (4.0 * k * k - 1.0);
        weight[j] = 2.0 / rings * sum;
    }
}

/* P_lm of all rings, six at a time. p[l - m][ring] */
static void tabulate(const ibl_legendre_dsp *dsp, int m, double p[][NODES])
{
    fixture x = make(NODES, TOP, m);

    bind(&x, NODES, TOP, m);
    for (int j = 0; j < NODES; j += PARTS) {
        for (int part = 0; part < PARTS; part++) {
            float *f = x.f + (size_t)part * x.stride;
            memset(f, 0, NODES * sizeof *f);
            f[j + part] = 1.0f;
        }
        dsp->analyse(&x.order, x.f, x.stride, x.a);
        for (size_t l = 0; l < x.terms; l++)
            memcpy(&p[l][j], x.a + PARTS * l, PARTS * sizeof **p);
    }
    drop(&x);
}

static void check_orthonormal(const ibl_legendre_dsp *dsp, ibl_isa isa)
{
    static double p[TOP + 1][NODES], weight[NODES];

    worst = 0.0;
    fejer(NODES, weight);
    for (int m = 0; m <= TOP; m++) {
        tabulate(dsp, m, p);
        for (int l = 0; l <= TOP - m; l++) {
            for (int k = 0; k <= l; k++) {
                double sum = 0.0;
                for (int j = 0; j < NODES; j++)
                    sum += weight[j] * p[l][j] * p[k][j];
                sum *= 2.0 * (double)pi;
                worst = fmax(worst, fabs(sum - (l == k)));
                CHECK_NEAR(sum, l == k, 2e-13);
            }
        }
    }
    printf("%-6s orthonormal to %.2g\n", ibl_isa_name(isa), worst);
}

static void orthonormal_to_64(void)
{
    for_each_isa(check_orthonormal);
}

static const test tests[] = {TEST(every_value_to_64),
                             TEST(random_values_to_2048),
                             TEST(extreme_values),
                             TEST(analysis_is_the_direct_sum),
                             TEST(synthesis_is_the_direct_sum),
                             TEST(orthonormal_to_64)};
TEST_MAIN(tests)
