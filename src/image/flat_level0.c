/* SPDX-License-Identifier: MIT */
/*
 * The environment as a flat map: means of the source over each texel.
 *
 * Texels of an equirectangular map meet the source's patches in rectangles.
 * Those of an octahedral one are taken in the quadrant of their horizon, from
 * the axis of x to that of z, both upwards. There, at the azimuth a, with
 * c = cos(a), s = sin(a), a meridian is at the height 1 - t over the point
 *     u = t c / (c + s)            v = t s / (c + s)            t <= 1
 *     u = 1 - (2 - t) s / (c + s)  v = 1 - (2 - t) c / (c + s)  t >= 1
 * of the map, t = 0..2, which both grow with t. So it is in a texel over one
 * interval of t, and the integral along it is exact. Between the azimuths of
 * the texel's corners and the borders of the source's columns it is smooth, but
 * for kinks where an edge crosses a border of rows. There pieces of two Gauss
 * points integrate it.
 */
#include <math.h>
#include <stdbool.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"
#include "image/image.h"
#include "image/upsample.h"

enum {
    PIECES = 2 /* of a column in a texel */
};

typedef struct source {
    int columns, rows;
    const float *rgb; /* patches */
    float *own;       /* them, if they are finer than the map; NULL */
    double *height;   /* cosines of the borders of rows, rows + 1 */
    double turns;     /* of the yaw */
} source;

typedef struct target {
    const source *from;
    ibl_level_shape shape;
    float *rgb;
} target;

/* A weighted sum of colours, and of weights. */
typedef struct mean {
    double rgb[3], weight;
} mean;

static void add(mean *m, const float *rgb, double weight)
{
    for (int c = 0; c < 3; c++)
        m->rgb[c] += weight * (double)rgb[c];
    m->weight += weight;
}

static void put(const mean *m, float *rgb)
{
    for (int c = 0; c < 3; c++)
        rgb[c] = (float)(m->rgb[c] / m->weight);
}

/* ---- the source --------------------------------------------------------- */

/* A row of patches, interpolated as <ibl/ibl.h> says. */
static void refine_row(const ibl_upsample *f, const ibl_image *env, int row,
                       float *to)
{
    int from[2];
    const ibl_octant_blend b = ibl_upsample_between(f, row, from);

    for (int i = 0; i < f->columns; i++, to += 3) {
        mean m = {0};
        for (int k = 0; k < 2 && b.weight[k] > 0; k++) {
            const float *line =
                env->data + 3 * (size_t)from[k] * (size_t)env->width;
            const ibl_octant_tap *tap = &b.taps[(i + b.turn[k]) % f->columns];
            add(&m, line + tap->at[0], b.weight[k] * (1 - tap->weight));
            add(&m, line + tap->at[1], b.weight[k] * tap->weight);
        }
        put(&m, to);
    }
}

static ibl_status open_source(ibl_ctx *ctx, const ibl_image *env,
                              double yaw_deg, int size, source *s)
{
    ibl_upsample f;
    const ibl_status status =
        ibl_upsample_init(ctx, env->width, env->height, size, &f);
    if (status)
        return status;
    *s = (source){f.columns, f.rows, env->data,
                  NULL,      NULL,   yaw_deg / 360 - floor(yaw_deg / 360)};
    s->height = ibl_alloc_array((size_t)f.rows + 1, sizeof *s->height);
    if (f.taps)
        s->rgb = s->own = ibl_alloc_array((size_t)f.rows * (size_t)f.columns,
                                          3 * sizeof *s->own);
    const bool ok = s->height && s->rgb;
    for (int j = 0; ok && s->own && j < f.rows; j++)
        refine_row(&f, env, j, s->own + 3 * (size_t)j * (size_t)f.columns);
    for (int j = 0; ok && j <= f.rows; j++)
        s->height[j] = cos(IBL_PI * j / f.rows);
    ibl_upsample_free(&f);
    return ok ? IBL_OK : ibl_no_memory(ctx, "the patches of a map");
}

static void close_source(source *s)
{
    ibl_free(s->own);
    ibl_free(s->height);
}

/* ---- equirectangular ---------------------------------------------------- */

/* Adds the patches of a row from the column `from` to `to`, around the map. */
static void add_run(const source *s, int row, double from, double to,
                    double weight, mean *m)
{
    const float *line = s->rgb + 3 * (size_t)row * (size_t)s->columns;
    const int last = (int)ceil(to);

    for (int i = (int)floor(from); i < last; i++) {
        const double part = fmin(to, i + 1) - fmax(from, i);
        if (part > 0)
            add(m, line + 3 * (ptrdiff_t)(i % s->columns), weight * part);
    }
}

static void equirect_row(void *arg, int y, int worker)
{
    const target *t = arg;
    const source *s = t->from;
    const int w = t->shape.width, h = t->shape.height;
    const double columns = s->columns, rows = s->rows;
    const double top = cos(IBL_PI * y / h), bottom = cos(IBL_PI * (y + 1) / h);
    const int first = (int)((double)y * rows / h);
    const int last = (int)ceil((y + 1.0) * rows / h);

    (void)worker;
    for (int x = 0; x < w; x++) {
        const double from = (x / (double)w + s->turns) * columns;
        mean m = {0};
        for (int j = first; j < last && j < s->rows; j++) {
            const double weight =
                fmin(top, s->height[j]) - fmax(bottom, s->height[j + 1]);
            if (weight > 0)
                add_run(s, j, from, from + columns / w, weight, &m);
        }
        put(&m, t->rgb + 3 * ((size_t)y * (size_t)w + (size_t)x));
    }
}

/* ---- octahedral --------------------------------------------------------- */

/* A texel in its quadrant. */
typedef struct texel {
    double u[2], v[2];
    double zero, step; /* column = zero + step * azimuth */
    int row;           /* of the source, found last */
    mean mean;
} texel;

/* t where u, or v with c and s exchanged, is at. */
static double at_line(double at, double c, double s)
{
    return at * (c + s) <= c ? at * (c + s) / c : 2 - (1 - at) * (c + s) / s;
}

/* Cosine of the angle from +Y. */
static double height_at(double t, double c, double s)
{
    const double across = fmin(t, 2 - t) / (c + s);
    return (1 - t) / sqrt((1 - t) * (1 - t) + across * across);
}

/* Adds the part of a meridian that is in the texel. */
static void add_meridian(const source *s, texel *p, double azimuth,
                         double width)
{
    const double cosine = cos(azimuth), sine = sin(azimuth);
    const double begin =
        fmax(at_line(p->u[0], cosine, sine), at_line(p->v[0], sine, cosine));
    const double end =
        fmin(at_line(p->u[1], cosine, sine), at_line(p->v[1], sine, cosine));
    const int turned = (int)floor(p->zero + p->step * azimuth) % s->columns;
    const size_t column = (size_t)(turned < 0 ? turned + s->columns : turned);

    if (!(end > begin))
        return;
    double top = height_at(begin, cosine, sine);
    const double bottom = height_at(end, cosine, sine);
    while (p->row > 0 && s->height[p->row] < top)
        p->row--;
    while (p->row < s->rows - 1 && s->height[p->row + 1] >= top)
        p->row++;
    for (int j = p->row; j < s->rows && top > bottom; j++) {
        const double to = fmax(bottom, s->height[j + 1]);
        add(&p->mean, s->rgb + 3 * ((size_t)j * (size_t)s->columns + column),
            width * (top - to));
        top = to;
    }
}

/* Azimuth of a corner; below: of a texel below the equator. */
static double azimuth_of(double u, double v, bool below)
{
    return below ? atan2(1 - u, 1 - v) : atan2(v, u);
}

static void add_between(const source *s, texel *p, double from, double to)
{
    static const double node = 0.28867513459481287; /* 1 / sqrt(12) */
    const double width = (to - from) / PIECES;

    for (int k = 0; width > 0 && k < PIECES; k++) {
        const double middle = from + (k + 0.5) * width;
        add_meridian(s, p, middle - node * width, 0.5 * width);
        add_meridian(s, p, middle + node * width, 0.5 * width);
    }
}

/* Adds the texel's azimuths from..to, in pieces of one column. */
static void add_columns(const source *s, texel *p, double from, double to)
{
    const double at = p->zero + p->step * from;
    const int sign = p->step > 0 ? 1 : -1;
    int border = sign > 0 ? (int)floor(at) + 1 : (int)ceil(at) - 1;

    while (from < to) {
        const double next = fmin((border - p->zero) / p->step, to);
        add_between(s, p, from, next);
        from = fmax(from, next);
        border += sign;
    }
}

static void integrate(const source *s, texel *p)
{
    const bool below = p->u[0] + p->u[1] + p->v[0] + p->v[1] > 2 + 1e-9;
    const double low = azimuth_of(p->u[0], p->v[0], below);
    const double high = azimuth_of(p->u[1], p->v[1], below);
    const double knot[4] = {azimuth_of(p->u[1], p->v[0], below),
                            fmin(low, high), fmax(low, high),
                            azimuth_of(p->u[0], p->v[1], below)};

    for (int k = 0; k < 3; k++)
        add_columns(s, p, fmax(knot[k], knot[0]), fmin(knot[k + 1], knot[3]));
}

static void octahedral_row(void *arg, int y, int worker)
{
    const target *t = arg;
    const source *s = t->from;
    const int n = t->shape.width / 2;
    const bool south = y >= n; /* +Z */
    const int j = south ? y - n : n - 1 - y;
    texel p = {.v = {(double)j / n, (j + 1.0) / n}};

    (void)worker;
    for (int x = 0; x < 2 * n; x++) {
        const bool east = x >= n;
        const int i = east ? x - n : n - 1 - x;
        p.u[0] = (double)i / n;
        p.u[1] = (i + 1.0) / n;
        p.zero = ((east ? 0.5 : 1) + s->turns) * s->columns;
        p.step = (east == south ? 1 : -1) * s->columns / (2 * IBL_PI);
        p.mean = (mean){0};
        integrate(s, &p);
        put(&p.mean, t->rgb + 3 * ((size_t)y * 2 * (size_t)n + (size_t)x));
    }
}

/* ---- the call ----------------------------------------------------------- */

ibl_status ibl_flat_from_latlong(ibl_ctx *ctx, const ibl_image *env,
                                 double yaw_deg, const ibl_cube *map)
{
    ibl_status status = ibl_check_image(ctx, env);
    source from = {0};

    if (!status)
        status = ibl_check_map(ctx, map);
    if (status)
        return status;
    if (map->projection == IBL_PROJECTION_CUBE || !isfinite(yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a cube or a yaw of %g: must be flat and finite",
                        yaw_deg);
    ibl_progress(ctx, "level 0", 0);
    status = open_source(ctx, env, yaw_deg, map->size, &from);
    for (int l = 0; l < map->levels && !status; l++) {
        target t = {&from, ibl_map_shape(map, l), ibl_cube_face(map, l, 0)};
        status =
            ibl_run(ctx, l ? NULL : "level 0", t.shape.height,
                    map->projection == IBL_PROJECTION_EQUIRECT ? equirect_row
                                                               : octahedral_row,
                    &t);
    }
    close_source(&from);
    return status;
}
