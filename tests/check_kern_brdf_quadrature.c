/* SPDX-License-Identifier: MIT */
/* The split-sum kernels of every instruction set against the plain ones. */
#include <float.h>
#include <math.h>

#include "core/cpu.h"
#include "kern/brdf_quadrature.h"
#include "test.h"

enum {
    GUARD = 16,
    MAX_VIEWS = 40,
    MAX_TERMS = 41,
    MAX_MIXED = 150
};

static const float guard = -12345.678f;

static bool is_clear(const float *from)
{
    for (int i = 0; i < GUARD; i++)
        if (from[i] != guard)
            return false;
    return true;
}

/* In floats each of 340 terms is off by some roundings, the arcs' cosines by
 * 1.2e-7; both sums are at most 1. */
static void compare_sums(const ibl_brdf_dsp *dsp, ibl_isa isa,
                         const ibl_brdf_rule *rule, ibl_geometry geometry,
                         double alpha, const double *n_dot_v, int count)
{
    float want[2 * MAX_VIEWS], got[2 * MAX_VIEWS + GUARD];
    for (int i = 0; i < 2 * MAX_VIEWS + GUARD; i++)
        got[i] = guard;
    ibl_brdf_sums_c(rule, geometry, alpha, n_dot_v, count, want);
    dsp->sums(rule, geometry, alpha, n_dot_v, count, got);
    CHECK_MSG(is_clear(got + 2 * count), "%s: %d views: writes beyond",
              ibl_isa_name(isa), count);
    for (int i = 0; i < 2 * count; i++)
        CHECK_MSG(fabsf(got[i] - want[i]) <= 24 * FLT_EPSILON,
                  "%s: alpha %.9g, N.V %.17g: %.9g is off by %g",
                  ibl_isa_name(isa), alpha, n_dot_v[i / 2], (double)want[i],
                  (double)(got[i] - want[i]));
}

/* From the smallest to the largest of a table of 4096, and beyond. */
static void sums(void)
{
    test_random rnd = {97};
    ibl_brdf_rule rule;
    double n_dot_v[MAX_VIEWS];

    ibl_brdf_rule_init(&rule);
    for (int isa = IBL_ISA_C; isa <= (int)ibl_isa_best(); isa++) {
        ibl_brdf_dsp dsp;
        ibl_brdf_dsp_init(&dsp, (ibl_isa)isa);
        for (int n = 0; n <= MAX_VIEWS; n++) {
            for (int i = 0; i < n; i++) {
                const double x = test_random_unit(&rnd);
                const double y = exp2(-14 * test_random_unit(&rnd));
                n_dot_v[i] = i % 3 == 0   ? (x + 1e-4) / 1.0002
                             : i % 3 == 1 ? y * 0.9999
                                          : 1 - y * 0.9999;
            }
            const double r = n % 5 ? exp2(-13 * test_random_unit(&rnd)) : 1;
            compare_sums(&dsp, (ibl_isa)isa, &rule,
                         n % 2 ? IBL_GEOMETRY_SMITH : IBL_GEOMETRY_SCHLICK_IBL,
                         r * r, n_dot_v, n);
        }
    }
}

static void compare_mix(const ibl_brdf_dsp *dsp, ibl_isa isa, int terms,
                        int count, const float *table, const float *pair)
{
    const size_t stride = MAX_MIXED;
    float got[MAX_MIXED + GUARD];
    for (int i = 0; i < MAX_MIXED + GUARD; i++)
        got[i] = guard;
    dsp->mix(table, stride, pair, terms, count, got);
    CHECK_MSG(is_clear(got + count), "%s: %d: writes beyond", ibl_isa_name(isa),
              count);
    for (int i = 0; i < count; i++) {
        double want = 0, size = 0;
        for (int k = 0; k < terms; k++) {
            const double term = (double)table[(size_t)k * stride + (size_t)i] *
                                pair[2 * k + i % 2];
            want += term;
            size += fabs(term);
        }
        CHECK_MSG(fabs(got[i] - want) <= (double)terms * FLT_EPSILON * size,
                  "%s: %d terms, %d of %d: %.9g, must be %.9g",
                  ibl_isa_name(isa), terms, i, count, (double)got[i], want);
    }
}

static void mix(void)
{
    static float table[MAX_TERMS * MAX_MIXED], pair[2 * MAX_TERMS];
    test_random rnd = {98};

    for (int i = 0; i < MAX_TERMS * MAX_MIXED; i++)
        table[i] = (float)(2 * test_random_unit(&rnd) - 1);
    for (int i = 0; i < 2 * MAX_TERMS; i++)
        pair[i] = (float)(2 * test_random_unit(&rnd) - 1);
    for (int isa = IBL_ISA_C; isa <= (int)ibl_isa_best(); isa++) {
        ibl_brdf_dsp dsp;
        ibl_brdf_dsp_init(&dsp, (ibl_isa)isa);
        for (int count = 0; count <= MAX_MIXED; count += 2)
            for (int terms = 0; terms <= MAX_TERMS; terms += count % 3 + 1)
                compare_mix(&dsp, (ibl_isa)isa, terms, count, table, pair);
    }
}

static const test tests[] = {TEST(sums), TEST(mix)};
TEST_MAIN(tests)
