/* SPDX-License-Identifier: MIT */
/*
 * The texels of a cube come in families of equal positions. Column x of the
 * four side faces lies on one meridian, at -atan(u) from the face's middle,
 * and the faces differ by a quarter of the columns. Texels at u and -u, and
 * rows at v and -v, are mirror images, in which taps change their order.
 * On top and bottom u and v, both signs of each, and the two faces share one
 * distance from the pole and one azimuth in its quadrant.
 *
 * So a job takes a few pairs of rows, y and n - 1 - y, of the four side faces
 * or of top and bottom, and finds places and weights once for all of a pair.
 */
#include "bake/spectral/resample.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "bake/spectral/taps.h"
#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"
#include "kern/interp.h"

#define PI 3.14159265358979323846

enum {
    TEXELS_PER_JOB = 6144,
    LIGHTS_PER_JOB = 1 << 18 /* times texels */
};

/* ---- the grid ---------------------------------------------------------- */

static ibl_status check_shape(ibl_ctx *ctx, int rings, int columns)
{
    if (rings < 1 || rings > IBL_MAX_EDGE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a grid of %d rings: must be 1 to %d", rings,
                        IBL_MAX_EDGE);
    if (columns < 4 || columns > IBL_MAX_EDGE || (columns & (columns - 1)))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a grid of %d columns: must be a power of two, 4 to %d",
                        columns, IBL_MAX_EDGE);
    return IBL_OK;
}

ibl_status ibl_ring_grid_alloc(ibl_ctx *ctx, int rings, int columns,
                               ibl_ring_grid *grid)
{
    ibl_status status = check_shape(ctx, rings, columns);
    if (status) {
        ibl_ring_grid_free(grid);
        return status;
    }
    grid->rings = rings;
    grid->columns = columns;
    grid->stride = 4 * ((size_t)columns + 2 * IBL_GRID_BORDER);
    const size_t rows = (size_t)rings + 2 * IBL_GRID_BORDER;
    if (grid->room / grid->stride >= rows)
        return IBL_OK;
    ibl_free(grid->data);
    grid->data = ibl_alloc_array(rows, grid->stride * sizeof *grid->data);
    grid->room = rows * grid->stride;
    if (!grid->data) {
        *grid = (ibl_ring_grid){0};
        return ibl_no_memory(ctx, "a grid of rings");
    }
    return IBL_OK;
}

void ibl_ring_grid_free(ibl_ring_grid *grid)
{
    if (!grid)
        return;
    ibl_free(grid->data);
    *grid = (ibl_ring_grid){0};
}

/* The ring that a row of the border continues, and whether it lies half a turn
 * away: around the sphere after 2 rings. */
static int ring_behind(const ibl_ring_grid *grid, int row, int *turned)
{
    const int around = 2 * grid->rings;
    row = (row % around + around) % around;
    *turned = row >= grid->rings;
    return *turned ? around - 1 - row : row;
}

/* Writes a row with its border from column `shift` on of another. */
static void copy_ring(const ibl_ring_grid *grid, const float *from, int shift,
                      float *to)
{
    const int n = grid->columns;
    for (int i = -IBL_GRID_BORDER; i < n + IBL_GRID_BORDER; i++)
        memcpy(to + 4 * i, from + 4 * (size_t)((i + shift + 2 * n) & (n - 1)),
               4 * sizeof *to);
}

static void close_ring(const ibl_ring_grid *grid, int ring)
{
    const int n = grid->columns, rings = grid->rings;
    float *row = ibl_ring_grid_at(grid, ring);
    for (int i = 0; i < IBL_GRID_BORDER; i++) {
        memcpy(row + 4 * (i - IBL_GRID_BORDER),
               row + 4 * (size_t)((i - IBL_GRID_BORDER + n) & (n - 1)),
               4 * sizeof *row);
        memcpy(row + 4 * ((size_t)n + i), row + 4 * (size_t)(i & (n - 1)),
               4 * sizeof *row);
    }
    for (int i = 0; i < 2 * IBL_GRID_BORDER; i++) {
        const int at = i < IBL_GRID_BORDER ? i - IBL_GRID_BORDER
                                           : rings + i - IBL_GRID_BORDER;
        int turned;
        if (ring_behind(grid, at, &turned) == ring)
            copy_ring(grid, row, turned ? n / 2 : 0,
                      ibl_ring_grid_at(grid, at));
    }
}

void ibl_ring_grid_close(const ibl_ring_grid *grid, int first, int count)
{
    for (int ring = first; ring < first + count; ring++)
        close_ring(grid, ring);
}

static void close_job(void *arg, int job, int worker)
{
    const ibl_ring_grid *grid = arg;
    const int first = 64 * job, left = grid->rings - first;
    (void)worker;
    ibl_ring_grid_close(grid, first, left < 64 ? left : 64);
}

ibl_status ibl_ring_grid_fill_borders(ibl_ctx *ctx, const ibl_ring_grid *grid)
{
    return ibl_run(ctx, NULL, (grid->rings + 63) / 64, close_job,
                   (void *)(uintptr_t)grid);
}

/* ---- a level ----------------------------------------------------------- */

/* A row of texels: where their taps begin and weights, 8 a texel. */
typedef struct places {
    int *first;
    float *weight;
} places;

/* What a worker has for a pair of rows. */
typedef struct scratch {
    double *angle, *azimuth; /* of a half row */
    places ring, low_ring;   /* of the upper row, and of its mirror image */
    places column, low_column;
    float *gain, *low_gain;
    float *rgba;
    float *point;
} scratch;

typedef struct level {
    const ibl_level_sum *sum;
    ibl_interp_dsp dsp;
    ibl_radial_dsp radial;
    ibl_taps ring_taps, column_taps;
    ibl_interp_range range;
    places column;     /* of +X, every row */
    float *gain;       /* of the rings and their border */
    scratch *parts;    /* one for each worker */
    int n, half;       /* edge, and (n + 1) / 2 */
    int pairs, chunks; /* of rows in a job, and jobs for all pairs */
    float *texels;
} level;

/* Texel i of a row from the mirror image of texel n - 1 - i, for i >= from:
 * the first tap from end - the other's, the weights in reverse. */
static void mirror(const level *a, const places *src, int from, int end,
                   places *dst)
{
    for (int i = from; i < a->n; i++) {
        const int k = a->n - 1 - i;
        dst->first[i] = end - src->first[k];
        for (int t = 0; t < IBL_TAPS; t++)
            dst->weight[IBL_TAPS * i + t] =
                src->weight[IBL_TAPS * k + IBL_TAPS - 1 - t];
    }
}

/* The other half of a row, the same as the first in reverse order. */
static void repeat(const level *a, places *p)
{
    for (int i = a->half; i < a->n; i++) {
        const int k = a->n - 1 - i;
        p->first[i] = p->first[k];
        memcpy(p->weight + IBL_TAPS * i, p->weight + IBL_TAPS * k,
               IBL_TAPS * sizeof *p->weight);
    }
}

/* The same row mirrored in the equator. */
static void flip(const level *a, const places *src, places *dst)
{
    const int end = a->sum->grid->rings - IBL_TAPS;
    for (int i = 0; i < a->n; i++) {
        dst->first[i] = end - src->first[i];
        for (int t = 0; t < IBL_TAPS; t++)
            dst->weight[IBL_TAPS * i + t] =
                src->weight[IBL_TAPS * i + IBL_TAPS - 1 - t];
    }
}

/* Columns that every row of +X has: phi = -atan(u). u falls short of 0 in the
 * first half, and phi is above 0. */
static void side_columns(level *a, double *angle)
{
    const int columns = a->sum->grid->columns;
    for (int i = 0; i < a->half; i++)
        angle[i] = atan(1 - (2 * i + 1) / (double)a->n);
    a->dsp.weights(&a->column_taps, 0.5 * columns - 0.5, columns / (2 * PI),
                   angle, a->half, a->column.first, a->column.weight);
    mirror(a, &a->column, a->half, columns - IBL_TAPS, &a->column);
}

/* Interpolates the gain where a row's texels are; NULL for none. */
static const float *gain_of(const level *a, const places *ring, float *out)
{
    if (!a->gain)
        return NULL;
    for (int i = 0; i < a->n; i++) {
        const float *gain = a->gain + ring->first[i] + IBL_GRID_BORDER;
        float sum = 0;
        for (int t = 0; t < IBL_TAPS; t++)
            sum += ring->weight[IBL_TAPS * i + t] * gain[t];
        out[i] = sum;
    }
    return out;
}

/* Texels begin..end - 1 of a row, their columns turned. */
static void interpolate(const level *a, const places *ring,
                        const places *column, int turn, int begin, int end,
                        scratch *s)
{
    const ibl_ring_grid *grid = a->sum->grid;
    const ibl_interp_row row = {
        .grid = ibl_ring_grid_at(grid, 0) + 4 * (ptrdiff_t)turn,
        .stride = grid->stride,
        .ring = ring->first + begin,
        .column = column->first + begin,
        .ring_weight = ring->weight + (ptrdiff_t)IBL_TAPS * begin,
        .column_weight = column->weight + (ptrdiff_t)IBL_TAPS * begin,
        .count = end - begin,
        .rgba = s->rgba + 4 * (ptrdiff_t)begin};
    a->dsp.row(&row);
}

/* What is to be known of row y of any face before its lights are added. */
static void place_points(const level *a, int y, scratch *s)
{
    if (a->sum->bright)
        a->radial.points((2 * y + 1) / (double)a->n - 1, a->n, s->point);
}

static void finish(const level *a, int face, int y, const float *gain,
                   scratch *s)
{
    const ibl_bright *bright = a->sum->bright;
    const size_t n = (size_t)a->n;
    if (bright)
        a->radial.add(a->sum->lobe, ibl_bright_face(bright, face),
                      ibl_bright_count(bright), s->point, a->n, s->rgba);
    a->dsp.finish(s->rgba, gain, &a->range, a->n,
                  a->texels + 3 * ((size_t)face * n + (size_t)y) * n);
}

/* Row y of the side faces, a quarter turn apart. On -X, half a turn from +X,
 * the left half of the columns are the grid's first and the right half its
 * last. */
static void side_row(const level *a, int y, const places *ring,
                     const float *gain, scratch *s)
{
    static const struct {
        int face, left, right; /* quarter turns of its halves */
    } side[4] = {{0, 0, 0}, {1, -2, 2}, {4, 1, 1}, {5, -1, -1}};
    const int quarter = a->sum->grid->columns / 4, middle = a->n / 2;
    place_points(a, y, s);
    for (int k = 0; k < 4; k++) {
        interpolate(a, ring, &a->column, side[k].left * quarter, 0, middle, s);
        interpolate(a, ring, &a->column, side[k].right * quarter, middle, a->n,
                    s);
        finish(a, side[k].face, y, gain, s);
    }
}

static void side_pair(const level *a, int y, scratch *s)
{
    const int rings = a->sum->grid->rings;
    const double v = (2 * y + 1) / (double)a->n - 1;
    a->dsp.latitudes(v, a->n, a->half, s->angle);
    /* theta = pi / 2 + latitude of v, since v grows downwards. */
    a->dsp.weights(&a->ring_taps, 0.5 * rings - 0.5, rings / PI, s->angle,
                   a->half, s->ring.first, s->ring.weight);
    repeat(a, &s->ring);
    side_row(a, y, &s->ring, gain_of(a, &s->ring, s->gain), s);
    if (a->n - 1 - y == y)
        return;
    flip(a, &s->ring, &s->low_ring);
    side_row(a, a->n - 1 - y, &s->low_ring, gain_of(a, &s->low_ring, s->gain),
             s);
}

/*
 * Columns of row y of the top, where v <= 0. With a the azimuth in its
 * quadrant phi = a - pi where u <= 0, half a turn from a, and -a where u > 0,
 * the mirror image of a. Row n - 1 - y of the top has pi - a and a, the same
 * from right to left and half a turn on; rows of the bottom have z = -v, so
 * the two are the other way around.
 */
static void pole_columns(const level *a, scratch *s)
{
    const int columns = a->sum->grid->columns, n = a->n;
    a->dsp.weights(&a->column_taps, 0.5 * columns - 0.5, columns / (2 * PI),
                   s->azimuth, a->half, s->column.first, s->column.weight);
    mirror(a, &s->column, a->half, columns - IBL_TAPS, &s->column);
    for (int i = 0; i < a->half; i++)
        s->column.first[i] -= columns / 2;
    for (int i = 0; i < n; i++) {
        const int k = n - 1 - i;
        s->low_column.first[i] = s->column.first[k] + columns / 2;
        memcpy(s->low_column.weight + IBL_TAPS * i,
               s->column.weight + IBL_TAPS * k,
               IBL_TAPS * sizeof *s->column.weight);
    }
}

static void pole_row(const level *a, int y, const places *top,
                     const places *bottom, scratch *s)
{
    place_points(a, y, s);
    interpolate(a, &s->ring, top, 0, 0, a->n, s);
    finish(a, 2, y, a->gain ? s->gain : NULL, s);
    interpolate(a, &s->low_ring, bottom, 0, 0, a->n, s);
    finish(a, 3, y, a->gain ? s->low_gain : NULL, s);
}

static void pole_pair(const level *a, int y, scratch *s)
{
    const int rings = a->sum->grid->rings;
    const double v = (2 * y + 1) / (double)a->n - 1;
    a->dsp.polar(v, a->n, a->half, s->angle, s->azimuth);
    a->dsp.weights(&a->ring_taps, -0.5, rings / PI, s->angle, a->half,
                   s->ring.first, s->ring.weight);
    repeat(a, &s->ring);
    flip(a, &s->ring, &s->low_ring);
    pole_columns(a, s);
    gain_of(a, &s->ring, s->gain);
    gain_of(a, &s->low_ring, s->low_gain);
    pole_row(a, y, &s->column, &s->low_column, s);
    if (a->n - 1 - y != y)
        pole_row(a, a->n - 1 - y, &s->low_column, &s->column, s);
}

static void level_job(void *arg, int job, int worker)
{
    const level *a = arg;
    const int poles = job >= a->chunks;
    const int begin = (poles ? job - a->chunks : job) * a->pairs;
    const int end = begin + a->pairs < a->half ? begin + a->pairs : a->half;
    for (int y = begin; y < end; y++)
        (poles ? pole_pair : side_pair)(a, y, &a->parts[worker]);
}

/* ---- setting up -------------------------------------------------------- */

/* Memory in pieces: with base NULL their sizes are summed alone. */
typedef struct cutter {
    char *base;
    size_t used;
} cutter;

static void *cut(cutter *c, size_t count, size_t size)
{
    const size_t at = c->used;
    c->used += (count * size + 63) / 64 * 64;
    return c->base ? c->base + at : NULL;
}

static places cut_places(cutter *c, size_t n)
{
    int *first = cut(c, n, sizeof *first);
    return (places){first, cut(c, IBL_TAPS * n, sizeof(float))};
}

static scratch cut_scratch(cutter *c, size_t n)
{
    scratch s;
    s.angle = cut(c, n, sizeof *s.angle);
    s.azimuth = cut(c, n, sizeof *s.azimuth);
    s.ring = cut_places(c, n);
    s.low_ring = cut_places(c, n);
    s.column = cut_places(c, n);
    s.low_column = cut_places(c, n);
    s.gain = cut(c, n, sizeof *s.gain);
    s.low_gain = cut(c, n, sizeof *s.low_gain);
    s.rgba = cut(c, 4 * n, sizeof *s.rgba);
    s.point = cut(c, 6 * n, sizeof *s.point);
    return s;
}

/* Everything that a level needs, in one piece of memory. */
static void cut_level(cutter *c, level *a, int threads)
{
    const size_t n = ((size_t)a->n + IBL_RADIAL_BLOCK - 1) / IBL_RADIAL_BLOCK *
                     IBL_RADIAL_BLOCK;
    const size_t rings =
        (size_t)a->sum->grid->rings + 2 * (size_t)IBL_GRID_BORDER;
    scratch *parts = cut(c, (size_t)threads, sizeof *parts);
    a->column = cut_places(c, n);
    a->gain = a->sum->gain ? cut(c, rings, sizeof *a->gain) : NULL;
    for (int i = 0; i < threads; i++) {
        const scratch s = cut_scratch(c, n);
        if (parts)
            parts[i] = s;
    }
    a->parts = parts;
}

static void border_gain(level *a)
{
    const ibl_ring_grid *grid = a->sum->grid;
    for (int i = 0; a->gain && i < grid->rings + 2 * IBL_GRID_BORDER; i++) {
        int turned;
        a->gain[i] =
            a->sum->gain[ring_behind(grid, i - IBL_GRID_BORDER, &turned)];
    }
}

/* Jobs of equal work: rows of two faces, or four, and the lights on them. */
static void divide(level *a)
{
    const ibl_bright *bright = a->sum->bright;
    const long row = 6L * a->n;
    const long lights = row * (bright ? ibl_bright_count(bright) : 0);
    long pairs = TEXELS_PER_JOB / row;
    if (pairs * lights > LIGHTS_PER_JOB)
        pairs = LIGHTS_PER_JOB / lights;
    a->pairs = pairs < 1 ? 1 : (int)pairs;
    a->chunks = (a->half + a->pairs - 1) / a->pairs;
}

ibl_status ibl_spectral_texels(ibl_ctx *ctx, const char *stage,
                               const ibl_level_sum *sum, const ibl_cube *cube,
                               int level_index)
{
    const ibl_ring_grid *grid = sum->grid;
    level a = {.sum = sum, .n = ibl_cube_edge(cube->size, level_index)};
    cutter c = {0};
    a.half = (a.n + 1) / 2;
    cut_level(&c, &a, ibl_ctx_threads(ctx));
    c = (cutter){.base = ibl_alloc_array(c.used, 1)};
    if (!c.base)
        return ibl_no_memory(ctx, "the places of a level's texels");
    cut_level(&c, &a, ibl_ctx_threads(ctx));

    ibl_interp_dsp_init(&a.dsp, ibl_ctx_isa(ctx));
    ibl_radial_dsp_init(&a.radial, ibl_ctx_isa(ctx));
    ibl_taps_design(sum->spectrum, sum->degree, 2.0 * grid->rings,
                    &a.ring_taps);
    ibl_taps_design(sum->spectrum, sum->degree, grid->columns, &a.column_taps);
    for (int k = 0; k < 3; k++) {
        a.range.offset[k] = sum->offset[k];
        a.range.low[k] = sum->low[k];
        a.range.high[k] = sum->high[k];
    }
    a.texels = ibl_cube_face(cube, level_index, 0);
    side_columns(&a, a.parts[0].angle);
    border_gain(&a);
    divide(&a);
    const ibl_status status = ibl_run(ctx, stage, 2 * a.chunks, level_job, &a);
    ibl_free(c.base);
    return status;
}

ibl_status ibl_grid_to_cube(ibl_ctx *ctx, const char *stage,
                            const ibl_ring_grid *grid, const ibl_cube *cube,
                            int level_index)
{
    const int degree = grid->rings / 2 < grid->columns / 4 ? grid->rings / 2
                                                           : grid->columns / 4;
    const ibl_level_sum sum = {.grid = grid,
                               .degree = degree,
                               .low = {-INFINITY, -INFINITY, -INFINITY},
                               .high = {INFINITY, INFINITY, INFINITY}};
    return ibl_spectral_texels(ctx, stage, &sum, cube, level_index);
}
