/* SPDX-License-Identifier: MIT */
/*
 * Kernels that sum: every version against sums in double that are written from
 * the definitions, within what roundings leave.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "kern.h"
#include "kern/gather.h"
#include "kern/interp.h"
#include "kern/row_block.h"

static float *random_floats(test_random *r, size_t count, size_t align)
{
    float *p = kern_alloc(count * sizeof *p, align);
    for (size_t i = 0; i < count; i++)
        p[i] = (float)test_random_between(r, -1, 1);
    return p;
}

/* ---- gather ------------------------------------------------------------- */

enum {
    MAX_SAMPLES = 512
};

/* Two levels, and two groups of samples: count from the first on, about half
 * of that from 256 on. Weights past a group's end are never used. */
typedef struct lookups {
    ibl_gather_level levels[2];
    float *texels[2];
    float *arrays; /* 5 x MAX_SAMPLES */
    ibl_gather_group groups[2];
    ibl_gather_samples set;
    float frame[9];
} lookups;

/* Directions of every kind: axes, diagonals, near ties, any length. */
static void random_direction(test_random *r, float d[3])
{
    static const float special[] = {0, 1, -1, 0.5f, -0.5f, 1.0000001f};
    const int kind = test_random_below(r, 4);
    const float scale =
        kind == 3 ? ldexpf(1, test_random_below(r, 120) - 60) : 1;
    do {
        for (int k = 0; k < 3; k++)
            d[k] = kind ? scale * (float)test_random_between(r, -1, 1)
                        : special[test_random_below(r, 6)];
    } while (d[0] == 0 && d[1] == 0 && d[2] == 0);
}

static void random_frame(test_random *r, bool identity, float frame[9])
{
    const double a = test_random_between(r, 0, 6.3),
                 b = test_random_between(r, 0, 6.3);
    const double f[9] = {cos(a),           sin(a),           0,
                         -sin(a) * cos(b), cos(a) * cos(b),  sin(b),
                         sin(a) * sin(b),  -cos(a) * sin(b), cos(b)};
    for (int k = 0; k < 9; k++)
        frame[k] = identity ? (float)(k % 4 == 0) : (float)f[k];
}

/* flat: all of a level's texels are the same, so that it does not matter which
 * of two faces a tie is looked up in; else directions have no ties. */
static void lookups_make(lookups *x, int edge, int count, int mips, bool flat,
                         uint64_t seed)
{
    test_random r = {seed};
    float *a = x->arrays = kern_alloc(5 * MAX_SAMPLES * sizeof *a, 64);
    for (int l = 0; l < 2; l++) {
        const int n = l ? 1 + edge / 2 : edge;
        const size_t floats = 24 * (size_t)((n + 2) * (n + 2));
        float *t = x->texels[l] = kern_alloc(floats * sizeof *t, 4);
        for (size_t i = 0; i < floats; i++)
            t[i] =
                (float)(flat ? 3 + l : pow(10, test_random_between(&r, -3, 5)));
        x->levels[l] = (ibl_gather_level){t, n};
    }
    x->groups[0] = (ibl_gather_group){0, count, 0, mips};
    x->groups[1] = (ibl_gather_group){256, 1 + count / 2, mips == 1, mips};
    x->set = (ibl_gather_samples){a,
                                  a + MAX_SAMPLES,
                                  a + 2 * MAX_SAMPLES,
                                  a + 3 * MAX_SAMPLES,
                                  a + 4 * MAX_SAMPLES,
                                  x->groups,
                                  2};
    for (int i = 0; i < MAX_SAMPLES; i++) {
        const ibl_gather_group *g = &x->groups[i / 256];
        const bool used = i < g->first + g->count;
        float d[3];
        random_direction(&r, d);
        for (int k = 0; k < 3; k++)
            a[k * MAX_SAMPLES + i] =
                flat ? d[k] : (float)test_random_between(&r, -1, 1);
        for (int k = 3; k < 5; k++)
            a[k * MAX_SAMPLES + i] = used ? (float)test_random_unit(&r) : NAN;
    }
    random_frame(&r, seed % 3 == 0, x->frame);
}

static void lookups_free(lookups *x)
{
    kern_free(x->texels[0]);
    kern_free(x->texels[1]);
    kern_free(x->arrays);
}

static void true_lookup(const ibl_gather_level *level, const double d[3],
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

static void true_gather(const lookups *x, double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int g = 0; g < 2; g++) {
        const ibl_gather_group *group = &x->groups[g];
        for (int i = group->first; i < group->first + group->count; i++) {
            double d[3];
            for (int k = 0; k < 3; k++)
                d[k] = (double)x->set.x[i] * (double)x->frame[k] +
                       (double)x->set.y[i] * (double)x->frame[3 + k] +
                       (double)x->set.z[i] * (double)x->frame[6 + k];
            true_lookup(&x->levels[group->level], d, (double)x->set.fine[i],
                        rgb);
            if (group->mips == 2)
                true_lookup(&x->levels[group->level + 1], d,
                            (double)x->set.coarse[i], rgb);
        }
    }
}

/* Eight terms >= 0 for each sample, in any order; a position is rounded by some
 * n ulp, which counts where texels differ. */
static void check_gather(ibl_isa isa, int edge, int count, int mips, bool flat,
                         uint64_t seed)
{
    ibl_gather_dsp dsp;
    lookups x;
    double got[3], want[3];
    lookups_make(&x, edge, count, mips, flat, seed);
    ibl_gather_dsp_init(&dsp, isa);
    dsp.gather(&x.set, x.levels, x.frame, got);
    true_gather(&x, want);
    for (int c = 0; c < 3; c++) {
        const double bound =
            (8 * count + (flat ? 8 : 100 * edge)) * (double)FLT_EPSILON;
        CHECK_MSG(fabs(got[c] - want[c]) <= bound * want[c],
                  "%s edge %d count %d mips %d seed %d: %.9g, not %.9g",
                  ibl_isa_name(isa), edge, count, mips, (int)seed, got[c],
                  want[c]);
    }
    lookups_free(&x);
}

/* The corners and edges of levels: no lookup leaves its face. */
static void check_corners(ibl_isa isa, int edge)
{
    ibl_gather_dsp dsp;
    lookups x;
    double rgb[3], want[3];
    lookups_make(&x, edge, 27, 2, true, 3);
    for (int i = 0; i < 27; i++) {
        const float d[3] = {(float)(i % 3 - 1), (float)(i / 3 % 3 - 1),
                            i == 13 ? 1 : (float)(i / 9 - 1)};
        for (int k = 0; k < 3; k++)
            x.arrays[k * MAX_SAMPLES + i] = d[k];
    }
    ibl_gather_dsp_init(&dsp, isa);
    dsp.gather(&x.set, x.levels, x.frame, rgb);
    true_gather(&x, want);
    CHECK_NEAR(rgb[0], want[0], 1e-4 * want[0]);
    lookups_free(&x);
}

static void gather_of(ibl_isa isa)
{
    uint64_t seed = 1;
    for (int count = 1; count <= 50; count++)
        for (int k = 0; k < 4; k++)
            check_gather(isa, 1 + count % (k % 2 ? 17 : 9), count, 1 + k % 2,
                         k / 2, seed++);
    check_gather(isa, 64, IBL_GATHER_MAX_GROUP, 2, false, seed++);
    check_gather(isa, 301, IBL_GATHER_MAX_GROUP, 2, true, seed++);
    for (int edge = 1; edge < 40; edge++)
        check_corners(isa, edge);
}

KERN_TEST(gather)

/* ---- interpolation ------------------------------------------------------ */

enum {
    MAX_TEXELS = 40,
    RINGS = 24,
    COLUMNS = 64
};

static const double pi = 3.14159265358979323846;

/* Component k of point i of `stride`, as a float and what it lacks. */
static void put(float *point, int stride, int i, const double d[3])
{
    for (int k = 0; k < 3; k++) {
        point[k * stride + i] = (float)d[k];
        point[(k + 3) * stride + i] =
            (float)(d[k] - (double)point[k * stride + i]);
    }
}

/* A unit vector: any, an axis, or next to one. */
static void random_unit(test_random *r, double d[3])
{
    const int kind = test_random_below(r, 4);
    double length = 0;
    for (int k = 0; k < 3; k++)
        d[k] = test_random_between(r, -1, 1) * (kind == 1   ? 0
                                                : kind == 2 ? 1e-6
                                                            : 1);
    if (kind)
        d[test_random_below(r, 3)] = test_random_below(r, 2) ? 1 : -1;
    for (int k = 0; k < 3; k++)
        length += d[k] * d[k];
    for (int k = 0; k < 3; k++)
        d[k] /= sqrt(length);
}

static void angles_of(ibl_isa isa)
{
    test_random r = {17};
    ibl_interp_dsp dsp;
    ibl_interp_dsp_init(&dsp, isa);
    for (int count = 0; count <= 64; count += 8) {
        const size_t bytes = (size_t)count * sizeof(double);
        float *point = kern_alloc((size_t)count * 6 * sizeof *point, 64);
        double *theta = kern_alloc(bytes, 64), *phi = kern_alloc(bytes, 64);
        double worst = 0, d[64][3];
        for (int i = 0; i < count; i++) {
            random_unit(&r, d[i]);
            put(point, count, i, d[i]);
        }
        dsp.angles(point, count, count, theta, phi);
        for (int i = 0; i < count; i++) {
            const double across = hypot(d[i][0], d[i][2]);
            double turn = fabs(phi[i] - atan2(d[i][2], d[i][0]));
            turn = fmin(turn, fabs(2 * pi - turn));
            worst = fmax(worst, fabs(theta[i] - atan2(across, d[i][1])));
            worst = fmax(worst, across > 0 ? turn * across : 0);
            CHECK(isfinite(phi[i]));
        }
        CHECK_MSG(worst <= 1e-11, "%s, %d: %.2e", ibl_isa_name(isa), count,
                  worst);
        kern_free(point);
        kern_free(theta);
        kern_free(phi);
    }
}

KERN_TEST(angles)

/* Solves n equations; row i is a[i][0..n - 1] and the right side a[i][n]. */
static void solve(int n, long double a[][10])
{
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k; i < n; i++)
            best = fabsl(a[i][k]) > fabsl(a[best][k]) ? i : best;
        for (int j = 0; j <= n; j++) {
            const long double x = a[k][j];
            a[k][j] = a[best][j];
            a[best][j] = x;
        }
        for (int i = 0; i < n; i++) {
            const long double f = a[i][k] / a[k][k];
            for (int j = k; i != k && j <= n; j++)
                a[i][j] -= f * a[k][j];
        }
    }
    for (int i = 0; i < n; i++)
        a[i][n] /= a[i][i];
}

/*
 * The constants of kern/interp_simd.c. Along a line a field of one degree has
 * waves of all lengths above its own. For waves of power p and w radians per
 * sample, weights c_k of samples at x_k have at g the mean square error
 *     sum over w of p |e^(i w g) - sum over k of c_k e^(i w x_k)|^2
 * with a noise as large as a float's rounding. It is made least, with a sum
 * of 1, at Chebyshev's nodes, and polynomials go through these weights.
 */
static void design(long double coef[6][8])
{
    long double node[6], w[6][8];
    for (int n = 0; n < 6; n++) {
        long double a[9][10] = {{0}}, power = 0, total = 0;
        node[n] = 0.5L * cosl((long double)pi * (n + 0.5L) / 6);
        for (int l = 32; l > 0; l--) {
            const long double turn = 2 * (long double)pi * l / 32 / 3;
            power += powl(10, -10.0L * l / 32);
            total += power;
            for (int i = 0; i < 8; i++) {
                for (int j = 0; j < 8; j++)
                    a[i][j] += power * cosl(turn * (i - j));
                a[i][9] += power * cosl(turn * (node[n] - i + 3.5L));
            }
        }
        for (int i = 0; i < 8; i++) {
            a[i][i] += 1e-14L * total;
            a[i][8] = a[8][i] = total;
        }
        a[8][9] = total;
        solve(9, a);
        for (int k = 0; k < 8; k++)
            w[n][k] = a[k][9];
    }
    for (int k = 0; k < 8; k++) {
        long double a[6][10] = {{0}};
        for (int n = 0; n < 6; n++) {
            for (int d = 0; d < 6; d++)
                a[n][d] = powl(node[n], d);
            a[n][6] = w[n][k];
        }
        solve(6, a);
        for (int d = 0; d < 6; d++)
            coef[d][k] = a[d][6];
    }
}

/* Positions of every kind, whole ones and those below 0 among them. With
 * IBL_TEST_VERBOSE=1 the constants are printed. */
static void weights_of(ibl_isa isa)
{
    long double coef[6][8];
    ibl_interp_dsp dsp;
    design(coef);
    if (getenv("IBL_TEST_VERBOSE"))
        for (int i = 0; i < 48; i++)
            printf("%.15Lg,%c", coef[i / 8][i % 8], i % 8 == 7 ? '\n' : ' ');
    ibl_interp_dsp_init(&dsp, isa);
    for (int count = 0; count <= MAX_TEXELS; count++) {
        test_random r = {(uint64_t)count + 1};
        double angle[MAX_TEXELS];
        int *first = kern_alloc((size_t)count * sizeof *first, 4);
        float *weight = kern_alloc((size_t)count * 8 * sizeof *weight, 4);
        for (int i = 0; i < count; i++)
            angle[i] = i % 5 ? test_random_between(&r, -3, 40) : i / 5;
        dsp.weights(-0.5, 10, angle, count, first, weight);
        for (int i = 0; i < count; i++) {
            const double position = 10 * angle[i] - 0.5;
            const double t = position - floor(position);
            double sum = 0;
            CHECK(first[i] == (int)floor(position) - 3);
            for (int k = 0; k < 8; k++) {
                const double w = (double)weight[8 * i + k];
                double want = 0;
                for (int d = 5; d >= 0; d--)
                    want = want * (t - 0.5) + (double)coef[d][k];
                CHECK_NEAR(w, want, 1.3e-7);
                sum += w;
            }
            CHECK_NEAR(sum, 1, 2e-7);
        }
        kern_free(first);
        kern_free(weight);
    }
}

KERN_TEST(weights)

/* One texel's channel in double, and the sum of the terms' sizes. */
static double true_texel(const ibl_interp_row *row, int i, int channel,
                         double *size)
{
    double sum = 0;
    *size = 0;
    for (int j = 0; j < 8; j++)
        for (int k = 0; k < 8; k++) {
            const double x =
                (double)row->ring_weight[8 * i + j] *
                (double)row->column_weight[8 * i + k] *
                (double)row->grid[(row->ring[i] + j) * row->stride +
                                  4 * (row->column[i] + k) + channel];
            sum += x;
            *size += fabs(x);
        }
    return sum;
}

/* A grid of NaN but for the samples that texels touch. */
static void check_row(ibl_isa isa, int count, uint64_t seed)
{
    const size_t floats = 4 * COLUMNS;
    test_random r = {seed + 1};
    float *grid = kern_alloc(RINGS * floats * sizeof *grid, 4);
    float *ring_weight = random_floats(&r, 8 * (size_t)count, 4);
    float *column_weight = random_floats(&r, 8 * (size_t)count, 4);
    int ring[MAX_TEXELS], column[MAX_TEXELS];
    ibl_interp_dsp dsp;
    int bad = 0;
    for (size_t i = 0; i < RINGS * floats; i++)
        grid[i] = NAN;
    for (int i = 0; i < MAX_TEXELS; i++) {
        ring[i] = test_random_below(&r, RINGS - 7);
        column[i] = test_random_below(&r, COLUMNS - 7);
    }
    const ibl_interp_row row = {
        .grid = grid,
        .stride = (ptrdiff_t)floats,
        .ring = ring,
        .column = column,
        .ring_weight = ring_weight,
        .column_weight = column_weight,
        .count = count,
        .rgba = kern_alloc((size_t)count * 4 * sizeof(float), 4)};
    for (int i = 0; i < count * 8 * 32; i++)
        grid[(ring[i / 256] + i / 32 % 8) * row.stride + 4 * column[i / 256] +
             i % 32] = (float)(test_random_between(&r, -0.3, 0.7) *
                               pow(10, test_random_between(&r, 0, 6)));
    ibl_interp_dsp_init(&dsp, isa);
    dsp.row(&row);
    for (int i = 0; i < 4 * count; i++) {
        double size, want = true_texel(&row, i / 4, i % 4, &size);
        bad += !(fabs((double)row.rgba[i] - want) <=
                 9 * (double)FLT_EPSILON * size);
    }
    CHECK_MSG(!bad, "%s, %d texels, seed %d: %d differences", ibl_isa_name(isa),
              count, (int)seed, bad);
    kern_free(row.rgba);
    kern_free(ring_weight);
    kern_free(column_weight);
    kern_free(grid);
}

static void rows_of(ibl_isa isa)
{
    for (int count = 0; count <= MAX_TEXELS; count++)
        for (uint64_t seed = 0; seed < 2; seed++)
            check_row(isa, count, seed);
}

KERN_TEST(rows)

/* ---- pixels to samples --------------------------------------------------- */

/* Random taps, firsts that stand, step and jump; blocks of every length. */
static void spread_of(ibl_isa isa)
{
    enum {
        LANES = IBL_ROW_BLOCK_LANES,
        TAPS = IBL_ROW_BLOCK_TAPS,
        PERIOD = 5,
        STEP = 23,
        PIXELS = 64,
        SAMPLES = (PIXELS / PERIOD + 1) * STEP + TAPS
    };
    int32_t first[PERIOD] = {0, 0, 1, 2, 22};
    test_random r = {7};
    float *taps = random_floats(&r, PERIOD * TAPS, 4);
    float *pixels = random_floats(&r, PIXELS * LANES, 64);
    double truth[SAMPLES * LANES] = {0};
    ibl_row_block_dsp dsp;
    const ibl_row_block_spread spread = {PERIOD, STEP, first, taps};
    const size_t used =
        ((size_t)ibl_row_block_first(&spread, PIXELS - 1) + TAPS) * LANES;
    ibl_row_block_dsp_init(&dsp, isa);
    for (int i = 0; i < PIXELS; i++)
        for (int k = 0; k < TAPS * LANES; k++)
            truth[(first[i % PERIOD] + i / PERIOD * STEP) * LANES + k] +=
                (double)taps[i % PERIOD * TAPS + k / LANES] *
                (double)pixels[i * LANES + k % LANES];
    for (int block = 1; block <= PIXELS; block++) {
        float *samples = kern_alloc(used * sizeof *samples, 64);
        for (int i = 0; i < PIXELS; i += block) {
            const int left = PIXELS - i;
            dsp.spread(&spread, pixels + (ptrdiff_t)i * LANES, i,
                       left < block ? left : block, samples);
        }
        for (size_t k = 0; k < used; k++)
            CHECK_NEAR((double)samples[k], truth[k], 20 * (double)FLT_EPSILON);
        kern_free(samples);
    }
    kern_free(pixels);
    kern_free(taps);
}

KERN_TEST(spread)
