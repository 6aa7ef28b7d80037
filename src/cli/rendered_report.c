/* SPDX-License-Identifier: MIT */
/* Errors of what is rendered, as a table, as JSON and as a picture. */
#include <math.h>
#include <string.h>

#include "cli/rendered.h"
#include "cli/sheet.h"
#include "engine/png.h"
#include "json/json_text.h"

bool ibl_rendered_passes(const ibl_rendered *rendered, double most, char *why,
                         size_t size)
{
    *why = '\0';
    for (int f = 0; f < rendered->options.f0_count; f++) {
        const ibl_rendered_row *mean = ibl_rendered_mean(rendered, f);
        if (!*why && mean->nrmse > most)
            snprintf(why, size,
                     "rendered with F0 = %g, the files have an nRMSE of %.3g, "
                     "above %g",
                     mean->f0, mean->nrmse, most);
    }
    return !*why;
}

/* ---- table ----------------------------------------------------------- */

static void print_row(const ibl_rendered_row *row, FILE *to)
{
    fprintf(to, "%-5g ", row->f0);
    if (isnan(row->roughness))
        fprintf(to, "%6s", "mean");
    else
        fprintf(to, "%6.4f", row->roughness);
    fprintf(to, "  %8.2e %8.2e %8.2e %7.4f ", row->nrmse, row->median, row->p95,
            row->ratio);
    for (int p = 0; p < IBL_PARTS; p++)
        fprintf(to, " %8.2e", row->part[p]);
    fputc('\n', to);
}

void ibl_rendered_print(const ibl_rendered *rendered, FILE *to)
{
    fprintf(to, "as rendered by %s: %d directions\n%-5s %6s  %8s %8s %8s %7s ",
            ibl_shader_names[rendered->options.shader],
            rendered->options.directions, "F0", "r", "nRMSE", "median", "p95",
            "ratio");
    for (int p = 0; p < IBL_PARTS; p++)
        fprintf(to, " %8s", ibl_part_names[p]);
    fputc('\n', to);
    for (int i = 0; i < rendered->count; i++)
        print_row(&rendered->rows[i], to);
    fflush(to);
}

/* ---- JSON ------------------------------------------------------------ */

static json_t *row_json(const ibl_rendered_row *row)
{
    json_t *j = json_object(), *parts = json_object();

    put(&j, "f0", json_real(row->f0));
    if (!isnan(row->roughness))
        put(&j, "roughness", json_real(row->roughness));
    put(&j, "nrmse", json_real(ibl_json_digits(row->nrmse)));
    put(&j, "median", json_real(ibl_json_digits(row->median)));
    put(&j, "p95", json_real(ibl_json_digits(row->p95)));
    put(&j, "mean_ratio", json_real(ibl_json_digits(row->ratio)));
    for (int p = 0; p < IBL_PARTS; p++)
        put(&parts, ibl_part_names[p],
            json_real(ibl_json_digits(row->part[p])));
    put(&j, "parts", parts);
    return j;
}

json_t *ibl_rendered_json(const ibl_rendered *rendered)
{
    const ibl_rendered_options *o = &rendered->options;
    json_t *j = json_object(), *rows = json_array(), *means = json_array();

    put(&j, "shader", json_string(ibl_shader_names[o->shader]));
    put(&j, "directions", json_integer(o->directions));
    put(&j, "seed", json_integer(o->seed));
    for (int i = 0; i < rendered->count; i++)
        append(isnan(rendered->rows[i].roughness) ? &means : &rows,
               row_json(&rendered->rows[i]));
    put(&j, "rows", rows);
    put(&j, "means", means);
    return j;
}

/* ---- picture ---------------------------------------------------------- */

enum {
    LINES = IBL_PARTS + 1, /* the whole error, and its parts */
    DECADES = 5,           /* from 1e-4 to 10 */
    MARGIN = 5 * IBL_SHEET_GLYPH,
    WIDTH = IBL_PANEL_WIDTH - MARGIN,
    HEIGHT = IBL_PANEL_HEIGHT - 3 * IBL_SHEET_LINE
};

static const unsigned char colours[LINES][3] = {{240, 240, 240},
                                                {235, 110, 80},
                                                {240, 190, 70},
                                                {90, 190, 120},
                                                {90, 150, 240}};

/* A plot's upper left corner. */
typedef struct plot {
    const ibl_sheet *sheet;
    int left, top;
} plot;

static int place_y(double error)
{
    const double decades = error > 0 ? log10(error) + 4 : 0;

    return (int)((HEIGHT - 1) * (1 - fmin(fmax(decades / DECADES, 0), 1)) +
                 0.5);
}

static void draw_dot(const plot *p, int x, int y, const unsigned char rgb[3])
{
    memcpy(ibl_sheet_pixel(p->sheet, p->left + x, p->top + y), rgb, 3);
}

/* A column of a line, from y to the y of the next column. */
static void draw_column(const plot *p, int x, int from, int to,
                        const unsigned char rgb[3])
{
    for (int y = from < to ? from : to; y <= (from < to ? to : from); y++) {
        draw_dot(p, x, y, rgb);
        draw_dot(p, x, y + 1 < HEIGHT ? y + 1 : y, rgb);
    }
}

static void draw_piece(const plot *p, double r0, double e0, double r1,
                       double e1, const unsigned char rgb[3])
{
    const int x0 = (int)(r0 * (WIDTH - 1)), x1 = (int)(r1 * (WIDTH - 1));
    const int y0 = place_y(e0), y1 = place_y(e1);

    for (int x = x0; x < x1; x++)
        draw_column(p, x, y0 + (y1 - y0) * (x - x0) / (x1 - x0),
                    y0 + (y1 - y0) * (x + 1 - x0) / (x1 - x0), rgb);
    draw_column(p, x1, y1, y1, rgb);
}

/* Errors are on the left, from 1e-4 to 10, roughness below. */
static void draw_axes(const plot *p)
{
    static const unsigned char grey[3] = {70, 70, 70};
    static const char *const errors[DECADES + 1] = {"1E-4", "1E-3", "0.01",
                                                    "0.1",  "1",    "10"};
    const int letter = 5 * IBL_SHEET_DOT, below = p->top + HEIGHT + letter / 2;

    for (int d = 0; d <= DECADES; d++) {
        const int y = place_y(pow(10, d - 4));
        for (int x = 0; x < WIDTH; x++)
            draw_dot(p, x, y, grey);
        ibl_sheet_write(p->sheet, p->left - MARGIN,
                        p->top + y - (y > letter ? letter : 0), errors[d]);
    }
    ibl_sheet_write(p->sheet, p->left, below, "R = 0");
    ibl_sheet_write(p->sheet, p->left + WIDTH / 2 - IBL_SHEET_GLYPH, below,
                    "0.5");
    ibl_sheet_write(p->sheet, p->left + WIDTH - IBL_SHEET_GLYPH, below, "1");
}

static void draw_legend(const plot *p, double f0)
{
    char text[32];
    int left = 0;

    snprintf(text, sizeof text, "F0 = %g", f0);
    ibl_sheet_write(p->sheet, p->left, p->top + HEIGHT + IBL_SHEET_LINE, text);
    for (int line = 0; line < LINES; line++) {
        const char *name = line ? ibl_part_names[line - 1] : "all";
        const int y = HEIGHT + 2 * IBL_SHEET_LINE;
        for (int k = 0; k < 100; k++)
            draw_dot(p, left + k % 10, y + k / 10, colours[line]);
        ibl_sheet_write(p->sheet, p->left + left + 2 * IBL_SHEET_GLYPH,
                        p->top + y, name);
        left += (4 + (int)strlen(name)) * IBL_SHEET_GLYPH;
    }
}

static double error_of(const ibl_rendered_row *row, int line)
{
    return line ? row->part[line - 1] : row->nrmse;
}

static void draw_plot(const plot *p, const ibl_rendered_row *rows, int count)
{
    draw_axes(p);
    draw_legend(p, rows->f0);
    for (int line = LINES - 1; line >= 0; line--)
        for (int k = 0; k < count; k++) {
            const ibl_rendered_row *a = &rows[k > 0 ? k - 1 : 0], *b = &rows[k];
            draw_piece(p, a->roughness, error_of(a, line), b->roughness,
                       error_of(b, line), colours[line]);
        }
}

bool ibl_rendered_png(const ibl_rendered *rendered, void **png, size_t *size)
{
    const ibl_rendered_options *o = &rendered->options;
    ibl_sheet s = {0};
    bool ok = ibl_sheet_create(&s, o->f0_count, 0);

    for (int f = 0; f < o->f0_count && ok; f++) {
        plot p = {.sheet = &s};
        ibl_sheet_place(&s, f, &p.left, &p.top);
        p.left += MARGIN;
        draw_plot(&p, rendered->rows + f * (o->roughness_count + 1),
                  o->roughness_count);
    }
    ok = ok && ibl_png_encode_rgb(s.pixels, s.width, s.height, png, size);
    ibl_sheet_free(&s);
    return ok;
}
