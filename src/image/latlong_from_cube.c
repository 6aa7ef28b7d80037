/* SPDX-License-Identifier: MIT */
/*
 * Maps a cube to an equirectangular map: the reverse of image/level0.c.
 *
 * Along a meridian, solid angle is proportional to z, the sine of the latitude.
 * The z at which a meridian leaves a texel is known in closed form. By symmetry
 * it is the same in sixteen octants: eight of the horizon, north and south. So
 * one octant is walked, and 16 x RGB, a bundle of the mirrored texels, is added
 * at once. The walked octant is north, with azimuths from 0 (+X) to pi/4. It
 * covers half of the +X face's upper half, whose bundles are by column from the
 * middle and row from the top, and an eighth of +Y, whose bundles are by steps
 * from the middle along +X and along +Z.
 *
 * A job is some columns of the octant, and writes only their pixels.
 */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"
#include "image/image.h"

enum {
    SUBDIVISIONS = 4,
    LEAST_WIDTH = 256,
    WAYS = 16,
    BUNDLE = 3 * WAYS,
    JOB_COLUMNS = 4
};

typedef struct mapper {
    const ibl_cube *cube;
    ibl_image *map;
    int half; /* texels from a face's middle to its edge; a middle one counts */
    double
        *lines; /* half + 1 borders of texels, from a face's middle, 0, to 1 */
    double *edges;      /* azimuths of the borders between columns: half + 1 */
    double *z;          /* z of the borders of rows, height / 2 + 1 */
    float *side, *pole; /* half x half bundles each */
    ibl_octant_place place[WAYS / 2][3];
    double *sums; /* for each worker one bundle per row */
} mapper;

/* The sixteen octants: eight in the north, then eight in the south. */
static bool is_south(int way)
{
    return way >= WAYS / 2;
}

int ibl_latlong_width(int size)
{
    if (size > IBL_MAX_EDGE / 8)
        return IBL_MAX_EDGE;
    return 8 * size > LEAST_WIDTH ? 8 * size : LEAST_WIDTH;
}

/* ---- bundles ----------------------------------------------------------- */

static const float *texel(const mapper *m, int way, bool side, int line, int z)
{
    const ibl_octant_face face = side            ? IBL_OCTANT_SIDE
                                 : is_south(way) ? IBL_OCTANT_BOTTOM
                                                 : IBL_OCTANT_TOP;
    const ibl_octant_place *p = &m->place[way % 8][face];
    if (side && is_south(way))
        line = m->cube->size - 1 - line;
    return p->base + line * p->line + z * p->step;
}

static void bundle_row(void *arg, int row, int worker)
{
    const mapper *m = arg;
    const size_t first = (size_t)row * (size_t)m->half * BUNDLE;

    (void)worker;
    for (int i = 0; i < m->half; i++)
        for (int k = 0; k < WAYS; k++) {
            const size_t at = first + (size_t)(BUNDLE * i + 3 * k);
            memcpy(m->side + at, texel(m, k, true, i, row), 3 * sizeof(float));
            memcpy(m->pole + at, texel(m, k, false, row, i), 3 * sizeof(float));
        }
}

/* ---- meridians --------------------------------------------------------- */

/* State of the walk along a meridian from +Y down. */
typedef struct walker {
    const mapper *m;
    double *sums;
    double width; /* of the meridian, in radians */
    double z;
    int row;
} walker;

static void add(double *restrict sums, const float *restrict bundle,
                double weight)
{
    for (int k = 0; k < BUNDLE; k++)
        sums[k] += weight * (double)bundle[k];
}

/* Moves down to z through one bundle. */
static void go(walker *w, double z, const float *bundle)
{
    const int last = w->m->map->height / 2 - 1;

    while (w->z > z) {
        const bool over = w->row < last && w->m->z[w->row + 1] >= z;
        const double to = over ? w->m->z[w->row + 1] : z;
        add(w->sums + (size_t)w->row * BUNDLE, bundle, w->width * (w->z - to));
        w->z = to;
        w->row += over;
    }
}

/* At distance rho from the middle of +Y, z = 1 / sqrt(1 + rho^2). */
static void walk_pole(walker *w, double along_x, double along_z)
{
    const mapper *m = w->m;
    const double by_x = 1 / along_x, by_z = 1 / along_z;
    int p = 0, q = 0;

    while (p < m->half) {
        const double to_p = m->lines[p + 1] * by_x;
        const double to_q = m->lines[q + 1] * by_z;
        const double rho = to_p < to_q ? to_p : to_q;
        go(w, 1 / sqrt(1 + rho * rho),
           m->pole + ((size_t)p * (size_t)m->half + (size_t)q) * BUNDLE);
        p += to_p <= rho;
        /* On the diagonal, rounding may choose the other side. */
        q += to_q <= rho && q + 1 < m->half;
    }
}

static void walk_side(walker *w, double along_x, int column)
{
    const mapper *m = w->m;
    const float *bundle = m->side + (size_t)column * (size_t)m->half * BUNDLE;

    for (int y = 0; y < m->half; y++, bundle += BUNDLE) {
        const double t = m->lines[m->half - 1 - y] * along_x;
        go(w, t / sqrt(1 + t * t), bundle);
    }
}

/* ---- columns ----------------------------------------------------------- */

/* Sums column x of the octant. *texels is the column of texels at its start. */
static void sum_column(const mapper *m, int x, int *texels, double *sums)
{
    const int w = m->map->width;
    const double end = 2 * IBL_PI * (x + 1) / w;

    memset(sums, 0, (size_t)(m->map->height / 2) * BUNDLE * sizeof *sums);
    for (double from = 2 * IBL_PI * x / w; from < end;) {
        while (*texels + 1 < m->half && m->edges[*texels + 1] <= from)
            ++*texels;
        const bool last = *texels + 1 == m->half;
        const double to = last ? end : fmin(end, m->edges[*texels + 1]);
        const double width = (to - from) / SUBDIVISIONS;
        for (int i = 0; i < SUBDIVISIONS; i++) {
            const double azimuth = from + (i + 0.5) * width;
            walker at = {m, sums, width, 1, 0};
            walk_pole(&at, cos(azimuth), sin(azimuth));
            walk_side(&at, cos(azimuth), *texels);
        }
        from = to;
    }
}

/* Writes the pixels of one row in all sixteen octants from its sums. */
static void put_row(const mapper *m, const size_t column[WAYS], int row,
                    const double *sums)
{
    const size_t width = (size_t)m->map->width;
    const double scale =
        (double)width / (2 * IBL_PI * (m->z[row] - m->z[row + 1]));

    for (int k = 0; k < WAYS; k++, sums += 3) {
        const int y = is_south(k) ? m->map->height - 1 - row : row;
        float *pixel = m->map->data + 3 * ((size_t)y * width + column[k]);
        for (int c = 0; c < 3; c++)
            pixel[c] = (float)(sums[c] * scale);
    }
}

static void put_column(const mapper *m, int x, const double *sums)
{
    const int width = m->map->width;
    size_t column[WAYS];

    for (int k = 0; k < WAYS; k++) {
        const int from = width / 2 + (k % 8 + 1) / 2 * (width / 4);
        column[k] = (size_t)((from + (k % 2 ? -1 - x : x)) % width);
    }
    for (int r = 0; r < m->map->height / 2; r++)
        put_row(m, column, r, sums + (size_t)r * BUNDLE);
}

static void fill_columns(void *arg, int job, int worker)
{
    const mapper *m = arg;
    const int all = m->map->width / 8, from = job * JOB_COLUMNS;
    const int to = from + JOB_COLUMNS < all ? from + JOB_COLUMNS : all;
    double *sums =
        m->sums + (size_t)worker * (size_t)(m->map->height / 2) * BUNDLE;
    int texels = 0;

    for (int x = from; x < to; x++) {
        sum_column(m, x, &texels, sums);
        put_column(m, x, sums);
    }
}

/* ---- the whole --------------------------------------------------------- */

static bool make(mapper *m, int threads)
{
    const size_t h = (size_t)m->half, rows = (size_t)(m->map->height / 2);
    const double height = m->map->height;

    m->edges = ibl_alloc_array(h + 1, sizeof *m->edges);
    m->lines = ibl_alloc_array(h + 1, sizeof *m->lines);
    m->z = ibl_alloc_array(rows + 1, sizeof *m->z);
    m->side = ibl_alloc_array(h * h, BUNDLE * sizeof *m->side);
    m->pole = ibl_alloc_array(h * h, BUNDLE * sizeof *m->pole);
    m->sums = ibl_alloc_array(rows * (size_t)threads, BUNDLE * sizeof *m->sums);
    if (!m->edges || !m->lines || !m->z || !m->side || !m->pole || !m->sums)
        return false;
    for (int k = 0; k < 3 * WAYS / 2; k++)
        m->place[k / 3][k % 3] =
            ibl_octant_place_of(m->cube, k / 3, (ibl_octant_face)(k % 3));
    for (int c = 0; c <= m->half; c++) {
        m->lines[c] =
            c ? 2.0 * (m->cube->size - m->half + c) / m->cube->size - 1 : 0;
        m->edges[c] = atan(m->lines[c]);
    }
    for (size_t y = 0; y < rows; y++)
        m->z[y] = cos(IBL_PI * (double)y / height);
    m->z[rows] = 0;
    return true;
}

ibl_status ibl_latlong_from_cube(ibl_ctx *ctx, const ibl_cube *cube,
                                 ibl_image *map)
{
    ibl_status status = ibl_check_cube(ctx, cube);

    if (!status)
        status = ibl_check_image(ctx, map);
    if (status)
        return status;
    if (map->width < 8 || map->width % 8 || map->height < 2 || map->height % 2)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a map of %dx%d for a cube: its width must be a "
                        "multiple of 8, its height even",
                        map->width, map->height);
    mapper m = {.cube = cube, .map = map, .half = (cube->size + 1) / 2};
    const int columns = map->width / 8;
    if (!make(&m, ibl_ctx_threads(ctx)))
        status = ibl_no_memory(ctx, "the map of a cube");
    if (!status)
        status = ibl_run(ctx, NULL, m.half, bundle_row, &m);
    if (!status)
        status = ibl_run(ctx, "map", (columns + JOB_COLUMNS - 1) / JOB_COLUMNS,
                         fill_columns, &m);
    ibl_free(m.edges);
    ibl_free(m.lines);
    ibl_free(m.z);
    ibl_free(m.side);
    ibl_free(m.pole);
    ibl_free(m.sums);
    return status;
}
