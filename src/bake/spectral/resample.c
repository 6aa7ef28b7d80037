/* SPDX-License-Identifier: MIT */
#include "bake/spectral/resample.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"

enum {
    ROWS = 8, /* in a job */
    TILE = IBL_LEVEL_TILE,
    BLOCK = IBL_RADIAL_BLOCK,
    BORDER = IBL_GRID_BORDER,
    MIN_COLUMNS = 128,
    BAND_BYTES = 3 << 20, /* of rings that are held */
    MIN_PAIRS = 96,
    MULTIPLE = 16 /* of the rings */
};
_Static_assert(TILE % BLOCK == 0, "whole blocks");

/* ---- grids -------------------------------------------------------------- */

ibl_ring_grid ibl_ring_grid_for(int degree)
{
    const double needed = IBL_GRID_SAMPLES * degree;
    int columns = MIN_COLUMNS;

    while (columns < 2.05 * degree)
        columns *= 2;
    const int half =
        MULTIPLE / 2 * (int)ceil(fmax(needed, MIN_COLUMNS) / 2 / MULTIPLE);
    const int fit = BAND_BYTES / (32 * columns);
    const int least = fit > MIN_PAIRS ? fit : MIN_PAIRS;
    return (ibl_ring_grid){.rings = 2 * half,
                           .columns = columns,
                           .pairs = half < least ? half : least};
}

ibl_status ibl_ring_grid_alloc(ibl_ctx *ctx, int rings, int columns, int pairs,
                               ibl_ring_grid *grid)
{
    assert(rings >= 2 && rings % 2 == 0 && rings <= IBL_MAX_EDGE &&
           columns >= 4 && columns <= IBL_MAX_EDGE &&
           !(columns & (columns - 1)) && pairs <= rings / 2);
    const size_t stride = 4 * ((size_t)columns + 2 * BORDER);
    const size_t rows = (size_t)pairs + 2 * BORDER;
    float *data = ibl_alloc_array(2 * rows, stride * sizeof *data);

    *grid = (ibl_ring_grid){0};
    if (!data)
        return ibl_no_memory(ctx, "a grid of rings");
    *grid =
        (ibl_ring_grid){rings, columns, 0, pairs, stride, rows * stride, data};
    return IBL_OK;
}

void ibl_ring_grid_free(ibl_ring_grid *grid)
{
    ibl_free(grid->data);
    *grid = (ibl_ring_grid){0};
}

void ibl_ring_grid_close(const ibl_ring_grid *grid, int south, int ring)
{
    const size_t n = (size_t)grid->columns, half = n / 2, whole = 4 * n;
    const int across = grid->rings - 1 - ring;
    const size_t edge = 4 * BORDER * sizeof(float);
    float *row = ibl_ring_grid_at(grid, south, ring);

    memcpy(row - 4 * BORDER, row + whole - 4 * BORDER, edge);
    memcpy(row + whole, row, edge);
    if (ring < BORDER - grid->first) {
        float *to = ibl_ring_grid_at(grid, south, -1 - ring) - 4 * BORDER;
        memcpy(to, row + 4 * half - 4 * BORDER, 4 * half * sizeof *to + edge);
        memcpy(to + 4 * half + 4 * BORDER, row, 4 * half * sizeof *to + edge);
    }
    if (across < grid->first + grid->pairs + BORDER)
        memcpy(ibl_ring_grid_at(grid, !south, across) - 4 * BORDER,
               row - 4 * BORDER, grid->stride * sizeof *row);
}

/* ---- texels ------------------------------------------------------------- */

typedef struct level {
    const ibl_level_sum *sum;
    ibl_interp_dsp dsp;
    ibl_radial_dsp radial;
    ibl_level_shape shape;
    int bands; /* of rows, in a face */
    float *texels;
} level;

/* The directions of TILE texels of a row from x on, as from points(). Those
 * beyond the row repeat the last one. */
static void directions(const level *a, int face, int y, int x, float *point)
{
    const int n = a->shape.width;
    const ibl_face_axes *axes = &ibl_face[face];
    const signed char *axis[3] = {axes->forward, axes->right, axes->down};
    float own[6 * TILE];

    if (a->shape.projection == IBL_PROJECTION_CUBE) {
        a->radial.points((2 * y + 1) / (double)n - 1, n, x, TILE, own);
        for (int k = 0; k < 6; k++)
            for (int i = n - x; i < TILE; i++)
                own[k * TILE + i] = own[k * TILE + n - x - 1];
        for (int j = 0; j < 6; j++)
            for (int k = 0; k < 3; k++) {
                const float sign = axis[j % 3][k];
                float *to = point + (k + j / 3 * 3) * TILE;
                if (sign != 0)
                    for (int i = 0; i < TILE; i++)
                        to[i] = sign * own[j * TILE + i];
            }
        return;
    }
    for (int i = 0; i < TILE; i++) {
        double d[3];
        ibl_level_direction(&a->shape, 0, x + i < n ? x + i : n - 1, y, d);
        for (int k = 0; k < 3; k++) {
            point[k * TILE + i] = (float)d[k];
            point[(k + 3) * TILE + i] =
                (float)(d[k] - (double)point[k * TILE + i]);
        }
    }
}

/* Finds the rings that texels need, to two, from the range of |y|; true if some
 * are in the bands. */
static bool find_reach(const level *a, const float *y, int count, int *reach)
{
    const ibl_ring_grid *grid = a->sum->grid;
    const double per_radian = grid->rings / IBL_PI;
    float least = 1, most = 0;

    for (int i = 0; i < count; i++) {
        const float height = fabsf(y[i]);
        least = height < least ? height : least;
        most = height > most ? height : most;
    }
    reach[0] = (int)(acos(fmin((double)most, 1)) * per_radian - 2.5);
    reach[1] = (int)(acos((double)least) * per_radian + 1.5);
    return reach[1] >= grid->first && reach[0] < grid->first + grid->pairs;
}

/* rgb[3 i + c] = rgba[4 i + c] gain + offset[c], limited to low[c]..high[c];
 * NaN becomes low[c]. */
static void finish(const float *rgba, const ibl_interp_range *range, int count,
                   float *rgb)
{
    const ibl_interp_range a = *range; /* a copy, which rgb cannot alias */
    for (int i = 0; i < count; i++, rgba += 4, rgb += 3)
#pragma GCC unroll 3
        for (int c = 0; c < 3; c++) {
            const float x = rgba[c] * a.gain + a.offset[c];
            const float y = x > a.low[c] ? x : a.low[c];
            rgb[c] = y < a.high[c] ? y : a.high[c];
        }
}

/* Makes the texels of a tile that lie between the rings of the bands. */
static void make_tile(const level *a, int face, int y, int x, int *reach,
                      bool known)
{
    const ibl_ring_grid *grid = a->sum->grid;
    const int width = a->shape.width, last = grid->first + grid->pairs;
    const int before = grid->first ? grid->first : -1;
    const int all = x + TILE < width ? TILE : width - x;
    double theta[TILE], phi[TILE];
    int ring[TILE], column[TILE], place[TILE], count = 0;
    float ring_weight[IBL_TAPS * TILE], column_weight[IBL_TAPS * TILE];
    float point[6 * TILE], rgba[4 * TILE] = {0}, rgb[3 * TILE];
    bool south[TILE];
    float *to =
        a->texels + 3 * (((size_t)face * (size_t)a->shape.height + (size_t)y) *
                             (size_t)width +
                         (size_t)x);

    if (known && (reach[1] < grid->first || reach[0] >= last))
        return;
    directions(a, face, y, x, point);
    if (!find_reach(a, point + TILE, all, reach))
        return;
    a->dsp.angles(point, TILE, (all + 7) / 8 * 8, theta, phi);
    for (int i = 0; i < all; i++)
        theta[i] = theta[i] > IBL_PI / 2 ? IBL_PI - theta[i] : theta[i];
    /* Those inside move together. */
    for (int i = 0; i < all; i++) {
        const int at = (int)(theta[i] * grid->rings / IBL_PI + 0.5) - 1;
        if (at < before || at >= last)
            continue;
        south[count] = point[TILE + i] < 0;
        theta[count] = theta[i];
        phi[count] = phi[i];
        for (int k = 0; k < 6 && count < i; k++)
            point[k * TILE + count] = point[k * TILE + i];
        place[count++] = i;
    }
    a->dsp.weights(-0.5, grid->rings / IBL_PI, theta, count, ring, ring_weight);
    a->dsp.weights(0.5 * grid->columns - 0.5, grid->columns / (2 * IBL_PI), phi,
                   count, column, column_weight);
    for (int i = 0; i < count; i++)
        ring[i] +=
            (south[i] ? (int)(grid->band / grid->stride) : 0) - grid->first;
    a->dsp.row(&(ibl_interp_row){.grid = ibl_ring_grid_at(grid, 0, grid->first),
                                 .stride = (ptrdiff_t)grid->stride,
                                 .ring = ring,
                                 .column = column,
                                 .ring_weight = ring_weight,
                                 .column_weight = column_weight,
                                 .count = count,
                                 .rgba = rgba});
    for (int i = 0; a->sum->bright && i < count; i += BLOCK)
        ibl_point_lights_add(a->sum->bright, &a->radial, point + i, TILE,
                             rgba + 4 * (ptrdiff_t)i);
    finish(rgba, &a->sum->range, count, rgb);
    for (int i = 0; i < count; i++)
        memcpy(to + 3 * (ptrdiff_t)place[i], rgb + 3 * (ptrdiff_t)i,
               3 * sizeof *rgb);
}

/* Rows of tiles, tile by tile: each row finds most of its samples where the one
 * before has read them, and in the first cache. */
static void rows_job(void *arg, int job, int worker)
{
    const level *a = arg;
    const int face = job / a->bands, first = job % a->bands * ROWS;
    const int tiles = (a->shape.width + TILE - 1) / TILE;
    const int height = a->shape.height;
    (void)worker;

    for (int t = 0; t < tiles; t++)
        for (int y = first; y < first + ROWS && y < height; y++) {
            int own[2], (*reach)[2] = a->sum->reach;
            const size_t at =
                ((size_t)face * (size_t)height + (size_t)y) * (size_t)tiles +
                (size_t)t;
            make_tile(a, face, y, t * TILE, reach ? reach[at] : own,
                      reach && a->sum->grid->first > 0);
        }
}

ibl_status ibl_spectral_texels(ibl_ctx *ctx, const ibl_level_sum *sum,
                               const ibl_cube *cube, int level_index)
{
    level a = {.sum = sum,
               .shape = ibl_map_shape(cube, level_index),
               .texels = ibl_cube_face(cube, level_index, 0)};

    a.bands = (a.shape.height + ROWS - 1) / ROWS;
    ibl_interp_dsp_init(&a.dsp, ibl_ctx_isa(ctx));
    ibl_radial_dsp_init(&a.radial, ibl_ctx_isa(ctx));
    return ibl_run(ctx, NULL, a.shape.faces * a.bands, rows_job, &a);
}
