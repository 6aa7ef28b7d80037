/* SPDX-License-Identifier: MIT */
/*
 * Maps a cube to an equirectangular map: the reverse of image/level0.c. The
 * cuts that give a pixel's light to the texels that it meets give it theirs.
 *
 * They are the same in sixteen octants: eight of the horizon, north and south.
 * So one is cut, and a bundle of the texels at one place in all is added at
 * once. A job is a row of the north and its mirror.
 */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"
#include "image/image.h"
#include "image/level0_geometry.h"

enum {
    LEAST_WIDTH = 256,
    LEAST_COLUMNS = 512,    /* as image/level0_geometry.h needs */
    WAYS = 2 * IBL_OCTANTS, /* those of the north, then those of the south */
    BUNDLE = 3 * WAYS
};

typedef struct mapper {
    const ibl_cube *cube;
    ibl_image *map;
    ibl_wedge wedge;
    ibl_wedge_part part;  /* all of it */
    int scale_x, scale_y; /* pixels and rows that are cut, in one of the map */
    ibl_octant_place place[IBL_OCTANTS][3];
    struct summing *workers;
} mapper;

/* A row of the map. */
typedef struct summing {
    ibl_wedge_sink sink; /* must be first: take_spans casts it to summing */
    const mapper *m;
    double *sums; /* a bundle for each pixel of the octant */
} summing;

int ibl_latlong_width(int size)
{
    if (size > IBL_MAX_EDGE / 8)
        return IBL_MAX_EDGE;
    return 8 * size > LEAST_WIDTH ? 8 * size : LEAST_WIDTH;
}

/* The texels of a line, from the pole, in all octants. */
static void gather(const mapper *m, int line, int z, double bundle[BUNDLE])
{
    const bool side = line >= m->wedge.half;
    const int i = side ? line - m->wedge.half : line;

    for (int k = 0; k < WAYS; k++) {
        const bool south = k >= IBL_OCTANTS;
        const ibl_octant_place *p =
            &m->place[k % IBL_OCTANTS][side    ? IBL_OCTANT_SIDE
                                       : south ? IBL_OCTANT_BOTTOM
                                               : IBL_OCTANT_TOP];
        const int down = side && south ? m->cube->size - 1 - i : i;
        const float *texel = p->base + down * p->line + z * p->step;
        for (int c = 0; c < 3; c++)
            bundle[3 * k + c] = (double)texel[c];
    }
}

static void take_spans(ibl_wedge_sink *sink)
{
    const summing *s = (const summing *)(void *)sink;
    const mapper *m = s->m;
    double bundle[BUNDLE];

    for (int i = 0; i < sink->count; i++) {
        const ibl_octant_span *span = &sink->spans[i];
        gather(m, span->slot / m->wedge.half, span->slot % m->wedge.half,
               bundle);
        for (int p = 0; p < span->count; p++) {
            const int x = (span->pixel + p) / m->scale_x;
            double *to = s->sums + (ptrdiff_t)BUNDLE * x;
            for (int k = 0; k < BUNDLE; k++)
                to[k] += (double)span->weight * bundle[k];
        }
    }
    sink->count = 0;
}

static void put_rows(const mapper *m, int y, const double *sums)
{
    const int w = m->map->width, h = m->map->height;
    const double height = cos(IBL_PI * y / h) - cos(IBL_PI * (y + 1) / h);
    const double scale = w / (2 * IBL_PI * height);

    for (int i = 0; i < w / 8 * WAYS; i++, sums += 3) {
        const int x = i / WAYS, way = i % WAYS, k = way % IBL_OCTANTS;
        const int from = w / 2 + (k + 1) / 2 * (w / 4);
        const int column = (from + (k % 2 ? -1 - x : x)) % w;
        const int row = way < IBL_OCTANTS ? y : h - 1 - y;
        float *to =
            m->map->data + 3 * ((size_t)row * (size_t)w + (size_t)column);
        for (int c = 0; c < 3; c++)
            to[c] = (float)(sums[c] * scale);
    }
}

static void rows_job(void *arg, int y, int worker)
{
    const mapper *m = arg;
    summing *s = &m->workers[worker];
    const int rows = m->map->height * m->scale_y;

    memset(s->sums, 0, (size_t)(m->map->width / 8) * BUNDLE * sizeof *s->sums);
    for (int j = y * m->scale_y; j < (y + 1) * m->scale_y; j++) {
        ibl_wedge_row row;
        int begin, end;
        if (!ibl_wedge_row_init(&m->wedge, rows, j, false, &row))
            continue;
        ibl_wedge_range(&m->wedge, &row, &m->part, &begin, &end);
        ibl_wedge_cut(&m->wedge, &row, &m->part, begin, end, &s->sink);
    }
    put_rows(m, y, s->sums);
}

static bool make(mapper *m, int threads)
{
    for (int k = 0; k < 3 * IBL_OCTANTS; k++)
        m->place[k / 3][k % 3] =
            ibl_octant_place_of(m->cube, k / 3, (ibl_octant_face)(k % 3));
    m->workers = ibl_alloc_zeroed((size_t)threads, sizeof *m->workers);
    for (int i = 0; m->workers && i < threads; i++) {
        summing *s = &m->workers[i];
        s->m = m;
        s->sink.full = take_spans;
        s->sums = ibl_alloc_array((size_t)m->map->width / 8,
                                  BUNDLE * sizeof *s->sums);
        if (!s->sums)
            return false;
    }
    return m->workers;
}

ibl_status ibl_latlong_from_cube(ibl_ctx *ctx, const ibl_cube *cube,
                                 ibl_image *map)
{
    mapper m = {.cube = cube, .map = map};
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
    const int columns =
        4 * cube->size > LEAST_COLUMNS ? 4 * cube->size : LEAST_COLUMNS;
    m.scale_x = (columns - 1) / map->width + 1;
    m.scale_y = (columns / 2 - 1) / map->height + 1;
    status =
        ibl_wedge_init(ctx, cube->size, m.scale_x * map->width, 0, &m.wedge);
    m.part = (ibl_wedge_part){0, m.wedge.half, 2 * m.wedge.half};
    if (!status && !make(&m, ibl_ctx_threads(ctx)))
        status = ibl_no_memory(ctx, "the map of a cube");
    if (!status)
        status = ibl_run(ctx, "map", map->height / 2, rows_job, &m);
    for (int i = 0; m.workers && i < ibl_ctx_threads(ctx); i++)
        ibl_free(m.workers[i].sums);
    ibl_free(m.workers);
    ibl_wedge_free(&m.wedge);
    return status;
}
