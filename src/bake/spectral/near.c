/* SPDX-License-Identifier: MIT */
/*
 * Angles are those of the map: theta from the pole, phi from the middle column,
 * seen from outside with theta downwards and phi to the right. R is the texel's
 * direction, Delta = phi - phi_R, and
 *     q = sin^2((theta - theta_R) / 2) +
 *         sin(theta) sin(theta_R) sin^2(Delta / 2),
 *     sin^2(psi) = 4 q (1 - q).
 * Along a meridian upwards, and along a parallel to the right,
 *     d gamma = sin(theta_R) sin(Delta) |d theta| / sin^2(psi),
 *     d gamma = sin(theta) (sin(theta - theta_R) +
 *               2 cos(theta) sin(theta_R) sin^2(Delta / 2)) dPhi / sin^2(psi).
 *
 * A piece of an edge that is no longer than its distance from R takes POINTS
 * Gauss-Legendre points. Nearer to R, d gamma turns by up to pi within the
 * distance. There the integral is H(0) times the angle between the ends, minus
 * the integral of H(0) - H, which changes over the lobe's width or more. Pieces
 * up to that length take POINTS points, longer ones are halved.
 */
#include "bake/spectral/near.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "bake/spectral/gauss.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"

enum {
    POINTS = IBL_GAUSS_POINTS,
    MAX_HALVINGS = 40,
    BITS = 5,
    PIECES = 1 << BITS, /* of the table in an octave */
    FIT = 4             /* nodes of a piece: 0, 1/3, 2/3, 1 */
};

/* ---- H as a table -------------------------------------------------------- */

/*
 * H of near.h as a function of q = sin^2(psi / 2), where
 *     H(q) = 2 int_q^reach K dq',
 * since sin(psi) dpsi = 2 dq; and (H(0) - H(q)) / q, which keeps its digits
 * where q is small. Cubic pieces, PIECES an octave of q + start: within 1e-6.
 */
typedef struct table {
    double start; /* a power of two */
    double reach; /* the largest q; beyond it H is 0 */
    double peak;  /* H(0) */
    int64_t base; /* number of the first piece */
    double *coef; /* 8 a piece: of H, and of (H(0) - H) / q */
} table;

/* A near part is cut off where it has fallen to exp(-REACH). */
static const double REACH = 12;

static double reach_of(const ibl_lobe_shape *s)
{
    return s->split > 0 ? fmin(REACH / s->split, s->reach) : s->reach;
}

static double near_weight(const ibl_lobe_shape *s, double q)
{
    const double k = ibl_lobe_value(s, q, 1 - 2 * q);
    return s->split > 0 ? k * ibl_lobe_near_share(s, q) : k;
}

/* 2 int K dq, by Gauss-Legendre points. */
static double integral(const ibl_lobe_shape *s, double from, double to)
{
    double sum = 0;
    for (int k = 0; k < IBL_GAUSS_POINTS; k++)
        sum += ibl_gauss_mass[k] *
               near_weight(s, from + (to - from) * ibl_gauss_node[k]);
    return 2 * (to - from) * sum;
}

/* q of a node of a piece. */
static double node_at(const table *t, int piece, int node)
{
    const double octave = ldexp(t->start, piece / PIECES);
    const double part = piece % PIECES + node / (FIT - 1.0);
    return fmin(octave * (1 + part / PIECES) - t->start, t->reach);
}

/* The cubic of x = 0..1 through values at 0, 1/3, 2/3, 1. */
static void fit_cubic(const double f[FIT], double c[4])
{
    c[0] = f[0];
    c[1] = (-11 * f[0] + 18 * f[1] - 9 * f[2] + 2 * f[3]) / 2;
    c[2] = 4.5 * (2 * f[0] - 5 * f[1] + 4 * f[2] - f[3]);
    c[3] = 4.5 * (f[3] - 3 * f[2] + 3 * f[1] - f[0]);
}

/* Fills the integrals from 0 up to the nodes, then from the reach down to them,
 * so that neither is a small difference of large numbers. */
static void fill_table(const ibl_lobe_shape *s, int pieces, table *t)
{
    double sum = 0, nodes[FIT];
    for (int k = 0; k < pieces; k++) {
        double *c = t->coef + 8 * (ptrdiff_t)k;
        for (int i = 0; i < FIT; i++) {
            const double q = node_at(t, k, i);
            if (i > 0)
                sum += integral(s, node_at(t, k, i - 1), q);
            nodes[i] = q > 0 ? sum / q : 2 * near_weight(s, 0);
        }
        fit_cubic(nodes, c + 4);
    }
    t->peak = sum;
    sum = 0;
    for (int k = pieces - 1; k >= 0; k--) {
        for (int i = FIT - 1; i >= 0; i--) {
            if (i < FIT - 1)
                sum += integral(s, node_at(t, k, i), node_at(t, k, i + 1));
            nodes[i] = sum;
        }
        fit_cubic(nodes, t->coef + 8 * (ptrdiff_t)k);
    }
}

static bool make_table(const ibl_lobe_shape *shape, table *out)
{
    const double size = 0.0625 * shape->alpha * shape->alpha;
    int64_t bits;
    *out = (table){.start = exp2(floor(log2(size))), .reach = reach_of(shape)};
    const double octaves = log2(1 + out->reach / out->start);
    const int pieces = PIECES * (int)ceil(octaves) + 1;
    out->coef = ibl_alloc_array(8 * (size_t)pieces, sizeof *out->coef);
    if (!out->coef)
        return false;
    memcpy(&bits, &out->start, sizeof bits);
    out->base = bits >> (52 - BITS);
    fill_table(shape, pieces, out);
    return true;
}

/* H(q) for which = 0, (H(0) - H(q)) / q for which = 1; q in 0..reach. */
static inline double value_at(const table *t, double q, int which)
{
    const double v = q + t->start;
    int64_t bits;
    double x;

    memcpy(&bits, &v, sizeof bits);
    const double *c =
        t->coef + 8 * ((bits >> (52 - BITS)) - t->base) + 4 * which;
    /* The rest of the fraction, as a number in 0..1. */
    const int64_t rest = (int64_t)((uint64_t)bits << (12 + BITS) >> 12);
    const int64_t one = rest | 0x3ff0000000000000;
    memcpy(&x, &one, sizeof x);
    x -= 1;
    return ((c[3] * x + c[2]) * x + c[1]) * x + c[0];
}

/* ---- the map --------------------------------------------------------------
 */

/* Least distance of a texel's direction from a pixel's edges, in pixels. */
static const double margin = 1e-6;

/* The sine and the cosine of half an angle. */
typedef struct half {
    double sine, cosine;
} half;

struct ibl_near {
    ibl_ctx *ctx;
    ibl_near_map map;
    ibl_level_shape shape;
    table table;
    double alpha2;
    half *edge;  /* half the phi of each edge */
    half *point; /* half the phi of the points of each pixel */
    half *row;   /* half the theta of each row's upper edge and its points */
    double *sum; /* three for each texel */
    float *last; /* row above the batch */
    const float *rgb;
    int first, rows; /* the batch */
};

/* ---- a texel's view of the map ----------------------------------------- */

typedef struct texel {
    double theta, phi; /* phi from 0 at the left of the map */
    double sine, cosine;
    half phi_half, theta_half;
    int row, column; /* the pixel it is in */
    double *sum;
} texel;

/* Moves a coordinate, in pixels, off the pixels' edges; returns its pixel. */
static int pixel_of(double *at, int count)
{
    int pixel = (int)floor(*at);
    pixel = pixel < 0 ? 0 : pixel >= count ? count - 1 : pixel;
    *at = fmin(fmax(*at, pixel + margin), pixel + 1 - margin);
    return pixel;
}

static texel texel_at(const ibl_near *a, const double d[3], double *sum)
{
    const ibl_near_map *m = &a->map;
    texel t = {.sum = sum};
    double row = atan2(hypot(d[0], d[2]), d[1]) / IBL_PI * m->height;
    double turns = (atan2(d[2], d[0]) + m->yaw) / (2 * IBL_PI) + 0.5;
    double column = (turns - floor(turns)) * m->width;
    t.row = pixel_of(&row, m->height);
    t.column = pixel_of(&column, m->width);
    t.theta = IBL_PI * row / m->height;
    t.phi = 2 * IBL_PI * column / m->width;
    t.sine = sin(t.theta);
    t.cosine = cos(t.theta);
    t.theta_half = (half){sin(0.5 * t.theta), cos(0.5 * t.theta)};
    t.phi_half = (half){sin(0.5 * t.phi), cos(0.5 * t.phi)};
    return t;
}

/* Half the difference of two angles. */
static half between(half a, half b)
{
    return (half){a.sine * b.cosine - a.cosine * b.sine,
                  a.cosine * b.cosine + a.sine * b.sine};
}

/* An angle in -pi..pi. */
static double wrap(double angle)
{
    return angle - 2 * IBL_PI * rint(angle / (2 * IBL_PI));
}

/* ---- along an edge ------------------------------------------------------ */

/* An edge between two points of a meridian or a parallel. */
typedef struct edge {
    const ibl_near *a;
    const texel *t;
    int parallel;
    double fixed;        /* theta of a parallel, Delta of a meridian */
    double sine, cosine; /* of that theta; sin^2(Delta / 2), sin(Delta) */
} edge;

typedef struct place {
    double q;
    double turn; /* d gamma sin^2(psi), per radian of theta or phi */
} place;

static place place_at(const edge *e, double at)
{
    const texel *t = e->t;
    const double theta = e->parallel ? e->fixed : at;
    const double up = sin(0.5 * (theta - t->theta));
    if (!e->parallel)
        return (place){up * up + sin(theta) * t->sine * e->sine,
                       t->sine * e->cosine};
    const double s = sin(0.5 * at), across = s * s;
    return (place){
        up * up + e->sine * t->sine * across,
        e->sine * (sin(theta - t->theta) + 2 * e->cosine * t->sine * across)};
}

/* Angle around R of a point of an edge. */
static double angle_at(const edge *e, double at)
{
    const texel *t = e->t;
    const double theta = e->parallel ? e->fixed : at;
    const double sine = sin(theta);
    const double s = e->parallel ? sin(0.5 * at) : 0;
    const double across = e->parallel ? s * s : e->sine;
    const double east = sine * (e->parallel ? sin(at) : e->cosine);
    const double north = sin(t->theta - theta) + 2 * sine * t->cosine * across;
    return atan2(north, east);
}

/* int of H d gamma, or of (H(0) - H) d gamma. */
static double points_sum(const edge *e, double from, double to, int near)
{
    const table *h = &e->a->table;
    double sum = 0;
    for (int k = 0; k < POINTS; k++) {
        const place p = place_at(e, from + (to - from) * ibl_gauss_node[k]);
        if (p.q < h->reach)
            sum += ibl_gauss_mass[k] * p.turn * value_at(h, p.q, near) /
                   (4 * (near ? 1 : p.q) * (1 - p.q));
        else if (near)
            sum += ibl_gauss_mass[k] * p.turn * h->peak / (4 * p.q * (1 - p.q));
    }
    return sum * (to - from);
}

/* Where a meridian is nearest to R. */
static double nearest_theta(const edge *e)
{
    const texel *t = e->t;
    const double cosine = 1 - 2 * e->sine;
    if (cosine < 0)
        return t->cosine > 0 ? 0 : IBL_PI;
    return atan2(t->sine * cosine, t->cosine);
}

/* int of d gamma. A parallel next to R bends around it, by more than pi if R is
 * on its inner side, so its turns to and from the nearest point are added. */
static double turn_between(const edge *e, double from, double to,
                           double nearest)
{
    const double begin = angle_at(e, from), end = angle_at(e, to);

    if (!e->parallel)
        return wrap(begin - end);
    const double middle = angle_at(e, nearest);
    return wrap(middle - begin) + wrap(end - middle);
}

/* int of H d gamma along a part of an edge, towards larger theta or phi. */
static double part_sum(const edge *e, double from, double to, int halvings)
{
    const double aim = e->parallel ? 0 : nearest_theta(e);
    const double middle = 0.5 * (from + to);
    const double nearest = aim < from ? from : aim > to ? to : aim;
    const double q = place_at(e, nearest).q;
    const double length = (to - from) * (e->parallel ? e->sine : 1);
    const double square = 0.25 * length * length;

    if (q > e->a->table.reach)
        return 0;
    if (square <= q)
        return points_sum(e, from, to, 0);
    if (square > q + e->a->alpha2 && halvings < MAX_HALVINGS)
        return part_sum(e, from, middle, halvings + 1) +
               part_sum(e, middle, to, halvings + 1);
    return e->a->table.peak * turn_between(e, from, to, nearest) -
           points_sum(e, from, to, 1);
}

/* ---- rows --------------------------------------------------------------- */

/* A latitude as a texel sees it. */
typedef struct line {
    double sine, cosine;
    double up;    /* sin^2((theta - theta_R) / 2) */
    double along; /* sin(theta - theta_R) */
} line;

static line line_at(const texel *t, half theta)
{
    const half h = between(theta, t->theta_half);
    return (line){2 * theta.sine * theta.cosine,
                  (theta.cosine - theta.sine) * (theta.cosine + theta.sine),
                  h.sine * h.sine, 2 * h.sine * h.cosine};
}

/* Columns in reach at a latitude: from..from + count - 1, around the map. */
typedef struct span {
    int from, count;
} span;

static span span_at(const ibl_near *a, const texel *t, double up, double sine)
{
    const int width = a->map.width;
    const double most = (a->table.reach - up) / (sine * t->sine);
    if (!(most > 0))
        return (span){0, 0};
    if (most >= 1)
        return (span){0, width};
    const double reach = asin(sqrt(most)) / IBL_PI * width + 1;
    const double column = t->phi / (2 * IBL_PI) * width;
    const int from = (int)floor(column - reach);
    const int to = (int)ceil(column + reach);
    if (to - from + 1 >= width)
        return (span){0, width};
    return (span){from < 0 ? from + width : from, to - from + 1};
}

/* Columns whose meridians in row j are in reach: at the row's nearest latitude,
 * and as narrow as the row is anywhere. */
static span row_span(const ibl_near *a, const texel *t, int j,
                     const line points[POINTS])
{
    const double first = points[0].sine, last = points[POINTS - 1].sine;
    const double up = fmin(points[0].up, points[POINTS - 1].up);
    const double height = IBL_PI / a->map.height;
    /* The edges are hardly nearer than the points next to them. */
    const double nearest_up = fmax(0, sqrt(up) - 0.05 * height);
    const bool pole = j == 0 || j == a->map.height - 1;
    return span_at(a, t, j == t->row ? 0 : nearest_up * nearest_up,
                   pole ? 0 : 0.9 * fmin(first, last));
}

static void add_step(const texel *t, const float *from, const float *to,
                     double weight)
{
    for (int c = 0; c < 3; c++)
        t->sum[c] += ((double)to[c] - (double)from[c]) * weight;
}

static int differ(const float *a, const float *b)
{
    return a[0] < b[0] || a[0] > b[0] || a[1] < b[1] || a[1] > b[1] ||
           a[2] < b[2] || a[2] > b[2];
}

/* Limit of q over the square of an edge's length: if all points have more, the
 * edge is no longer than its distance from R. */
static const double nearest = 0.35;

/* The edge left of a pixel, from the top of its row to the bottom. */
static double meridian_sum(const ibl_near *a, const texel *t, double theta,
                           const line points[POINTS], int column)
{
    const half h = between(a->edge[column], t->phi_half);
    const double square = h.sine * h.sine, sine = 2 * h.sine * h.cosine;
    const double height = IBL_PI / a->map.height;
    double sum = 0, least = INFINITY, q[POINTS];

    for (int k = 0; k < POINTS; k++) {
        q[k] = points[k].up + points[k].sine * t->sine * square;
        least = fmin(least, q[k]);
    }
    if (least < nearest * height * height || height > 1) {
        const edge e = {
            a,      t,   0, wrap(2 * IBL_PI * column / a->map.width - t->phi),
            square, sine};
        return part_sum(&e, theta, theta + height, 0);
    }
    for (int k = 0; k < POINTS; k++)
        if (q[k] < a->table.reach)
            sum += ibl_gauss_mass[k] * value_at(&a->table, q[k], 0) /
                   (q[k] * (1 - q[k]));
    return 0.25 * height * t->sine * sine * sum;
}

/* The edge above a pixel, from left to right. */
static double parallel_sum(const ibl_near *a, const texel *t, const line *top,
                           double theta, int column)
{
    const double width = 2 * IBL_PI / a->map.width;
    const double extent = width * top->sine;
    const half *points = a->point + POINTS * (ptrdiff_t)column;
    double sum = 0, least = INFINITY, q[POINTS], across[POINTS];

    for (int k = 0; k < POINTS; k++) {
        const half h = between(points[k], t->phi_half);
        across[k] = h.sine * h.sine;
        q[k] = top->up + top->sine * t->sine * across[k];
        least = fmin(least, q[k]);
    }
    if (least < nearest * extent * extent || width > 1) {
        const edge e = {a, t, 1, theta, top->sine, top->cosine};
        const double left =
            wrap(2 * IBL_PI * (column + 0.5) / a->map.width - t->phi) -
            0.5 * width;
        return part_sum(&e, left, left + width, 0);
    }
    for (int k = 0; k < POINTS; k++)
        if (q[k] < a->table.reach)
            sum += ibl_gauss_mass[k] * value_at(&a->table, q[k], 0) *
                   (top->along + 2 * top->cosine * t->sine * across[k]) /
                   (q[k] * (1 - q[k]));
    return 0.25 * width * top->sine * sum;
}

static void add_meridians(const ibl_near *a, const texel *t, int j,
                          const float *row)
{
    const half *halves = a->row + (1 + POINTS) * (ptrdiff_t)j;
    const int width = a->map.width;
    const double theta = IBL_PI * j / a->map.height;
    line points[POINTS];

    for (int k = 0; k < POINTS; k++)
        points[k] = line_at(t, halves[1 + k]);
    const span reach = row_span(a, t, j, points);
    for (int k = 0; k < reach.count; k++) {
        const int i = (reach.from + k) % width;
        const float *right = row + 3 * (ptrdiff_t)i;
        const float *left = row + 3 * (ptrdiff_t)(i ? i - 1 : width - 1);
        if (differ(left, right))
            add_step(t, left, right, meridian_sum(a, t, theta, points, i));
    }
}

static void add_parallels(const ibl_near *a, const texel *t, int j,
                          const float *above, const float *row)
{
    const double theta = IBL_PI * j / a->map.height;
    const line top = line_at(t, a->row[(1 + POINTS) * (ptrdiff_t)j]);
    const span reach = span_at(a, t, top.up, top.sine);
    for (int k = 0; k < reach.count; k++) {
        const int i = (reach.from + k) % a->map.width;
        const float *to = row + 3 * (ptrdiff_t)i;
        const float *from = above + 3 * (ptrdiff_t)i;
        if (differ(from, to))
            add_step(t, from, to, parallel_sum(a, t, &top, theta, i));
    }
}

static void add_row(const ibl_near *a, const texel *t, int j)
{
    const size_t stride = 3 * (size_t)a->map.width;
    const float *row = a->rgb + stride * (size_t)(j - a->first);
    const float *above = j > a->first ? row - stride : a->last;
    static const float black[3] = {0};

    if (j == t->row)
        add_step(t, black, row + 3 * (ptrdiff_t)t->column, ibl_near_whole(a));
    add_meridians(a, t, j, row);
    if (j)
        add_parallels(a, t, j, above, row);
}

/* ---- jobs --------------------------------------------------------------- */

double ibl_near_reach(const ibl_near *a)
{
    return 2 * asin(sqrt(a->table.reach));
}

static void add_texel(const ibl_near *a, const double d[3], double *sum)
{
    const double row = IBL_PI / a->map.height, reach = ibl_near_reach(a);
    const double theta = acos(fmin(fmax(d[1], -1), 1));
    const int last = a->first + a->rows - 1;
    int from = (int)floor((theta - reach) / row) - 1;
    int to = (int)floor((theta + reach) / row) + 1;

    from = from < a->first ? a->first : from;
    to = to > last ? last : to;
    if (from > to)
        return;
    const texel t = texel_at(a, d, sum);
    for (int j = from; j <= to; j++)
        add_row(a, &t, j);
}

/* Whether the batch may be in reach of a row of texels. Along this row theta is
 * monotone from either end to the middle. */
static bool is_in_reach(const ibl_near *a, int face, int y)
{
    const int w = a->shape.width, x[4] = {0, (w - 1) / 2, w / 2, w - 1};
    const double reach = ibl_near_reach(a) + 2 * IBL_PI / a->map.height;
    double least = IBL_PI, most = 0;

    for (int k = 0; k < 4; k++) {
        double d[3];
        ibl_level_direction(&a->shape, face, x[k], y, d);
        const double theta = acos(fmin(fmax(d[1], -1), 1));
        least = fmin(least, theta);
        most = fmax(most, theta);
    }
    return least <= IBL_PI * (a->first + a->rows) / a->map.height + reach &&
           most >= IBL_PI * a->first / a->map.height - reach;
}

static void row_job(void *arg, int job, int worker)
{
    const ibl_near *a = arg;
    const int face = job / a->shape.height, y = job % a->shape.height;
    const int w = a->shape.width;
    (void)worker;

    if (!is_in_reach(a, face, y))
        return;
    for (int x = 0; x < w; x++) {
        double d[3];
        ibl_level_direction(&a->shape, face, x, y, d);
        add_texel(a, d, a->sum + 3 * ((size_t)job * (size_t)w + (size_t)x));
    }
}

/* ---- the calls ---------------------------------------------------------- */

static void fill_half_angles(const ibl_near *a)
{
    const double width = IBL_PI / a->map.width;
    const double height = 0.5 * IBL_PI / a->map.height;
    for (int j = 0; j < a->map.height; j++)
        for (int k = 0; k <= POINTS; k++) {
            const double at = height * (j + (k ? ibl_gauss_node[k - 1] : 0));
            a->row[(1 + POINTS) * (ptrdiff_t)j + k] = (half){sin(at), cos(at)};
        }
    for (int i = 0; i < a->map.width; i++) {
        a->edge[i] = (half){sin(width * i), cos(width * i)};
        for (int k = 0; k < POINTS; k++) {
            const double at = width * (i + ibl_gauss_node[k]);
            a->point[POINTS * i + k] = (half){sin(at), cos(at)};
        }
    }
}

ibl_status ibl_near_create(ibl_ctx *ctx, const ibl_near_map *map,
                           const ibl_lobe_shape *shape,
                           const ibl_level_shape *level, ibl_near **out)
{
    const size_t width = (size_t)map->width;
    ibl_near *a = *out = ibl_alloc_zeroed(1, sizeof *a);
    if (!a)
        return ibl_no_memory(ctx, "a narrow lobe");
    a->ctx = ctx;
    a->map = *map;
    a->shape = *level;
    a->alpha2 = shape->alpha * shape->alpha;
    a->edge = ibl_alloc_array(width, sizeof *a->edge);
    a->point = ibl_alloc_array(POINTS * width, sizeof *a->point);
    a->row =
        ibl_alloc_array((1 + POINTS) * (size_t)map->height, sizeof *a->row);
    a->last = ibl_alloc_array(3 * width, sizeof *a->last);
    a->sum = ibl_alloc_zeroed(3 * ibl_level_texels(level), sizeof *a->sum);
    if (!a->edge || !a->point || !a->row || !a->last || !a->sum ||
        !make_table(shape, &a->table)) {
        ibl_near_free(a);
        *out = NULL;
        return ibl_no_memory(ctx, "a narrow lobe");
    }
    fill_half_angles(a);
    return IBL_OK;
}

void ibl_near_free(ibl_near *a)
{
    if (!a)
        return;
    ibl_free(a->table.coef);
    ibl_free(a->edge);
    ibl_free(a->point);
    ibl_free(a->row);
    ibl_free(a->last);
    ibl_free(a->sum);
    ibl_free(a);
}

void ibl_near_add(ibl_near *a, int rows, const float *rgb)
{
    const size_t stride = 3 * (size_t)a->map.width;
    const int next = a->first + a->rows;
    if (next)
        memcpy(a->last, a->rgb + stride * (size_t)(a->rows - 1),
               stride * sizeof *a->last);
    a->first = next;
    a->rows = rows;
    a->rgb = rgb;
    ibl_run_begin(a->ctx, "near", (double)next / a->map.height,
                  a->shape.faces * a->shape.height, row_job, a);
}

double ibl_near_whole(const ibl_near *a)
{
    return 2 * IBL_PI * a->table.peak;
}

const double *ibl_near_sums(const ibl_near *a)
{
    return a->sum;
}
