/* SPDX-License-Identifier: MIT */
#include "image/wedge.h"

#include <math.h>

#include "core/alloc.h"
#include "core/context.h"

#define PI 3.14159265358979323846

/* A row is searched so much of a texel beyond its borders, for rounding. */
static const double MARGIN = 1e-6;

/* ---- strips ----------------------------------------------------------- */

/* x of a line's upper border on top, z of a column's first one: 0..1. */
static double border(const ibl_wedge *w, int i)
{
    return i > 0 ? (2.0 * i - w->size % 2) / w->size : 0;
}

static void strips_free(ibl_wedge_strips *s)
{
    ibl_free(s->cosine);
    ibl_free(s->sine);
    ibl_free(s->width);
    ibl_free(s->pixel);
    ibl_free(s->column);
}

static bool strips_alloc(ibl_wedge_strips *s, int most, bool columns)
{
    const size_t n = (size_t)most;
    s->cosine = ibl_alloc_array(n + 1, sizeof *s->cosine);
    s->sine = ibl_alloc_array(n + 1, sizeof *s->sine);
    s->width = ibl_alloc_array(n, sizeof *s->width);
    s->pixel = ibl_alloc_array(n, sizeof *s->pixel);
    if (columns)
        s->column = ibl_alloc_array(n, sizeof *s->column);
    return s->cosine && s->sine && s->width && s->pixel &&
           (s->column || !columns);
}

static void set_border(ibl_wedge_strips *s, double psi)
{
    s->cosine[s->count] = cos(psi);
    s->sine[s->count] = sin(psi);
}

/* Borders of pixels and, if the strips have columns, of texels on the side;
 * two that differ by rounding alone are one. */
static void strips_fill(const ibl_wedge *w, int columns, double before,
                        ibl_wedge_strips *s)
{
    const double step = 2 * PI / columns, same = 1e-9 * step;
    double at = 0;
    int pixel = 0, column = 0;
    set_border(s, 0);
    while (at < PI / 4) {
        const double pixel_end = (pixel + 1 - before) * step;
        const double column_end =
            s->column ? atan(border(w, column + 1)) : PI / 4;
        double to = pixel_end < column_end ? pixel_end : column_end;
        if (to > PI / 4 - same)
            to = PI / 4;
        const bool ends_pixel = pixel_end <= to + same;
        const bool ends_column = column_end <= to + same;
        const bool begins_pixel = fabs(at - (pixel - before) * step) <= same;
        if (to > at + same) {
            s->width[s->count] = begins_pixel && ends_pixel ? step : to - at;
            s->pixel[s->count] = pixel;
            if (s->column)
                s->column[s->count] = column;
            s->count++;
            set_border(s, to);
            at = to;
        }
        pixel += ends_pixel;
        column += ends_column;
    }
}

ibl_status ibl_wedge_init(ibl_ctx *ctx, int size, int columns, double before,
                          ibl_wedge *w)
{
    *w = (ibl_wedge){.size = size, .half = (size + 1) / 2};
    w->lines = 4 * w->half - size % 2;
    w->pixels = (int)ceil(columns / 8.0 + before);
    if (!strips_alloc(&w->plain, w->pixels + 1, false) ||
        !strips_alloc(&w->cut, w->pixels + w->half + 1, true)) {
        ibl_wedge_free(w);
        return ibl_no_memory(ctx, "level 0's tables");
    }
    strips_fill(w, columns, before, &w->plain);
    strips_fill(w, columns, before, &w->cut);
    return IBL_OK;
}

void ibl_wedge_free(ibl_wedge *w)
{
    strips_free(&w->plain);
    strips_free(&w->cut);
    *w = (ibl_wedge){0};
}

/* ---- rows ------------------------------------------------------------- */

static int clamp(int i, int last)
{
    return i < 0 ? 0 : i > last ? last : i;
}

/* The texel line, from its pole on, that has x in the plane of the top, moved
 * by so much of a texel; x up to infinite. */
static int line_at(const ibl_wedge *w, double x, double move)
{
    const double scale = 0.5 * w->size;
    const double i =
        x < 1 ? x * scale + 0.5 * (w->size % 2) : (1 - 1 / x) * scale + w->half;
    return clamp((int)floor(i + move), 2 * w->half - 1);
}

/* The same for z on top. */
static int column_at(const ibl_wedge *w, double z, double move)
{
    const double i = z * 0.5 * w->size + 0.5 * (w->size % 2);
    return i + move < w->half ? clamp((int)floor(i + move), w->half - 1)
                              : w->half - 1;
}

bool ibl_wedge_row_init(const ibl_wedge *w, int rows, int j, bool south,
                        ibl_wedge_row *row)
{
    const double from = PI * (south ? rows - 1 - j : j) / rows;
    double to = PI * (south ? rows - j : j + 1) / rows;
    if (from > PI / 2 - 1e-12)
        return false;
    if (to > PI / 2)
        to = PI / 2;
    *row = (ibl_wedge_row){.south = south,
                           .top = cos(from),
                           .bottom = cos(to),
                           .top_tan = tan(from),
                           .bottom_tan = tan(to)};
    row->per_cosine = 1 / (row->top - row->bottom);
    const int first = line_at(w, row->top_tan * sqrt(0.5), -MARGIN);
    const int last = line_at(w, row->bottom_tan, MARGIN);
    row->top_lines = first < w->half;
    row->side = last >= w->half;
    row->first_line = south ? w->lines - 1 - last : first;
    row->last_line = south ? w->lines - 1 - first : last;
    return true;
}

int ibl_wedge_slot(const ibl_wedge_part *part, int line)
{
    return line % part->ring * (part->end_z - part->first_z);
}

/* Strips with borders below sine x begin at those before this one. */
static int strips_below(const ibl_wedge_strips *s, double x)
{
    int low = 0, high = s->count;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (s->sine[middle] < x)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static int strips_before_column(const ibl_wedge_strips *s, int column)
{
    int low = 0, high = s->count;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (s->column[middle] < column)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

const ibl_wedge_strips *ibl_wedge_range(const ibl_wedge *w,
                                        const ibl_wedge_row *row,
                                        const ibl_wedge_part *part, int *begin,
                                        int *end)
{
    const ibl_wedge_strips *s = row->side ? &w->cut : &w->plain;
    *begin = *end = 0;
    if (row->side) {
        *begin = strips_before_column(s, part->first_z);
        *end = strips_before_column(s, part->end_z);
    }
    if (row->top_lines) { /* z = t sin(psi) */
        const double slack = 2 * MARGIN / w->size;
        const double low = border(w, part->first_z) - slack;
        const double high = border(w, part->end_z) + slack;
        const int to = strips_below(s, high / row->top_tan);
        if (!row->side) {
            *begin = strips_below(s, low / row->bottom_tan);
            *begin -= *begin > 0;
        }
        *end = to > *end ? to : *end;
    }
    return s;
}

/* ---- cutting ---------------------------------------------------------- */

/* The part of a strip between two angles, as their cosine and sine. */
struct piece {
    double q[2], r[2];
    double width;
};

struct cutter {
    const ibl_wedge *w;
    const ibl_wedge_row *row;
    const ibl_wedge_part *part;
    ibl_wedge_sink *sink;
    int pixel, column;
};

static void emit(const struct cutter *c, int line, int column, double weight)
{
    ibl_wedge_sink *sink = c->sink;
    if (line < c->w->half && column > line)
        column = line; /* by rounding, on the diagonal */
    if (column < c->part->first_z || column >= c->part->end_z)
        return;
    if (c->row->south)
        line = c->w->lines - 1 - line;
    const int slot = ibl_wedge_slot(c->part, line) + column - c->part->first_z;
    sink->weights[slot] += weight;
    if (sink->count) {
        ibl_octant_span *last = &sink->spans[sink->count - 1];
        if (last->slot == slot && last->weight == weight &&
            last->pixel + last->count == c->pixel) {
            last->count++;
            return;
        }
    }
    if (sink->count == sink->capacity)
        sink->full(sink);
    sink->spans[sink->count++] = (ibl_octant_span){weight, c->pixel, 1, slot};
}

/* A point of a curve: the direction of psi, its cosine and slope there. */
struct point {
    double q, r;
    double cosine, slope;
};

/* A border of texels as cosine = p / sqrt(a^2 + p^2), p = y cos(psi), which
 * falls with psi, or sin(psi), which rises. */
struct curve {
    double a, y;
    bool rises;
};

static struct point point_at(const struct curve *k, double q, double r)
{
    const double p = k->rises ? r : k->y * q;
    const double dp = k->rises ? q : -k->y * r, a2 = k->a * k->a;
    const double inverse = 1 / sqrt(a2 + p * p);
    return (struct point){q, r, p * inverse,
                          dp * a2 * inverse * inverse * inverse};
}

/* Where a curve crosses a border of rows: p = a / tan(theta). */
static struct point crossing(const struct curve *k, double tangent)
{
    const double p = k->a / (k->y * tangent);
    const double other = sqrt(fmax(1 - p * p, 0));
    return k->rises ? point_at(k, other, p) : point_at(k, p, other);
}

/* Angle from one direction to another, not more than 0.02. */
static double angle_between(double q0, double r0, double q1, double r1)
{
    const double s = r1 * q0 - q1 * r0, s2 = s * s;
    return s * (1 + s2 * (1.0 / 6 + s2 * (3.0 / 40)));
}

/*
 * The share of a piece of the row above a curve. Where that is inside the row
 * it is taken as straight but for its bow, which makes the area right to fourth
 * order (Hermite's end correction of the trapezium rule).
 */
static double share_above(const ibl_wedge_row *row, const struct piece *e,
                          const struct curve *k)
{
    struct point at[2] = {point_at(k, e->q[0], e->r[0]),
                          point_at(k, e->q[1], e->r[1])};
    struct point *high = &at[k->rises], *low = &at[!k->rises];
    double below = 0;
    if (low->cosine >= row->top)
        return 0;
    if (high->cosine <= row->bottom)
        return 1;
    if (low->cosine < row->bottom) {
        const struct point to = crossing(k, row->bottom_tan);
        below = fabs(angle_between(low->q, low->r, to.q, to.r));
        *low = to;
    }
    if (high->cosine > row->top)
        *high = crossing(k, row->top_tan);
    const double inside = angle_between(at[0].q, at[0].r, at[1].q, at[1].r);
    const double mean = 0.5 * (at[0].cosine + at[1].cosine) +
                        (at[0].slope - at[1].slope) * inside / 12;
    const double share =
        (inside * (row->top - mean) * row->per_cosine + below) / e->width;
    return fmin(fmax(share, 0), 1);
}

/* Above the upper border of a line. */
static double above_line(const struct cutter *c, const struct piece *e,
                         int line)
{
    const int half = c->w->half;
    const struct curve k =
        line < half
            ? (struct curve){border(c->w, line), 1, false}
            : (struct curve){1, 1 - 2.0 * (line - half) / c->w->size, false};
    return share_above(c->row, e, &k);
}

/* Above the first border of a column of the top. */
static double above_column(const struct cutter *c, const struct piece *e,
                           int column)
{
    const struct curve k = {border(c->w, column), 1, true};
    return share_above(c->row, e, &k);
}

/* Texel lines and columns that a strip can touch. */
struct box {
    int line[2], column[2];
};

/* Hands a piece out to the texels of a box, downwards. Borders of the box do
 * not cross within the piece, so their order is that in the middle. */
static void share_out(const struct cutter *c, const struct box *b,
                      const struct piece *e)
{
    const ibl_wedge *w = c->w;
    const double q = e->q[0] + e->q[1], r = e->r[0] + e->r[1];
    const double area = e->width * (c->row->top - c->row->bottom);
    int line = b->line[0], column = b->column[0];
    double above = 0;
    while (above < 1) {
        const bool down = line < b->line[1];
        const bool top = line < w->half;
        const bool across =
            top && column < b->column[1] &&
            (!down || border(w, column + 1) * q < border(w, line + 1) * r);
        const double next = across ? above_column(c, e, column + 1)
                            : down ? above_line(c, e, line + 1)
                                   : 1;
        if (next > above) {
            if (!top)
                column = c->column;
            emit(c, line, column, (next - above) * area);
            above = next;
        }
        line += !across;
        column += across;
    }
}

/* The first place well within a piece where borders of the top cross. */
static bool first_crossing(const ibl_wedge *w, const struct box *b,
                           const struct piece *e, double *x, double *z)
{
    const double well = 1e-12; /* radians */
    bool found = false;
    for (int i = b->line[0] + 1; i <= b->line[1] && i < w->half; i++) {
        for (int j = b->column[0] + 1; j <= b->column[1]; j++) {
            const double xi = border(w, i), zj = border(w, j);
            if (zj * e->q[0] - xi * e->r[0] > well * xi &&
                xi * e->r[1] - zj * e->q[1] > well * xi &&
                (!found || zj * *x < *z * xi)) {
                *x = xi;
                *z = zj;
                found = true;
            }
        }
    }
    return found;
}

static void cut_strip(const struct cutter *c, const struct box *b,
                      struct piece rest)
{
    double x = 1, z = 0;
    while (first_crossing(c->w, b, &rest, &x, &z)) {
        const double length = 1 / sqrt(x * x + z * z);
        struct piece e = rest;
        e.q[1] = x * length;
        e.r[1] = z * length;
        e.width = angle_between(e.q[0], e.r[0], e.q[1], e.r[1]);
        share_out(c, b, &e);
        rest.q[0] = e.q[1];
        rest.r[0] = e.r[1];
        rest.width -= e.width;
    }
    share_out(c, b, &rest);
}

void ibl_wedge_cut(const ibl_wedge *w, const ibl_wedge_row *row,
                   const ibl_wedge_part *part, int begin, int end,
                   ibl_wedge_sink *sink)
{
    const ibl_wedge_strips *s = row->side ? &w->cut : &w->plain;
    struct cutter c = {w, row, part, sink, 0, 0};
    for (int i = begin; i < end; i++) {
        const double *q = s->cosine + i, *r = s->sine + i;
        struct box b = {{line_at(w, row->top_tan * q[1], -MARGIN),
                         line_at(w, row->bottom_tan * q[0], MARGIN)},
                        {0, 0}};
        c.pixel = s->pixel[i] - s->pixel[begin];
        c.column = s->column ? s->column[i] : 0;
        const bool top = b.line[0] < w->half;
        if (top) {
            b.column[0] = column_at(w, row->top_tan * r[0], -MARGIN);
            b.column[1] = column_at(w, row->bottom_tan * r[1], MARGIN);
        } else {
            b.column[0] = b.column[1] = c.column;
        }
        if (b.column[1] < part->first_z || b.column[0] >= part->end_z)
            continue;
        if (b.line[0] == b.line[1] && b.column[0] == b.column[1]) {
            emit(&c, b.line[0], b.column[0],
                 s->width[i] * (row->top - row->bottom));
            continue;
        }
        const struct piece all = {{q[0], q[1]}, {r[0], r[1]}, s->width[i]};
        cut_strip(&c, &b, all);
    }
    if (sink->count)
        sink->full(sink);
}
