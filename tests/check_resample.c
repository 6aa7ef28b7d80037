/* SPDX-License-Identifier: MIT */
/*
 * Grids of rings to cubes. The truth is a field in closed form: sums of zonal
 * harmonics around random axes, so band-limited, isotropic and of any spectrum,
 * evaluated in double at the places of the samples and of the texels.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/spectral/resample.h"
#include "maps.h"
#include "truth.h"

#define PI 3.14159265358979323846

enum {
    AXES = 8,
    MAX_DEGREE = 128
};

typedef struct field {
    int degree;
    double spectrum[MAX_DEGREE + 1]; /* of each degree */
    double axis[AXES][3], colour[AXES][3];
} field;

static void field_init(field *f, int degree, double at_degree, uint64_t seed)
{
    test_random r = {seed};
    f->degree = degree;
    for (int l = 0; l <= degree; l++)
        f->spectrum[l] = degree ? pow(at_degree, (double)l / degree) : 1;
    for (int k = 0; k < AXES; k++) {
        const double y = 2 * test_random_unit(&r) - 1;
        const double phi = 2 * PI * test_random_unit(&r), s = sqrt(1 - y * y);
        f->axis[k][0] = s * cos(phi);
        f->axis[k][1] = y;
        f->axis[k][2] = s * sin(phi);
        for (int c = 0; c < 3; c++)
            f->colour[k][c] = 2 * test_random_unit(&r) - 1;
    }
}

/* Orthonormal zonal harmonics: a degree's power is its spectrum's square. */
static void field_at(const field *f, const double d[3], double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int k = 0; k < AXES; k++) {
        const double *a = f->axis[k];
        const double x = a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
        double last = 0, p = 1, sum = 0;
        for (int l = 0; l <= f->degree; l++) {
            sum += f->spectrum[l] * sqrt(2 * l + 1) * p;
            const double next = ((2 * l + 1) * x * p - l * last) / (l + 1);
            last = p;
            p = next;
        }
        for (int c = 0; c < 3; c++)
            rgb[c] += f->colour[k][c] * sum;
    }
}

/* Of ring j from the north pole, column i, also where they are in the border.
 */
static void grid_direction(const ibl_ring_grid *g, int j, int i, double d[3])
{
    const double theta = PI * (j + 0.5) / g->rings;
    const double phi = 2 * PI * (i + 0.5) / g->columns - PI;
    d[0] = sin(theta) * cos(phi);
    d[1] = cos(theta);
    d[2] = sin(theta) * sin(phi);
}

/* Samples the field on the bands and what they need around them. */
static void sample(const field *f, const ibl_ring_grid *g)
{
    const int end = g->first + g->pairs + IBL_GRID_BORDER;
    for (int j = 0; j < 2 * end; j++) {
        const int south = j & 1, ring = j / 2;
        if (ring < g->first - IBL_GRID_BORDER || ring >= g->rings / 2)
            continue;
        float *at = ibl_ring_grid_at(g, south, ring);
        for (int i = 0; i < g->columns; i++) {
            double d[3], rgb[3];
            grid_direction(g, south ? g->rings - 1 - ring : ring, i, d);
            field_at(f, d, rgb);
            for (int c = 0; c < 3; c++)
                at[4 * i + c] = (float)rgb[c];
            at[4 * i + 3] = 0;
        }
        ibl_ring_grid_close(g, south, ring);
    }
}

typedef struct error {
    double rms, worst; /* of the field's rms */
} error;

static error compare(const field *f, const ibl_cube *cube)
{
    const int n = cube->size;
    const float *texel = cube->data;
    double squares = 0, truth2 = 0, worst = 0;
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < n * n; i++, texel += 3) {
            double d[3], rgb[3];
            truth_cube_direction(n, face, i % n, i / n, d);
            field_at(f, d, rgb);
            for (int c = 0; c < 3; c++) {
                const double e = fabs((double)texel[c] - rgb[c]);
                squares += e * e;
                truth2 += rgb[c] * rgb[c];
                worst = e > worst || isnan(e) ? e : worst;
            }
        }
    }
    const double rms = sqrt(truth2 / (18.0 * n * n));
    return (error){sqrt(squares / (18.0 * n * n)) / rms, worst / rms};
}

static void free_grid(void *grid)
{
    ibl_ring_grid_free(grid);
}

/* All NaN; freed after the running test. */
static ibl_ring_grid grid_of(ibl_ctx *ctx, int rings, int columns, int pairs)
{
    ibl_ring_grid grid = {0};
    if (ibl_ring_grid_alloc(ctx, rings, columns, pairs, &grid))
        exit(1);
    for (size_t i = 0; i < 2 * grid.band; i++)
        grid.data[i] = NAN;
    test_defer_copy(free_grid, &grid, sizeof grid);
    return grid;
}

static ibl_status to_cube(ibl_ctx *ctx, const ibl_ring_grid *grid,
                          const ibl_cube *cube, int level, int (*reach)[2])
{
    const ibl_level_sum sum = {.grid = grid,
                               .range.gain = 1,
                               .range.low = {-INFINITY, -INFINITY, -INFINITY},
                               .range.high = {INFINITY, INFINITY, INFINITY},
                               .reach = reach};
    return ibl_spectral_texels(ctx, &sum, cube, level);
}

/* Interpolates the field from a grid to faces of n and tells the error. */
static error run(ibl_ctx *ctx, const field *f, int rings, int columns, int n)
{
    ibl_ring_grid grid = grid_of(ctx, rings, columns, rings / 2);
    ibl_cube cube = cube_alloc(ctx, n, 1);
    sample(f, &grid);
    if (to_cube(ctx, &grid, &cube, 0, NULL))
        return (error){INFINITY, INFINITY};
    return compare(f, &cube);
}

/* ---- accuracy ---------------------------------------------------------- */

/* What resample.h says: 2.2 samples a wave of degree 64 are 70.4 rings and
 * 140.8 columns; the worst texel. */
TEST_SLOW(samples_a_wave)
{
    static const struct {
        double at_degree;
        int rings, columns;
        double rms;
    } cases[] = {{1e-5, 72, 256, 8e-5},
                 {1e-5, 96, 256, 3.5e-5},
                 {1e-5, 128, 512, 4e-6},
                 {1e-7, 72, 256, 4e-5}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        field f;
        field_init(&f, 64, cases[i].at_degree, i + 1);
        const error e = run(ctx, &f, cases[i].rings, cases[i].columns, 24);
        CHECK_MSG(e.rms <= cases[i].rms && e.worst <= 15 * cases[i].rms,
                  "%g at the degree, %d rings, %d columns: rms %.2e, worst "
                  "%.2e",
                  cases[i].at_degree, cases[i].rings, cases[i].columns, e.rms,
                  e.worst);
    }
}

/* Every edge to 20 and some more; they include the poles and the seams. */
TEST(edges)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    field f;
    field_init(&f, 4, 1e-4, 3);
    for (int n = 1; n <= 20; n++) {
        const error e = run(ctx, &f, 32, 64, n);
        CHECK_MSG(e.worst <= 4e-6, "edge %d: worst %.2e", n, e.worst);
    }
    CHECK(run(ctx, &f, 32, 64, 63).worst <= 4e-6);
    CHECK(run(ctx, &f, 32, 64, 100).worst <= 4e-6);
}

TEST(isas)
{
    field f;
    field_init(&f, 8, 1e-5, 4);
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        ibl_ctx *ctx = test_ctx(1, isa);
        CHECK(run(ctx, &f, 44, 128, 16).worst <= 6e-6);
        CHECK(run(ctx, &f, 46, 128, 33).worst <= 6e-6);
    }
}

/* ---- bands ------------------------------------------------------------- */

/* Bands of any kind are what the whole grid gives, to the byte. */
TEST(bands)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_ring_grid whole = grid_of(ctx, 40, 64, 20);
    ibl_cube want = cube_alloc(ctx, 70, 1);
    field f;
    field_init(&f, 10, 1e-2, 9);
    sample(&f, &whole);
    NEED(!to_cube(ctx, &whole, &want, 0, NULL));
    for (int pairs = 1; pairs <= 20; pairs += 3)
        for (int known = 0; known < 2; known++) {
            ibl_ring_grid grid = grid_of(ctx, 40, 64, pairs);
            ibl_cube cube = cube_alloc(ctx, 70, 1);
            static int reach[6 * 70 * 2][2];
            for (int first = 0; first < 20; first += pairs) {
                grid.first = first;
                grid.pairs = 20 - first < pairs ? 20 - first : pairs;
                for (size_t i = 0; i < 2 * grid.band; i++)
                    grid.data[i] = NAN;
                sample(&f, &grid);
                CHECK(!to_cube(ctx, &grid, &cube, 0, known ? reach : NULL));
            }
            CHECK_MSG(!memcmp(cube.data, want.data, 18 * 70 * 70 * 4),
                      "%d pairs, reach %d", pairs, known);
        }
}

/* ---- properties -------------------------------------------------------- */

/* A grid of one value, everywhere. */
static ibl_ring_grid filled(ibl_ctx *ctx, float value, int rings, int columns)
{
    ibl_ring_grid grid = grid_of(ctx, rings, columns, rings / 2);
    for (size_t i = 0; i < 2 * grid.band; i++)
        grid.data[i] = value;
    return grid;
}

/* Constants stay within 2 ulp, and offset alone is exact. */
TEST(constants)
{
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        ibl_ctx *ctx = test_ctx(1, isa);
        ibl_ring_grid grid = filled(ctx, 1, 50, 128);
        ibl_cube cube = cube_alloc(ctx, 37, 1);
        float low = INFINITY, high = 0;
        CHECK(!to_cube(ctx, &grid, &cube, 0, NULL));
        for (int i = 0; i < 18 * 37 * 37; i++) {
            low = fminf(low, cube.data[i]);
            high = fmaxf(high, cube.data[i]);
        }
        CHECK_MSG(low >= 1 - 4 * FLT_EPSILON && high <= 1 + 2 * FLT_EPSILON,
                  "%s: 1 %+.1f .. %+.1f epsilon", ibl_isa_name(isa),
                  (double)((low - 1) / FLT_EPSILON),
                  (double)((high - 1) / FLT_EPSILON));
        grid = filled(ctx, 0, 50, 128);
        const ibl_level_sum sum = {.grid = &grid,
                                   .range.gain = 1,
                                   .range.offset = {0.1f, 0.7f, 1e20f},
                                   .range.high = {1, 0.5f, INFINITY}};
        CHECK(!ibl_spectral_texels(ctx, &sum, &cube, 0));
        int bad = 0;
        for (int i = 0; i < 6 * 37 * 37; i++)
            bad += cube.data[3 * i] != 0.1f || cube.data[3 * i + 1] != 0.5f ||
                   cube.data[3 * i + 2] != 1e20f;
        CHECK(!bad);
    }
}

/* The same bytes from any number of threads, on every level of a chain; what
 * lies outside of the level is left alone. */
TEST(threads)
{
    enum {
        SIZE = 130,
        LEVELS = 8
    };
    ibl_ctx *ctx[3];
    ibl_cube cube[3];
    field f;
    field_init(&f, 10, 1e-2, 9);
    for (int k = 0; k < 3; k++) {
        ctx[k] = test_ctx(k + 1, IBL_ISA_AUTO);
        cube[k] = cube_alloc(ctx[k], SIZE, LEVELS);
        for (size_t i = 0; i < 3 * ibl_cube_texels(SIZE, LEVELS); i++)
            cube[k].data[i] = 1e30f;
    }
    ibl_ring_grid grid = grid_of(ctx[0], 40, 64, 20);
    sample(&f, &grid);
    for (int l = 0; l < LEVELS; l++) {
        for (int k = 0; k < 3; k++) {
            CHECK(!to_cube(ctx[k], &grid, &cube[k], l, NULL));
            CHECK(!memcmp(cube[k].data, cube[0].data,
                          ibl_cube_texels(SIZE, LEVELS) * 3 * sizeof(float)));
        }
        size_t left = 0;
        for (size_t i = 3 * ibl_cube_texels(SIZE, l + 1);
             i < 3 * ibl_cube_texels(SIZE, LEVELS); i++)
            left += cube[0].data[i] == 1e30f;
        CHECK(left == 3 * (ibl_cube_texels(SIZE, LEVELS) -
                           ibl_cube_texels(SIZE, l + 1)));
    }
}

TEST(large)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    field f;
    field_init(&f, 3, 1e-2, 10);
    CHECK(run(ctx, &f, 24, 32, 512).worst <= 1e-5);
}

TEST(cancelled)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_ring_grid grid = filled(ctx, 1, 20, 32);
    ibl_cube cube = cube_alloc(ctx, 64, 1);
    ibl_ctx_cancel(ctx);
    CHECK(to_cube(ctx, &grid, &cube, 0, NULL) == IBL_ERR_CANCELLED);
}
