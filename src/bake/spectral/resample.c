/* SPDX-License-Identifier: MIT */
/*
 * The texels of a cube come in families of equal positions. Column x of the
 * four side faces lies on one meridian, at -atan(u) from the face's middle,
 * and the faces differ by a quarter of the columns. Texels at u and -u, and
 * rows at v and -v, are mirror images, in which taps change their order.
 * On top and bottom u and v, both signs of each, and the two faces share one
 * distance from the pole and one azimuth in its quadrant.
 *
 * So a job takes some pairs of rows, y and n - 1 - y, of the four side faces
 * or of top and bottom, and finds places and weights once for all of them.
 */
#include "bake/spectral/resample.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "bake/spectral/interp_weights.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"

enum {
    PAIRS = 8, /* of rows in a job, at most */
    TILE = 64, /* texels along a row, a multiple of IBL_RADIAL_BLOCK */
    LIGHTS_PER_JOB = 1 << 20 /* times texels, if it is more than a pair */
};

/* ---- grids -------------------------------------------------------------- */

ibl_status ibl_ring_grid_alloc(ibl_ctx *ctx, int rings, int columns,
                               ibl_ring_grid *grid)
{
    assert(rings >= 1 && rings <= IBL_MAX_EDGE && columns >= 4 &&
           columns <= IBL_MAX_EDGE && !(columns & (columns - 1)));
    const size_t stride = 4 * ((size_t)columns + 2 * IBL_GRID_BORDER);
    const size_t rows = (size_t)rings + 2 * IBL_GRID_BORDER;
    float *data = ibl_alloc_array(rows, stride * sizeof *data);

    *grid = (ibl_ring_grid){0};
    if (!data)
        return ibl_no_memory(ctx, "a grid of rings");
    *grid = (ibl_ring_grid){rings, columns, stride, data};
    return IBL_OK;
}

void ibl_ring_grid_free(ibl_ring_grid *grid)
{
    ibl_free(grid->data);
    *grid = (ibl_ring_grid){0};
}

/* The ring that a border ring copies; turned: by half a turn. */
static int ring_behind(const ibl_ring_grid *grid, int row, bool *turned)
{
    const int around = 2 * grid->rings;
    row = (row % around + around) % around;
    *turned = row >= grid->rings;
    return *turned ? around - 1 - row : row;
}

/* Writes a row with its border, from column `shift` of another row on. */
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
        bool turned;
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

/* ---- texels ------------------------------------------------------------- */

/* First tap of each texel, and the weights, 8 per texel. */
typedef struct places {
    int *first;
    float *weight;
} places;

/* A worker's places for a pair of rows, y and n - 1 - y. */
typedef struct pair {
    places ring;   /* of the upper row's left half */
    places column; /* of the upper row of a pole */
} pair;

typedef struct scratch {
    double *angle, *azimuth; /* of a half row */
    pair pair[PAIRS];
} scratch;

typedef struct level {
    const ibl_level_sum *sum;
    ibl_interp_dsp dsp;
    ibl_radial_dsp radial;
    ibl_interp_weights ring_taps, column_taps;
    places column;         /* of +X, every row */
    scratch *parts;        /* one for each worker */
    int n, half;           /* edge, and (n + 1) / 2 */
    ibl_level_shape shape; /* if flat, all but n, half, chunks and places */
    int chunk;             /* pairs of rows in a job */
    int chunks;            /* jobs for all pairs */
    float *texels;
} level;

/* The right half of columns from the left: the first tap is that of the mirror
 * image, the weights are in reverse. */
static void mirror(const level *a, const places *p)
{
    const int end = a->sum->grid->columns - IBL_TAPS;
    for (int i = a->half; i < a->n; i++) {
        const ptrdiff_t k = a->n - 1 - i;
        float *to = p->weight + IBL_TAPS * (ptrdiff_t)i;
        p->first[i] = end - p->first[k];
        for (int t = 0; t < IBL_TAPS; t++)
            to[t] = p->weight[IBL_TAPS * k + IBL_TAPS - 1 - t];
    }
}

/* Fills the columns for every row of +X: phi = -atan(u), > 0 on the left. */
static void side_columns(level *a, double *angle)
{
    const int columns = a->sum->grid->columns;
    for (int i = 0; i < a->half; i++)
        angle[i] = atan(1 - (2 * i + 1) / (double)a->n);
    a->dsp.weights(&a->column_taps, 0.5 * columns - 0.5, columns / (2 * IBL_PI),
                   angle, a->half, a->column.first, a->column.weight);
    mirror(a, &a->column);
}

/* Rows y of the side faces: theta = pi / 2 + the latitude of v, since v grows
 * downwards. */
static void prepare_side(const level *a, double v, scratch *s, const pair *p)
{
    const int rings = a->sum->grid->rings;
    a->dsp.latitudes(v, a->n, a->half, s->angle);
    a->dsp.weights(&a->ring_taps, 0.5 * rings - 0.5, rings / IBL_PI, s->angle,
                   a->half, p->ring.first, p->ring.weight);
}

/*
 * Rows y of top and bottom. On the top v <= 0, and with the azimuth in its
 * quadrant, a, phi is a - pi on the left, half a turn from a, and -a on the
 * right, the mirror image of a.
 */
static void prepare_pole(const level *a, double v, scratch *s, const pair *p)
{
    const int columns = a->sum->grid->columns;
    a->dsp.polar(v, a->n, a->half, s->angle, s->azimuth);
    a->dsp.weights(&a->ring_taps, -0.5, a->sum->grid->rings / IBL_PI, s->angle,
                   a->half, p->ring.first, p->ring.weight);
    a->dsp.weights(&a->column_taps, 0.5 * columns - 0.5, columns / (2 * IBL_PI),
                   s->azimuth, a->half, p->column.first, p->column.weight);
    mirror(a, &p->column);
    for (int i = 0; i < a->half; i++)
        p->column.first[i] -= columns / 2;
}

/* Some texels of a row, all left or all right of the middle. */
typedef struct tile {
    int face, y, begin, end;
    const places *ring, *column;
    bool low;       /* south of the equator: rings mirrored */
    bool backwards; /* columns from right to left */
    int turn;       /* columns to add */
} tile;

static void interpolate(const level *a, const tile *t, float *rgba)
{
    const ibl_ring_grid *grid = a->sum->grid;
    const ptrdiff_t last = a->n - 1, stride = (ptrdiff_t)grid->stride;
    const bool left = t->begin < a->half;
    const ptrdiff_t ring = left ? t->begin : last - t->begin;
    const ptrdiff_t column = t->backwards ? last - t->begin : t->begin;
    const float *first = ibl_ring_grid_at(grid, t->low ? grid->rings - 1 : 0);
    const ibl_interp_row row = {
        .grid = first + 4 * (ptrdiff_t)t->turn,
        .stride = t->low ? -stride : stride,
        .ring = t->ring->first + ring,
        .column = t->column->first + column,
        .ring_weight = t->ring->weight + IBL_TAPS * ring,
        .column_weight = t->column->weight + IBL_TAPS * column,
        .ring_step = left ? 1 : -1,
        .column_step = t->backwards ? -1 : 1,
        .count = t->end - t->begin,
        .rgba = rgba};
    a->dsp.row(&row);
}

/* rgba has room for whole blocks. */
static void add_lights(const level *a, const tile *t, int count, float *rgba)
{
    const double v = (2 * t->y + 1) / (double)a->n - 1;
    float point[6 * IBL_RADIAL_BLOCK];
    for (int at = 0; at < count; at += IBL_RADIAL_BLOCK) {
        a->radial.points(v, a->n, t->begin + at, IBL_RADIAL_BLOCK, point);
        ibl_point_lights_add(a->sum->bright, t->face, &a->radial, point,
                             rgba + 4 * at);
    }
}

static void make_tile(const level *a, const tile *t)
{
    const size_t n = (size_t)a->n;
    const size_t at = ((size_t)t->face * n + (size_t)t->y) * n;
    const int count = t->end - t->begin;
    float rgba[4 * TILE] = {0};
    interpolate(a, t, rgba);
    if (a->sum->bright)
        add_lights(a, t, count, rgba);
    ibl_interp_finish(rgba, &a->sum->range, count,
                      a->texels + 3 * (at + (size_t)t->begin));
}

/* One face's upper or lower rows of a job. They are made tile by tile, in
 * columns of tiles: each row finds most of its samples where the one before
 * has read them, and in the first cache. */
typedef struct strip {
    int face, y, rows;
    bool upwards; /* rows n - 1 - y, n - 2 - y, ... */
    bool pole, low, backwards;
    int left, right; /* turns of its halves, in columns */
} strip;

static void make_column_of_tiles(const level *a, const strip *s,
                                 const scratch *parts, int begin, int end)
{
    const bool left = begin < a->half;
    for (int k = 0; k < s->rows; k++) {
        const pair *p = &parts->pair[k];
        const tile t = {.face = s->face,
                        .y = s->upwards ? a->n - 1 - s->y - k : s->y + k,
                        .begin = begin,
                        .end = end,
                        .ring = &p->ring,
                        .column = s->pole ? &p->column : &a->column,
                        .low = s->low,
                        .backwards = s->backwards,
                        .turn = left ? s->left : s->right};
        if (2 * t.y + 1 != a->n || !s->upwards)
            make_tile(a, &t);
    }
}

static void make_strip(const level *a, const strip *s, const scratch *parts)
{
    for (int begin = 0; begin < a->n;) {
        const int stop = begin < a->half ? a->half : a->n;
        const int end = begin + TILE < stop ? begin + TILE : stop;
        make_column_of_tiles(a, s, parts, begin, end);
        begin = end;
    }
}

/* The side faces are a quarter turn apart. On -X, half a turn from +X, the
 * left half of the columns are the grid's first and the right half its last. */
static void make_sides(const level *a, int y, int rows, const scratch *parts)
{
    static const struct {
        int face, left, right; /* quarter turns */
    } side[4] = {{0, 0, 0}, {1, -2, 2}, {4, 1, 1}, {5, -1, -1}};
    const int quarter = a->sum->grid->columns / 4;
    for (int k = 0; k < 8; k++) {
        const strip s = {.face = side[k / 2].face,
                         .y = y,
                         .rows = rows,
                         .low = k % 2,
                         .upwards = k % 2,
                         .left = side[k / 2].left * quarter,
                         .right = side[k / 2].right * quarter};
        make_strip(a, &s, parts);
    }
}

/* Row n - 1 - y of the top is row y from right to left and half a turn on;
 * rows of the bottom have z = -v, so there it is row y that is so. */
static void make_poles(const level *a, int y, int rows, const scratch *parts)
{
    for (int k = 0; k < 4; k++) {
        const bool bottom = k / 2, upwards = k % 2;
        const int turn = bottom != upwards ? a->sum->grid->columns / 2 : 0;
        const strip s = {.face = bottom ? 3 : 2,
                         .y = y,
                         .rows = rows,
                         .pole = true,
                         .low = bottom,
                         .backwards = bottom != upwards,
                         .upwards = upwards,
                         .left = turn,
                         .right = turn};
        make_strip(a, &s, parts);
    }
}

/* ---- flat levels -------------------------------------------------------- */

/* Of up to TILE texels from x on in row y. The parts of their places are not
 * shared, and their directions are found one by one. */
static void make_flat_tile(const level *a, int y, int x, int count)
{
    const ibl_ring_grid *grid = a->sum->grid;
    const size_t at = (size_t)y * (size_t)a->shape.width + (size_t)x;
    double theta[TILE] = {0}, phi[TILE] = {0};
    int ring[TILE], column[TILE];
    float ring_weight[IBL_TAPS * TILE], column_weight[IBL_TAPS * TILE];
    float rgba[4 * TILE] = {0},
                   points[TILE / IBL_RADIAL_BLOCK][6 * IBL_RADIAL_BLOCK];

    for (int i = 0; i < TILE; i++) {
        float *point = points[i / IBL_RADIAL_BLOCK] + i % IBL_RADIAL_BLOCK;
        double d[3];
        ibl_level_direction(&a->shape, 0, x + (i < count ? i : count - 1), y,
                            d);
        theta[i] = atan2(hypot(d[0], d[2]), d[1]);
        phi[i] = atan2(d[2], d[0]);
        for (int k = 0; k < 3; k++) {
            const float whole = (float)d[k];
            point[k * IBL_RADIAL_BLOCK] = whole;
            point[(k + 3) * IBL_RADIAL_BLOCK] = (float)(d[k] - (double)whole);
        }
    }
    a->dsp.weights(&a->ring_taps, -0.5, grid->rings / IBL_PI, theta, count,
                   ring, ring_weight);
    a->dsp.weights(&a->column_taps, 0.5 * grid->columns - 0.5,
                   grid->columns / (2 * IBL_PI), phi, count, column,
                   column_weight);
    const ibl_interp_row row = {.grid = ibl_ring_grid_at(grid, 0),
                                .stride = (ptrdiff_t)grid->stride,
                                .ring = ring,
                                .column = column,
                                .ring_weight = ring_weight,
                                .column_weight = column_weight,
                                .ring_step = 1,
                                .column_step = 1,
                                .count = count,
                                .rgba = rgba};
    a->dsp.row(&row);
    for (int i = 0; a->sum->bright && i < count; i += IBL_RADIAL_BLOCK)
        ibl_point_lights_add_at(a->sum->bright, &a->radial,
                                points[i / IBL_RADIAL_BLOCK], rgba + 4 * i);
    ibl_interp_finish(rgba, &a->sum->range, count, a->texels + 3 * at);
}

static void flat_job(void *arg, int y, int worker)
{
    const level *a = arg;
    (void)worker;
    for (int x = 0; x < a->shape.width; x += TILE) {
        const int left = a->shape.width - x;
        make_flat_tile(a, y, x, left < TILE ? left : TILE);
    }
}

/* ---- jobs ---------------------------------------------------------------- */

static void level_job(void *arg, int job, int worker)
{
    const level *a = arg;
    scratch *parts = &a->parts[worker];
    const bool poles = job >= a->chunks;
    const int y = (poles ? job - a->chunks : job) * a->chunk;
    const int rows = y + a->chunk < a->half ? a->chunk : a->half - y;
    for (int k = 0; k < rows; k++) {
        const double v = (2 * (y + k) + 1) / (double)a->n - 1;
        (poles ? prepare_pole : prepare_side)(a, v, parts, &parts->pair[k]);
    }
    (poles ? make_poles : make_sides)(a, y, rows, parts);
}

/* ---- setting up -------------------------------------------------------- */

/* Cuts memory into pieces; with base NULL it only sums up their sizes. */
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

/* Half rows are written up to a multiple of 8. */
static void cut_scratch(cutter *c, const level *a, scratch *s)
{
    const size_t n = (size_t)a->n, half = ((size_t)a->half + 7) / 8 * 8;
    s->angle = cut(c, half, sizeof *s->angle);
    s->azimuth = cut(c, half, sizeof *s->azimuth);
    for (int k = 0; k < a->chunk; k++) {
        pair *p = &s->pair[k];
        p->ring = cut_places(c, half);
        p->column = cut_places(c, n);
    }
}

/* Cuts all memory of a level from one piece. */
static void cut_level(cutter *c, level *a, int threads)
{
    scratch none;
    a->parts = cut(c, (size_t)threads, sizeof *a->parts);
    a->column = cut_places(c, (size_t)a->n);
    for (int i = 0; i < threads; i++)
        cut_scratch(c, a, a->parts ? &a->parts[i] : &none);
}

/* Few jobs for small levels, and short jobs for many lights. */
static void divide(level *a)
{
    const ibl_point_lights *bright = a->sum->bright;
    const long lights = bright ? ibl_point_lights_count(bright) : 0;
    long chunk = LIGHTS_PER_JOB / (8L * a->n * (lights + 1));
    chunk = chunk > PAIRS ? PAIRS : chunk < 1 ? 1 : chunk;
    a->half = (a->n + 1) / 2;
    a->chunk = chunk < a->half ? (int)chunk : a->half;
    a->chunks = (a->half + a->chunk - 1) / a->chunk;
}

static ibl_status run_level(ibl_ctx *ctx, const char *stage, level *a)
{
    const ibl_level_sum *sum = a->sum;
    ibl_interp_dsp_init(&a->dsp, ibl_ctx_isa(ctx));
    ibl_radial_dsp_init(&a->radial, ibl_ctx_isa(ctx));
    ibl_interp_weights_design(sum->spectrum, sum->degree,
                              2.0 * sum->grid->rings, &a->ring_taps);
    ibl_interp_weights_design(sum->spectrum, sum->degree, sum->grid->columns,
                              &a->column_taps);
    if (a->shape.projection != IBL_PROJECTION_CUBE)
        return ibl_run(ctx, stage, a->shape.height, flat_job, a);
    side_columns(a, a->parts[0].angle);
    return ibl_run(ctx, stage, 2 * a->chunks, level_job, a);
}

ibl_status ibl_spectral_texels(ibl_ctx *ctx, const char *stage,
                               const ibl_level_sum *sum, const ibl_cube *cube,
                               int level_index)
{
    level a = {.sum = sum,
               .n = ibl_cube_edge(cube->size, level_index),
               .shape = ibl_map_shape(cube, level_index),
               .texels = ibl_cube_face(cube, level_index, 0)};
    cutter size = {0}, memory = {0};
    divide(&a);
    cut_level(&size, &a, ibl_ctx_threads(ctx));
    memory.base = ibl_alloc_array(size.used, 1);
    if (!memory.base)
        return ibl_no_memory(ctx, "the places of a level's texels");
    cut_level(&memory, &a, ibl_ctx_threads(ctx));
    const ibl_status status = run_level(ctx, stage, &a);
    ibl_free(memory.base);
    return status;
}

double ibl_ring_grid_error(const double *spectrum, int degree, int rings,
                           int columns)
{
    ibl_interp_weights taps;
    return hypot(
        ibl_interp_weights_design(spectrum, degree, 2.0 * rings, &taps),
        ibl_interp_weights_design(spectrum, degree, columns, &taps));
}
