/* SPDX-License-Identifier: MIT */
#include "image/level0_geometry.h"

#include <assert.h>
#include <math.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"

/* Rows are searched this part of a texel beyond their borders, for rounding. */
static const double MARGIN = 1e-6;

/* ---- borders that cut a row ------------------------------------------- */

double ibl_coverage_clipped(const ibl_coverage_row *row, double a, double q0,
                            double r0, double q1, double r1, double width)
{
    const double height = row->top - row->bottom;
    const double enter = a * row->top_cot, leave = a * row->bottom_cot;
    double below = 0;
    if (q1 >= enter)
        return 0;
    if (q0 <= leave)
        return width * height;
    if (q1 < leave) {
        const double r = sqrt(1 - leave * leave);
        below = ibl_coverage_angle(leave, r, q1, r1);
        q1 = leave;
        r1 = r;
    }
    if (q0 > enter) {
        q0 = enter;
        r0 = sqrt(1 - enter * enter);
    }
    const double inside = ibl_coverage_angle(q0, r0, q1, r1);
    const double mean = ibl_coverage_mean(a, q0, r0, q1, r1, inside);
    return inside * (row->top - mean) + below * height;
}

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
    ibl_free(s->strip);
    ibl_free(s->first);
}

/* Allocates up to `most` strips, and `first` for this many columns. */
static bool strips_alloc(ibl_wedge_strips *s, int most, int columns)
{
    s->strip = ibl_alloc_zeroed((size_t)most + 1, sizeof *s->strip);
    s->first = ibl_alloc_zeroed((size_t)columns, sizeof *s->first);
    return s->strip && s->first;
}

static void find_runs(ibl_wedge_strips *s)
{
    for (int i = s->count - 1; i >= 0; i--) {
        ibl_wedge_strip *at = s->strip + i;
        const bool on = i + 1 < s->count && at[1].pixel == at->pixel + 1 &&
                        at[1].width == at->width && at[1].column == at->column;
        at->run = on ? at[1].run + 1 : 1;
    }
}

static void set_border(ibl_wedge_strips *s, double psi)
{
    s->strip[s->count].cosine = cos(psi);
    s->strip[s->count].sine = sin(psi);
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
        if (to > at + same) {
            ibl_wedge_strip *new = &s->strip[s->count++];
            new->width = to - at;
            new->pixel = pixel;
            new->column = column;
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
    if (!w->border || !strips_alloc(&w->plain, w->pixels + 1, 1) ||
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

/* The texel line, counted from its pole, at 1 / y = tan(theta) cos(psi) in the
 * plane of the top, after moving by `move` texels. */
static int line_at(const ibl_wedge *w, double y, double move)
{
    const double scale = 0.5 * w->size;
    const double i =
        y > 1 ? scale / y + 0.5 * (w->size % 2) : (1 - y) * scale + w->half;
    const int line = (int)(i + move), last = 2 * w->half - 1;
    return line < last ? line : last;
}

/* z of the end of a texel column, but of the last one infinite. */
static double column_end(const ibl_wedge *w, int column)
{
    return column + 1 < w->half ? w->border[column + 1] : INFINITY;
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
    const ibl_coverage_row cut = {cos(from), cos(to), 1 / tan(from),
                                  1 / tan(to)};
    const int first = line_at(w, cut.top_cot * sqrt(2), -MARGIN);
    const int last = line_at(w, cut.bottom_cot, MARGIN);
    *row = (ibl_wedge_row){.south = south,
                           .cut = cut,
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
        if (s->strip[middle].sine < x)
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
        const int to = strips_below(s, high * row->cut.top_cot);
        if (!row->side) {
            *begin = strips_below(s, low * row->cut.bottom_cot);
            *begin -= *begin > 0;
        }
        *end = to > *end ? to : *end;
    }
    return s;
}

/* ---- cutting ---------------------------------------------------------- */

/* First and last texel lines and columns that a strip can touch. */
struct box {
    int line[2], column[2];
    int slot; /* of the first line, from the part's first column */
};

struct cutter {
    const ibl_wedge *w;
    const ibl_coverage_row *row;
    double height;           /* of the row, as a difference of cosines */
    int first, width, slots; /* of the part */
    ibl_wedge_sink *sink;
};

/* Adds a span of count pixels, fewer than 2^16, if column z of the part is in
 * it. */
static inline void add_span(const struct cutter *c, double weight, int slot,
                            int z, int pixel, int count)
{
    ibl_wedge_sink *s = c->sink;
    if ((unsigned)z >= (unsigned)c->width)
        return;
    if (s->count == IBL_WEDGE_SPANS)
        s->full(s);
    s->spans[s->count++] = (ibl_octant_span){(float)weight, slot + z,
                                             (uint16_t)pixel, (uint16_t)count};
}

/* Distributes a strip, or a piece of one, over the texels of a box, from top to
 * bottom. Each gets the difference of the areas above its two borders. Borders
 * of the box must not cross within the piece; they are sorted by their order in
 * its middle. */
static void share_out(const struct cutter *c, const struct box *b,
                      const ibl_wedge_strip *s)
{
    const double *border = c->w->border + 1;
    const double q0 = s->cosine, r0 = s->sine, width = s->width;
    const double q1 = s[1].cosine, r1 = s[1].sine, all = width * c->height;
    const int half = c->w->half, last = b->line[1];
    int line = b->line[0], slot = b->slot;
    int column = line < half ? b->column[0] : s->column;
    int columns = line < half ? b->column[1] : column;
    for (double above = 0, area = 0; area < all; above = area) {
        const int at = column - c->first, to = slot;
        const bool down = line < last;
        if (column < columns &&
            (!down || border[column] * (q0 + q1) < border[line] * (r0 + r1))) {
            area = ibl_coverage_above(c->row, border[column], r1, q1, r0, q0,
                                      width);
            column++;
        } else if (down) {
            area =
                ibl_coverage_above(c->row, border[line], q0, r0, q1, r1, width);
            slot += c->width;
            slot -= slot < c->slots ? 0 : c->slots;
            if (++line == half)
                column = columns = s->column;
        } else {
            area = all;
        }
        area = area < above ? above : area < all ? area : all;
        if (area > above)
            add_span(c, area - above, to, at, s->pixel, 1);
    }
}

/* Finds the first point inside a piece where borders of the top cross. */
static bool first_crossing(const ibl_wedge *w, const struct box *b,
                           const ibl_wedge_strip *s, double *x, double *z)
{
    const double well = 1e-12; /* distance from the ends in radians */
    bool found = false;
    for (int i = b->line[0] + 1; i <= b->line[1] && i < w->half; i++) {
        for (int j = b->column[0] + 1; j <= b->column[1]; j++) {
            const double xi = w->border[i], zj = w->border[j];
            if (zj * s->cosine - xi * s->sine > well * xi &&
                xi * s[1].sine - zj * s[1].cosine > well * xi &&
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
                      const ibl_wedge_strip *s)
{
    ibl_wedge_strip piece[2] = {*s}, rest[2] = {*s, s[1]};
    double x = 1, z = 0;
    while (first_crossing(c->w, b, rest, &x, &z)) {
        const double length = 1 / sqrt(x * x + z * z);
        piece[0] = rest[0];
        piece[1].cosine = rest[0].cosine = x * length;
        piece[1].sine = rest[0].sine = z * length;
        piece[0].width = ibl_coverage_angle(piece[0].cosine, piece[0].sine,
                                            piece[1].cosine, piece[1].sine);
        rest[0].width -= piece[0].width;
        share_out(c, b, piece);
    }
    share_out(c, b, rest);
}

/* As strips follow each other, lines fall and columns rise: q and r are the
 * cosines and sines where a strip leaves the first and the last of its box. */
void ibl_wedge_cut(const ibl_wedge *w, const ibl_wedge_row *row,
                   const ibl_wedge_part *part, int begin, int end,
                   ibl_wedge_sink *sink)
{
    const ibl_wedge_strip *strip = (row->side ? &w->cut : &w->plain)->strip;
    const double top = row->cut.top_cot, bottom = row->cut.bottom_cot;
    const int width = part->end_z - part->first_z;
    const struct cutter c = {w,
                             &row->cut,
                             row->cut.top - row->cut.bottom,
                             part->first_z,
                             width,
                             part->ring * width,
                             sink};
    const double z = 0.5 * (strip[begin].sine / top * w->size + w->size % 2);
    const int column = z < w->half ? (int)z : w->half - 1;
    const int last = row->last_line;
    struct box b = {{last, last}, {column, column}, last % part->ring * width};
    double q0 = w->border[last] * top, q1 = w->border[last] * bottom;
    double r0 = column_end(w, column) * top;
    double r1 = column_end(w, column) * bottom;
    const ibl_wedge_strip *const stop = strip + end;
    for (const ibl_wedge_strip *s = strip + begin, *next; s < stop; s = next) {
        while (s[1].cosine < q0 && b.line[0] > row->first_line) {
            q0 = w->border[--b.line[0]] * top;
            b.slot = (b.slot ? b.slot : c.slots) - width;
        }
        while (s->cosine < q1 && b.line[1] > b.line[0])
            q1 = w->border[--b.line[1]] * bottom;
        while (s->sine > r0)
            r0 = column_end(w, ++b.column[0]) * top;
        while (s[1].sine > r1)
            r1 = column_end(w, ++b.column[1]) * bottom;
        const bool side = b.line[0] >= w->half, down = b.line[0] < b.line[1];
        const bool across = !side && b.column[0] < b.column[1];
        next = s + 1;
        if (down && across) {
            cut_strip(&c, &b, s);
        } else if (down || across) {
            share_out(&c, &b, s);
        } else {
            /* with the strips after it that are inside the same texel */
            const ibl_wedge_strip *most = s + s->run < stop ? s + s->run : stop;
            while (next < most && !(next[1].cosine < q0) &&
                   (side || next[1].sine <= r1))
                next++;
            add_span(&c, s->width * c.height, b.slot,
                     (side ? s->column : b.column[0]) - c.first, s->pixel,
                     (int)(next - s));
        }
    }
    if (sink->count)
        sink->full(sink);
}
