/* SPDX-License-Identifier: MIT */
/*
 * Kernels that sum: every version against sums in double that are written from
 * the definitions, within what roundings leave.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bake/spectral/interp_weights.h"
#include "bake/spectral/lobe_table.h"
#include "kern.h"
#include "kern/brdf_quadrature.h"
#include "kern/gather.h"
#include "kern/interp.h"
#include "kern/legendre_sums.h"
#include "kern/radial.h"
#include "kern/reflection.h"
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

/* ---- ties: of equal components x wins, then y ---------------------------- */

/* Faces that hold their number; of a direction, the face that is looked up. */
static void check_ties(ibl_isa isa)
{
    static const float d[][3] = {{1, 1, 1},  {-1, 1, -1}, {1, -1, 0.5f},
                                 {0, 1, 1},  {0, -1, 1},  {0.5f, 1, -1},
                                 {1, 0, -1}, {-1, 0, 1}};
    static const int face[] = {0, 1, 0, 2, 3, 2, 0, 1};
    ibl_gather_dsp dsp;
    lookups x;
    lookups_make(&x, 4, 1, 1, true, 3);
    for (int i = 0; i < 6 * 36 * 4; i++)
        x.texels[0][i] = (float)(1 + i / (36 * 4));
    x.set.group_count = 1;
    ibl_gather_dsp_init(&dsp, isa);
    for (size_t i = 0; i < sizeof face / sizeof *face; i++) {
        double rgb[3];
        for (int k = 0; k < 3; k++)
            x.arrays[k * MAX_SAMPLES] = d[i][k];
        x.arrays[3 * MAX_SAMPLES] = 1;
        dsp.gather(&x.set, x.levels, x.frame, rgb);
        CHECK_MSG(rgb[0] == 1 + face[i], "%s: direction %zu: face %g",
                  ibl_isa_name(isa), i, rgb[0] - 1);
    }
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
    check_ties(isa);
}

KERN_TEST(gather)

/* ---- interpolation ------------------------------------------------------ */

enum {
    MAX_TEXELS = 40,
    RINGS = 24,
    COLUMNS = 64
};

static void angles_of(ibl_isa isa)
{
    ibl_interp_dsp dsp;
    ibl_interp_dsp_init(&dsp, isa);
    for (int k = 0; k < 33 * 33; k++) {
        const int size = 1 + k % 33, y = k / 33;
        const double v = (2 * y + 1) / (double)size - 1;
        const size_t bytes = (size_t)(size + 7) / 8 * 8 * sizeof(double);
        double *latitude = kern_alloc(bytes, 64),
               *angle = kern_alloc(bytes, 64);
        double *azimuth = kern_alloc(bytes, 64), worst = 0;
        for (int i = 0; y < size && i < size; i++) {
            if (i == 0) {
                dsp.latitudes(v, size, size, latitude);
                dsp.polar(v, size, size, angle, azimuth);
            }
            const double u = (2 * i + 1) / (double)size - 1;
            const double at = atan2(fabs(v), fabs(u));
            worst = fmax(worst, fabs(latitude[i] - atan2(v, hypot(1, u))));
            worst = fmax(worst, fabs(angle[i] - atan2(hypot(u, v), 1)));
            if (hypot(u, v) > 0)
                worst = fmax(worst, fabs(azimuth[i] - at));
            CHECK(isfinite(azimuth[i]));
        }
        CHECK_MSG(worst <= 1e-11, "%s, edge %d, row %d: %.2e",
                  ibl_isa_name(isa), size, y, worst);
        kern_free(latitude);
        kern_free(angle);
        kern_free(azimuth);
    }
}

KERN_TEST(angles)

static double polynomial(const ibl_interp_weights *taps, int k, double t)
{
    double sum = 0;
    for (int d = 0; d <= IBL_TAPS_DEGREE; d++)
        sum += taps->coef[d][k] * pow(t - 0.5, d);
    return sum;
}

/* Positions of every kind, whole ones and those below 0 among them. */
static void weights_of(ibl_isa isa)
{
    ibl_interp_dsp dsp;
    ibl_interp_weights taps;
    ibl_interp_weights_design(NULL, 20, 64, &taps);
    ibl_interp_dsp_init(&dsp, isa);
    for (int count = 0; count <= MAX_TEXELS; count++) {
        test_random r = {(uint64_t)count + 1};
        double angle[MAX_TEXELS];
        int *first = kern_alloc((size_t)count * sizeof *first, 4);
        float *weight = kern_alloc((size_t)count * 8 * sizeof *weight, 4);
        for (int i = 0; i < count; i++)
            angle[i] = i % 5 ? test_random_between(&r, 0, 40) : i / 5;
        dsp.weights(&taps, -0.5, 10, angle, count, first, weight);
        for (int i = 0; i < count; i++) {
            const double position = 10 * angle[i] - 0.5;
            const double t = position - floor(position);
            double sum = 0;
            CHECK(first[i] == (int)floor(position) - 3);
            for (int k = 0; k < 8; k++) {
                const double w = (double)weight[8 * i + k];
                CHECK_NEAR(w, polynomial(&taps, k, t), 1.3e-7);
                sum += w;
            }
            CHECK_NEAR(sum, 1, 0.26 * (double)FLT_EPSILON);
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
    const ptrdiff_t r = i * row->ring_step, c = i * row->column_step;
    double sum = 0;
    *size = 0;
    for (int j = 0; j < 8; j++)
        for (int k = 0; k < 8; k++) {
            const double x =
                (double)row->ring_weight[8 * r + j] *
                (double)row->column_weight[8 * c + k] *
                (double)row->grid[(row->ring[r] + j) * row->stride +
                                  4 * (row->column[c] + k) + channel];
            sum += x;
            *size += fabs(x);
        }
    return sum;
}

/* A grid of NaN but for the samples that texels touch. seed: whether rings,
 * columns, and the grid run backwards. */
static void check_row(ibl_isa isa, int count, uint64_t seed)
{
    const size_t floats = 4 * COLUMNS;
    const int r0 = seed & 1 ? MAX_TEXELS - 1 : 0;
    const int c0 = seed & 2 ? MAX_TEXELS - 1 : 0;
    test_random r = {seed + 1};
    float *memory = kern_alloc(RINGS * floats * sizeof *memory, 4);
    float *ring_weight = random_floats(&r, 8 * MAX_TEXELS, 4);
    float *column_weight = random_floats(&r, 8 * MAX_TEXELS, 4);
    int ring[MAX_TEXELS], column[MAX_TEXELS];
    ibl_interp_dsp dsp;
    int bad = 0;
    for (size_t i = 0; i < RINGS * floats; i++)
        memory[i] = NAN;
    for (int i = 0; i < MAX_TEXELS; i++) {
        ring[i] = test_random_below(&r, RINGS - 7);
        column[i] = test_random_below(&r, COLUMNS - 7);
    }
    float *const grid = memory + (seed & 4 ? (RINGS - 1) * floats : 0);
    const ibl_interp_row row = {
        .grid = grid,
        .stride = seed & 4 ? -(ptrdiff_t)floats : (ptrdiff_t)floats,
        .ring = ring + r0,
        .column = column + c0,
        .ring_weight = ring_weight + 8 * r0,
        .column_weight = column_weight + 8 * c0,
        .ring_step = r0 ? -1 : 1,
        .column_step = c0 ? -1 : 1,
        .count = count,
        .rgba = kern_alloc((size_t)count * 4 * sizeof(float), 4)};
    for (int i = 0; i < count * 8 * 32; i++) {
        const int t = i / 256, j = i / 32 % 8, k = i % 32;
        grid[(row.ring[t * row.ring_step] + j) * row.stride +
             4 * row.column[t * row.column_step] + k] =
            (float)(test_random_between(&r, -0.3, 0.7) *
                    pow(10, test_random_between(&r, 0, 6)));
    }
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
    kern_free(memory);
}

static void rows_of(ibl_isa isa)
{
    for (int count = 0; count <= MAX_TEXELS; count++)
        for (uint64_t seed = 0; seed < 8; seed++)
            check_row(isa, count, seed);
}

KERN_TEST(rows)

/* ---- the design of the weights ------------------------------------------- */

/* Mirrored taps, a sum of 1, and samples found again at their own places. */
TEST(designs)
{
    static const double circles[] = {2.2, 2.5, 3, 4, 8, 50, 1000};
    for (int degree = 0; degree <= 300; degree += 30) {
        for (size_t i = 0; i < 7; i++) {
            ibl_interp_weights taps;
            ibl_interp_weights_design(NULL, degree, circles[i] * (degree + 1),
                                      &taps);
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

/* The error that a design promises, against what its weights do to the waves
 * along a line through plane waves of all directions, as many of a degree as it
 * has orders, whose spectrum falls as a Gaussian. */
TEST(promises)
{
    static const double circles[] = {2.2, 2.5, 3, 4, 5};
    enum {
        DEGREE = 70,
        TURNS = 16
    };
    double spectrum[DEGREE + 1];
    for (int l = 0; l <= DEGREE; l++)
        spectrum[l] = pow(10, -4.0 * l * l / (DEGREE * DEGREE));
    for (size_t i = 0; i < 5; i++) {
        const double circle = circles[i] * DEGREE;
        double errors = 0, powers = 0;
        ibl_interp_weights taps;
        const double promised =
            ibl_interp_weights_design(spectrum, DEGREE, circle, &taps);
        for (int n = 0; n < 50; n++) {
            const double t = (n + 0.5) / 50;
            for (int j = TURNS; j < (DEGREE + 1) * TURNS; j++) {
                const int l = j / TURNS;
                const double turn = (j % TURNS + 0.5) / TURNS * 1.5707963267949;
                const double w = 6.283185307179586 * l * cos(turn) / circle;
                double re = cos(w * t), im = sin(w * t);
                for (int k = 0; k < 8; k++) {
                    re -= polynomial(&taps, k, t) * cos(w * (k - 3));
                    im -= polynomial(&taps, k, t) * sin(w * (k - 3));
                }
                const double power = l * spectrum[l] * spectrum[l];
                errors += (re * re + im * im) * power;
                powers += power;
            }
        }
        const double is = sqrt(errors / powers);
        CHECK_MSG(promised >= 0.65 * is && promised <= 1.4 * is,
                  "%g samples a wave: promised %.2e, is %.2e", circles[i],
                  promised, is);
    }
}

/* ---- point lights -------------------------------------------------------- */

enum {
    BLOCKS = 3,
    POINTS = BLOCKS * IBL_RADIAL_BLOCK,
    LIGHTS = 9
};

static void check_points(ibl_isa isa, int size, int first, int stride)
{
    float *point = kern_alloc((size_t)stride * 6 * sizeof *point, 64);
    ibl_radial_dsp dsp;
    int bad = 0;
    ibl_radial_dsp_init(&dsp, isa);
    for (int y = 0; y < size; y++) {
        const double v = (2 * y + 1) / (double)size - 1;
        dsp.points(v, size, first, stride, point);
        for (int i = 0; i < stride; i++) {
            const double u = (2 * (first + i) + 1) / (double)size - 1;
            const double d[3] = {1, u, v};
            for (int k = 0; k < 3; k++) {
                const double want = d[k] / sqrt(1 + u * u + v * v);
                const float *at = point + k * stride + i;
                bad += !(fabs((double)at[0] + (double)at[3 * stride] - want) <=
                         1e-14 * fabs(want) + 1e-17);
                bad += at[0] != (float)want && first + i < size;
            }
        }
    }
    CHECK_MSG(!bad, "%s: edge %d, first %d, %d: %d differences",
              ibl_isa_name(isa), size, first, stride, bad);
    kern_free(point);
}

static void points_of(ibl_isa isa)
{
    for (int blocks = 1; blocks <= BLOCKS; blocks++) {
        check_points(isa, 1, 0, blocks * IBL_RADIAL_BLOCK);
        check_points(isa, 16 * blocks, 0, blocks * IBL_RADIAL_BLOCK);
        check_points(isa, 64, 16, blocks * IBL_RADIAL_BLOCK);
        check_points(isa, 100, 37, blocks * IBL_RADIAL_BLOCK);
    }
}

KERN_TEST(points)

static double ring_lobe(double chord, const void *arg)
{
    (void)arg;
    return chord < 1.2 ? chord * (1.2 - chord) : 0;
}

/* Which ends at the horizon and nowhere else. */
static double flat_lobe(double chord, const void *arg)
{
    (void)chord;
    (void)arg;
    return 1;
}

/* Points anywhere, some of them lights' own places and beyond all horizons. */
static void random_scene(uint64_t seed, float *point,
                         ibl_radial_light lights[LIGHTS])
{
    test_random r = {seed};
    for (int i = 0; i < 6 * POINTS; i++)
        point[i] = (float)(test_random_between(&r, -1, 1) *
                           (i < 3 * POINTS ? 1 : 1e-8));
    for (int l = 0; l < LIGHTS; l++) {
        for (int k = 0; k < 3; k++) {
            lights[l].at[k] = (float)test_random_between(&r, -1, 1);
            lights[l].rest[k] = (float)(1e-8 * test_random_unit(&r));
            lights[l].rgb[k] = (float)pow(10, test_random_between(&r, -4, 4));
            point[k * POINTS + 5 * l] = lights[l].at[k];
            point[(k + 3) * POINTS + 5 * l] = lights[l].rest[k];
        }
        lights[l].rgb[3] = NAN;
    }
    for (int i = 16; i < 32 && seed % 2; i++)
        point[i] = 9;
}

/*
 * Against plain C, which check_point_lights compares with the lobes. Roundings
 * of q cost a lobe no more than a few of themselves, but near the horizon:
 * there what they do to 1 - q/2 counts. `steep` is how much K falls by there.
 */
static void check_lights(ibl_isa isa, const ibl_radial *lobe, double steep,
                         int count, uint64_t seed)
{
    ibl_radial_dsp plain, dsp;
    ibl_radial_light lights[LIGHTS];
    float *point = kern_alloc(6 * POINTS * sizeof *point, 64);
    float want[4 * POINTS], *got = kern_alloc(sizeof want, 64);
    double worst = 0, slack[3] = {1e-30, 1e-30, 1e-30};
    random_scene(seed, point, lights);
    for (int l = 0; l < count; l++)
        for (int c = 0; c < 3; c++)
            slack[c] += 1e-6 * steep * (double)lights[l].rgb[c];
    for (int i = 0; i < 4 * POINTS; i++)
        want[i] = got[i] = i % 4 == 3 ? 12345 : 0;
    ibl_radial_dsp_init(&plain, IBL_ISA_C);
    ibl_radial_dsp_init(&dsp, isa);
    plain.add(lobe, lights, count, point, POINTS, want);
    dsp.add(lobe, lights, count, point, POINTS, got);
    for (int i = 0; i < 4 * POINTS; i++) {
        const double w = (double)want[i], off = fabs((double)got[i] - w);
        const double e = i % 4 == 3 ? 2 * (got[i] != 12345)
                                    : off / (3e-6 * w + slack[i % 4]);
        worst = e > worst || isnan(e) ? e : worst;
    }
    CHECK_MSG(worst <= 1, "%s, %d lights, seed %d: %.2f", ibl_isa_name(isa),
              count, (int)seed, worst);
    kern_free(point);
    kern_free(got);
}

static void lights_of(ibl_isa isa)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_C);
    ibl_radial lobe[4];
    double steep[4] = {1, 1, 1, 1};
    for (int n = 0; n < 2; n++) {
        const ibl_lobe_shape shape =
            ibl_lobe_shape_of(IBL_LOBE_GGX, n ? 1 : 0.01);
        NEED(!ibl_radial_make(ctx, &shape, &lobe[n]));
        const double t = 1 + (double)lobe[n].slope;
        steep[n] = (double)lobe[n].peak / (t * t);
    }
    NEED(!ibl_radial_table(ctx, ring_lobe, NULL, &lobe[2]));
    NEED(!ibl_radial_table(ctx, flat_lobe, NULL, &lobe[3]));
    for (int k = 0; k < 160; k++)
        check_lights(isa, &lobe[k % 4], steep[k % 4], k / 4 % (LIGHTS + 1),
                     (uint64_t)k / 4);
    for (int n = 0; n < 4; n++)
        ibl_radial_free(&lobe[n]);
}

KERN_TEST(lights)

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

/* ---- Legendre coefficients ----------------------------------------------- */

enum {
    MAX_COUNT = 4 * IBL_LEGENDRE_SUMS_POINTS,
    MAX_DEGREE = 700
};

/* Angles of all sizes, the ends among them; weights of both signs, some 0. */
static void random_points(test_random *r, int count, double *y, double *w)
{
    for (int i = 0; i < count; i++) {
        const int pick = test_random_below(r, 16);
        const double psi = 3.141592653589793 * test_random_unit(r) *
                           (pick < 4 ? exp2(-20 * test_random_unit(r)) : 1);
        y[i] = pick == 4   ? 0
               : pick == 5 ? 2
               : pick == 6 ? 1
                           : 2 * sin(0.5 * psi) * sin(0.5 * psi);
        w[i] = pick == 7 ? 0 : test_random_between(r, -1, 1);
    }
}

/* By the three-term recurrence for P_l, in long double. */
static void true_coefficients(const double *y, const double *w, int count,
                              int degree, double *k)
{
    memset(k, 0, (size_t)(degree + 1) * sizeof *k);
    for (int i = 0; i < count; i++) {
        const long double x = 1 - (long double)y[i];
        long double before = 0, p = 1;
        for (int l = 0; l <= degree; l++) {
            const long double next =
                ((2 * l + 1) * x * p - l * before) / (l + 1);
            k[l] += (double)((long double)w[i] * p);
            before = p;
            p = next;
        }
    }
}

/* k[l] of some points; the caller frees it. */
static double *coefficients(ibl_isa isa, const double *y, const double *w,
                            int count, int degree)
{
    const size_t terms = (size_t)degree + 1;
    double *k = kern_alloc(terms * sizeof *k, 64);
    double *scratch =
        kern_alloc(IBL_LEGENDRE_SUMS_SCRATCH * terms * sizeof *scratch, 64);
    double inverse[MAX_DEGREE];
    ibl_legendre_sums_dsp dsp;
    for (int l = 0; l < degree; l++)
        inverse[l] = 1.0 / (l + 1);
    ibl_legendre_sums_dsp_init(&dsp, isa);
    dsp.sums(y, w, count, inverse, degree, scratch, k);
    kern_free(scratch);
    return k;
}

/* |P_l| <= 1; a point's rounding grows with the root of the steps, and next
 * to y = 2, the other pole, as in every recurrence from l = 0, with l. */
static void legendre_coefficients_of(ibl_isa isa)
{
    static const int degrees[] = {0, 1, 2, 3, 7, 63, 256, MAX_DEGREE};
    test_random r = {41};
    double y[MAX_COUNT], w[MAX_COUNT], want[MAX_DEGREE + 1];
    for (int n = IBL_LEGENDRE_SUMS_POINTS; n <= MAX_COUNT;
         n += IBL_LEGENDRE_SUMS_POINTS)
        for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
            const int degree = degrees[i];
            const double bound = 4 * DBL_EPSILON * n * (2 + degree / 4.0);
            double worst = 0;
            random_points(&r, n, y, w);
            true_coefficients(y, w, n, degree, want);
            double *k = coefficients(isa, y, w, n, degree);
            for (int l = 0; l <= degree; l++)
                worst = fmax(worst, fabs(k[l] - want[l]));
            CHECK_MSG(worst <= bound,
                      "%s: count %d degree %d: %g off, allowed %g",
                      ibl_isa_name(isa), n, degree, worst, bound);
            kern_free(k);
        }
}

KERN_TEST(legendre_coefficients)

/* Next to the pole P_l(cos psi) is J_0((l + 1/2) psi), with which plain
 * recurrences in cos(psi) part; 1 - P_l, to second order in y: l (l + 1) y / 2.
 */
static void near_the_pole_of(ibl_isa isa)
{
    const double psi = 1e-6;
    double y[IBL_LEGENDRE_SUMS_POINTS] = {2 * sin(psi / 2) * sin(psi / 2)};
    double w[IBL_LEGENDRE_SUMS_POINTS] = {1};
    double *k = coefficients(isa, y, w, IBL_LEGENDRE_SUMS_POINTS, MAX_DEGREE);
    for (int l = 1; l <= MAX_DEGREE; l++) {
        const double z = 0.5 * l * (l + 1.0) * y[0];
        const double off = fabs(1 - z + 0.25 * z * z - k[l]);
        CHECK_MSG(off < 8 * DBL_EPSILON, "%s: %d: %g off", ibl_isa_name(isa), l,
                  off);
    }
    kern_free(k);
}

KERN_TEST(near_the_pole)

/* With factors 2, -2, 2 ... Q_m+k is +-sin((k + 1) t) / sin t at x = cos t, a
 * Chebyshev polynomial of the second kind. */
static void legendre_values_of(ibl_isa isa)
{
    enum {
        ALL = 3 * IBL_LEGENDRE_VALUES_POINTS,
        STRIDE = ALL + 1,
        DEGREES = 8,
        M = 3
    };
    static const int degree[DEGREES] = {3, 4, 6, 7, 8, 11, 50, 53};
    test_random r = {43};
    double factor[53], t[ALL], x[ALL], start[ALL];
    ibl_legendre_sums_dsp dsp;
    ibl_legendre_sums_dsp_init(&dsp, isa);
    for (int l = 0; l < 53; l++)
        factor[l] = l < M ? NAN : (l - M) % 2 ? -2 : 2;
    for (int i = 0; i < ALL; i++) {
        t[i] = test_random_between(&r, 0.1, 3);
        x[i] = cos(t[i]);
        start[i] = test_random_between(&r, -1, 1);
    }
    for (int n = IBL_LEGENDRE_VALUES_POINTS; n <= ALL;
         n += IBL_LEGENDRE_VALUES_POINTS) {
        double *v = kern_alloc(DEGREES * STRIDE * sizeof *v, 64);
        dsp.values(x, start, n, factor, M, degree, DEGREES, STRIDE, v);
        for (int d = 0; d < DEGREES; d++)
            for (int i = 0; i < n; i++) {
                const int k = degree[d] - M;
                const double sign = k % 4 < 2 ? 1 : -1;
                CHECK_NEAR(v[d * STRIDE + i],
                           sign * start[i] * sin((k + 1) * t[i]) / sin(t[i]),
                           1e-12);
            }
        kern_free(v);
    }
}

KERN_TEST(legendre_values)

/* ---- the table of the BRDF ---------------------------------------------- */

/* From the smallest to the largest of a table of 4096, and beyond, against
 * plain C, which check_lut judges. In floats each of 340 terms is off by some
 * roundings, the arcs' cosines by 1.2e-7; both sums are at most 1. */
static void brdf_sums_of(ibl_isa isa)
{
    test_random r = {97};
    ibl_brdf_rule rule;
    ibl_brdf_dsp plain, dsp;
    double n_dot_v[40];
    float want[2 * 40];
    ibl_brdf_rule_init(&rule);
    ibl_brdf_dsp_init(&plain, IBL_ISA_C);
    ibl_brdf_dsp_init(&dsp, isa);
    for (int n = 0; n <= 40; n++) {
        const ibl_geometry geometry =
            n % 2 ? IBL_GEOMETRY_SMITH : IBL_GEOMETRY_SCHLICK_IBL;
        float *got = kern_alloc((size_t)n * 2 * sizeof *got, 4);
        for (int i = 0; i < n; i++) {
            const double x = test_random_unit(&r);
            const double y = exp2(-14 * test_random_unit(&r));
            n_dot_v[i] = i % 3 == 0   ? (x + 1e-4) / 1.0002
                         : i % 3 == 1 ? y * 0.9999
                                      : 1 - y * 0.9999;
        }
        const double t = n % 5 ? exp2(-26 * test_random_unit(&r)) : 1;
        plain.sums(&rule, geometry, t, n_dot_v, n, want);
        dsp.sums(&rule, geometry, t, n_dot_v, n, got);
        for (int i = 0; i < 2 * n; i++)
            CHECK_MSG(fabsf(got[i] - want[i]) <= 24 * FLT_EPSILON,
                      "%s: alpha %.9g, N.V %.17g: %.9g is off by %g",
                      ibl_isa_name(isa), t, n_dot_v[i / 2], (double)want[i],
                      (double)(got[i] - want[i]));
        kern_free(got);
    }
}

KERN_TEST(brdf_sums)

static void mix_of(ibl_isa isa)
{
    enum {
        TERMS = 41,
        MOST = 150
    };
    test_random r = {98};
    ibl_brdf_dsp dsp;
    float *pair = random_floats(&r, 2 * TERMS, 4);
    ibl_brdf_dsp_init(&dsp, isa);
    for (int count = 0; count <= MOST; count += 2) {
        float *table = random_floats(&r, (size_t)(TERMS * count), 4);
        for (int terms = 0; terms <= TERMS; terms += count % 3 + 1) {
            float *got = kern_alloc((size_t)count * sizeof *got, 4);
            dsp.mix(table, (size_t)count, pair, terms, count, got);
            for (int i = 0; i < count; i++) {
                double want = 0, size = 0;
                for (int k = 0; k < terms; k++) {
                    const double term = (double)table[k * count + i] *
                                        (double)pair[2 * k + i % 2];
                    want += term;
                    size += fabs(term);
                }
                CHECK_MSG(fabs((double)got[i] - want) <=
                              (double)terms * (double)FLT_EPSILON * size,
                          "%s: %d terms, %d of %d: %.9g, must be %.9g",
                          ibl_isa_name(isa), terms, i, count, (double)got[i],
                          want);
            }
            kern_free(got);
        }
        kern_free(table);
    }
    kern_free(pair);
}

KERN_TEST(mix)

/* ---- reflection --------------------------------------------------------- */

/* Whether a and b differ by no more than roundings of sums of size `of`. */
static bool near_sums(double a, double b, double of)
{
    return fabs(a - b) <= 1e-13 * of;
}

static void reflection_of(ibl_isa isa)
{
    enum {
        BLOCK = IBL_REFLECTION_BLOCK
    };
    test_random r = {9};
    ibl_reflection_dsp plain, dsp;
    double cosine[BLOCK], sine[BLOCK], rgb[3 * BLOCK];
    ibl_reflection_row row = {.sv = 0.6,
                              .nv = 0.8,
                              .solid_angle = 0.1,
                              .wide = 1e-3,
                              .least = 0.2,
                              .low = 0.1};

    ibl_reflection_dsp_init(&plain, IBL_ISA_C);
    ibl_reflection_dsp_init(&dsp, isa);
    for (int k = 0; k < 3; k++) {
        row.at[k] = test_random_between(&r, -0.5, 0.5);
        row.ahead[k] = test_random_between(&r, -0.5, 0.5);
        row.aside[k] = test_random_between(&r, -0.5, 0.5);
    }
    for (int i = 0; i < BLOCK; i++) {
        cosine[i] = cos(0.1 * i);
        sine[i] = sin(0.1 * i);
        for (int c = 0; c < 3; c++)
            rgb[c * BLOCK + i] = test_random_unit(&r);
    }
    ibl_reflection_points a, b;
    const int n = BLOCK - 3, whole = plain.place(&row, cosine, sine, n, &a);
    CHECK(dsp.place(&row, cosine, sine, n, &b) == whole);
    int left_out = 0;
    for (int i = 0; i < BLOCK; i++) {
        CHECK(near_sums(a.z[i], b.z[i], 1) && near_sums(a.s2[i], b.s2[i], 1) &&
              near_sums(a.c2[i], b.c2[i], 1) && near_sums(a.fc[i], b.fc[i], 1));
        CHECK(near_sums(a.mass[i], b.mass[i], 1) &&
              !(a.mass[i] > 0) == !(b.mass[i] > 0));
        left_out += !(a.mass[i] > 0);
    }
    CHECK(left_out > 3 && left_out == BLOCK - whole && whole > 0);
    CHECK(a.mass[n] == 0);
    for (int k = 0; k < 3; k++) {
        const ibl_reflection_shape shape = {(ibl_reflection_kind)k, 0.01, 0.8,
                                            0.3};
        double want[8] = {1, 2, 3, 4, 5, 6, 7, 8}, got[8];
        memcpy(got, want, sizeof got);
        plain.add(&shape, &a, rgb, BLOCK, BLOCK, want);
        dsp.add(&shape, &a, rgb, BLOCK, BLOCK, got);
        for (int c = 0; c < 8; c++)
            CHECK_MSG(near_sums(got[c], want[c], want[c]),
                      "%s: sum %d is %.17g, must be %.17g", ibl_isa_name(isa),
                      c, got[c], want[c]);
    }
}

KERN_TEST(reflection)
