/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "bake/spectral/lobe_coefficients.h"
#include "test.h"
#include "truth.h"

static const long double pi = 3.141592653589793238462643383279503L;
static const ibl_lobe lobes[] = {IBL_LOBE_GGX, IBL_LOBE_CHARLIE,
                                 IBL_LOBE_PHONG};

static double *make(ibl_ctx *ctx, ibl_lobe lobe, double alpha, int degree)
{
    double *k = test_alloc((size_t)degree + 1, sizeof *k);
    const ibl_lobe_shape shape = ibl_lobe_shape_of(lobe, alpha);
    CHECK(ibl_lobe_coefficients(ctx, &shape, degree, k) == IBL_OK);
    return k;
}

/* ---- brute force ------------------------------------------------------- */

enum {
    RULE = 32
};

/* The weights of ibl/ibl.h, not scaled. c = cos(psi), q = sin^2(psi / 2). */
static long double weight(ibl_lobe lobe, long double alpha, long double q,
                          long double c)
{
    const long double a2 = alpha * alpha, t = q + a2 * (1 - q);
    if (lobe == IBL_LOBE_CHARLIE)
        return powl(sqrtl(q) * sqrtl(2), 1 / alpha) * c;
    if (lobe == IBL_LOBE_PHONG)
        return powl(c, (1 / a2 - 1) / 2 + 1);
    return a2 / t * (a2 / t) * c;
}

typedef struct brute {
    ibl_lobe lobe;
    long double alpha;
    int degree;
    long double sum; /* over the sphere */
    long double *k;
} brute;

static void add_angle(brute *b, long double psi, long double x_horizon,
                      long double mass)
{
    const long double c =
        x_horizon < 0.5L ? sinl(x_horizon) : 1 - 2 * powl(sinl(psi / 2), 2);
    const long double q =
        x_horizon < 0.5L ? (1 - c) / 2 : powl(sinl(psi / 2), 2);
    const long double w =
        2 * pi * sinl(psi) * mass * weight(b->lobe, b->alpha, q, c);
    long double before = 0, p = 1;
    b->sum += w;
    for (int l = 0; l <= b->degree; l++) {
        const long double next = ((2 * l + 1) * c * p - l * before) / (l + 1);
        b->k[l] += w * p;
        before = p;
        p = next;
    }
}

/* Panels that double from either end, of two waves of the degree at most. */
static brute add_up(ibl_lobe lobe, double alpha, int degree)
{
    brute b = {.lobe = lobe, .alpha = alpha, .degree = degree};
    const long double half = pi / 4, most = 12.0L / (degree + 1);
    long double x[RULE], w[RULE];
    truth_gauss(RULE, x, w);
    b.k = test_alloc((size_t)degree + 1, sizeof *b.k);
    for (int end = 0; end < 2; end++) {
        long double at = 0, step = 1e-6L * b.alpha;
        while (at < half) {
            const long double to = fminl(half, at + fminl(step, most));
            for (int i = 0; i < RULE; i++) {
                const long double d = (at + to) / 2 + (to - at) / 2 * x[i];
                add_angle(&b, end ? pi / 2 - d : d, end ? d : pi / 2 - d,
                          (to - at) / 2 * w[i]);
            }
            at = to;
            step = at / 2;
        }
    }
    for (int l = 0; l <= degree; l++)
        b.k[l] /= b.sum;
    return b;
}

static double worst_against(const double *k, const brute *b)
{
    double worst = 0;
    for (int l = 0; l <= b->degree; l++)
        worst = fmax(worst, fabs((double)(k[l] - b->k[l])));
    return worst;
}

/* Random widths and degrees; the default chain's, high degrees, wild widths. */
TEST(against_brute_force)
{
    static const struct {
        double alpha;
        int degree;
    } cases[] = {{0.04, 512}, {0.16, 300}, {0.64, 300},   {0.82, 100},
                 {0.92, 100}, {1, 512},    {0.001, 1000}, {1e-5, 100}};
    enum {
        FIXED = sizeof cases / sizeof *cases
    };
    test_random rnd = {3};
    for (int i = 0; i < 3 * FIXED + 36; i++) {
        const bool fixed = i < 3 * FIXED;
        const double alpha =
            fixed ? cases[i / 3].alpha : exp2(-8 * test_random_unit(&rnd));
        const int degree =
            fixed ? cases[i / 3].degree : (int)exp2(9 * test_random_unit(&rnd));
        brute b = add_up(lobes[i % 3], alpha, degree);
        for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
             isa = test_next_isa(isa)) {
            double *k = make(test_ctx(1, isa), lobes[i % 3], alpha, degree);
            CHECK_MSG(worst_against(k, &b) < (fixed ? 4e-15 : 2e-15),
                      "%s, %s alpha %g degree %d: %g off", ibl_isa_name(isa),
                      ibl_lobe_name(lobes[i % 3]), alpha, degree,
                      worst_against(k, &b));
        }
    }
}

/* ---- ends of the range ------------------------------------------------- */

/* A needle has all degrees; a ring on the horizon has P_l(0). */
TEST(narrowest)
{
    static const double alphas[] = {1e-9, 1e-75, 1e-300};
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    for (int i = 0; i < 3; i++) {
        double *ggx = make(ctx, IBL_LOBE_GGX, alphas[i], 100);
        double *phong = make(ctx, IBL_LOBE_PHONG, alphas[i], 100);
        double *charlie = make(ctx, IBL_LOBE_CHARLIE, alphas[i], 100);
        double p = 1;
        for (int l = 0; l <= 100; l++) {
            CHECK_NEAR(ggx[l], 1, 1e-12);
            CHECK_NEAR(phong[l], 1, 1e-14);
            if (l % 2 == 0) {
                CHECK_NEAR(charlie[l], p, 1e-5 * (alphas[i] > 1e-10) + 2e-15);
                p *= -(l + 1.0) / (l + 2);
            } else {
                CHECK_NEAR(charlie[l], 0, 1e-6);
            }
        }
    }
}
