/* SPDX-License-Identifier: MIT */
#include "cli/plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    WIDTH = 720,
    HEIGHT = 400, /* of the frame and its axes; the legend comes on top */
    LEFT = 74,
    RIGHT = 18,
    TOP = 12,
    BOTTOM = 52,
    LINE = 20, /* of the legend and the title */
    MAX_TICKS = 64,
    MAX_LABELS = 256
};

/* About the width of a character of 12 px sans serif. */
static const double letter = 6.6;

/* Colours that stay apart for most colour-blind eyes and on both grounds
 * (after Okabe and Ito 2008). */
const char ibl_plot_css[] =
    ":root{--bg:#fff;--fg:#1b1f24;--dim:#59636e;--grid:#e3e7ec;--rule:#c4cbd3;"
    "--s0:#0066b8;--s1:#c64a00;--s2:#00805c;--s3:#a83b83;--s4:#8a6a00;"
    "--s5:#3d3dc4;--s6:#4d7d1c;--s7:#b3261e}\n"
    "@media(prefers-color-scheme:dark){:root{--bg:#14171c;--fg:#e6e9ee;"
    "--dim:#9aa4b0;--grid:#2a3038;--rule:#434b55;--s0:#58aef5;--s1:#f79256;"
    "--s2:#3fc9a0;--s3:#e68ac6;--s4:#e0bb4a;--s5:#9b9bff;--s6:#9dcf62;"
    "--s7:#ff8a80}}\n"
    "svg text{font:12px system-ui,sans-serif;fill:var(--dim)}\n"
    "svg .t{font-weight:600;font-size:14px;fill:var(--fg)}\n"
    "svg .l{fill:var(--fg)}\n"
    "svg .g{stroke:var(--grid)}svg .m{stroke:var(--grid);opacity:.45}\n"
    "svg .a{stroke:var(--rule);fill:none}\n"
    "svg .r{stroke:var(--fg);fill:none;stroke-width:1.5}\n"
    "svg .h{stroke:var(--bg);stroke-width:3;paint-order:stroke;"
    "stroke-linejoin:round}\n"
    "svg .n{fill:none;stroke-width:2}svg .d{fill:none;stroke-width:1.5;"
    "stroke-dasharray:5 4}\n"
    "svg .b{stroke-width:1.2;opacity:.7}\n";

void ibl_plot_escape(const char *text, FILE *to)
{
    for (; *text; text++)
        switch (*text) {
        case '&':
            fputs("&amp;", to);
            break;
        case '<':
            fputs("&lt;", to);
            break;
        case '>':
            fputs("&gt;", to);
            break;
        case '"':
            fputs("&quot;", to);
            break;
        default:
            fputc((unsigned char)*text < ' ' && *text != '\n' ? ' ' : *text,
                  to);
        }
}

void ibl_plot_format(ibl_plot_unit unit, double value, char *text, size_t size)
{
    const char *name = "";

    if (unit == IBL_PLOT_PERCENT) {
        value *= 100;
        name = " %";
    } else if (unit == IBL_PLOT_SECONDS) {
        const double size_s = fabs(value);
        name = size_s >= 0.9995 ? " s" : size_s >= 0.9995e-3 ? " ms" : " µs";
        value *= size_s >= 0.9995 ? 1 : size_s >= 0.9995e-3 ? 1e3 : 1e6;
    }
    if (fabs(value) >= 999.5 && fabs(value) < 1e6)
        snprintf(text, size, "%.0f%s", value, name);
    else
        snprintf(text, size, "%.3g%s", value, name);
}

/* ---- axes ------------------------------------------------------------ */

typedef struct scale {
    const ibl_plot_axis *axis;
    double low, high; /* of the data, logarithms if log */
    double from, to;  /* pixels */
    double ticks[MAX_TICKS];
    int ticks_count;
} scale;

static double unit_of(const scale *s, double value)
{
    return s->axis->log ? log10(value) : value;
}

static double place(const scale *s, double value)
{
    return s->from + (unit_of(s, value) - s->low) / (s->high - s->low) *
                         (s->to - s->from);
}

static bool is_drawn(const ibl_plot *plot, const ibl_plot_point *p)
{
    return isfinite(p->x) && isfinite(p->y) && (!plot->x.log || p->x > 0) &&
           (!plot->y.log || p->y > 0);
}

static double value_of(const ibl_plot_point *p, bool along_x)
{
    return along_x ? p->x : p->y;
}

/* The range of the points, with their bars, and some room. */
static void find_range(scale *s, const ibl_plot *plot, bool along_x)
{
    double low = INFINITY, high = -INFINITY;

    for (int i = 0; i < plot->count; i++)
        for (int k = 0; k < plot->series[i].count; k++) {
            const ibl_plot_point *p = &plot->series[i].points[k];
            const double lo = along_x ? p->x_low : p->y_low;
            const double hi = along_x ? p->x_high : p->y_high;
            if (!is_drawn(plot, p))
                continue;
            low = fmin(low, unit_of(s, value_of(p, along_x)));
            high = fmax(high, unit_of(s, value_of(p, along_x)));
            if (hi > 0 && (lo > 0 || !s->axis->log)) {
                low = fmin(low, unit_of(s, lo));
                high = fmax(high, unit_of(s, hi));
            }
        }
    if (s->axis->low < s->axis->high) {
        s->low = unit_of(s, s->axis->low);
        s->high = unit_of(s, s->axis->high);
        return;
    }
    if (low > high) {
        low = 0;
        high = 1;
    }
    /* A log axis of less than half a decade shows noise as if it was much. */
    const double least = s->axis->log ? 0.5 : 1e-9;
    const double lack = fmax(least - (high - low), 0) / 2;
    const double room = 0.06 * fmax(high - low, least);
    s->low = low - lack - room;
    s->high = high + lack + room;
}

static void add_tick(scale *s, double value)
{
    const double at = unit_of(s, value), slack = 1e-9 * (s->high - s->low);

    for (int i = 0; i < s->ticks_count; i++)
        if (fabs(unit_of(s, s->ticks[i]) - at) < slack)
            return;
    if (at >= s->low - slack && at <= s->high + slack &&
        s->ticks_count < MAX_TICKS)
        s->ticks[s->ticks_count++] = value;
}

static void linear_ticks(scale *s, double low, double high)
{
    const double raw = (high - low) / 6;
    const double power = pow(10, floor(log10(raw)));
    const double part = raw / power;
    const double step = power * (part > 5   ? 10
                                 : part > 2 ? 5
                                 : part > 1 ? 2
                                            : 1);

    s->ticks_count = 0;
    for (double k = ceil(low / step - 1e-9); k * step <= high * (1 + 1e-9); k++)
        add_tick(s, k == 0 ? 0 : k * step);
}

/* Decades, or 1 2 5 of each where they are few, or round steps. */
static void log_ticks(scale *s)
{
    const int first = (int)floor(s->low), last = (int)ceil(s->high);

    for (int e = first; e <= last; e++)
        add_tick(s, pow(10, e));
    if (s->ticks_count < 3) {
        s->ticks_count = 0;
        for (int e = first; e <= last; e++) {
            add_tick(s, pow(10, e));
            add_tick(s, 2 * pow(10, e));
            add_tick(s, 5 * pow(10, e));
        }
    }
    if (s->ticks_count < 2)
        linear_ticks(s, pow(10, s->low), pow(10, s->high));
}

static void value_ticks(scale *s, const ibl_plot *plot, bool along_x)
{
    for (int i = 0; i < plot->count; i++)
        for (int k = 0; k < plot->series[i].count; k++)
            if (is_drawn(plot, &plot->series[i].points[k]))
                add_tick(s, value_of(&plot->series[i].points[k], along_x));
}

static scale make_scale(const ibl_plot *plot, bool along_x, double from,
                        double to)
{
    scale s = {.axis = along_x ? &plot->x : &plot->y, .from = from, .to = to};

    find_range(&s, plot, along_x);
    if (s.axis->at_values)
        value_ticks(&s, plot, along_x);
    else if (s.axis->log)
        log_ticks(&s);
    else
        linear_ticks(&s, s.low, s.high);
    return s;
}

/* Lines between the ticks of a log axis that has decades alone. */
static void minor_lines(const scale *s, bool along_x, double a, double b,
                        FILE *to)
{
    if (!s->axis->log || s->axis->at_values || s->high - s->low > 5)
        return;
    for (int e = (int)floor(s->low); e <= (int)ceil(s->high); e++)
        for (int k = 2; k < 10; k++) {
            const double value = k * pow(10, e), at = place(s, value);
            if (log10(value) < s->low || log10(value) > s->high)
                continue;
            fprintf(to, "<path class=\"m\" d=\"M%.1f %.1f%c%.1f\"/>\n",
                    along_x ? at : a, along_x ? a : at, along_x ? 'V' : 'H', b);
        }
}

static void draw_axis(const scale *s, bool along_x, double a, double b,
                      FILE *to)
{
    double last = -INFINITY;

    minor_lines(s, along_x, a, b, to);
    for (int i = 0; i < s->ticks_count; i++) {
        const double at = place(s, s->ticks[i]);
        char text[32];
        ibl_plot_format(s->axis->unit, s->ticks[i], text, sizeof text);
        fprintf(to, "<path class=\"g\" d=\"M%.1f %.1f%c%.1f\"/>",
                along_x ? at : a, along_x ? a : at, along_x ? 'V' : 'H', b);
        if (!along_x) {
            fprintf(to,
                    "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n",
                    LEFT - 8, at + 4, text);
            continue;
        }
        /* Labels that would touch the one before are left out. */
        const double half = letter * (double)strlen(text) / 2;
        if (at - half > last + 6) {
            fprintf(to,
                    "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s"
                    "</text>",
                    at, a + 18, text);
            last = at + half;
        }
        fputc('\n', to);
    }
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void draw_axes(scale *x, scale *y, FILE *to)
{
    const double top = y->to, bottom = y->from;

    qsort(x->ticks, (size_t)x->ticks_count, sizeof *x->ticks, by_value);
    draw_axis(x, true, bottom, top, to);
    draw_axis(y, false, x->from, x->to, to);
    fprintf(to,
            "<rect class=\"a\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" "
            "height=\"%.1f\"/>\n",
            x->from, top, x->to - x->from, bottom - top);
    fprintf(to,
            "<text class=\"l\" x=\"%.1f\" y=\"%.1f\" "
            "text-anchor=\"middle\">",
            (x->from + x->to) / 2, bottom + 40);
    ibl_plot_escape(x->axis->label, to);
    fprintf(to,
            "</text>\n<text class=\"l\" text-anchor=\"middle\" "
            "transform=\"translate(15 %.1f) rotate(-90)\">",
            (top + bottom) / 2);
    ibl_plot_escape(y->axis->label, to);
    fputs("</text>\n", to);
}

/* ---- points ---------------------------------------------------------- */

static void draw_marker(int style, double x, double y, FILE *to)
{
    const int shape = style % 5;

    fprintf(to, "<path style=\"fill:var(--s%d)\" d=\"",
            style % IBL_PLOT_COLOURS);
    if (shape == 0)
        fprintf(to, "M%.1f %.1fa4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0 -9 0z", x - 4.5,
                y);
    else if (shape == 1)
        fprintf(to, "M%.1f %.1fh8v8h-8z", x - 4, y - 4);
    else if (shape == 2)
        fprintf(to, "M%.1f %.1fl5 9h-10z", x, y - 5.5);
    else if (shape == 3)
        fprintf(to, "M%.1f %.1fl5.5 5.5l-5.5 5.5l-5.5 -5.5z", x, y - 5.5);
    else
        fprintf(to, "M%.1f %.1fl5 -9h-10z", x, y + 5.5);
    fputs("\"/>", to);
}

static void draw_bars(const ibl_plot_point *p, const scale *x, const scale *y,
                      int style, FILE *to)
{
    const double at_x = place(x, p->x), at_y = place(y, p->y);
    const int colour = style % IBL_PLOT_COLOURS;

    if (p->x_high > p->x_low && p->x_low > 0)
        fprintf(to,
                "<path class=\"b\" style=\"stroke:var(--s%d)\" d=\"M%.1f "
                "%.1fH%.1f\"/>",
                colour, place(x, p->x_low), at_y, place(x, p->x_high));
    if (p->y_high > p->y_low && p->y_low > 0)
        fprintf(to,
                "<path class=\"b\" style=\"stroke:var(--s%d)\" d=\"M%.1f "
                "%.1fV%.1f\"/>",
                colour, at_x, place(y, p->y_low), place(y, p->y_high));
}

static void draw_line(const ibl_plot *plot, const ibl_plot_series *s,
                      const scale *x, const scale *y, FILE *to)
{
    char step = 'M';

    fprintf(to, "<path class=\"%c\" style=\"stroke:var(--s%d)\" d=\"",
            s->dashed ? 'd' : 'n', s->style % IBL_PLOT_COLOURS);
    for (int i = 0; i < s->count; i++) {
        const ibl_plot_point *p = &s->points[i];
        if (!is_drawn(plot, p))
            continue;
        fprintf(to, "%c%.1f %.1f", step, place(x, p->x), place(y, p->y));
        step = 'L';
    }
    fputs(step == 'M' ? "M0 0\"/>\n" : "\"/>\n", to);
}

static void draw_markers(const ibl_plot *plot, const ibl_plot_series *s,
                         const scale *x, const scale *y, FILE *to)
{
    for (int i = 0; i < s->count && !s->dashed; i++) {
        const ibl_plot_point *p = &s->points[i];
        char at[2][32];
        if (!is_drawn(plot, p))
            continue;
        ibl_plot_format(plot->x.unit, p->x, at[0], sizeof at[0]);
        ibl_plot_format(plot->y.unit, p->y, at[1], sizeof at[1]);
        fputs("<g><title>", to);
        ibl_plot_escape(s->name, to);
        fputs(*p->label ? " " : "", to);
        ibl_plot_escape(p->label, to);
        fprintf(to, ": %s, %s</title>", at[0], at[1]);
        draw_bars(p, x, y, s->style, to);
        draw_marker(s->style, place(x, p->x), place(y, p->y), to);
        if (p->ring)
            fprintf(to, "<circle class=\"r\" cx=\"%.1f\" cy=\"%.1f\" r=\"8\"/>",
                    place(x, p->x), place(y, p->y));
        fputs("</g>\n", to);
    }
}

/* ---- labels ---------------------------------------------------------- */

typedef struct box {
    double x0, y0, x1, y1;
} box;

typedef struct boxes {
    box at[MAX_LABELS];
    int count;
} boxes;

static double overlap(box a, box b)
{
    const double w = fmin(a.x1, b.x1) - fmax(a.x0, b.x0);
    const double h = fmin(a.y1, b.y1) - fmax(a.y0, b.y0);
    return w > 0 && h > 0 ? w * h : 0;
}

static void keep_out(boxes *taken, box b)
{
    if (taken->count < MAX_LABELS)
        taken->at[taken->count++] = b;
}

/* Writes a label where it covers least: eight places round its point. */
static void draw_label(boxes *taken, box frame, double x, double y,
                       const char *text, FILE *to)
{
    static const double around[8][2] = {{1, -1}, {-1, -1}, {1, 1}, {-1, 1},
                                        {0, -1}, {0, 1},   {1, 0}, {-1, 0}};
    const double width = letter * (double)strlen(text), height = 13;
    double least = INFINITY;
    box best = {0};

    for (int i = 0; i < 8; i++) {
        const double dx = around[i][0], dy = around[i][1];
        const double gap = dx != 0 && dy != 0 ? 7 : 11;
        const double x0 = x + dx * gap -
                          (dx < 0    ? width
                           : dx == 0 ? width / 2
                                     : 0);
        const double y0 = y + dy * gap - height / 2 - (dy < 0 ? 2 : 0);
        const box b = {x0, y0, x0 + width, y0 + height};
        double covered = width * height - overlap(b, frame) + 0.01 * i;
        for (int k = 0; k < taken->count; k++)
            covered += overlap(b, taken->at[k]);
        if (covered < least) {
            least = covered;
            best = b;
        }
    }
    keep_out(taken, best);
    fprintf(to, "<text class=\"h\" x=\"%.1f\" y=\"%.1f\">", best.x0,
            best.y1 - 2.5);
    ibl_plot_escape(text, to);
    fputs("</text>\n", to);
}

/* Points along the lines, so that labels keep off them, too. */
static void keep_off_line(boxes *taken, const ibl_plot *plot,
                          const ibl_plot_series *s, const scale *x,
                          const scale *y)
{
    for (int i = 0; i + 1 < s->count && s->line; i++) {
        const ibl_plot_point *p = &s->points[i], *q = p + 1;
        if (!is_drawn(plot, p) || !is_drawn(plot, q))
            continue;
        for (int k = 1; k < 6; k++) {
            const double t = k / 6.0;
            const double at_x = (1 - t) * place(x, p->x) + t * place(x, q->x);
            const double at_y = (1 - t) * place(y, p->y) + t * place(y, q->y);
            keep_out(taken, (box){at_x - 2, at_y - 2, at_x + 2, at_y + 2});
        }
    }
}

static void draw_labels(const ibl_plot *plot, const scale *x, const scale *y,
                        FILE *to)
{
    const box frame = {x->from, y->to, x->to, y->from};
    boxes taken = {.count = 0};

    for (int i = 0; i < plot->count; i++)
        for (int k = 0; k < plot->series[i].count; k++) {
            const ibl_plot_point *p = &plot->series[i].points[k];
            if (!is_drawn(plot, p) || plot->series[i].dashed)
                continue;
            const double at_x = place(x, p->x), at_y = place(y, p->y);
            keep_out(&taken, (box){at_x - 6, at_y - 6, at_x + 6, at_y + 6});
        }
    for (int i = 0; i < plot->count; i++)
        keep_off_line(&taken, plot, &plot->series[i], x, y);
    for (int i = 0; i < plot->count; i++)
        for (int k = 0; k < plot->series[i].count; k++) {
            const ibl_plot_point *p = &plot->series[i].points[k];
            if (*p->label && is_drawn(plot, p))
                draw_label(&taken, frame, place(x, p->x), place(y, p->y),
                           p->label, to);
        }
}

/* ---- the whole ------------------------------------------------------- */

/* Draws the legend from y on, or only measures it (to == NULL); returns its
 * height. */
static double legend(const ibl_plot *plot, double y, FILE *to)
{
    double x = LEFT, height = LINE;

    for (int i = 0; i <= plot->count; i++) {
        const ibl_plot_series *s = i < plot->count ? &plot->series[i] : NULL;
        const char *name = s ? s->name : plot->ring;
        if (!name)
            continue;
        const double width = 26 + letter * (double)strlen(name) + 14;
        if (x > LEFT && x + width > WIDTH - RIGHT + 14) {
            x = LEFT;
            y += LINE;
            height += LINE;
        }
        if (to) {
            if (!s)
                fprintf(to,
                        "<circle class=\"r\" cx=\"%.1f\" cy=\"%.1f\" "
                        "r=\"7\"/>",
                        x + 10, y + 9);
            if (s && (s->line || s->dashed))
                fprintf(to,
                        "<path class=\"%c\" style=\"stroke:var(--s%d)\" "
                        "d=\"M%.1f %.1fh20\"/>",
                        s->dashed ? 'd' : 'n', s->style % IBL_PLOT_COLOURS, x,
                        y + 9);
            if (s && !s->dashed)
                draw_marker(s->style, x + 10, y + 9, to);
            fprintf(to, "<text class=\"l\" x=\"%.1f\" y=\"%.1f\">", x + 26,
                    y + 13);
            ibl_plot_escape(name, to);
            fputs("</text>\n", to);
        }
        x += width;
    }
    return height;
}

static void begin(const ibl_plot *plot, double height, bool standalone,
                  FILE *to)
{
    /* In a page of HTML the namespace is known. */
    fprintf(to,
            "<svg%s viewBox=\"0 0 %d %.0f\" width=\"%d\" height=\"%.0f\" "
            "role=\"img\">\n",
            standalone ? " xmlns=\"http://www.w3.org/2000/svg\"" : "", WIDTH,
            height, WIDTH, height);
    if (plot->title) {
        fputs("<title>", to);
        ibl_plot_escape(plot->title, to);
        fputs("</title>\n", to);
    }
    if (standalone)
        fprintf(to,
                "<style>\n%s</style>\n<rect width=\"100%%\" height=\"100%%\" "
                "style=\"fill:var(--bg)\"/>\n",
                ibl_plot_css);
}

void ibl_plot_write(const ibl_plot *plot, bool standalone, FILE *to)
{
    const double title = plot->title && standalone ? LINE + 4 : 0;
    const double keys = legend(plot, 0, NULL) + 6;
    const double top = TOP + title + keys;
    scale x = make_scale(plot, true, LEFT, WIDTH - RIGHT);
    scale y = make_scale(plot, false, top + HEIGHT - BOTTOM, top);

    begin(plot, top + HEIGHT, standalone, to);
    if (title > 0) {
        fprintf(to, "<text class=\"t\" x=\"%d\" y=\"%d\">", LEFT, TOP + 12);
        ibl_plot_escape(plot->title, to);
        fputs("</text>\n", to);
    }
    legend(plot, TOP + title - 6, to);
    draw_axes(&x, &y, to);
    for (int i = 0; i < plot->count; i++)
        if (plot->series[i].line || plot->series[i].dashed)
            draw_line(plot, &plot->series[i], &x, &y, to);
    for (int i = 0; i < plot->count; i++)
        draw_markers(plot, &plot->series[i], &x, &y, to);
    draw_labels(plot, &x, &y, to);
    fputs("</svg>\n", to);
}
