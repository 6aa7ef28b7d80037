/* SPDX-License-Identifier: MIT */
/*
 * Maps an octahedral image to an equirectangular map, as latlong_from_cube.c
 * does with a cube: each pixel is the mean of patches along meridians, on which
 * solid angle is proportional to z, the sine of the latitude.
 *
 * With (c, d) = (|cos|, |sin|) of its azimuth, a meridian leaves the middle of
 * the image towards the corner of its quadrant. At distance u from the middle
 * of the image along one axis, where c is that axis' share,
 *   in the north  cot(angle from +Y) = c / u - (c + d)
 *   in the south  cot(angle from -Y) = d / (1 - u) - (c + d).
 */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/image.h"

enum {
    SUBDIVISIONS = 4,
    JOB_COLUMNS = 4
};

typedef struct mapper {
    const ibl_image *from;
    ibl_image *map;
    double *z;    /* of the borders of rows, height + 1 */
    double *sums; /* for each worker, one RGB for each row */
} mapper;

/* The walk along a meridian from +Y down. */
typedef struct walker {
    const mapper *m;
    double *sums;
    double width; /* of the meridian, in radians */
    double share[2];
    int sign[2];  /* of X and Z in the image */
    int texel[2]; /* column and row */
    double z;
    int row;
} walker;

/* Moves down to z through the texel. */
static void go(walker *w, double z)
{
    const mapper *m = w->m;
    const int last = m->map->height - 1;
    const float *texel =
        m->from->data + 3 * ((size_t)w->texel[1] * (size_t)m->from->width +
                             (size_t)w->texel[0]);

    while (w->z > z) {
        const bool over = w->row < last && m->z[w->row + 1] >= z;
        const double to = over ? m->z[w->row + 1] : z;
        for (int c = 0; c < 3; c++)
            w->sums[3 * w->row + c] +=
                w->width * (w->z - to) * (double)texel[c];
        w->z = to;
        w->row += over;
    }
}

/* The distance from the middle to the texel's outer border along an axis. */
static double border(const walker *w, int axis)
{
    const int n = w->m->from->width, at = w->texel[axis];
    return (double)(w->sign[axis] > 0 ? 2 * at + 2 - n : n - 2 * at) / n;
}

static bool is_last(const walker *w, int axis)
{
    return w->texel[axis] == (w->sign[axis] > 0 ? w->m->from->width - 1 : 0);
}

/* z at which the meridian leaves the texel by its border along an axis. */
static double leaves(const walker *w, int axis, bool south)
{
    const double c = w->share[0], d = w->share[1], u = border(w, axis);
    const double cot = south ? w->share[!axis] / (1 - u) - (c + d)
                             : w->share[axis] / u - (c + d);

    if (south && is_last(w, axis))
        return -1;
    if (cot <= 0)
        return 0;
    return (south ? -1 : 1) / sqrt(1 + 1 / (cot * cot));
}

/* Walks to the equator or, in the south, to -Y. */
static void walk_half(walker *w, bool south)
{
    const double end = south ? -1 : 0;

    for (;;) {
        const double z[2] = {leaves(w, 0, south), leaves(w, 1, south)};
        const double to = fmax(z[0], z[1]);
        go(w, to);
        if (to <= end)
            return;
        for (int axis = 0; axis < 2; axis++)
            if (z[axis] >= to)
                w->texel[axis] += w->sign[axis];
    }
}

static void walk(const mapper *m, double azimuth, double width, double *sums)
{
    const double at[2] = {cos(azimuth), sin(azimuth)};
    const int n = m->from->width;
    walker w = {.m = m, .sums = sums, .width = width, .z = 1};

    for (int axis = 0; axis < 2; axis++) {
        w.sign[axis] = at[axis] < 0 ? -1 : 1;
        w.share[axis] = fabs(at[axis]);
        w.texel[axis] = at[axis] < 0 ? (n - 1) / 2 : n / 2;
    }
    walk_half(&w, false);
    walk_half(&w, true);
}

static void put_column(const mapper *m, int x, const double *sums)
{
    const size_t width = (size_t)m->map->width;

    for (int y = 0; y < m->map->height; y++) {
        const double area =
            2 * IBL_PI / (double)width * (m->z[y] - m->z[y + 1]);
        float *pixel = m->map->data + 3 * ((size_t)y * width + (size_t)x);
        for (int c = 0; c < 3; c++)
            pixel[c] = (float)(sums[3 * y + c] / area);
    }
}

static void fill_columns(void *arg, int job, int worker)
{
    const mapper *m = arg;
    const int from = job * JOB_COLUMNS, all = m->map->width;
    const size_t floats = 3 * (size_t)m->map->height;
    const double width = 2 * IBL_PI / all / SUBDIVISIONS;
    double *sums = m->sums + (size_t)worker * floats;

    for (int x = from; x < all && x < from + JOB_COLUMNS; x++) {
        memset(sums, 0, floats * sizeof *sums);
        for (int i = 0; i < SUBDIVISIONS; i++)
            walk(m, (SUBDIVISIONS * x + i + 0.5) * width - IBL_PI, width, sums);
        put_column(m, x, sums);
    }
}

ibl_status ibl_latlong_from_octahedral(ibl_ctx *ctx, const ibl_image *from,
                                       ibl_image *map)
{
    const size_t height = (size_t)map->height;
    const size_t workers = (size_t)ibl_ctx_threads(ctx);
    mapper m = {.from = from, .map = map};
    ibl_status status = IBL_OK;

    m.z = ibl_alloc_array(height + 1, sizeof *m.z);
    m.sums = ibl_alloc_array(workers * height, 3 * sizeof *m.sums);
    if (m.z && m.sums) {
        for (size_t y = 0; y <= height; y++)
            m.z[y] = cos(IBL_PI * (double)y / (double)height);
        status =
            ibl_run(ctx, "map", (map->width + JOB_COLUMNS - 1) / JOB_COLUMNS,
                    fill_columns, &m);
    } else {
        status = ibl_no_memory(ctx, "the map of an octahedral image");
    }
    ibl_free(m.sums);
    ibl_free(m.z);
    return status;
}
