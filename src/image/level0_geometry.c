/* SPDX-License-Identifier: MIT */
#include "image/level0_geometry.h"

#include <assert.h>
#include <math.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"

/* Rows are searched this part of a texel beyond their borders, for rounding. */
static const double MARGIN = 1e-6;

/* ---- strips ----------------------------------------------------------- */

/* a of line i's upper border; for i <= half also z of column i's first one. */
static double border(const ibl_wedge *w, int i)
{
    if (i == 0)
        return 0;
    if (i <= w->half)
        return (2.0 * i - w->size % 2) / w->size;
    return w->size / (w->size - 2.0 * (i - w->half));
}

static void strips_free(ibl_wedge_strips *s)
{
    ibl_free(s->cosine);
    ibl_free(s->pixel);
}

/* Allocates up to `most` strips, and `first` for this many columns. */
static bool strips_alloc(ibl_wedge_strips *s, int most, int columns)
{
    const size_t n = (size_t)most + 1;
    s->cosine = ibl_alloc_zeroed(4 * n, sizeof *s->cosine);
    s->pixel = ibl_alloc_zeroed(3 * n + (size_t)columns, sizeof *s->pixel);
    if (!s->cosine || !s->pixel)
        return false;
    s->sine = s->cosine + n;
    s->secant = s->cosine + 2 * n;
    s->width = s->cosine + 3 * n;
    s->column = s->pixel + n;
    s->run = s->pixel + 2 * n;
    s->first = s->pixel + 3 * n;
    return true;
}

static void find_runs(ibl_wedge_strips *s)
{
    for (int i = s->count - 1; i >= 0; i--) {
        const int j = i + 1;
        const bool on = j < s->count && s->pixel[j] == s->pixel[i] + 1 &&
                        s->width[j] == s->width[i] &&
                        s->column[j] == s->column[i];
        s->run[i] = on ? s->run[j] : j;
    }
}

static void set_border(ibl_wedge_strips *s, double psi)
{
    s->cosine[s->count] = cos(psi);
    s->sine[s->count] = sin(psi);
    s->secant[s->count] = 1 / cos(psi);
}

/* Fills strips between borders of pixels and, if by_column, of texels on the
 * side. Borders that differ only by rounding are merged. */
static void strips_fill(const ibl_wedge *w, int columns, double before,
                        bool by_column, ibl_wedge_strips *s)
{
    const double step = 2 * IBL_PI / columns, same = 1e-9 * step;
    double at = 0;
    int pixel = 0, column = 0;
    set_border(s, 0);
    while (at < IBL_PI / 4) {
        const double pixel_end = (pixel + 1 - before) * step;
        const double column_end =
            by_column ? atan(w->border[column + 1]) : IBL_PI / 4;
        double to = pixel_end < column_end ? pixel_end : column_end;
        if (to > IBL_PI / 4 - same)
            to = IBL_PI / 4;
        const bool ends_pixel = pixel_end <= to + same;
        const bool ends_column = column_end <= to + same;
        const bool begins_pixel = fabs(at - (pixel - before) * step) <= same;
        if (to > at + same) {
            s->width[s->count] = begins_pixel && ends_pixel ? step : to - at;
            s->pixel[s->count] = pixel;
            s->column[s->count++] = column;
            set_border(s, to);
            at = to;
        }
        pixel += ends_pixel;
        if (by_column && ends_column)
            s->first[++column] = s->count;
    }
    find_runs(s);
}

ibl_status ibl_wedge_init(ibl_ctx *ctx, int size, int columns, double before,
                          ibl_wedge *w)
{
    *w = (ibl_wedge){.size = size, .half = (size + 1) / 2};
    w->lines = 4 * w->half - size % 2;
    w->pixels = (int)ceil(columns / 8.0 + before);
    assert(w->pixels <= UINT16_MAX);
    w->border = ibl_alloc_array((size_t)w->half * 2, sizeof *w->border);
    if (!w->border || !strips_alloc(&w->plain, w->pixels + 1, 0) ||
        !strips_alloc(&w->cut, w->pixels + w->half + 1, w->half + 1)) {
        ibl_wedge_free(w);
        return ibl_no_memory(ctx, "level 0's tables");
    }
    for (int i = 0; i < 2 * w->half; i++)
        w->border[i] = border(w, i);
    strips_fill(w, columns, before, false, &w->plain);
    strips_fill(w, columns, before, true, &w->cut);
    return IBL_OK;
}

void ibl_wedge_free(ibl_wedge *w)
{
    strips_free(&w->plain);
    strips_free(&w->cut);
    ibl_free(w->border);
    *w = (ibl_wedge){0};
}

/* ---- rows ------------------------------------------------------------- */

/* The texel line, counted from its pole, at x = tan(theta) cos(psi) in the
 * plane of the top, after moving by `move` texels. inverse: 1 / x. */
static int line_at(const ibl_wedge *w, double x, double inverse, double move)
{
    const double scale = 0.5 * w->size;
    const double i = x < 1 ? x * scale + 0.5 * (w->size % 2)
                           : (1 - inverse) * scale + w->half;
    const int line = (int)(i + move), last = 2 * w->half - 1;
    return line < last ? line : last;
}

/* The texel column at z on top, after moving by `move` texels. */
static int column_at(const ibl_wedge *w, double z, double move)
{
    const double i = z * 0.5 * w->size + 0.5 * (w->size % 2) + move;
    return i < w->half ? (int)i : w->half - 1;
}

bool ibl_wedge_row_init(const ibl_wedge *w, int rows, int j, bool south,
                        ibl_wedge_row *row)
{
    const double from = IBL_PI * (south ? rows - 1 - j : j) / rows;
    double to = IBL_PI * (south ? rows - j : j + 1) / rows;
    if (from > IBL_PI / 2 - 1e-12)
        return false;
    if (to > IBL_PI / 2)
        to = IBL_PI / 2;
    const ibl_coverage_row cut = {cos(from), cos(to), 1 / (cos(from) - cos(to)),
                                  tan(from), tan(to)};
    const double top_cot = 1 / cut.top_tan, bottom_cot = 1 / cut.bottom_tan;
    const int first =
        line_at(w, cut.top_tan * sqrt(0.5), top_cot * sqrt(2), -MARGIN);
    const int last = line_at(w, cut.bottom_tan, bottom_cot, MARGIN);
    *row = (ibl_wedge_row){.south = south,
                           .cut = cut,
                           .top_cot = top_cot,
                           .bottom_cot = bottom_cot,
                           .top_lines = first < w->half,
                           .side = last >= w->half,
                           .first_line = first,
                           .last_line = last};
    return true;
}

int ibl_wedge_lines_before(const ibl_wedge *w, const ibl_wedge_row *row)
{
    return row->south ? w->lines - 1 - row->last_line : row->first_line;
}

int ibl_wedge_slot(const ibl_wedge *w, const ibl_wedge_part *part, int line)
{
    const int mirror = w->lines - 1 - line;
    const int from_pole = line < mirror ? line : mirror;
    return from_pole % part->ring * (part->end_z - part->first_z);
}

/* The number of strip borders with a sine below x. */
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

const ibl_wedge_strips *ibl_wedge_range(const ibl_wedge *w,
                                        const ibl_wedge_row *row,
                                        const ibl_wedge_part *part, int *begin,
                                        int *end)
{
    const ibl_wedge_strips *s = row->side ? &w->cut : &w->plain;
    *begin = *end = 0;
    if (row->side) {
        *begin = s->first[part->first_z];
        *end = s->first[part->end_z];
    }
    if (row->top_lines) { /* z = t sin(psi) */
        const double slack = 2 * MARGIN / w->size;
        const double low = w->border[part->first_z] - slack;
        const double high = w->border[part->end_z] + slack;
        const int to = strips_below(s, high / row->cut.top_tan);
        if (!row->side) {
            *begin = strips_below(s, low / row->cut.bottom_tan);
            *begin -= *begin > 0;
        }
        *end = to > *end ? to : *end;
    }
    return s;
}

/* ---- cutting ---------------------------------------------------------- */

/* The part of a strip between two angles, given by cosines q and sines r. */
struct piece {
    double q[2], r[2];
    double width;
};

/* First and last texel lines and columns that a strip can touch. */
struct box {
    int line[2], column[2];
};

struct cutter {
    const ibl_wedge *w;
    const ibl_wedge_row *row;
    const ibl_wedge_part *part;
    ibl_wedge_sink *sink;
    double height; /* of the row, as a difference of cosines */
    int base;      /* place of the row's first line in the ring */
    int pixel, column;
};

/* The slot of a texel; -1: not in the part. */
static int slot_of(const struct cutter *c, int line, int column)
{
    const ibl_wedge_part *part = c->part;
    if (line < c->w->half && column > line)
        column = line; /* rounding on the diagonal */
    if (column < part->first_z || column >= part->end_z)
        return -1;
    line += c->base - c->row->first_line;
    if (line >= part->ring)
        line -= part->ring;
    return line * (part->end_z - part->first_z) + column - part->first_z;
}

/* Adds a span of count pixels, fewer than 2^16, to a slot of the part. */
static void add_span(ibl_wedge_sink *s, double weight, int slot, int pixel,
                     int count)
{
    if (slot < 0 || !(weight > 0))
        return;
    if (s->count == IBL_WEDGE_SPANS)
        s->full(s);
    s->spans[s->count++] =
        (ibl_octant_span){weight, slot, (uint16_t)pixel, (uint16_t)count};
}

/*
 * Adds strip i, which lies inside one texel, and the following strips inside
 * it: those with the upper border above and, on top, the lower border below.
 * Returns the next strip to test.
 */
static int add_whole(const struct cutter *c, const ibl_wedge_strips *s, int i,
                     int end, int line, int column)
{
    const ibl_wedge *w = c->w;
    const bool top = line < w->half;
    const double q = w->border[line] * c->row->top_cot + 2 * MARGIN / w->size;
    const double r =
        top && column + 1 < w->half
            ? w->border[column + 1] * c->row->bottom_cot - 2 * MARGIN / w->size
            : 1;
    const int most = s->run[i] < end ? s->run[i] : end;
    int next = i + 1;
    while (next < most && s->cosine[next + 1] >= q && s->sine[next + 1] <= r)
        next++;
    add_span(c->sink, s->width[i] * c->height, slot_of(c, line, column),
             c->pixel, next - i);
    return next;
}

/* The share of a piece above a border: a line's or, with rises, a column's. */
static double piece_above(const struct cutter *c, const struct piece *e,
                          double a, bool rises)
{
    const double *q = rises ? e->r : e->q, *r = rises ? e->q : e->r;
    const ibl_border_point high = ibl_border_point_at(a, q[rises], r[rises]);
    const ibl_border_point low = ibl_border_point_at(a, q[!rises], r[!rises]);
    return ibl_coverage_share(&c->row->cut, a, &high, &low, e->width);
}

/* Distributes a piece over the texels of a box, from top to bottom. Each gets
 * the difference of the shares above its two borders. Borders of the box must
 * not cross within the piece; they are sorted by their order in its middle. */
static void share_out(const struct cutter *c, const struct box *b,
                      const struct piece *e)
{
    const double *border = c->w->border;
    const double q = e->q[0] + e->q[1], r = e->r[0] + e->r[1];
    const double area = e->width * c->height;
    int line = b->line[0], column = b->column[0];
    for (double above = 0;;) {
        const bool top = line < c->w->half, down = line < b->line[1];
        const bool across =
            top && column < b->column[1] &&
            (!down || border[column + 1] * q < border[line + 1] * r);
        const bool last = !across && !down;
        const double share =
            last ? 1
                 : piece_above(c, e, border[across ? column + 1 : line + 1],
                               across);
        if (share > above) {
            add_span(c->sink, area * (share - above),
                     slot_of(c, line, top ? column : c->column), c->pixel, 1);
            above = share;
        }
        if (last)
            return;
        line += !across;
        column += across;
    }
}

/* Finds the first point inside a piece where borders of the top cross. */
static bool first_crossing(const ibl_wedge *w, const struct box *b,
                           const struct piece *e, double *x, double *z)
{
    const double well = 1e-12; /* distance from the ends in radians */
    bool found = false;
    for (int i = b->line[0] + 1; i <= b->line[1] && i < w->half; i++) {
        for (int j = b->column[0] + 1; j <= b->column[1]; j++) {
            const double xi = w->border[i], zj = w->border[j];
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
        e.width = ibl_coverage_angle(e.q[0], e.r[0], e.q[1], e.r[1]);
        share_out(c, b, &e);
        rest.q[0] = e.q[1];
        rest.r[0] = e.r[1];
        rest.width -= e.width;
    }
    share_out(c, b, &rest);
}

static struct box box_of(const ibl_wedge *w, const ibl_wedge_row *row,
                         const ibl_wedge_strips *s, int i)
{
    const double *q = s->cosine + i, *r = s->sine + i;
    const double *secant = s->secant + i;
    struct box b;
    b.line[0] =
        line_at(w, row->cut.top_tan * q[1], row->top_cot * secant[1], -MARGIN);
    b.line[1] = line_at(w, row->cut.bottom_tan * q[0],
                        row->bottom_cot * secant[0], MARGIN);
    if (b.line[0] < w->half) {
        b.column[0] = column_at(w, row->cut.top_tan * r[0], -MARGIN);
        b.column[1] = column_at(w, row->cut.bottom_tan * r[1], MARGIN);
    } else {
        b.column[0] = b.column[1] = s->column[i];
    }
    return b;
}

/* ---- sides ------------------------------------------------------------ */

/* The strips that a border crosses, and their shares above it. */
struct zone {
    int begin, end;
    double *share;
};

/* Moves a zone to border a. Borders must come from below to above: each crosses
 * later strips than the one before. */
static void find_zone(const struct cutter *c, const ibl_wedge_strips *s,
                      int end, double a, struct zone *z)
{
    const double from = a * c->row->top_cot, to = a * c->row->bottom_cot;
    while (z->begin < end && s->cosine[z->begin + 1] >= from)
        z->begin++;
    z->end = z->end > z->begin ? z->end : z->begin;
    while (z->end < end && s->cosine[z->end] > to)
        z->end++;
    ibl_border_point high =
        ibl_border_point_at(a, s->cosine[z->begin], s->sine[z->begin]);
    for (int i = z->begin; i < z->end; i++) {
        const ibl_border_point low =
            ibl_border_point_at(a, s->cosine[i + 1], s->sine[i + 1]);
        z->share[i - z->begin] =
            ibl_coverage_share(&c->row->cut, a, &high, &low, s->width[i]);
        high = low;
    }
}

/* Adds the texels of a line, between two borders. slot is that of column 0. */
static void side_line(const struct cutter *c, const ibl_wedge_strips *s,
                      int origin, int slot, const struct zone *lower,
                      const struct zone *upper)
{
    for (int i = lower->begin, next; i < upper->end; i = next) {
        double share = i < lower->end ? lower->share[i - lower->begin] : 1;
        if (i >= upper->begin)
            share -= upper->share[i - upper->begin];
        next = i + 1;
        if (i >= lower->end && i < upper->begin)
            next = s->run[i] < upper->begin ? s->run[i] : upper->begin;
        add_span(c->sink, share * s->width[i] * c->height, slot + s->column[i],
                 s->pixel[i] - origin, next - i);
    }
}

/* Cuts a row that does not reach the top, line by line from the lowest, at
 * `begin`, to the highest. A border crosses one strip after the other. */
static void cut_side(const struct cutter *c, const ibl_wedge_strips *s,
                     int begin, int end)
{
    const ibl_wedge *w = c->w;
    const ibl_wedge_row *row = c->row;
    const int last = line_at(w, row->cut.bottom_tan * s->cosine[begin],
                             row->bottom_cot * s->secant[begin], MARGIN);
    const int first = line_at(w, row->cut.top_tan * s->cosine[end],
                              row->top_cot * s->secant[end], -MARGIN);
    struct zone lower = {begin, begin, c->sink->zone};
    struct zone upper = {begin, begin, c->sink->zone + w->cut.count};
    for (int line = last; line >= first; line--) {
        double *const room = lower.share;
        if (line > first)
            find_zone(c, s, end, w->border[line], &upper);
        else
            upper.begin = upper.end = end;
        side_line(c, s, s->pixel[begin],
                  slot_of(c, line, c->part->first_z) - c->part->first_z, &lower,
                  &upper);
        lower = upper;
        upper.share = room;
    }
}

/* ---- rows of strips --------------------------------------------------- */

/* Cuts the strips of a row that reaches the top. */
static void cut_top(struct cutter *c, const ibl_wedge_strips *s, int begin,
                    int end)
{
    for (int i = begin; i < end;) {
        const struct box b = box_of(c->w, c->row, s, i);
        c->pixel = s->pixel[i] - s->pixel[begin];
        c->column = s->column[i];
        if (b.line[0] == b.line[1] && b.column[0] == b.column[1]) {
            i = add_whole(c, s, i, end, b.line[0], b.column[0]);
            continue;
        }
        if (b.column[1] >= c->part->first_z && b.column[0] < c->part->end_z)
            cut_strip(c, &b,
                      (struct piece){{s->cosine[i], s->cosine[i + 1]},
                                     {s->sine[i], s->sine[i + 1]},
                                     s->width[i]});
        i++;
    }
}

void ibl_wedge_cut(const ibl_wedge *w, const ibl_wedge_row *row,
                   const ibl_wedge_part *part, int begin, int end,
                   ibl_wedge_sink *sink)
{
    struct cutter c = {w,
                       row,
                       part,
                       sink,
                       row->cut.top - row->cut.bottom,
                       row->first_line % part->ring,
                       0,
                       0};
    if (row->top_lines)
        cut_top(&c, row->side ? &w->cut : &w->plain, begin, end);
    else
        cut_side(&c, &w->cut, begin, end);
    if (sink->count)
        sink->full(sink);
}
