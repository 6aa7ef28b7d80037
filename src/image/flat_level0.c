/* SPDX-License-Identifier: MIT */
/*
 * The environment as a flat map: means of the source over each texel. And an
 * octahedral map as an equirectangular one, which is cut in the same places.
 *
 * Texels of an equirectangular map meet the source's patches in rectangles.
 * Those of an octahedral one are taken in the quadrant of their horizon, from
 * the axis of x to that of z, both upwards. There (u, 1 - u - v, v) points to a
 * point of the map above the equator, and (1 - v, 1 - u - v, 1 - u) to one
 * below: edges are great circles. Between the azimuths of the texel's corners
 * and the borders of the source's columns it is between two of them, and what
 * is above an edge in a row of the source is an area of image/strip_coverage.h.
 */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"
#include "image/image.h"
#include "image/strip_coverage.h"
#include "image/upsample.h"

typedef struct source {
    int columns, rows;
    float *rgb;     /* patches */
    float *own;     /* them, if they are finer than the map; NULL */
    double *height; /* cosines of the borders of rows, rows + 1, and */
    double *cot;    /* cotangents, finite */
    double turns;   /* of the yaw */
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

static bool set_borders(source *s)
{
    const size_t borders = (size_t)s->rows + 1;
    s->height = ibl_alloc_array(2 * borders, sizeof *s->height);
    if (!s->height)
        return false;
    s->cot = s->height + borders;
    for (int j = 0; j <= s->rows; j++) {
        s->height[j] = cos(IBL_PI * j / s->rows);
        s->cot[j] = s->height[j] / fmax(sin(IBL_PI * j / s->rows), 1e-300);
    }
    return true;
}

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
    *s = (source){.columns = f.columns,
                  .rows = f.rows,
                  .rgb = env->data,
                  .turns = yaw_deg / 360 - floor(yaw_deg / 360)};
    if (f.taps)
        s->rgb = s->own = ibl_alloc_array((size_t)f.rows * (size_t)f.columns,
                                          3 * sizeof *s->own);
    const bool ok = set_borders(s) && s->rgb;
    for (int j = 0; ok && s->own && j < f.rows; j++)
        refine_row(&f, env, j, s->own + 3 * (size_t)j * (size_t)f.columns);
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

/*
 * An edge of a texel, u = at or v = at, is part of a great circle: a border of
 * image/strip_coverage.h. Its psi is the azimuth, for v what is left of it to
 * 90 degrees, less `zero`.
 */
typedef struct edge {
    double a, cosine, sine; /* of zero */
    bool of_v;
} edge;

/* Most width of a piece, see ibl_coverage_above. */
static const double widest = 0.02;

enum {
    U,
    V
};

enum {
    QUADRANTS = 4
};

/* A texel in its quadrant, and its images in others whose columns have the same
 * borders. */
typedef struct texel {
    double u[2], v[2];
    double zero, step; /* column c = zero + step * azimuth */
    const edge *top, *bottom;
    int row; /* of the source, found last */
    int images;
    struct {
        int base; /* its column is base + c or, backwards, base - 1 - c */
        bool backwards;
        mean mean;
    } image[QUADRANTS];
    const float *light; /* added to the source instead of the mean, or NULL */
} texel;

/* below: of a texel below the equator. */
static edge edge_at(double at, bool below, bool of_v)
{
    const double inverse = 1 / sqrt((1 - at) * (1 - at) + at * at);
    return (edge){(below ? 1 - at : at) * inverse, (1 - at) * inverse,
                  -at * inverse, of_v};
}

/* Cosine and sine of psi, from those of an azimuth. */
static void psi_of(const edge *e, const double azimuth[2], double psi[2])
{
    const double c = azimuth[e->of_v], s = azimuth[!e->of_v];
    psi[0] = c * e->cosine + s * e->sine;
    psi[1] = s * e->cosine - c * e->sine;
}

/* A part of an edge, and the cosines and sines of its psi. */
typedef struct arc {
    double a, first[2], last[2];
} arc;

static arc arc_of(const edge *e, const double from[2], const double to[2])
{
    arc part = {.a = e->a};
    psi_of(e, e->of_v ? to : from, part.first);
    psi_of(e, e->of_v ? from : to, part.last);
    return part;
}

static double area_above(const ibl_coverage_row *row, const arc *e,
                         double width)
{
    return ibl_coverage_above(row, e->a, e->first[0], e->first[1], e->last[0],
                              e->last[1], width);
}

/* The higher, or the lower, of two edges at an azimuth. */
static const edge *outer(const edge pair[2], double azimuth, bool lower)
{
    const double at[2] = {cos(azimuth), sin(azimuth)};
    double u[2], v[2];
    psi_of(&pair[U], at, u);
    psi_of(&pair[V], at, v);
    return &pair[(u[0] * pair[V].a < v[0] * pair[U].a) == lower ? U : V];
}

/* Azimuth of a corner; below: of a texel below the equator. */
static double azimuth_of(double u, double v, bool below)
{
    return below ? atan2(1 - u, 1 - v) : atan2(v, u);
}

/* Adds a piece of column c between two azimuths, given by their cosines and
 * sines. */
static void add_piece(const source *s, texel *p, int c, const double from[2],
                      const double to[2], double width)
{
    const arc top = arc_of(p->top, from, to),
              bottom = arc_of(p->bottom, from, to);
    size_t column[QUADRANTS];

    for (int i = 0; i < p->images; i++) {
        const int base = p->image[i].base;
        const int turned =
            (p->image[i].backwards ? base - 1 - c : base + c) % s->columns;
        column[i] = (size_t)(turned < 0 ? turned + s->columns : turned);
    }

    while (p->row > 0 && top.a * s->cot[p->row] < top.first[0])
        p->row--;
    while (p->row < s->rows - 1 && top.a * s->cot[p->row + 1] >= top.first[0])
        p->row++;
    for (int j = p->row; j < s->rows && bottom.a * s->cot[j] > bottom.last[0];
         j++) {
        const ibl_coverage_row cut = {s->height[j], s->height[j + 1], s->cot[j],
                                      s->cot[j + 1]};
        const double area =
            area_above(&cut, &bottom, width) - area_above(&cut, &top, width);
        float *row = s->rgb + 3 * (size_t)j * (size_t)s->columns;
        if (area <= 0)
            continue;
        for (int i = 0; i < p->images && !p->light; i++)
            add(&p->image[i].mean, row + 3 * column[i], area);
        for (int k = 0; k < 3 && p->light; k++)
            row[3 * column[0] + (size_t)k] +=
                (float)(area * (double)p->light[k]);
    }
}

/* Adds the texel's azimuths from..to, between the same edges, in pieces of one
 * column. */
static void add_columns(const source *s, texel *p, double from, double to)
{
    const double at = p->zero + p->step * from;
    const int sign = p->step > 0 ? 1 : -1;
    int border = sign > 0 ? (int)floor(at) + 1 : (int)ceil(at) - 1;
    double begin[2] = {cos(from), sin(from)};

    while (from < to) {
        const double column_end = (border - p->zero) / p->step;
        const double next = fmin(fmin(column_end, from + widest), to);
        const double end[2] = {cos(next), sin(next)};
        if (from < next)
            add_piece(s, p, border - (sign > 0), begin, end, next - from);
        border += next >= column_end ? sign : 0;
        memcpy(begin, end, sizeof begin);
        from = fmax(from, next);
    }
}

static void integrate(const source *s, texel *p)
{
    const double sum = p->u[0] + p->u[1] + p->v[0] + p->v[1];
    const bool below = sum > 2 + 1e-9, above = sum < 2 - 1e-9;
    const double low = azimuth_of(p->u[0], p->v[0], below);
    const double high = azimuth_of(p->u[1], p->v[1], below);
    const double knot[4] = {azimuth_of(p->u[1], p->v[0], below),
                            fmin(low, high), fmax(low, high),
                            azimuth_of(p->u[0], p->v[1], below)};
    const edge top[2] = {edge_at(p->u[0], below, false),
                         edge_at(p->v[0], below, true)};
    const edge bottom[2] = {edge_at(p->u[1], !above, false),
                            edge_at(p->v[1], !above, true)};

    for (int k = 0; k < 3; k++) {
        const double from = fmax(knot[k], knot[0]);
        const double to = fmin(knot[k + 1], knot[3]);
        p->top = outer(top, 0.5 * (from + to), true);
        p->bottom = outer(bottom, 0.5 * (from + to), false);
        add_columns(s, p, from, to);
    }
}

/* Integrates a texel of a quadrant of n x n, counted from its pole. */
static void integrate_at(const source *s, int n, int i, int j, texel *p)
{
    p->u[0] = (double)i / n;
    p->u[1] = (i + 1.0) / n;
    p->v[0] = (double)j / n;
    p->v[1] = (j + 1.0) / n;
    integrate(s, p);
}

/* Begins a texel of one quadrant: bit 0 is towards +X, bit 1 +Z. */
static texel begin_in(const source *s, int quadrant)
{
    const bool forwards = quadrant == 0 || quadrant == 3;
    return (texel){
        .zero = ((quadrant % 2 ? 0.5 : 1) + s->turns) * s->columns,
        .step = (forwards ? 1 : -1) * s->columns / (2 * IBL_PI),
        .images = 1,
    };
}

/* Begins a texel of all quadrants, if a column begins at their azimuth 0, else
 * of one. */
static texel begin(const source *s, int quadrant)
{
    const double turned = s->turns * s->columns, whole = floor(turned + 0.5);
    texel p = begin_in(s, quadrant);

    if (s->columns % 4 || fabs(turned - whole) > 1e-9)
        return p;
    p.zero = 0;
    p.step = s->columns / (2 * IBL_PI);
    p.images = QUADRANTS;
    for (int q = 0; q < QUADRANTS; q++) {
        p.image[q].base = (int)whole + s->columns / (q % 2 ? 2 : 1);
        p.image[q].backwards = q == 1 || q == 2;
    }
    return p;
}

/* Line j of all quadrants, from their pole. */
static void octahedral_line(void *arg, int j, int worker)
{
    const target *t = arg;
    const int n = t->shape.width / 2;
    texel p;

    (void)worker;
    for (int first = 0; first < QUADRANTS; first += p.images) {
        p = begin(t->from, first);
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < p.images; k++)
                p.image[k].mean = (mean){0};
            integrate_at(t->from, n, i, j, &p);
            for (int k = 0; k < p.images; k++) {
                const int x = (first + k) % 2 ? n + i : n - 1 - i;
                const int y = (first + k) / 2 ? n + j : n - 1 - j;
                put(&p.image[k].mean,
                    t->rgb + 3 * ((size_t)y * 2 * (size_t)n + (size_t)x));
            }
        }
    }
}

/* ---- from an octahedral map --------------------------------------------- */

typedef struct unfolding {
    source map;
    const ibl_image *from;
    int n, line; /* of quadrants of n x n texels, and from their first */
    bool odd;    /* the quadrants +X -Z and -X +Z, else the others */
} unfolding;

/* Adds a line of a quadrant to the map. Two opposite ones have no pixel in
 * common. Of an odd map, which the axes divide, each texel counts as four. */
static void quadrant_job(void *arg, int job, int worker)
{
    const unfolding *u = arg;
    const size_t width = (size_t)u->from->width;
    const int left = job ? u->n : 0, top = (job != 0) == u->odd ? 0 : u->n;
    const int divide = width % 2 ? 2 : 1, y = top + u->line, n = u->n;
    texel p = begin_in(&u->map, (left > 0) + 2 * (top > 0));

    (void)worker;
    for (int x = left; x < left + n; x++) {
        const size_t at = (size_t)(y / divide) * width + (size_t)(x / divide);
        p.light = u->from->data + 3 * at;
        integrate_at(&u->map, n, left ? x - n : n - 1 - x,
                     top ? y - n : n - 1 - y, &p);
    }
}

ibl_status ibl_latlong_from_octahedral(ibl_ctx *ctx, const ibl_image *from,
                                       ibl_image *map)
{
    const size_t floats = 3 * (size_t)map->width;
    const int width = from->width, n = width % 2 ? width : width / 2;
    unfolding u = {
        .map = {.columns = map->width, .rows = map->height, .rgb = map->data},
        .from = from,
        .n = n};
    ibl_status status = IBL_OK;

    if (!set_borders(&u.map))
        return ibl_no_memory(ctx, "the map of an octahedral image");
    memset(map->data, 0, floats * (size_t)map->height * sizeof *map->data);
    for (int i = 0; i < 2 * n && !status; i++) {
        ibl_progress(ctx, "map", i / (2.0 * n));
        u.odd = i >= n;
        u.line = i % n;
        status = ibl_run(ctx, NULL, 2, quadrant_job, &u);
    }
    for (size_t i = 0; i < floats * (size_t)map->height && !status; i++) {
        const size_t j = i / floats;
        const double angle =
            2 * IBL_PI / map->width * (u.map.height[j] - u.map.height[j + 1]);
        map->data[i] = (float)fmin((double)map->data[i] / angle, FLT_MAX);
    }
    if (!status)
        ibl_progress(ctx, "map", 1);
    ibl_free(u.map.height);
    return status;
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
        status = map->projection == IBL_PROJECTION_EQUIRECT
                     ? ibl_run(ctx, l ? NULL : "level 0", t.shape.height,
                               equirect_row, &t)
                     : ibl_run(ctx, l ? NULL : "level 0", t.shape.height / 2,
                               octahedral_line, &t);
    }
    close_source(&from);
    return status;
}
