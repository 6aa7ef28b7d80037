/* SPDX-License-Identifier: MIT */
/*
 * The spherical harmonic transform against direct sums in long double, closed
 * forms (point lights, turned maps, powers) and itself (there and back,
 * threads, instruction sets).
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/spectral/transform.h"
#include "core/alloc.h"
#include "core/cpu.h"
#include "test.h"
#include "truth.h"

enum {
    PARTS = 6
};

static const double pi = 3.14159265358979323846;
static const long double long_pi = 3.141592653589793238462643383279502884L;

static void *memory(size_t n, size_t size)
{
    void *p = ibl_alloc_zeroed(n, size);

    if (!p)
        exit(1);
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
static double *at(const ibl_harmonics *h, int l, int m)
{
    return ibl_harmonics_at(h, m) + 6 * (size_t)(l - m);
}

static size_t harmonics_bytes(const ibl_harmonics *h)
{
    return 3 * (size_t)(h->degree + 1) * (size_t)(h->degree + 2) *
           sizeof *h->data;
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
                at(h, l, m)[part] =
                    m || part % 2 == 0 ? test_random_unit(rnd) - 0.5 : 0.0;
        }
    }
}

static double *filled(size_t n, double value)
{
    double *p = memory(n, sizeof *p);

    for (size_t i = 0; i < n; i++)
        p[i] = value;
    return p;
}

/* P_lm of a ring for l = m..degree. */
static void ring_legendre(int rings, int j, int m, int degree, long double *p)
{
    const long double half = long_pi / 2 / rings;

    truth_legendre(sinl(half * (rings - 1 - 2 * j)), sinl(half * (2 * j + 1)),
                   m, degree, p);
}

/* The bound of P_lm in transform.h. */
static double legendre_bound(int rings, int j, int l)
{
    const double s = sin(pi * (j + 0.5) / rings), n = l + 1.0;

    return DBL_EPSILON * (n * sqrt(n) * fmin(n, 2.0 / s) + 1.0);
}

static const ibl_isa isas[] = {IBL_ISA_C, IBL_ISA_SSE2, IBL_ISA_AVX2,
                               IBL_ISA_AVX512};

/* ---- direct sums ---------------------------------------------------- */

/* One order of an analysis, all degrees and parts. */
static void check_analysis(const ibl_ring_spectra *s, const double *weight,
                           const ibl_harmonics *h, int m)
{
    const size_t terms = (size_t)(h->degree - m) + 1;
    long double *p = memory(terms, sizeof *p);
    long double *sum = memory(PARTS * terms, sizeof *sum);
    double *bound = memory(PARTS * terms, sizeof *bound);

    for (int j = 0; j < s->rings && m < s->orders; j++) {
        ring_legendre(s->rings, j, m, h->degree, p);
        for (size_t i = 0; i < PARTS * terms; i++) {
            const long double f = weight[j] * (long double)ibl_ring_spectra_at(
                                                  s, m, (int)(i % 6))[j];
            sum[i] += f * p[i / 6];
            bound[i] += (double)fabsl(f) *
                        legendre_bound(s->rings, j, m + (int)(i / 6));
        }
    }
    for (size_t i = 0; i < PARTS * terms; i++)
        CHECK_MSG(fabs((double)(at(h, m, m)[i] - sum[i])) <= bound[i],
                  "%d rings, l %zu, m %d: %.17g, not %.17Lg", s->rings,
                  (size_t)m + i / 6, m, at(h, m, m)[i], sum[i]);
    ibl_free(p);
    ibl_free(sum);
    ibl_free(bound);
}

/* One order of a synthesis, on every ring. */
static void check_synthesis(const ibl_harmonics *h, const double *factor,
                            int degree, const ibl_ring_spectra *s, int m)
{
    const int terms = degree - m + 1;
    long double *p = memory((size_t)degree + 1, sizeof *p);

    for (int j = 0; j < s->rings; j++) {
        long double sum[PARTS] = {0};
        double bound[PARTS] = {0};
        if (terms > 0)
            ring_legendre(s->rings, j, m, degree, p);
        for (int i = 0; i < PARTS * terms; i++) {
            const double c = factor[m + i / 6] * at(h, m, m)[i];
            sum[i % 6] += c * p[i / 6];
            bound[i % 6] += fabs(c) * legendre_bound(s->rings, j, m + i / 6);
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
    ibl_free(p);
}

/* Both directions, all orders up to step apart. */
static void check_shape(ibl_ctx *ctx, int rings, int degree, int orders,
                        int step)
{
    test_random rnd = {(uint64_t)(rings * 1000 + degree)};
    ibl_ring_spectra in = make_spectra(ctx, rings, orders);
    ibl_ring_spectra out = make_spectra(ctx, rings, degree + 2);
    ibl_harmonics h = make_harmonics(ctx, degree);
    double *weight = memory((size_t)rings, sizeof *weight);
    double *factor = memory((size_t)degree + 1, sizeof *factor);
    const int less = degree - degree / 5;

    random_spectra(&in, &rnd);
    for (int j = 0; j < rings; j++)
        weight[j] = test_random_unit(&rnd);
    for (int l = 0; l <= degree; l++)
        factor[l] = test_random_unit(&rnd);
    CHECK(ibl_sht_analyse(ctx, NULL, &in, weight, &h) == IBL_OK);
    for (int m = 0; m <= degree; m += step)
        check_analysis(&in, weight, &h, m);
    CHECK(ibl_sht_synthesise(ctx, NULL, &h, factor, less, &out) == IBL_OK);
    for (int m = 0; m <= degree + 1; m += step)
        check_synthesis(&h, factor, less, &out, m);
    ibl_ring_spectra_free(&in);
    ibl_ring_spectra_free(&out);
    ibl_harmonics_free(&h);
    ibl_free(weight);
    ibl_free(factor);
}

static void direct_sums(void)
{
    static const int rings[] = {1, 2, 3, 4, 5, 8, 15, 16, 17, 33};
    static const int degrees[] = {0, 1, 2, 3, 8, 21};

    for (size_t i = 0; i < sizeof isas / sizeof isas[0]; i++) {
        if (!ibl_cpu_has(isas[i]))
            continue;
        ibl_ctx *ctx = test_ctx(2, isas[i]);
        for (size_t r = 0; r < sizeof rings / sizeof rings[0]; r++) {
            for (size_t d = 0; d < sizeof degrees / sizeof degrees[0]; d++) {
                const int n = degrees[d];
                check_shape(ctx, rings[r], n, n / 2 + 1, 1);
                check_shape(ctx, rings[r], n, n + 3, 1);
            }
        }
        check_shape(ctx, 96, 64, 65, 1);
        check_shape(ctx, 131, 300, 301, 60);
        check_shape(ctx, 700, 100, 101, 25);
        if (!TEST_SANITIZED)
            check_shape(ctx, 9, 2048, 2049, 293);
        ibl_ctx_free(ctx);
    }
}

/* ---- there and back ------------------------------------------------- */

/* Weights for the integral over x (Fejer's first rule): exact for products of
 * two functions of degree below half the number of rings. */
static double *fejer(int rings)
{
    double *weight = memory((size_t)rings, sizeof *weight);

    for (int j = 0; j < rings; j++) {
        const double theta = pi * (j + 0.5) / rings;
        double sum = 1.0;
        for (int k = 1; k <= rings / 2; k++)
            sum -= 2.0 * cos(2.0 * k * theta) / (4.0 * k * k - 1.0);
        /* Twice 2 pi: the integral of P^2 is 1 / (2 pi). */
        weight[j] = 2.0 / rings * sum * 2.0 * pi;
    }
    return weight;
}

static void check_round_trip(ibl_ctx *ctx, int rings, int degree)
{
    test_random rnd = {3};
    ibl_harmonics h = make_harmonics(ctx, degree);
    ibl_harmonics back = make_harmonics(ctx, degree);
    ibl_ring_spectra s = make_spectra(ctx, rings, degree + 1);
    double *weight = fejer(rings), *ones = filled((size_t)degree + 1, 1.0);
    double worst = 0.0;

    random_harmonics(&h, &rnd);
    CHECK(ibl_sht_synthesise(ctx, NULL, &h, ones, degree, &s) == IBL_OK);
    CHECK(ibl_sht_analyse(ctx, NULL, &s, weight, &back) == IBL_OK);
    for (size_t i = 0; i < harmonics_bytes(&h) / sizeof *h.data; i++)
        worst = fmax(worst, fabs(h.data[i] - back.data[i]));
    for (int l = 0; l <= degree; l++)
        CHECK(at(&back, l, 0)[1] == 0.0 && at(&back, l, 0)[5] == 0.0);
    /* The spectra, about sqrt(degree) large, are rounded to floats; that
     * averages over the rings. */
    CHECK_MSG(worst <= 4.0 * FLT_EPSILON, "%d rings, degree %d: %g", rings,
              degree, worst);
    ibl_harmonics_free(&h);
    ibl_harmonics_free(&back);
    ibl_ring_spectra_free(&s);
    ibl_free(weight);
    ibl_free(ones);
}

static void round_trip(void)
{
    for (size_t i = 0; i < sizeof isas / sizeof isas[0]; i++) {
        if (!ibl_cpu_has(isas[i]))
            continue;
        ibl_ctx *ctx = test_ctx(2, isas[i]);
        check_round_trip(ctx, 1, 0);
        check_round_trip(ctx, 5, 1);
        check_round_trip(ctx, 64, 31);
        check_round_trip(ctx, 301, 150);
        check_round_trip(ctx, 640, 100);
        ibl_ctx_free(ctx);
    }
}

/* ---- point lights --------------------------------------------------- */

/* The spectra of a light of energy (1, 2, -3) on ring j at phi. */
static ibl_harmonics point_light(ibl_ctx *ctx, int rings, int j, double phi,
                                 int degree)
{
    static const double energy[] = {1.0, 2.0, -3.0};
    ibl_ring_spectra s = make_spectra(ctx, rings, degree + 1);
    ibl_harmonics h = make_harmonics(ctx, degree);
    double *ones = filled((size_t)rings, 1.0);

    memset(s.data, 0, 6 * (size_t)s.orders * s.stride * sizeof *s.data);
    for (int m = 0; m <= degree; m++) {
        for (int part = 0; part < PARTS; part++)
            ibl_ring_spectra_at(&s, m, part)[j] =
                (float)(energy[part / 2] *
                        (part % 2 ? -sin(m * phi) : cos(m * phi)));
    }
    CHECK(ibl_sht_analyse(ctx, NULL, &s, ones, &h) == IBL_OK);
    ibl_ring_spectra_free(&s);
    ibl_free(ones);
    return h;
}

/* A turn about the axis is a phase. */
static void turned_about_the_axis(void)
{
    enum {
        DEGREE = 40,
        RINGS = 50
    };
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const double turn = 1.234;
    ibl_harmonics a = point_light(ctx, RINGS, 12, 0.4, DEGREE);
    ibl_harmonics b = point_light(ctx, RINGS, 12, 0.4 + turn, DEGREE);

    for (int m = 0; m <= DEGREE; m++) {
        for (int l = m; l <= DEGREE; l++) {
            const double *p = at(&a, l, m), *q = at(&b, l, m);
            const double c = cos(m * turn), e = sin(m * turn);
            CHECK_NEAR(q[4], p[4] * c + p[5] * e, 3e-6);
            CHECK_NEAR(q[5], p[5] * c - p[4] * e, 3e-6);
        }
    }
    ibl_harmonics_free(&a);
    ibl_harmonics_free(&b);
    ibl_ctx_free(ctx);
}

/* Ring j at phi in the world's axes. */
static void direction(int rings, int j, double phi, double d[3])
{
    const double theta = pi * (j + 0.5) / rings;

    d[0] = sin(theta) * cos(phi);
    d[1] = cos(theta);
    d[2] = sin(theta) * sin(phi);
}

/*
 * A light's coefficients about +Z are its energy times the basis functions in
 * its direction: what a quarter turn of the axes by sh_rotate must give.
 */
static void turned_to_another_axis(void)
{
    enum {
        DEGREE = 20,
        RINGS = 31
    };
    static double sh[3 * (DEGREE + 1) * (DEGREE + 1)];
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int j = 0; j < RINGS; j += 3) {
        const double phi = 0.7 * j - 2.0, yaw = 10.0 * j;
        ibl_harmonics h = point_light(ctx, RINGS, j, phi, DEGREE);
        double d[3];
        direction(RINGS, j, phi - yaw / 180.0 * pi, d);
        CHECK(ibl_sht_to_sh(ctx, &h, DEGREE, yaw, sh) == IBL_OK);
        for (int l = 0; l <= DEGREE; l++) {
            for (int m = -l; m <= l; m++) {
                const double *c = sh + 3 * (l * (l + 1) + m);
                CHECK_NEAR(c[0], truth_sh(l, m, d), 1e-6);
                CHECK_NEAR(c[2], -3.0 * truth_sh(l, m, d), 3e-6);
            }
        }
        ibl_harmonics_free(&h);
    }
    ibl_ctx_free(ctx);
}

/*
 * A light is on a ring about +Y and on one about +Z. Its coefficients about
 * +Y, brought to +Z, are those of the map turned by a quarter, in which the
 * light is seen about the pole as it was about +Z.
 */
static void turned_map(void)
{
    enum {
        DEGREE = 64,
        RINGS = 17,
        ABOUT_Y = 3, /* rings */
        ABOUT_Z = 5
    };
    static double sh[3 * (DEGREE + 1) * (DEGREE + 1)];
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const double theta = pi * (ABOUT_Y + 0.5) / RINGS;
    const double z = cos(pi * (ABOUT_Z + 0.5) / RINGS);
    const double phi = asin(z / sin(theta));
    /* About +Z the azimuth runs from +X to +Y. */
    const double azimuth = atan2(cos(theta), sin(theta) * cos(phi));
    ibl_harmonics a = point_light(ctx, RINGS, ABOUT_Y, phi, DEGREE);
    ibl_harmonics b = point_light(ctx, RINGS, ABOUT_Z, azimuth, DEGREE);

    CHECK(ibl_sht_to_sh(ctx, &a, DEGREE, 0.0, sh) == IBL_OK);
    for (int m = 0; m <= DEGREE; m++) {
        const double g = m ? sqrt(2.0) : 1.0;
        for (int l = m; l <= DEGREE; l++) {
            const double *c = at(&b, l, m);
            CHECK_NEAR(sh[3 * (l * (l + 1) + m)], g * c[0], 3e-6);
            if (m)
                CHECK_NEAR(sh[3 * (l * (l + 1) - m)], -g * c[1], 3e-6);
        }
    }
    ibl_harmonics_free(&a);
    ibl_harmonics_free(&b);
    ibl_ctx_free(ctx);
}

/* Unsoeld's theorem: |E|^2 (2l + 1) / 4 pi, wherever the light is. */
static void power(void)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);

    for (int j = 0; j < 20; j++) {
        ibl_harmonics h = point_light(ctx, 20, j, 0.3 * j, 50);
        double got[51];
        ibl_sht_power(&h, got);
        for (int l = 0; l <= 50; l++) {
            const double want = 14.0 * (2 * l + 1) / (4.0 * pi);
            CHECK_NEAR(got[l], want, 1e-6 * want);
        }
        ibl_harmonics_free(&h);
    }
    ibl_ctx_free(ctx);
}

/* ---- rows of patches ------------------------------------------------ */

enum {
    POINTS = 8 /* of a panel */
};

/* The rule of Gauss and Legendre on -1..1, by Newton's method on P_8. */
static void gauss(long double node[POINTS], long double weight[POINTS])
{
    for (int i = 0; i < POINTS; i++) {
        long double x = cosl(long_pi * (i + 0.75L) / (POINTS + 0.5L)), slope;
        for (int step = 0; step < 10; step++) {
            long double p = 1, below = 0;
            for (int l = 0; l < POINTS; l++) {
                const long double next =
                    ((2 * l + 1) * x * p - l * below) / (l + 1);
                below = p;
                p = next;
            }
            slope = POINTS * (x * p - below) / (x * x - 1);
            x -= p / slope;
        }
        node[i] = x;
        weight[i] = 2 / ((1 - x * x) * slope * slope);
    }
}

/* The integral of P_lm over a row, l = m..degree, in panels of less than a
 * radian of the highest degree. */
static void row_integral(int rows, int j, int m, int degree, long double *sum)
{
    const int panels = 1 + (int)(4.0 * (degree + 1) / rows);
    const size_t terms = (size_t)(degree - m) + 1;
    long double node[POINTS], weight[POINTS], *p = memory(terms, sizeof *p);

    gauss(node, weight);
    memset(sum, 0, terms * sizeof *sum);
    for (int k = 0; k < panels * POINTS; k++) {
        const long double at = k / POINTS + 0.5L + 0.5L * node[k % POINTS];
        const long double theta = long_pi * (j + at / panels) / rows;
        const long double mass =
            weight[k % POINTS] * 0.5L * long_pi / rows / panels * sinl(theta);
        truth_legendre(cosl(theta), sinl(theta), m, degree, p);
        for (size_t l = 0; l < terms; l++)
            sum[l] += mass * p[l];
    }
    ibl_free(p);
}

/* One order. Errors of the functions at the edges are summed up by degree,
 * and Q is P / l. */
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
        const double l = (double)m + (double)(i / 6) + 1, got = at(h, m, m)[i];
        const double limit =
            DBL_EPSILON * fabs(width[m]) * all[i % 6] * (4 + l * sqrt(l));
        CHECK_MSG(fabs((double)(got - sum[i])) <= limit,
                  "%d rows, l %g, m %d: %.17g, not %.17Lg (within %.2g)",
                  s->rings, l - 1, m, got, sum[i], limit);
    }
    ibl_free(row);
    ibl_free(sum);
    ibl_free(all);
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
    CHECK(ibl_sht_analyse_patches(ctx, NULL, &in, width, &h) == IBL_OK);
    for (int m = 0; m <= degree; m += step)
        check_patches(&in, width, &h, m);
    ibl_ring_spectra_free(&in);
    ibl_harmonics_free(&h);
    ibl_free(width);
}

static void rows_of_patches(void)
{
    static const int rows[] = {1, 2, 3, 4, 7, 16, 17, 32, 65};

    for (size_t i = 0; i < sizeof isas / sizeof isas[0]; i++) {
        if (!ibl_cpu_has(isas[i]))
            continue;
        ibl_ctx *ctx = test_ctx(2, isas[i]);
        for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
            check_rows(ctx, rows[r], 0, 1);
            check_rows(ctx, rows[r], 9, 1);
            check_rows(ctx, rows[r], 60, 29);
        }
        if (!TEST_SANITIZED)
            check_rows(ctx, 40, 260, 129);
        ibl_ctx_free(ctx);
    }
}

/* ---- threads, sets, refusals ---------------------------------------- */

struct run {
    ibl_harmonics h;
    ibl_ring_spectra s;
};

static struct run run_both(int threads, ibl_isa isa)
{
    enum {
        DEGREE = 70,
        RINGS = 151
    };
    ibl_ctx *ctx = test_ctx(threads, isa);
    test_random rnd = {4};
    ibl_ring_spectra in = make_spectra(ctx, RINGS, DEGREE + 1);
    struct run r = {make_harmonics(ctx, DEGREE),
                    make_spectra(ctx, RINGS, DEGREE + 1)};
    double *ones = filled(RINGS, 1.0 / RINGS);

    random_spectra(&in, &rnd);
    CHECK(ibl_sht_analyse(ctx, NULL, &in, ones, &r.h) == IBL_OK);
    memset(r.s.data, 0, 6 * (size_t)r.s.orders * r.s.stride * sizeof(float));
    CHECK(ibl_sht_synthesise(ctx, NULL, &r.h, ones, DEGREE, &r.s) == IBL_OK);
    ibl_ring_spectra_free(&in);
    ibl_free(ones);
    ibl_ctx_free(ctx);
    return r;
}

static void drop_run(struct run *r)
{
    ibl_harmonics_free(&r->h);
    ibl_ring_spectra_free(&r->s);
}

static void same_for_any_threads(void)
{
    static const int threads[] = {2, 3, 7};

    for (size_t i = 0; i < sizeof isas / sizeof isas[0]; i++) {
        if (!ibl_cpu_has(isas[i]))
            continue;
        struct run one = run_both(1, isas[i]);
        for (size_t t = 0; t < sizeof threads / sizeof threads[0]; t++) {
            struct run r = run_both(threads[t], isas[i]);
            CHECK(!memcmp(r.h.data, one.h.data, harmonics_bytes(&r.h)));
            CHECK(!memcmp(r.s.data, one.s.data,
                          6 * (size_t)r.s.orders * r.s.stride * sizeof(float)));
            drop_run(&r);
        }
        drop_run(&one);
    }
}

static void sets_agree(void)
{
    struct run plain = run_both(1, IBL_ISA_C);

    for (size_t i = 1; i < sizeof isas / sizeof isas[0]; i++) {
        if (!ibl_cpu_has(isas[i]))
            continue;
        struct run r = run_both(1, isas[i]);
        for (size_t k = 0; k < harmonics_bytes(&r.h) / sizeof(double); k++)
            CHECK_NEAR(r.h.data[k], plain.h.data[k], 1e-13);
        for (size_t k = 0; k < 6 * (size_t)r.s.orders * r.s.stride; k++)
            CHECK_NEAR((double)r.s.data[k], (double)plain.s.data[k],
                       2.0 * FLT_EPSILON *
                           (1e-6 + fabs((double)plain.s.data[k])));
        drop_run(&r);
    }
    drop_run(&plain);
}

/* What is not there is not read as a number. */
static void missing_orders_are_zero(void)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    test_random rnd = {8};
    ibl_ring_spectra s = make_spectra(ctx, 9, 4);
    ibl_harmonics h = make_harmonics(ctx, 7);
    double *ones = filled(9, 1.0);

    random_spectra(&s, &rnd);
    CHECK(ibl_sht_analyse(ctx, NULL, &s, ones, &h) == IBL_OK);
    for (int m = 4; m <= 7; m++) {
        for (int i = 0; i < 6 * (8 - m); i++)
            CHECK(at(&h, m, m)[i] == 0.0);
    }
    CHECK(ibl_sht_synthesise(ctx, NULL, &h, ones, 1, &s) == IBL_OK);
    for (int part = 0; part < PARTS; part++) {
        CHECK(ibl_ring_spectra_at(&s, 2, part)[8] == 0.0f);
        CHECK(ibl_ring_spectra_at(&s, 3, part)[0] == 0.0f);
        CHECK(ibl_ring_spectra_at(&s, 1, part)[4] != 0.0f);
    }
    ibl_ring_spectra_free(&s);
    ibl_harmonics_free(&h);
    ibl_free(ones);
    ibl_ctx_free(ctx);
}

static void refusals(void)
{
    test_messages kept = {{{0}}};
    ibl_ring_spectra s;
    ibl_harmonics h;
    double ones[9], sh[3 * 81];

    ibl_ctx *ctx = test_keeping_ctx(0, &kept);
    CHECK(ibl_ring_spectra_alloc(ctx, 0, 1, &s) == IBL_ERR_ARGUMENT);
    CHECK(ibl_ring_spectra_alloc(ctx, 65537, 1, &s) == IBL_ERR_ARGUMENT);
    CHECK(ibl_ring_spectra_alloc(ctx, 1, 0, &s) == IBL_ERR_ARGUMENT);
    CHECK(ibl_harmonics_alloc(ctx, -1, &h) == IBL_ERR_ARGUMENT);
    CHECK(ibl_harmonics_alloc(ctx, IBL_SHT_MAX_DEGREE + 1, &h) ==
          IBL_ERR_ARGUMENT);
    CHECK(!h.data && !s.data);
    for (int i = 0; i < 9; i++)
        ones[i] = 1.0;
    s = make_spectra(ctx, 9, 4);
    h = make_harmonics(ctx, 8);
    memset(h.data, 0, harmonics_bytes(&h));
    CHECK(ibl_sht_synthesise(ctx, NULL, &h, ones, 4, &s) == IBL_ERR_ARGUMENT);
    CHECK(strstr(kept.text[IBL_LOG_ERROR], "degree 4"));
    CHECK(ibl_sht_synthesise(ctx, NULL, &h, ones, -1, &s) == IBL_ERR_ARGUMENT);
    CHECK(ibl_sht_to_sh(ctx, &h, 9, 0.0, sh) == IBL_ERR_ARGUMENT);
    CHECK(ibl_sht_to_sh(ctx, &h, 8, INFINITY, sh) == IBL_ERR_ARGUMENT);
    CHECK(ibl_sht_to_sh(ctx, &h, 8, 0.0, sh) == IBL_OK);
    ibl_ctx_cancel(ctx);
    CHECK(ibl_sht_synthesise(ctx, NULL, &h, ones, 3, &s) == IBL_ERR_CANCELLED);
    CHECK(ibl_sht_analyse(ctx, NULL, &s, ones, &h) == IBL_ERR_CANCELLED);
    ibl_ring_spectra_free(&s);
    ibl_harmonics_free(&h);
    ibl_ctx_free(ctx);
}

static const test tests[] = {
    TEST(direct_sums),
    TEST(round_trip),
    TEST(turned_about_the_axis),
    TEST(turned_to_another_axis),
    TEST(turned_map),
    TEST(power),
    TEST(rows_of_patches),
    TEST(same_for_any_threads),
    TEST(sets_agree),
    TEST(missing_orders_are_zero),
    TEST(refusals),
};
TEST_MAIN(tests)
