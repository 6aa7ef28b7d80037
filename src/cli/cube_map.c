/* SPDX-License-Identifier: MIT */
#include "cli/cube_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

enum {
    SUBDIVISIONS = 4,
    LEAST_WIDTH = 256
};

int ibl_cube_map_width(int n)
{
    if (n > IBL_MAX_EDGE / 8)
        return IBL_MAX_EDGE;
    return 8 * n > LEAST_WIDTH ? 8 * n : LEAST_WIDTH;
}

/* Part of a meridian within one texel, by its lower end's cosine from +Y. */
typedef struct piece {
    double z;
    const float *rgb;
} piece;

typedef struct mapper {
    const ibl_cube *cube;
    ibl_image *map;
    double *edges;  /* azimuths of the edges of texel columns, rising */
    double *z;      /* of the edges of the map's rows, falling */
    piece *pieces;  /* of one meridian, from +Y down */
    double *column; /* sums of one column of the map */
} mapper;

static const float *texel(const mapper *m, int face, int x, int y)
{
    const int n = m->cube->size;
    return ibl_cube_face(m->cube, 0, face) + 3 * ((size_t)y * (size_t)n + x);
}

/* The first line of the grid of n texels that a ray from its centre crosses
 * along an axis, and the texel that it begins in. */
static int first(double along, int n, int *next)
{
    const int from = along > 0 ? n / 2 : (n + 1) / 2 - 1;
    *next = along > 0 ? from + 1 : from;
    return from;
}

static double line(int k, int n, double along)
{
    return along != 0 ? (2.0 * k / n - 1) / along : HUGE_VAL;
}

/* Pieces of the ray (du, dv) from the centre of a face to its edge; distance
 * rho on the face has the cosine 1 / sqrt(1 + rho^2). */
static int walk_pole(const mapper *m, int face, double du, double dv,
                     piece *pieces)
{
    const int n = m->cube->size;
    const double end = 1 / fmax(fabs(du), fabs(dv));
    int count = 0, next_x, next_y;
    int x = first(du, n, &next_x), y = first(dv, n, &next_y);

    for (double rho = 0; rho < end;) {
        const double to_x = line(next_x, n, du), to_y = line(next_y, n, dv);
        rho = fmin(end, fmin(to_x, to_y));
        pieces[count++] =
            (piece){1 / sqrt(1 + rho * rho), texel(m, face, x, y)};
        if (rho >= end)
            break;
        if (to_x <= rho)
            x = du > 0 ? next_x++ : --next_x;
        if (to_y <= rho)
            y = dv > 0 ? next_y++ : --next_y;
    }
    return count;
}

/* The pieces of a whole meridian. */
static int walk(const mapper *m, double azimuth, piece *pieces)
{
    const int n = m->cube->size;
    const double c = cos(azimuth), s = sin(azimuth);
    const bool along_x = fabs(c) >= fabs(s);
    const int face = along_x ? (c > 0 ? 0 : 1) : (s > 0 ? 4 : 5);
    const double most = fmax(fabs(c), fabs(s));
    const double u = along_x ? -s / c : c / s;
    const int x = (int)fmin(fmax(floor((u + 1) / 2 * n), 0), n - 1);
    int count = walk_pole(m, 2, c, s, pieces);

    for (int y = 0; y < n; y++) {
        const double t = (1 - 2.0 * (y + 1) / n) * most;
        pieces[count++] = (piece){t / sqrt(1 + t * t), texel(m, face, x, y)};
    }
    /* Outwards as the other, then turned round: a piece then ends where the
     * one nearer to the centre did. */
    piece *south = pieces + count;
    const int pole = walk_pole(m, 3, c, -s, south);
    for (int i = 0, j = pole - 1; i < j; i++, j--) {
        const piece swap = south[i];
        south[i] = south[j];
        south[j] = swap;
    }
    for (int i = 0; i < pole; i++)
        south[i].z = i + 1 < pole ? -south[i + 1].z : -1;
    return count + pole;
}

/* Adds a meridian of some width to the sums of its column. */
static void add(mapper *m, double azimuth, double width)
{
    const int count = walk(m, azimuth, m->pieces);
    const int last = m->map->height - 1;
    double z = 1;
    int row = 0;

    for (int i = 0; i < count; i++) {
        const piece *p = &m->pieces[i];
        while (z > p->z) {
            const bool over = row < last && m->z[row + 1] >= p->z;
            const double to = over ? m->z[row + 1] : p->z;
            const double w = width * (z - to);
            for (int k = 0; k < 3; k++)
                m->column[3 * row + k] += w * (double)p->rgb[k];
            z = to;
            row += over;
        }
    }
}

/* The column from azimuth a to b; *edge is the first edge of texels after a. */
static void fill_column(mapper *m, int x, int *edge)
{
    const int w = m->map->width, h = m->map->height, n = m->cube->size;
    const double end = 2 * PI * (x + 1) / w - PI;

    memset(m->column, 0, 3 * (size_t)h * sizeof *m->column);
    for (double from = 2 * PI * x / w - PI; from < end;) {
        while (*edge < 4 * n && m->edges[*edge] <= from)
            ++*edge;
        const double to = *edge < 4 * n ? fmin(end, m->edges[*edge]) : end;
        const double width = (to - from) / SUBDIVISIONS;
        for (int i = 0; i < SUBDIVISIONS; i++)
            add(m, from + (i + 0.5) * width, width);
        from = to;
    }
    for (int y = 0; y < h; y++) {
        float *pixel = m->map->data + 3 * ((size_t)y * (size_t)w + (size_t)x);
        const double all = 2 * PI / w * (m->z[y] - m->z[y + 1]);
        for (int k = 0; k < 3; k++)
            pixel[k] = (float)(m->column[3 * y + k] / all);
    }
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void find_edges(const mapper *m)
{
    const int n = m->cube->size, h = m->map->height;

    for (int quarter = 0; quarter < 4; quarter++)
        for (int k = 0; k < n; k++) {
            const double a = quarter * PI / 2 + atan(2.0 * k / n - 1);
            m->edges[quarter * n + k] = a < PI ? a : a - 2 * PI;
        }
    qsort(m->edges, 4 * (size_t)n, sizeof *m->edges, compare);
    for (int y = 0; y <= h; y++)
        m->z[y] = cos(PI * y / h);
}

bool ibl_cube_map_fill(const ibl_cube *cube, ibl_image *map)
{
    const size_t n = (size_t)cube->size, h = (size_t)map->height;
    mapper m = {.cube = cube, .map = map};
    int edge = 0;

    m.edges = calloc(4 * n, sizeof *m.edges);
    m.z = calloc(h + 1, sizeof *m.z);
    m.pieces = calloc(5 * n + 8, sizeof *m.pieces);
    m.column = calloc(3 * h, sizeof *m.column);
    const bool ok = m.edges && m.z && m.pieces && m.column;
    if (ok) {
        find_edges(&m);
        for (int x = 0; x < map->width; x++)
            fill_column(&m, x, &edge);
    }
    free(m.edges);
    free(m.z);
    free(m.pieces);
    free(m.column);
    return ok;
}
