/* SPDX-License-Identifier: MIT */
/* Shares of strips: against the integral, and every version the same bytes. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/cpu.h"
#include "kern/strip_coverage.h"
#include "test.h"

enum {
    MAX = 64,
    ARRAYS = 7
};

static const double pi = 3.14159265358979323846;
static const ibl_isa levels[] = {IBL_ISA_SSE2, IBL_ISA_AVX2, IBL_ISA_AVX512};
static test_random rng = {9};

static double between(double a, double b)
{
    return a + (b - a) * test_random_unit(&rng);
}

static ibl_coverage_row make_row(double theta, double height)
{
    const double to = fmin(theta + height, pi / 2);
    return (ibl_coverage_row){cos(theta), cos(to), tan(theta), tan(to)};
}

/* Where a border of the sphere's octant can be, most of them in the row. No
 * closer to the pole than pixels are wide: these are no wider than texels. */
static void fill(const ibl_coverage_cuts *c, double theta, double height)
{
    for (int i = 0; i < MAX; i++) {
        const double psi = between(0, pi / 2 - 0.02);
        const double width = between(1e-5, 0.0125);
        const double at = between(theta - height, theta + 2 * height);
        const double tangent = tan(fmin(fmax(at, 1e-3), pi / 2 - 1e-3));
        c->a[i] =
            i % 9 ? tangent * cos(psi + between(0, width)) : between(1e-4, 2);
        c->q[0][i] = cos(psi);
        c->r[0][i] = sin(psi);
        c->q[1][i] = cos(psi + width);
        c->r[1][i] = sin(psi + width);
        c->width[i] = width;
    }
}

static double *make_cuts(ibl_coverage_cuts *c)
{
    double *p = ibl_alloc_zeroed(ARRAYS * MAX, sizeof *p);
    *c = (ibl_coverage_cuts){.a = p + MAX, .width = p + 2 * MAX};
    for (int k = 0; k < 2; k++) {
        c->q[k] = p + (3 + 2 * k) * MAX;
        c->r[k] = p + (4 + 2 * k) * MAX;
    }
    return p;
}

static double cosine(double a, double psi)
{
    const double q = cos(psi);
    return q / sqrt(a * a + q * q);
}

/* The largest fourth derivative of a border along a strip, by differences. */
static double fourth(double a, double psi, double width)
{
    const double h = fmax(width / 8, 1e-3);
    double most = 0;
    for (int k = 0; k <= 8; k++) {
        const double x = psi + width * k / 8;
        const double d = cosine(a, x - 2 * h) - 4 * cosine(a, x - h) +
                         6 * cosine(a, x) - 4 * cosine(a, x + h) +
                         cosine(a, x + 2 * h);
        most = fmax(most, fabs(d) / (h * h * h * h));
    }
    return most;
}

/*
 * By midpoints, which miss a kink by step^2 / 8 of its slope at most. Hermite's
 * rule leaves d^5 / 720 of the fourth derivative, d the part of the strip in
 * which the border is inside the row.
 */
static void integral(void)
{
    enum {
        POINTS = 4000
    };
    ibl_coverage_cuts c;
    double *share = make_cuts(&c), most = 0;
    for (int k = 0; k < 30; k++) {
        const double height = between(2e-4, 0.02);
        const double theta = k % 10 ? between(0, pi / 2 - height) : 0;
        const ibl_coverage_row row = make_row(theta, height);
        const double high = row.top - row.bottom;
        fill(&c, theta, height);
        ibl_coverage_c(&row, &c, MAX, share);
        for (int i = 0; i < MAX; i++) {
            const double psi = atan2(c.r[0][i], c.q[0][i]);
            const double width = c.width[i], step = width / POINTS;
            double want = 0, slope = 0, last = NAN;
            int inside = 1;
            for (int j = 0; j < POINTS; j++) {
                const double at = cosine(c.a[i], psi + step * (j + 0.5));
                const double x = (row.top - at) / high;
                want += fmin(fmax(x, 0), 1) / POINTS;
                inside += x > 0 && x < 1;
                slope = fmax(slope, fabs(x - last));
                last = x;
            }
            const double d = inside * step;
            const double bound =
                pow(d, 5) / 720 / width / high * fourth(c.a[i], psi, width) +
                2 * slope / 8 / POINTS + 1e-9;
            CHECK_MSG(fabs(share[i] - want) <= bound,
                      "theta %g + %g, psi %g + %g, a %g: %.9g, not %.9g +- %g",
                      theta, height, psi, width, c.a[i], share[i], want, bound);
            most = fmax(most, fabs(share[i] - want) / bound);
        }
    }
    if (getenv("IBL_TEST_VERBOSE"))
        printf("integral: %.3g of its bound\n", most);
    ibl_free(share);
}

static void every_isa(void)
{
    ibl_coverage_cuts c;
    double *want = make_cuts(&c);
    double *got = ibl_alloc_zeroed(MAX + 8, sizeof *got);
    for (size_t l = 0; l < sizeof levels / sizeof *levels; l++) {
        ibl_coverage_dsp dsp;
        if (!ibl_cpu_has(levels[l]))
            continue;
        ibl_coverage_dsp_init(&dsp, levels[l]);
        for (int n = 0; n <= MAX; n++) {
            const double height = between(2e-4, 0.1);
            const double theta = n % 7   ? between(0, pi / 2 - height)
                                 : n % 2 ? 0
                                         : pi / 2 - height;
            const ibl_coverage_row row = make_row(theta, height);
            fill(&c, theta, height);
            ibl_coverage_c(&row, &c, n, want);
            for (int i = 0; i < MAX + 8; i++)
                got[i] = -3;
            dsp.share(&row, &c, n, got);
            CHECK_MSG(!memcmp(want, got, (size_t)n * sizeof *got),
                      "%d by %s: other bytes", n, ibl_isa_name(levels[l]));
            const int padded = (n + IBL_COVERAGE_PAD - 1) & -IBL_COVERAGE_PAD;
            for (int i = padded; i < MAX + 8; i++)
                CHECK(got[i] == -3);
        }
    }
    ibl_free(got);
    ibl_free(want);
}

static const test tests[] = {TEST(integral), TEST(every_isa)};
TEST_MAIN(tests)
