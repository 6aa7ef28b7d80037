/* SPDX-License-Identifier: MIT */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "kern/legendre_sums.h"
#include "test.h"

enum {
    GUARD = 16,
    MAX_COUNT = 4 * IBL_LEGENDRE_SUMS_POINTS,
    MAX_DEGREE = 700
};

static const double guard = -12345.678;

typedef struct arrays {
    double y[MAX_COUNT], w[MAX_COUNT], inverse[MAX_DEGREE];
    double scratch[IBL_LEGENDRE_SUMS_SCRATCH * (MAX_DEGREE + 1) + GUARD];
    double k[MAX_DEGREE + 1 + GUARD], want[MAX_DEGREE + 1];
} arrays;

static arrays *make_arrays(void)
{
    arrays *a = malloc(sizeof *a);
    if (!a)
        exit(1);
    for (int l = 0; l < MAX_DEGREE; l++)
        a->inverse[l] = 1.0 / (l + 1);
    return a;
}

/* Angles of all sizes, the ends among them; weights of both signs, some 0. */
static void fill(arrays *a, int count, test_random *rnd)
{
    for (int i = 0; i < count; i++) {
        const uint64_t pick = test_random_u64(rnd) % 16;
        const double psi = 3.141592653589793 * test_random_unit(rnd) *
                           (pick < 4 ? exp2(-20 * test_random_unit(rnd)) : 1);
        a->y[i] = pick == 4   ? 0
                  : pick == 5 ? 2
                  : pick == 6 ? 1
                              : 2 * sin(0.5 * psi) * sin(0.5 * psi);
        a->w[i] = pick == 7 ? 0 : 2 * test_random_unit(rnd) - 1;
    }
}

static void clear(arrays *a, int degree)
{
    for (int i = 0; i < GUARD; i++) {
        a->scratch[IBL_LEGENDRE_SUMS_SCRATCH * (degree + 1) + i] = guard;
        a->k[degree + 1 + i] = guard;
    }
}

static bool is_clear(const arrays *a, int degree)
{
    for (int i = 0; i < GUARD; i++)
        if (a->scratch[IBL_LEGENDRE_SUMS_SCRATCH * (degree + 1) + i] != guard ||
            a->k[degree + 1 + i] != guard)
            return false;
    return true;
}

/* The three-term recurrence for P_l, in long double. */
static void sum_plainly(arrays *a, int count, int degree)
{
    for (int l = 0; l <= degree; l++)
        a->want[l] = 0;
    for (int i = 0; i < count; i++) {
        const long double x = 1 - (long double)a->y[i];
        long double before = 0, p = 1;
        for (int l = 0; l <= degree; l++) {
            const long double next =
                ((2 * l + 1) * x * p - l * before) / (l + 1);
            a->want[l] += (double)((long double)a->w[i] * p);
            before = p;
            p = next;
        }
    }
}

/* |P_l| <= 1; a point's rounding grows with the root of the steps, and next
 * to y = 2, the other pole, as in every recurrence from l = 0, with l. */
static double tolerance(int count, int degree)
{
    return 4 * DBL_EPSILON * count * (2 + degree / 4.0);
}

static void compare(arrays *a, const ibl_legendre_sums_dsp *dsp, int count,
                    int degree, const char *name)
{
    double worst = 0;
    clear(a, degree);
    dsp->sums(a->y, a->w, count, a->inverse, degree, a->scratch, a->k);
    CHECK_MSG(is_clear(a, degree), "%s: count %d degree %d writes beyond", name,
              count, degree);
    for (int l = 0; l <= degree; l++)
        worst = fmax(worst, fabs(a->k[l] - a->want[l]));
    CHECK_MSG(worst <= tolerance(count, degree),
              "%s: count %d degree %d: %g off, allowed %g", name, count, degree,
              worst, tolerance(count, degree));
}

static void against_plain_sums(void)
{
    static const int degrees[] = {0, 1, 2, 3, 7, 63, 256, MAX_DEGREE};
    test_random rnd = {41};
    arrays *a = make_arrays();
    for (int isa = IBL_ISA_C; isa <= (int)ibl_isa_best(); isa++) {
        ibl_legendre_sums_dsp dsp;
        ibl_legendre_sums_dsp_init(&dsp, (ibl_isa)isa);
        for (int n = IBL_LEGENDRE_SUMS_POINTS; n <= MAX_COUNT;
             n += IBL_LEGENDRE_SUMS_POINTS) {
            for (size_t d = 0; d < sizeof degrees / sizeof *degrees; d++) {
                fill(a, n, &rnd);
                sum_plainly(a, n, degrees[d]);
                compare(a, &dsp, n, degrees[d], ibl_isa_name((ibl_isa)isa));
            }
        }
    }
    free(a);
}

/* Next to the pole P_l(cos psi) is J_0((l + 1/2) psi), with which plain
 * recurrences in cos(psi) part. */
static void near_the_pole(void)
{
    arrays *a = make_arrays();
    for (int isa = IBL_ISA_C; isa <= (int)ibl_isa_best(); isa++) {
        ibl_legendre_sums_dsp dsp;
        double worst = 0;
        ibl_legendre_sums_dsp_init(&dsp, (ibl_isa)isa);
        for (int i = 0; i < IBL_LEGENDRE_SUMS_POINTS; i++) {
            a->y[i] = a->w[i] = 0;
        }
        const double psi = 1e-6;
        a->y[0] = 2 * sin(psi / 2) * sin(psi / 2);
        a->w[0] = 1;
        dsp.sums(a->y, a->w, IBL_LEGENDRE_SUMS_POINTS, a->inverse, MAX_DEGREE,
                 a->scratch, a->k);
        /* 1 - P_l, to second order in y: l (l + 1) y / 2. */
        for (int l = 1; l <= MAX_DEGREE; l++) {
            const double z = 0.5 * l * (l + 1.0) * a->y[0];
            worst = fmax(worst, fabs(1 - z + 0.25 * z * z - a->k[l]));
        }
        CHECK_MSG(worst < 8 * DBL_EPSILON, "%s: %g off",
                  ibl_isa_name((ibl_isa)isa), worst);
    }
    free(a);
}

static const test tests[] = {TEST(against_plain_sums), TEST(near_the_pole)};
TEST_MAIN(tests)
