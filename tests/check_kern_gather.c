/* SPDX-License-Identifier: MIT */
/*
 * The gather kernels: the plain one against sums in double written from the
 * conventions, the others against the plain one. Every texel that a lookup
 * must not touch is NaN.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/cpu.h"
#include "kern/gather.h"
#include "test.h"
#include "truth.h"

enum {
    LEVELS = 2,
    GUARD = 64, /* texels of NaN around a level */
    MAX_SAMPLES = 512
};

typedef struct fixture {
    float *memory[LEVELS];
    ibl_gather_level levels[LEVELS];
    float *arrays; /* 5 x MAX_SAMPLES */
    ibl_gather_group groups[4];
    ibl_gather_samples set;
    float frame[9];
} fixture;

static void make_level(fixture *x, int l, int edge, test_random *r)
{
    const size_t texels = 6 * (size_t)(edge + 2) * (size_t)(edge + 2);
    const size_t floats = 4 * (texels + 2 * GUARD);
    float *m = ibl_alloc_array(floats, sizeof *m);
    if (!m)
        exit(1);
    for (size_t i = 0; i < floats; i++)
        m[i] = i < 4 * GUARD || i >= floats - 4 * GUARD
                   ? NAN
                   : (float)pow(10, 8 * test_random_unit(r) - 3);
    x->memory[l] = m;
    x->levels[l] = (ibl_gather_level){m + (size_t)4 * GUARD, edge};
}

/* Directions of every kind: axes, diagonals, near ties, any length. */
static void random_direction(test_random *r, float d[3])
{
    static const float special[] = {0, 1, -1, 0.5f, -0.5f, 1.0000001f};
    const uint64_t kind = test_random_u64(r) % 4;
    do {
        for (int k = 0; k < 3; k++)
            d[k] = kind ? (float)(2 * test_random_unit(r) - 1)
                        : special[test_random_u64(r) % 6];
    } while (d[0] == 0 && d[1] == 0 && d[2] == 0);
    if (kind == 3) {
        const float scale = ldexpf(1, (int)(test_random_u64(r) % 120) - 60);
        for (int k = 0; k < 3; k++)
            d[k] *= scale;
    }
}

static void random_frame(test_random *r, bool identity, float frame[9])
{
    const double a = 6.3 * test_random_unit(r), b = 6.3 * test_random_unit(r);
    const double f[9] = {cos(a),           sin(a),           0,
                         -sin(a) * cos(b), cos(a) * cos(b),  sin(b),
                         sin(a) * sin(b),  -cos(a) * sin(b), cos(b)};
    for (int k = 0; k < 9; k++)
        frame[k] = identity ? (float)(k % 4 == 0) : (float)f[k];
}

static void fixture_init(fixture *x, int edge, int count, int mips,
                         uint64_t seed)
{
    test_random r = {seed};
    make_level(x, 0, edge, &r);
    make_level(x, 1, 1 + edge / 2, &r);
    float *a = x->arrays = ibl_alloc_array(5 * MAX_SAMPLES, sizeof *x->arrays);
    if (!a)
        exit(1);
    x->set = (ibl_gather_samples){a,
                                  a + MAX_SAMPLES,
                                  a + 2 * MAX_SAMPLES,
                                  a + 3 * MAX_SAMPLES,
                                  a + 4 * MAX_SAMPLES,
                                  x->groups,
                                  2};
    /* Weights past a group's end are never used. */
    for (int i = 0; i < MAX_SAMPLES; i++) {
        float d[3];
        random_direction(&r, d);
        for (int k = 0; k < 3; k++)
            a[k * MAX_SAMPLES + i] = d[k];
        a[3 * MAX_SAMPLES + i] = a[4 * MAX_SAMPLES + i] = NAN;
    }
    x->groups[0] = (ibl_gather_group){0, count, 0, mips};
    x->groups[1] =
        (ibl_gather_group){256, 1 + count / 2, mips == 2 ? 0 : 1, mips};
    for (int g = 0; g < 2; g++) {
        const int first = x->groups[g].first;
        for (int i = first; i < first + x->groups[g].count; i++) {
            a[3 * MAX_SAMPLES + i] = (float)test_random_unit(&r);
            a[4 * MAX_SAMPLES + i] = (float)test_random_unit(&r);
        }
    }
    random_frame(&r, seed % 3 == 0, x->frame);
}

static void fixture_free(fixture *x)
{
    for (int l = 0; l < LEVELS; l++)
        ibl_free(x->memory[l]);
    ibl_free(x->arrays);
}

/* ---- in double -------------------------------------------------------- */

static void lookup(const ibl_gather_level *level, const double d[3],
                   double weight, double rgb[3])
{
    const double rows[6][2][3] = {
        {{0, 0, -1}, {0, -1, 0}}, {{0, 0, 1}, {0, -1, 0}},
        {{1, 0, 0}, {0, 0, 1}},   {{1, 0, 0}, {0, 0, -1}},
        {{1, 0, 0}, {0, -1, 0}},  {{-1, 0, 0}, {0, -1, 0}}};
    int axis = 0;
    for (int k = 1; k < 3; k++)
        axis = fabs(d[k]) > fabs(d[axis]) ? k : axis;
    const int face = 2 * axis + (d[axis] < 0), n = level->edge;
    double p[2];
    for (int k = 0; k < 2; k++) {
        const double *e = rows[face][k];
        const double u = (e[0] * d[0] + e[1] * d[1] + e[2] * d[2]);
        p[k] = (u / fabs(d[axis]) + 1) / 2 * n - 0.5;
    }
    const double x = floor(p[0]), y = floor(p[1]);
    for (int tap = 0; tap < 4; tap++) {
        const int i = (int)x + 1 + tap % 2, j = (int)y + 1 + tap / 2;
        const double w = (tap % 2 ? p[0] - x : 1 - (p[0] - x)) *
                         (tap / 2 ? p[1] - y : 1 - (p[1] - y));
        const float *t =
            level->texels + 4 * ((face * (n + 2) + j) * (n + 2) + i);
        for (int c = 0; c < 3; c++)
            rgb[c] += w > 1e-9 ? weight * w * (double)t[c] : 0;
    }
}

static void in_double(const fixture *x, double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int g = 0; g < x->set.group_count; g++) {
        const ibl_gather_group *group = &x->groups[g];
        for (int i = group->first; i < group->first + group->count; i++) {
            double d[3];
            for (int k = 0; k < 3; k++)
                d[k] = (double)x->set.x[i] * (double)x->frame[k] +
                       (double)x->set.y[i] * (double)x->frame[3 + k] +
                       (double)x->set.z[i] * (double)x->frame[6 + k];
            lookup(&x->levels[group->level], d, (double)x->set.fine[i], rgb);
            if (group->mips == 2)
                lookup(&x->levels[group->level + 1], d,
                       (double)x->set.coarse[i], rgb);
        }
    }
}

/* Random directions only: at ties of two faces the texels, random here, do
 * not meet. A position is rounded by some n ulp, the texel's worth of it. */
static void plain_version_is_right(void)
{
    test_random r = {5};
    for (int edge = 1; edge < 20; edge += 3) {
        fixture x;
        double got[3], want[3];
        fixture_init(&x, edge, 200, 1 + edge % 2, (uint64_t)edge);
        for (int i = 0; i < 3 * MAX_SAMPLES; i++)
            x.arrays[i] = (float)(2 * test_random_unit(&r) - 1);
        ibl_gather_c(&x.set, x.levels, x.frame, got);
        in_double(&x, want);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(got[c], want[c],
                       (8 * 200 + 100 * edge) * (double)FLT_EPSILON * want[c]);
        fixture_free(&x);
    }
}

/* ---- the others ------------------------------------------------------- */

static void compare(ibl_isa isa, int edge, int count, int mips, uint64_t seed)
{
    ibl_gather_dsp dsp;
    fixture x;
    double got[3], want[3];
    ibl_gather_dsp_init(&dsp, isa);
    fixture_init(&x, edge, count, mips, seed);
    ibl_gather_c(&x.set, x.levels, x.frame, want);
    dsp.gather(&x.set, x.levels, x.frame, got);
    for (int c = 0; c < 3; c++) {
        /* Eight terms >= 0 for each sample, in any order, both sides. */
        const double bound = 8 * count * (double)FLT_EPSILON * want[c];
        CHECK_MSG(fabs(got[c] - want[c]) <= bound,
                  "%s edge %d count %d mips %d seed %d: %.9g, not %.9g",
                  ibl_isa_name(isa), edge, count, mips, (int)seed, got[c],
                  want[c]);
    }
    fixture_free(&x);
}

static void versions_agree(void)
{
    for (ibl_isa isa = IBL_ISA_SSE2; isa <= IBL_ISA_AVX512; isa++) {
        if (!ibl_cpu_has(isa))
            continue;
        uint64_t seed = 1;
        for (int count = 1; count <= 50; count++) {
            compare(isa, 1 + count % 9, count, 1, seed++);
            compare(isa, 1 + count % 17, count, 2, seed++);
        }
        compare(isa, 64, IBL_GATHER_MAX_GROUP, 2, seed++);
        compare(isa, 301, IBL_GATHER_MAX_GROUP, 2, seed++);
    }
}

/* The corners and edges of the largest level: no lookup leaves its face. */
static void lookups_stay_inside(void)
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        ibl_gather_dsp dsp;
        if (!ibl_cpu_has(isa))
            continue;
        ibl_gather_dsp_init(&dsp, isa);
        for (int edge = 1; edge < 40; edge++) {
            fixture x;
            double rgb[3];
            fixture_init(&x, edge, 27, 2, 3);
            for (int i = 0; i < 27; i++) {
                const float d[3] = {(float)(i % 3 - 1), (float)(i / 3 % 3 - 1),
                                    i == 13 ? 1 : (float)(i / 9 - 1)};
                for (int k = 0; k < 3; k++)
                    x.arrays[k * MAX_SAMPLES + i] = d[k];
            }
            dsp.gather(&x.set, x.levels, x.frame, rgb);
            CHECK(isfinite(rgb[0]) && isfinite(rgb[1]) && isfinite(rgb[2]));
            fixture_free(&x);
        }
    }
}

static const test tests[] = {
    TEST(plain_version_is_right),
    TEST(versions_agree),
    TEST(lookups_stay_inside),
};
TEST_MAIN(tests)
