/* SPDX-License-Identifier: MIT */
/*
 * The interpolation kernels: the plain ones against sums in double, the others
 * against the plain ones. Every sample that no texel may touch is NaN, and
 * what lies around the outputs must stay as it is.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bake/spectral/taps.h"
#include "core/cpu.h"
#include "kern/interp.h"
#include "test.h"

enum {
    MAX = 40, /* texels */
    RINGS = 24,
    COLUMNS = 64,
    GUARD = 16
};

static const float guard = 12345.0f;

static void random_taps(ibl_taps *taps)
{
    ibl_taps_design(NULL, 20, 64, taps);
}

/* ---- places ------------------------------------------------------------ */

static void angles(void)
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        ibl_interp_dsp dsp;
        if (!ibl_cpu_has(isa))
            continue;
        ibl_interp_dsp_init(&dsp, isa);
        for (int size = 1; size <= 33; size++) {
            for (int y = 0; y < size; y++) {
                const double v = (2 * y + 1) / (double)size - 1;
                double a[48], b[48], c[48], worst = 0;
                for (int i = 0; i < 48; i++)
                    a[i] = b[i] = c[i] = guard;
                dsp.latitudes(v, size, size, a);
                dsp.polar(v, size, size, b, c);
                for (int i = 0; i < size; i++) {
                    const double u = (2 * i + 1) / (double)size - 1;
                    const double at = atan2(fabs(v), fabs(u));
                    worst = fmax(worst, fabs(a[i] - atan2(v, hypot(1, u))));
                    worst = fmax(worst, fabs(b[i] - atan2(hypot(u, v), 1)));
                    if (hypot(u, v) > 0)
                        worst = fmax(worst, fabs(c[i] - at));
                    CHECK(isfinite(c[i]));
                }
                CHECK_MSG(worst <= 1e-11, "%s, edge %d, row %d: %.2e",
                          ibl_isa_name(isa), size, y, worst);
                for (int i = (size + 7) / 8 * 8; i < 48; i++)
                    CHECK(a[i] == (double)guard && b[i] == (double)guard &&
                          c[i] == (double)guard);
            }
        }
    }
}

static double polynomial(const ibl_taps *taps, int k, double t)
{
    double sum = 0;
    for (int d = 0; d <= IBL_TAPS_DEGREE; d++)
        sum += taps->coef[d][k] * pow(t - 0.5, d);
    return sum;
}

/* Positions of every kind, whole ones and those below 0 among them. */
static void check_weights(ibl_isa isa, int count)
{
    ibl_interp_dsp dsp;
    ibl_taps taps;
    test_random r = {(uint64_t)count + 1};
    double angle[MAX];
    int first[MAX + GUARD];
    float weight[8 * MAX + GUARD];
    random_taps(&taps);
    ibl_interp_dsp_init(&dsp, isa);
    for (int i = 0; i < count; i++)
        angle[i] = i % 5 ? 40 * test_random_unit(&r) : i / 5;
    for (int i = 0; i < MAX + GUARD; i++)
        first[i] = -77;
    for (int i = 0; i < 8 * MAX + GUARD; i++)
        weight[i] = guard;
    dsp.weights(&taps, -0.5, 10, angle, count, first, weight);
    for (int i = 0; i < count; i++) {
        const double position = 10 * angle[i] - 0.5;
        double sum = 0;
        CHECK(first[i] == (int)floor(position) - 3);
        for (int k = 0; k < 8; k++) {
            const double w = polynomial(&taps, k, position - floor(position));
            CHECK_NEAR((double)weight[8 * i + k], w, 1.3e-7);
            sum += (double)weight[8 * i + k];
        }
        CHECK_NEAR(sum, 1, 0.26 * (double)FLT_EPSILON);
    }
    for (int i = count; i < MAX + GUARD; i++)
        CHECK(first[i] == -77);
    for (int i = 8 * count; i < 8 * MAX + GUARD; i++)
        CHECK(weight[i] == guard);
}

static void weights(void)
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
        for (int count = 0; ibl_cpu_has(isa) && count <= MAX; count++)
            check_weights(isa, count);
}

/* ---- sums -------------------------------------------------------------- */

typedef struct sums {
    float *memory, *grid; /* the sample of ring 0, column 0 */
    ptrdiff_t stride;
    int ring[MAX], column[MAX];
    float ring_weight[8 * MAX], column_weight[8 * MAX];
} sums;

/* A grid of NaN but for the samples that texels touch. */
static bool sums_init(sums *s, test_random *r, bool mirrored)
{
    const size_t row = 4 * COLUMNS, floats = RINGS * row;
    s->memory = malloc(floats * sizeof *s->memory);
    if (!s->memory)
        return false;
    for (size_t i = 0; i < floats; i++)
        s->memory[i] = NAN;
    s->grid = s->memory + (mirrored ? (RINGS - 1) * row : 0);
    s->stride = mirrored ? -(ptrdiff_t)row : (ptrdiff_t)row;
    for (int i = 0; i < MAX; i++) {
        s->ring[i] = (int)(test_random_u64(r) % (RINGS - 7));
        s->column[i] = (int)(test_random_u64(r) % (COLUMNS - 7));
        for (int k = 0; k < 8; k++) {
            s->ring_weight[8 * i + k] = (float)(2 * test_random_unit(r) - 1);
            s->column_weight[8 * i + k] = (float)(2 * test_random_unit(r) - 1);
        }
    }
    return true;
}

static void touch(const sums *s, test_random *r, int ring, int column)
{
    for (int j = 0; j < 8; j++)
        for (int k = 0; k < 32; k++)
            s->grid[(ring + j) * s->stride + 4 * column + k] =
                (float)((test_random_unit(r) - 0.3) *
                        pow(10, 6 * test_random_unit(r)));
}

/* One texel in double, and the sum of the terms' sizes. */
static double one_sum(const sums *s, int r, int c, int channel, double *size)
{
    double sum = 0;
    *size = 0;
    for (int j = 0; j < 8; j++) {
        for (int k = 0; k < 8; k++) {
            const double x = (double)s->ring_weight[8 * r + j] *
                             (double)s->column_weight[8 * c + k] *
                             (double)s->grid[(s->ring[r] + j) * s->stride +
                                             4 * (s->column[c] + k) + channel];
            sum += x;
            *size += fabs(x);
        }
    }
    return sum;
}

static void check_row(ibl_isa isa, int count, uint64_t seed)
{
    const bool back_ring = seed & 1, back_column = seed & 2;
    ibl_interp_dsp dsp;
    test_random random = {seed + 1};
    sums s;
    float rgba[4 * MAX + GUARD];
    int bad = 0;
    NEED(sums_init(&s, &random, seed & 4));
    for (int i = 0; i < 4 * MAX + GUARD; i++)
        rgba[i] = guard;
    for (int i = 0; i < count; i++)
        touch(&s, &random, s.ring[back_ring ? MAX - 1 - i : i],
              s.column[back_column ? MAX - 1 - i : i]);
    const int r0 = back_ring ? MAX - 1 : 0, c0 = back_column ? MAX - 1 : 0;
    const ibl_interp_row row = {.grid = s.grid,
                                .stride = s.stride,
                                .ring = s.ring + r0,
                                .column = s.column + c0,
                                .ring_weight = s.ring_weight + 8 * r0,
                                .column_weight = s.column_weight + 8 * c0,
                                .ring_step = back_ring ? -1 : 1,
                                .column_step = back_column ? -1 : 1,
                                .count = count,
                                .rgba = rgba};
    ibl_interp_dsp_init(&dsp, isa);
    dsp.row(&row);
    for (int i = 0; i < 4 * count; i++) {
        const int r = back_ring ? r0 - i / 4 : i / 4;
        const int c = back_column ? c0 - i / 4 : i / 4;
        double size, want = one_sum(&s, r, c, i % 4, &size);
        bad +=
            !(fabs((double)rgba[i] - want) <= 9 * (double)FLT_EPSILON * size);
    }
    for (int i = 4 * count; i < 4 * MAX + GUARD; i++)
        bad += rgba[i] != guard;
    CHECK_MSG(!bad, "%s, %d texels, seed %d: %d differences", ibl_isa_name(isa),
              count, (int)seed, bad);
    free(s.memory);
}

static void rows(void)
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
        for (int count = 0; ibl_cpu_has(isa) && count <= MAX; count++)
            for (uint64_t seed = 0; seed < 8; seed++)
                check_row(isa, count, seed);
}

/* ---- the last step ------------------------------------------------------ */

static void check_finish(ibl_isa isa, int count, float gain)
{
    static const float hostile[] = {NAN,      INFINITY, -INFINITY, 0,
                                    -0.0f,    FLT_MAX,  1e-45f,    -3,
                                    65504.0f, 2,        1e30f,     0.5f};
    const ibl_interp_range range = {
        gain, {1, -2, 0, 0}, {0, -INFINITY, 0.25f, 0}, {INFINITY, 3, 1e4f, 0}};
    ibl_interp_dsp plain, dsp;
    float rgba[4 * MAX], want[3 * MAX + GUARD], got[3 * MAX + GUARD];
    for (int i = 0; i < 4 * MAX; i++)
        rgba[i] = hostile[(i + count) % 12];
    for (int i = 0; i < 3 * MAX + GUARD; i++)
        want[i] = got[i] = guard;
    ibl_interp_dsp_init(&plain, IBL_ISA_C);
    ibl_interp_dsp_init(&dsp, isa);
    plain.finish(rgba, &range, count, want);
    dsp.finish(rgba, &range, count, got);
    CHECK(!memcmp(want, got, sizeof got));
    for (int i = 0; i < 3 * count; i++) {
        const int c = i % 3;
        const double x = (double)rgba[4 * (i / 3) + c] * (double)gain +
                         (double)range.offset[c];
        const double y =
            fmin(fmax(isnan(x) ? -INFINITY : x, (double)range.low[c]),
                 (double)range.high[c]);
        CHECK(want[i] == (float)y ||
              fabs((double)want[i] - y) <= 2e-7 * fabs(y));
    }
}

static void finishes(void)
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
        for (int count = 0; ibl_cpu_has(isa) && count <= MAX; count++)
            for (int k = 0; k < 2; k++)
                check_finish(isa, count, k ? 1.125f : 1);
}

/* ---- the design ---------------------------------------------------------- */

/* Mirrored taps, a sum of 1, and samples found again at their own places. */
static void designs(void)
{
    static const double circles[] = {2.2, 2.5, 3, 4, 8, 50, 1000};
    for (int degree = 0; degree <= 300; degree += 30) {
        for (size_t i = 0; i < 7; i++) {
            ibl_taps taps;
            ibl_taps_design(NULL, degree, circles[i] * (degree + 1), &taps);
            for (int n = 0; n <= 20; n++) {
                double sum = 0;
                for (int k = 0; k < 8; k++) {
                    const double w = polynomial(&taps, k, 0.05 * n);
                    sum += w;
                    CHECK_NEAR(w, polynomial(&taps, 7 - k, 1 - 0.05 * n),
                               1e-12);
                    CHECK(fabs(w) < 1.01);
                }
                CHECK_NEAR(sum, 1, 1e-12);
            }
        }
    }
}

/* The error that a design promises, against what its weights do to each wave
 * of a spectrum that falls as a Gaussian. */
static void promises(void)
{
    static const double circles[] = {2.2, 2.5, 3, 4, 5};
    enum {
        DEGREE = 70
    };
    double spectrum[DEGREE + 1];
    for (int l = 0; l <= DEGREE; l++)
        spectrum[l] = pow(10, -4.0 * l * l / (DEGREE * DEGREE));
    for (size_t i = 0; i < 5; i++) {
        const double circle = circles[i] * DEGREE;
        double errors = 0, powers = 0;
        ibl_taps taps;
        const double promised =
            ibl_taps_design(spectrum, DEGREE, circle, &taps);
        for (int n = 0; n < 50; n++) {
            const double t = (n + 0.5) / 50;
            for (int l = 1; l <= DEGREE; l++) {
                const double w = 6.283185307179586 * l / circle;
                double re = cos(w * t), im = sin(w * t);
                for (int k = 0; k < 8; k++) {
                    re -= polynomial(&taps, k, t) * cos(w * (k - 3));
                    im -= polynomial(&taps, k, t) * sin(w * (k - 3));
                }
                errors += (re * re + im * im) * spectrum[l] * spectrum[l];
                powers += spectrum[l] * spectrum[l];
            }
        }
        const double is = sqrt(errors / powers);
        CHECK_MSG(promised >= 0.7 * is && promised <= 1.4 * is,
                  "%g samples a wave: promised %.2e, is %.2e", circles[i],
                  promised, is);
    }
}

static const test tests[] = {TEST(angles),   TEST(weights), TEST(rows),
                             TEST(finishes), TEST(designs), TEST(promises)};
TEST_MAIN(tests)
