/* SPDX-License-Identifier: MIT */
/*
 * Legendre sums of one order, of every instruction set: the values of P_lm
 * themselves and sums with them, against long double. Rows that step from 0 to
 * 1 at an edge make the analysis give sin^2 P_lm in double.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "kern.h"
#include "kern/legendre.h"
#include "truth.h"

enum {
    PARTS = 6
};

static const long double pi = 3.141592653589793238462643383279502884L;

/* Sine of a ring's angle from the pole. */
static long double sine_of(ibl_ring_kind kind, int rings, int j)
{
    const int edges = kind == IBL_RINGS_EDGES;
    return sinl(pi / 2 / (rings + edges) * (2 * j + 1 + edges));
}

static void true_legendre(ibl_ring_kind kind, int rings, int j, int m,
                          int degree, long double *p)
{
    const int rows = rings + (kind == IBL_RINGS_EDGES);
    truth_legendre(sinl(pi / 2 / rows * (rings - 1 - 2 * j)),
                   sine_of(kind, rings, j), m, degree, p);
}

/* ---- fixture ------------------------------------------------------------ */

typedef struct fixture {
    ibl_legendre_dsp dsp;
    ibl_legendre_rings rings;
    ibl_legendre_order order;
    size_t stride, terms;
    ibl_ring_kind kind;
    int rows;       /* rings or, of edges, what is between them */
    float *f;       /* PARTS x stride: 0, and NaN beyond the rows */
    double *a;      /* of an analysis, */
    float *given;   /* and of a synthesis */
    long double *p; /* terms */
} fixture;

static void make(fixture *x, ibl_isa isa, ibl_ring_kind kind, int rings,
                 int degree, int m)
{
    const size_t scratch = ibl_legendre_scratch(degree);
    *x = (fixture){.stride = ((size_t)rings + 15) / 16 * 16 + 16,
                   .terms = (size_t)(degree - m) + 1,
                   .kind = kind,
                   .rows = rings + (kind == IBL_RINGS_EDGES)};
    ibl_legendre_dsp_init(&x->dsp, isa);
    x->f = kern_alloc(PARTS * x->stride * sizeof *x->f, 64);
    x->a = kern_alloc(PARTS * x->terms * sizeof *x->a, 8);
    x->given = kern_alloc(PARTS * x->terms * sizeof *x->given, 4);
    x->p = kern_alloc(x->terms * sizeof *x->p, sizeof *x->p);
    x->order = (ibl_legendre_order){
        &x->rings, m, degree, degree + 1,
        kern_alloc(scratch * sizeof *x->order.scratch, 64)};
    for (size_t i = 0; i < scratch; i++)
        x->order.scratch[i] = NAN;
    for (size_t i = 0; i < PARTS * x->stride; i++)
        x->f[i] = i % x->stride < (size_t)x->rows ? 0 : NAN;
    if (!ibl_legendre_rings_init(&x->rings, kind, rings, 0, (rings + 1) / 2,
                                 degree))
        exit(1);
}

static float *ring_of(const fixture *x, int part, int j)
{
    return x->f + (size_t)part * x->stride + (size_t)j;
}

static void drop(fixture *x)
{
    int written = 0;
    for (size_t i = 0; i < PARTS * x->stride; i++)
        written += i % x->stride >= (size_t)x->rows && !isnan(x->f[i]);
    CHECK_MSG(!written, "%d written beyond the rows", written);
    ibl_legendre_rings_free(&x->rings);
    kern_free(x->order.scratch);
    kern_free(x->f);
    kern_free(x->a);
    kern_free(x->given);
    kern_free(x->p);
}

/* ---- values ------------------------------------------------------------- */

/*
 * The bound of legendre.h. P_lm is at most about sqrt(l); the rounding of
 * cos theta moves theta by eps / sin theta and P_lm by l times that; near a
 * pole, where P_lm is even or odd in theta, by no more than l^2 eps.
 */
static double value_bound(const fixture *x, int ring, int l)
{
    const double s = (double)sine_of(x->kind, x->rings.count, ring);
    const double n = l + 1.0;
    return DBL_EPSILON * n * sqrt(n) * fmin(n, 2.0 / s) + IBL_LEGENDRE_NOTHING;
}

/* P_lm of six rings at once, against long double. */
static void check_values(ibl_isa isa, int rings, const int ring[PARTS], int m,
                         int degree)
{
    fixture x;
    make(&x, isa, IBL_RINGS_EDGES, rings, degree, m);
    for (int part = 0; part < PARTS; part++)
        for (int j = ring[part] + 1; j < x.rows; j++)
            *ring_of(&x, part, j) = 1;
    x.dsp.analyse(&x.order, x.f, x.stride, x.a);
    for (int part = 0; part < PARTS; part++) {
        const long double s = sine_of(x.kind, rings, ring[part]),
                          square = s * s;
        double worst = 0;
        true_legendre(x.kind, rings, ring[part], m, degree, x.p);
        for (int l = m; l <= degree; l++) {
            const double got = x.a[PARTS * (l - m) + part];
            const double error = (double)fabsl(got / square - x.p[l - m]);
            const double e = error / value_bound(&x, ring[part], l);
            worst = e > worst || isnan(e) ? e : worst;
        }
        CHECK_MSG(worst <= 1, "%s: P_lm, m %d, on ring %d of %d: %.2g of bound",
                  ibl_isa_name(isa), m, ring[part], rings, worst);
    }
    drop(&x);
}

/* To degree 64 all of them; then next to the poles of the finest grid, and
 * where P_mm is 2^-60000. */
static void values_of(ibl_isa isa)
{
    static const int counts[] = {1, 2, 3, 4, 5, 31, 64, 257};
    static const int extreme[PARTS] = {0, 1, 15, 100, 499, 1999};
    static const int of[][3] = {{65536, 4090, 4097},
                                {4000, 16000, 16384},
                                {65536, 0, 1024},
                                {65535, 1, 4096},
                                {65536, 3000, 4096}};
    test_random r = {17};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        const int n = counts[i];
        const int ring[PARTS] = {0, n / 7, n / 4, (n - 1) / 2, n / 2, n - 1};
        for (int m = 0; m <= 64; m++)
            check_values(isa, n, ring, m, 64);
    }
    for (int i = 0; i < (TEST_SANITIZED ? 15 : 60); i++) {
        const int rings = 1 << test_random_below(&r, 15);
        const int degree = test_random_below(&r, 2049);
        const int m = (int)(degree * pow(test_random_unit(&r), 2.0));
        int ring[PARTS];
        for (int k = 0; k < PARTS; k++)
            ring[k] = (int)(rings * pow(test_random_unit(&r), 3.0));
        check_values(isa, rings, ring, m, degree);
    }
    for (int i = 0; i < (TEST_SANITIZED ? 3 : 5); i++)
        check_values(isa, of[i][0], extreme, of[i][1], of[i][2]);
}

KERN_TEST_SLOW(values)

/* ---- sums --------------------------------------------------------------- */

/* Values as maps have them, and others. */
static double hostile(test_random *r)
{
    static const double of[] = {0.0, -0.0, 1e-45, 1e-30, 65504.0, 1e30};
    const int pick = test_random_below(r, 40);
    return pick < 6 ? of[pick] : test_random_between(r, -1, 1);
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
enum {
    SHAPES = sizeof shapes / sizeof shapes[0],
    MAX_DEGREE = 300
};

/* a_lm by the direct sum in long double, and what its error may be. */
static void true_analysis(const fixture *x, int part, long double *sum,
                          double *bound)
{
    const int rings = x->rings.count, m = x->order.m;
    for (size_t l = 0; l < x->terms; l++)
        sum[l] = bound[l] = 0;
    for (int j = 0; j < rings; j++) {
        const float *row = ring_of(x, part, j);
        const long double s = sine_of(x->kind, rings, j);
        const long double f = s * s * ((long double)row[1] - row[0]);
        true_legendre(x->kind, rings, j, m, x->order.degree, x->p);
        for (size_t l = 0; l < x->terms; l++) {
            sum[l] += f * x->p[l];
            bound[l] += (double)fabsl(f) * value_bound(x, j, m + (int)l);
        }
    }
}

/* How much larger errors may be than in doubles. */
static double looseness(const fixture *x)
{
    const bool floats = x->order.single <= x->order.degree;
    return floats ? FLT_EPSILON / DBL_EPSILON : 1;
}

static void analysis_from(ibl_isa isa, int single)
{
    static double bound[MAX_DEGREE + 1];
    static long double sum[MAX_DEGREE + 1];
    test_random r = {5};
    for (int i = 0; i < SHAPES; i++) {
        const int rings = shapes[i][0], degree = shapes[i][1], m = shapes[i][2];
        fixture x;
        make(&x, isa, IBL_RINGS_EDGES, rings, degree, m);
        for (int k = 0; k < PARTS * x.rows; k++)
            *ring_of(&x, k % PARTS, k / PARTS) = (float)hostile(&r);
        x.order.single = single;
        x.dsp.analyse(&x.order, x.f, x.stride, x.a);
        for (int part = 0; part < PARTS; part++) {
            true_analysis(&x, part, sum, bound);
            for (int l = 0; l <= degree - m; l++) {
                const double got = x.a[PARTS * l + part];
                CHECK_MSG(fabs(got - (double)sum[l]) <=
                              bound[l] * looseness(&x),
                          "%s: %d rings, degree %d, m %d, l - m %d: %g, not %g",
                          ibl_isa_name(isa), rings, degree, m, l, got,
                          (double)sum[l]);
            }
        }
        drop(&x);
    }
}

static void analysis_of(ibl_isa isa)
{
    analysis_from(isa, MAX_DEGREE + 1);
}

KERN_TEST_SLOW(analysis)

/* The direct sum for ring j and a part; its bound has the rounding to float. */
static double true_synthesis(const fixture *x, const double *factor, int j,
                             int part, double *bound)
{
    const int m = x->order.m;
    long double sum = 0;
    *bound = 0;
    for (size_t l = 0; l < x->terms; l++) {
        const double c =
            factor[(size_t)m + l] * (double)x->given[PARTS * l + (size_t)part];
        sum += c * x->p[l];
        *bound += fabs(c) * value_bound(x, j, m + (int)l);
    }
    *bound = looseness(x) * *bound +
             (double)FLT_EPSILON / 2 * (double)fabsl(sum) + 1e-45;
    return (double)sum;
}

static void synthesis_from(ibl_isa isa, int single)
{
    static double factor[MAX_DEGREE + 1];
    test_random r = {6};
    for (int i = 0; i < SHAPES; i++) {
        const int rings = shapes[i][0], degree = shapes[i][1], m = shapes[i][2];
        fixture x;
        make(&x, isa, IBL_RINGS_CENTRES, rings, degree, m);
        for (int l = 0; l <= degree; l++)
            factor[l] = hostile(&r);
        for (size_t l = 0; l < PARTS * x.terms; l++)
            x.given[l] = (float)test_random_between(&r, -0.5, 0.5);
        x.order.single = single;
        x.dsp.synthesise(&x.order, x.given, factor, x.f, x.stride);
        for (int j = 0; j < rings; j++) {
            true_legendre(x.kind, rings, j, m, degree, x.p);
            for (int part = 0; part < PARTS; part++) {
                const double got = (double)*ring_of(&x, part, j);
                double bound;
                const double want = true_synthesis(&x, factor, j, part, &bound);
                CHECK_MSG(fabs(got - want) <= bound,
                          "%s: ring %d of %d, degree %d, m %d: %g, not %g",
                          ibl_isa_name(isa), j, rings, degree, m, got, want);
            }
        }
        drop(&x);
    }
}

static void synthesis_of(ibl_isa isa)
{
    synthesis_from(isa, MAX_DEGREE + 1);
}

KERN_TEST(synthesis)

/* From the first degree, and from one in the middle of a block. */
static void floats_of(ibl_isa isa)
{
    for (int single = 0; single <= 37; single += 37) {
        analysis_from(isa, single);
        synthesis_from(isa, single);
    }
}

KERN_TEST_SLOW(floats)

/* ---- rows --------------------------------------------------------------- */

/* Sums over `rows` rows between rows / 2 + 1 edges; NaN is between the parts.
 */
static void check_rows(ibl_isa isa, int from, int rows, test_random *r)
{
    const size_t n = (size_t)rows, stride = n + 5, edges = n / 2 + 1;
    double *edge = kern_alloc(edges * sizeof *edge, sizeof *edge);
    float *f = kern_alloc((5 * stride + n) * sizeof *f, sizeof *f);
    double sum[PARTS];
    ibl_legendre_dsp dsp;

    ibl_legendre_dsp_init(&dsp, isa);
    for (size_t j = 0; j < edges; j++)
        edge[j] = test_random_unit(r);
    for (size_t j = 0; j < 5 * stride + n; j++)
        f[j] = j % stride < n ? (float)test_random_between(r, -1, 1) : NAN;
    for (int p = 0; p < PARTS; p++)
        sum[p] = p;
    dsp.add_rows(edge, from, rows / 2, rows, f, stride, sum);
    for (int p = 0; p < PARTS; p++) {
        const float *part = f + (size_t)p * stride;
        long double want = p;
        for (int j = from; j < rows / 2; j++)
            want += ((long double)edge[j] - edge[j + 1]) *
                    ((long double)part[j] + part[rows - 1 - j]);
        CHECK_MSG(fabs(sum[p] - (double)want) <= DBL_EPSILON * (rows + 8),
                  "%s: rows %d..%d of %d: %g, not %g", ibl_isa_name(isa), from,
                  rows / 2 - 1, rows, sum[p], (double)want);
    }
    kern_free(edge);
    kern_free(f);
}

static void rows_of(ibl_isa isa)
{
    test_random r = {7};
    for (int rows = 1; rows < 70; rows++)
        for (int from = 0; from <= rows / 2; from += 1 + from)
            check_rows(isa, from, rows, &r);
}

KERN_TEST(rows)
