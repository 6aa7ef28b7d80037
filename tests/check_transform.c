/* SPDX-License-Identifier: MIT */
/*
 * The spherical harmonic transform, by every instruction set, against direct
 * sums and integrals in long double.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bake/spectral/transform.h"
#include "core/alloc.h"
#include "kern.h"
#include "kern/legendre.h"
#include "truth.h"

enum {
    PARTS = 6
};

static const long double long_pi = 3.141592653589793238462643383279502884L;

/* Aligned, until the running test ends. */
static void *memory(size_t n, size_t size)
{
    void *p = ibl_alloc_zeroed(n, size);
    NEED(p);
    test_defer(ibl_free, p);
    return p;
}

static ibl_ring_spectra make_spectra(ibl_ctx *ctx, int rings, int orders)
{
    ibl_ring_spectra s;

    if (ibl_ring_spectra_alloc(ctx, rings, orders, &s))
        exit(1);
    for (size_t i = 0; i < 6 * (size_t)orders * s.stride; i++)
        s.data[i] = NAN;
    return s;
}

static ibl_harmonics make_harmonics(ibl_ctx *ctx, int degree)
{
    ibl_harmonics h;

    if (ibl_harmonics_alloc(ctx, degree, &h))
        exit(1);
    for (size_t i = 0; i < 3 * (size_t)(degree + 1) * (size_t)(degree + 2); i++)
        h.data[i] = NAN;
    return h;
}

/* All six parts of a_lm. */
static float *at(const ibl_harmonics *h, int l, int m)
{
    return ibl_harmonics_at(h, m) + 6 * (size_t)(l - m);
}

/* The analysis of rows, whose spectra are those of rings. */
static ibl_status analyse(ibl_ctx *ctx, const ibl_ring_spectra *in,
                          const double *width, ibl_harmonics *out)
{
    ibl_row_spectra rows;

    if (ibl_row_spectra_alloc(ctx, in->rings, in->orders - 1, &rows))
        exit(1);
    for (int g = 0; g < rows.groups; g++)
        for (int i = 0; i < ibl_row_spectra_orders(&rows, g) * PARTS; i++)
            for (int j = 0; j < IBL_ROW_GROUP; j++) {
                const int row = g * IBL_ROW_GROUP + j;
                ibl_row_spectra_at(&rows, g, 0, i)[j] =
                    row < in->rings ? ibl_ring_spectra_at(in, 0, i)[row] : NAN;
            }
    const ibl_status status = ibl_sht_analyse(ctx, NULL, &rows, width, out);
    ibl_row_spectra_free(&rows);
    return status;
}

static void random_spectra(const ibl_ring_spectra *s, test_random *rnd)
{
    for (int m = 0; m < s->orders; m++) {
        for (int part = 0; part < PARTS; part++) {
            float *f = ibl_ring_spectra_at(s, m, part);
            for (int j = 0; j < s->rings; j++)
                f[j] = (float)(test_random_unit(rnd) - 0.5);
        }
    }
}

/* a_l0 is real. */
static void random_harmonics(const ibl_harmonics *h, test_random *rnd)
{
    for (int m = 0; m <= h->degree; m++) {
        for (int l = m; l <= h->degree; l++) {
            for (int part = 0; part < PARTS; part++)
                at(h, l, m)[part] = m || part % 2 == 0
                                        ? (float)(test_random_unit(rnd) - 0.5)
                                        : 0;
        }
    }
}

/*
 * p[l - m] = P_lm(x) for l = m..degree, s = sqrt(1 - x^2) to its own last bits:
 * without the Condon-Shortley phase, the integral of the square over -1..1
 * being 1 / (2 pi). The recurrence in l of P_lm / (2m - 1)!! s^m, times
 * sqrt((2l + 1) / 4 pi (l - m)! / (l + m)!) (2m - 1)!! s^m, whose logarithm is
 * kept; what grows is scaled.
 */
static void true_legendre(long double x, long double s, int m, int degree,
                          long double *p)
{
    long double q = 1, last = 0, shift = 0, scale = m * log2l(s);

    for (int i = 1; i <= m;
         i++) /* (2m - 1)!!^2 / (2m)! = (2m - 1)!! / (2m)!! */
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
        p[l - m] =
            q * exp2l(scale + shift) * sqrtl((2 * l + 1) / (4 * long_pi));
    }
}

/* The bound of P_lm in kern/legendre.h, at the sine of a ring. */
static double legendre_bound(double s, int l)
{
    const double n = l + 1.0;

    return DBL_EPSILON * n * sqrt(n) * fmin(n, 2.0 / s) + IBL_LEGENDRE_NOTHING;
}

/* ---- values --------------------------------------------------------- */

/* P_lm of six rings at once: rows that step from 0 to 1 at a ring make the
 * analysis give sin^2 P_lm in double. */
static void check_values(ibl_isa isa, int rings, const int ring[PARTS], int m,
                         int degree)
{
    const size_t terms = (size_t)(degree - m) + 1;
    const size_t stride = ((size_t)rings + 15) / 16 * 16 + 16;
    float *f = memory(PARTS * stride, sizeof *f);
    double *a = memory(PARTS * terms, sizeof *a);
    long double *p = memory(terms, sizeof *p);
    ibl_legendre_rings all;
    const ibl_legendre_order order = {
        &all, m, degree, degree + 1,
        memory(ibl_legendre_scratch(degree), sizeof(double))};
    ibl_legendre_dsp dsp;

    ibl_legendre_dsp_init(&dsp, isa);
    NEED(ibl_legendre_rings_init(&all, IBL_RINGS_EDGES, rings, 0,
                                 (rings + 1) / 2, degree));
    for (int part = 0; part < PARTS; part++)
        for (int j = ring[part] + 1; j <= rings; j++)
            f[(size_t)part * stride + (size_t)j] = 1;
    dsp.analyse(&order, f, stride, a);
    for (int part = 0; part < PARTS; part++) {
        const long double half = long_pi / 2 / (rings + 1);
        const long double s = sinl(half * (2 * ring[part] + 2));
        double worst = 0;
        true_legendre(sinl(half * (rings - 1 - 2 * ring[part])), s, m, degree,
                      p);
        for (size_t l = 0; l < terms; l++) {
            const long double got = a[PARTS * l + (size_t)part] / (s * s);
            const double e = (double)fabsl(got - p[l]) /
                             legendre_bound((double)s, m + (int)l);
            worst = e > worst || isnan(e) ? e : worst;
        }
        CHECK_MSG(worst <= 1, "%s: P_lm, m %d, on ring %d of %d: %.2g of bound",
                  ibl_isa_name(isa), m, ring[part], rings, worst);
    }
    ibl_legendre_rings_free(&all);
}

/* To degree 64 all of them; then next to the poles of the finest grid, and
 * where P_mm is 2^-60000. */
static void values_of(ibl_isa isa)
{
    static const int extreme[PARTS] = {0, 1, 15, 100, 499, 1999};
    static const int of[][3] = {{65536, 4090, 4097},
                                {4000, 16000, 16384},
                                {65536, 0, 1024},
                                {65535, 1, 4096}};
    for (int n = 1; n < 258; n = 2 * n + 1) {
        const int ring[PARTS] = {0, n / 7, n / 4, (n - 1) / 2, n / 2, n - 1};
        for (int m = 0; m <= 64; m++)
            check_values(isa, n, ring, m, 64);
    }
    for (int i = 0; i < 4; i++)
        check_values(isa, of[i][0], extreme, of[i][1], of[i][2]);
}

KERN_TEST_SLOW(values)

/* ---- direct sums ---------------------------------------------------- */

/* One order of a synthesis, on every ring. */
static void check_synthesis(const ibl_harmonics *h, const double *factor,
                            int degree, const ibl_ring_spectra *s, int m)
{
    const int terms = degree - m + 1;
    const long double half = long_pi / 2 / s->rings;
    long double *p = memory((size_t)degree + 1, sizeof *p);
    int single = degree + 1; /* floats from here on */
    while (single > 0 && fabs(factor[single - 1]) < IBL_SHT_SMALL)
        single--;

    for (int j = 0; j < s->rings; j++) {
        const double sine = sin(M_PI * (j + 0.5) / s->rings);
        long double sum[PARTS] = {0};
        double bound[PARTS] = {0};
        if (terms > 0)
            true_legendre(sinl(half * (s->rings - 1 - 2 * j)),
                          sinl(half * (2 * j + 1)), m, degree, p);
        for (int i = 0; i < PARTS * terms; i++) {
            const double c = factor[m + i / 6] * (double)at(h, m, m)[i];
            sum[i % 6] += c * p[i / 6];
            bound[i % 6] += fabs(c) * legendre_bound(sine, m + i / 6);
            if (m + i / 6 >= single)
                bound[i % 6] += 2e-6 * fabs(c);
        }
        for (int part = 0; part < PARTS; part++) {
            const double got = ibl_ring_spectra_at(s, m, part)[j];
            const double limit =
                bound[part] + FLT_EPSILON / 2 * (double)fabsl(sum[part]);
            CHECK_MSG(fabs((double)(got - sum[part])) <= limit,
                      "ring %d of %d, degree %d, m %d: %.9g, not %.9Lg", j,
                      s->rings, degree, m, got, sum[part]);
        }
    }
}

static void check_rings(ibl_ctx *ctx, int rings, int degree, int step)
{
    test_random rnd = {(uint64_t)(rings * 1000 + degree)};
    ibl_ring_spectra out = make_spectra(ctx, rings, degree + 2);
    ibl_harmonics h = make_harmonics(ctx, degree);
    double *factor = memory((size_t)degree + 1, sizeof *factor);
    const int less = degree - degree / 5;

    random_harmonics(&h, &rnd);
    for (int l = 0; l <= degree; l++)
        factor[l] = test_random_unit(&rnd);
    CHECK(!ibl_sht_synthesise(ctx, &h, factor, less, rings, 0, &out));
    for (int m = 0; m <= less; m += step)
        check_synthesis(&h, factor, less, &out, m);
    CHECK(isnan(ibl_ring_spectra_at(&out, less + 1, 0)[0]));
    ibl_ring_spectra_free(&out);
    ibl_harmonics_free(&h);
}

static void rings_of_harmonics_of(ibl_isa isa)
{
    ibl_ctx *ctx = test_ctx(2, isa);
    static const int rings[] = {1, 2, 3, 4, 5, 8, 15, 16, 17, 33};
    static const int degrees[] = {0, 1, 2, 3, 8, 21};

    for (int k = 0; k < 60; k++)
        check_rings(ctx, rings[k / 6], degrees[k % 6], 1);
    check_rings(ctx, 96, 64, 1);
    check_rings(ctx, 131, 300, 60);
    if (!TEST_SANITIZED)
        check_rings(ctx, 9, 2048, 293);
}

KERN_TEST(rings_of_harmonics)

/* ---- rows of patches ------------------------------------------------ */

enum {
    POINTS = 8 /* of a panel */
};

/* The integral of P_lm over a row, l = m..degree, by panels under a radian. */
static void row_integral(int rows, int j, int m, int degree, long double *sum)
{
    const int panels = 1 + (int)(4.0 * (degree + 1) / rows);
    const size_t terms = (size_t)(degree - m) + 1;
    long double node[POINTS], weight[POINTS], *p = memory(terms, sizeof *p);

    truth_gauss(POINTS, node, weight);
    memset(sum, 0, terms * sizeof *sum);
    for (int k = 0; k < panels * POINTS; k++) {
        const long double at = k / POINTS + 0.5L + 0.5L * node[k % POINTS];
        const long double theta = long_pi * (j + at / panels) / rows;
        const long double mass =
            weight[k % POINTS] * 0.5L * long_pi / rows / panels * sinl(theta);
        true_legendre(cosl(theta), sinl(theta), m, degree, p);
        for (size_t l = 0; l < terms; l++)
            sum[l] += mass * p[l];
    }
}

/* One order. Errors at the edges add up by degree, and Q is P / l. */
static void check_patches(const ibl_ring_spectra *s, const double *width,
                          const ibl_harmonics *h, int m)
{
    const size_t terms = (size_t)(h->degree - m) + 1;
    long double *row = memory(terms, sizeof *row);
    long double *sum = memory(PARTS * terms, sizeof *sum);
    double *all = memory(PARTS, sizeof *all);

    for (int j = 0; j < s->rings; j++) {
        row_integral(s->rings, j, m, h->degree, row);
        for (size_t i = 0; i < PARTS * terms; i++) {
            const float f = ibl_ring_spectra_at(s, m, (int)(i % 6))[j];
            sum[i] += width[m] * (long double)f * row[i / 6];
        }
        for (int part = 0; part < PARTS; part++)
            all[part] += fabs((double)ibl_ring_spectra_at(s, m, part)[j]);
    }
    for (size_t i = 0; i < PARTS * terms; i++) {
        const double l = (double)m + (double)(i / 6) + 1;
        const double got = (double)at(h, m, m)[i];
        const double unit = l > h->single ? FLT_EPSILON : DBL_EPSILON;
        const double limit =
            unit * fabs(width[m]) * all[i % 6] * (4 + l * sqrt(l)) +
            FLT_EPSILON / 2 * (double)fabsl(sum[i]);
        CHECK_MSG(fabs((double)(got - sum[i])) <= limit,
                  "%d rows, l %g, m %d: %.17g, not %.17Lg (within %.2g)",
                  s->rings, l - 1, m, got, sum[i], limit);
    }
}

static void check_rows(ibl_ctx *ctx, int rows, int degree, int step)
{
    test_random rnd = {(uint64_t)(rows * 100 + degree)};
    ibl_ring_spectra in = make_spectra(ctx, rows, degree + 1);
    ibl_harmonics h = make_harmonics(ctx, degree);
    double *width = memory((size_t)degree + 1, sizeof *width);

    random_spectra(&in, &rnd);
    for (int m = 0; m <= degree; m++) {
        width[m] = test_random_unit(&rnd) - 0.5;
        /* A sun, on a row that is not the same for all. */
        ibl_ring_spectra_at(&in, m, 2)[m % rows] = 1e5f;
    }
    h.single = rows % 2 ? degree + 1 : degree / 3; /* floats from there on */
    CHECK(analyse(ctx, &in, width, &h) == IBL_OK);
    for (int m = 0; m <= degree; m += step)
        check_patches(&in, width, &h, m);
    ibl_ring_spectra_free(&in);
    ibl_harmonics_free(&h);
}

static void rows_of_patches_of(ibl_isa isa)
{
    ibl_ctx *ctx = test_ctx(2, isa);
    static const int rows[] = {1, 2, 3, 4, 7, 16, 17, 32, 65};

    for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
        check_rows(ctx, rows[r], 0, 1);
        check_rows(ctx, rows[r], 9, 1);
        check_rows(ctx, rows[r], 60, 29);
    }
    if (!TEST_SANITIZED)
        check_rows(ctx, 40, 260, 129);
}

TEST_OF(rows_of_patches, "rows_of_patches", TEST_RACES || !TEST_SANITIZED)
{
    kern_each_isa(rows_of_patches_of);
}
