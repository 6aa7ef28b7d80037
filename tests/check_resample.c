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

/* Floats of a grid with its borders. */
static size_t floats_of(const ibl_ring_grid *g)
{
    return (size_t)(g->rings + 2 * IBL_GRID_BORDER) * g->stride;
}

/* Of ring j, column i, also where they are in the border. */
static void grid_direction(const ibl_ring_grid *g, int j, int i, double d[3])
{
    const double theta = PI * (j + 0.5) / g->rings;
    const double phi = 2 * PI * (i + 0.5) / g->columns - PI;
    d[0] = sin(theta) * cos(phi);
    d[1] = cos(theta);
    d[2] = sin(theta) * sin(phi);
}

static void sample(const field *f, const ibl_ring_grid *g)
{
    for (int j = 0; j < g->rings; j++) {
        float *ring = ibl_ring_grid_at(g, j);
        for (int i = 0; i < g->columns; i++) {
            double d[3], rgb[3];
            grid_direction(g, j, i, d);
            field_at(f, d, rgb);
            for (int c = 0; c < 3; c++)
                ring[4 * i + c] = (float)rgb[c];
            ring[4 * i + 3] = 0;
        }
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

/* A field without its spectrum, of degree <= rings / 2: 4 samples a wave. */
static ibl_status to_cube(ibl_ctx *ctx, const char *stage,
                          const ibl_ring_grid *grid, const ibl_cube *cube,
                          int level)
{
    const int degree = grid->rings / 2 < grid->columns / 4 ? grid->rings / 2
                                                           : grid->columns / 4;
    const ibl_level_sum sum = {.grid = grid,
                               .degree = degree,
                               .range.gain = 1,
                               .range.low = {-INFINITY, -INFINITY, -INFINITY},
                               .range.high = {INFINITY, INFINITY, INFINITY}};
    return ibl_spectral_texels(ctx, stage, &sum, cube, level);
}

static void free_grid(void *grid)
{
    ibl_ring_grid_free(grid);
}

/* Freed after the running test. */
static ibl_ring_grid grid_of(ibl_ctx *ctx, int rings, int columns)
{
    ibl_ring_grid grid = {0};
    if (ibl_ring_grid_alloc(ctx, rings, columns, &grid))
        exit(1);
    test_defer_copy(free_grid, &grid, sizeof grid);
    return grid;
}

/* Interpolates the field from a grid to faces of n and tells the error. */
static error run(ibl_ctx *ctx, const field *f, int rings, int columns, int n)
{
    ibl_ring_grid grid = grid_of(ctx, rings, columns);
    ibl_cube cube = cube_alloc(ctx, n, 1);
    const ibl_level_sum sum = {.grid = &grid,
                               .spectrum = f->spectrum,
                               .degree = f->degree,
                               .range.gain = 1,
                               .range.low = {-INFINITY, -INFINITY, -INFINITY},
                               .range.high = {INFINITY, INFINITY, INFINITY}};
    sample(f, &grid);
    ibl_ring_grid_close(&grid, 0, rings);
    if (ibl_spectral_texels(ctx, NULL, &sum, &cube, 0))
        return (error){INFINITY, INFINITY};
    return compare(f, &cube);
}

/* ---- accuracy ---------------------------------------------------------- */

/* What resample.h says, for both directions together. */
TEST_SLOW(samples_a_wave)
{
    static const struct {
        double at_degree;
        int rings, columns; /* for degree 64: 4 samples are 128 and 256 */
        double rms;
    } cases[] = {{1e-5, 71, 128, 7e-5},  {1e-5, 80, 256, 2e-5},
                 {1e-5, 97, 256, 5e-6},  {1e-5, 128, 256, 8e-7},
                 {1e-7, 80, 256, 2e-6},  {1e-7, 128, 256, 2e-7},
                 {1e-5, 128, 512, 7e-7}, {1, 160, 512, 1e-4}};
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
    field_init(&f, 12, 1e-4, 3);
    for (int n = 1; n <= 20; n++) {
        const error e = run(ctx, &f, 30, 64, n);
        CHECK_MSG(e.worst <= 2e-6, "edge %d: worst %.2e", n, e.worst);
    }
    CHECK(run(ctx, &f, 31, 64, 63).worst <= 2e-6);
    CHECK(run(ctx, &f, 30, 64, 100).worst <= 2e-6);
}

TEST(isas)
{
    field f;
    field_init(&f, 20, 1e-5, 4);
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        ibl_ctx *ctx = test_ctx(1, isa);
        CHECK(run(ctx, &f, 44, 128, 16).worst <= 6e-6);
        CHECK(run(ctx, &f, 45, 128, 33).worst <= 6e-6);
    }
}

/* Few samples, but more than two a wave. */
TEST(tiny_grids)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    for (int rings = 1; rings <= 9; rings++) {
        for (int columns = 4; columns <= 16; columns *= 2) {
            for (int degree = 0; degree <= 2; degree++) {
                field f;
                field_init(&f, degree, 1, 5);
                if (rings <= degree || columns <= 2 * degree)
                    continue;
                const error e = run(ctx, &f, rings, columns, 9);
                CHECK_MSG(e.worst <= 4e-6,
                          "%d rings, %d columns, degree %d: worst %.2e", rings,
                          columns, degree, e.worst);
            }
        }
    }
}

TEST(without_spectrum)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_ring_grid grid = grid_of(ctx, 32, 64);
    ibl_cube cube = cube_alloc(ctx, 10, 1);
    field f;
    field_init(&f, 16, 1e-5, 6);
    sample(&f, &grid);
    ibl_ring_grid_close(&grid, 0, grid.rings);
    CHECK(!to_cube(ctx, NULL, &grid, &cube, 0));
    const error e = compare(&f, &cube);
    CHECK_MSG(e.rms <= 1e-6, "rms %.2e", e.rms);
}

/* ---- borders ----------------------------------------------------------- */

/* Samples hold their number: a border repeats the same direction's sample. */
static void check_borders(int rings, int columns)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_ring_grid grid = grid_of(ctx, rings, columns);
    int bad = 0;
    for (size_t i = 0; i < floats_of(&grid); i++)
        grid.data[i] = NAN;
    for (int j = 0; j < rings; j++)
        for (int i = 0; i < 4 * columns; i++)
            ibl_ring_grid_at(&grid, j)[i] =
                (float)(4 * (j * columns + i / 4) + i % 4);
    ibl_ring_grid_close(&grid, 0, grid.rings);
    for (int j = -IBL_GRID_BORDER; j < rings + IBL_GRID_BORDER; j++) {
        for (int i = -IBL_GRID_BORDER; i < columns + IBL_GRID_BORDER; i++) {
            const float *at = ibl_ring_grid_at(&grid, j) + 4 * i;
            double d[3], e[3];
            const int number = (int)at[0] / 4;
            grid_direction(&grid, j, i, d);
            bad += !(at[0] >= 0 && at[0] < (float)(4 * rings * columns));
            grid_direction(&grid, number / columns, number % columns, e);
            for (int k = 0; k < 3; k++)
                bad += !(fabs(d[k] - e[k]) < 1e-9);
            for (int c = 1; c < 4; c++)
                bad += !((int)at[c] == (int)at[0] + c);
        }
    }
    CHECK_MSG(!bad, "%d rings, %d columns: %d differences", rings, columns,
              bad);
}

TEST(borders)
{
    for (int rings = 1; rings <= 12; rings++)
        for (int columns = 4; columns <= 32; columns *= 2)
            check_borders(rings, columns);
    check_borders(67, 16);
    check_borders(130, 64);
}

/* ---- properties -------------------------------------------------------- */

/* A grid of one value, everywhere. */
static ibl_ring_grid filled(ibl_ctx *ctx, float value, int rings, int columns)
{
    ibl_ring_grid grid = grid_of(ctx, rings, columns);
    for (size_t i = 0; i < floats_of(&grid); i++)
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
        CHECK(!to_cube(ctx, NULL, &grid, &cube, 0));
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
                                   .degree = 20,
                                   .range.gain = 1,
                                   .range.offset = {0.1f, 0.7f, 1e20f},
                                   .range.high = {1, 0.5f, INFINITY}};
        CHECK(!ibl_spectral_texels(ctx, NULL, &sum, &cube, 0));
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
    ibl_ring_grid grid = grid_of(ctx[0], 40, 64);
    sample(&f, &grid);
    ibl_ring_grid_close(&grid, 0, grid.rings);
    for (int l = 0; l < LEVELS; l++) {
        for (int k = 0; k < 3; k++) {
            CHECK(!to_cube(ctx[k], NULL, &grid, &cube[k], l));
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
    CHECK(run(ctx, &f, 24, 32, 512).worst <= 2e-6);
}

TEST(cancelled)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_ring_grid grid = filled(ctx, 1, 20, 32);
    ibl_cube cube = cube_alloc(ctx, 64, 1);
    ibl_ctx_cancel(ctx);
    CHECK(to_cube(ctx, "level", &grid, &cube, 0) == IBL_ERR_CANCELLED);
}
