/* SPDX-License-Identifier: MIT */
/* Verdicts as a table, as JSON and as a picture. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/judge.h"
#include "cli/sheet.h"
#include "engine/png.h"
#include "json/json_text.h"

const char *const ibl_shader_names[] = {"auto",       "split",     "bent",
                                        "fit",        "table",     "two-taps",
                                        "three-taps", "four-taps", NULL};

static const char *content(const ibl_verdict *v)
{
    return v->level.content == IBL_OUTPUT_JSON
               ? "harmonics"
               : ibl_output_content(v->level.content);
}

/* Figures of verdicts on texels; the others are parts of what is rendered. */
enum {
    SIMPLE = IBL_FIGURE_VIEW
};

bool ibl_report_passes(const ibl_report *report, double max_error,
                       double max_rendered, char *why, size_t size)
{
    *why = '\0';
    for (const ibl_verdict *v = report->rows;
         v < report->rows + report->count && !*why && !isnan(max_error); v++) {
        const bool lut = v->level.content == IBL_OUTPUT_LUT;
        const double error = lut ? v->worst
                             : v->level.content == IBL_OUTPUT_JSON
                                 ? v->coefficients
                                 : v->measured.value[IBL_FIGURE_NRMSE];
        if (v->nonfinite)
            snprintf(why, size, "%s %d has %zu texels of NaN or Inf",
                     content(v), v->level.number, v->nonfinite);
        else if (lut && !(error <= max_error))
            snprintf(why, size,
                     "the BRDF table is off by %.3g at N.V = %.3g, r = %.3g, "
                     "more than %g",
                     error, v->worst_at[0], v->worst_at[1], max_error);
        else if (!(error <= max_error))
            snprintf(why, size,
                     "level %d of %s has an nRMSE of %.3g, above %g%s",
                     v->level.number, content(v), error, max_error,
                     v->over ? ": it has more light than its pixel can hold: "
                               "use --pixel rgba32f"
                             : "");
    }
    for (const ibl_drawn_row *row = report->drawn;
         row < report->drawn + report->drawn_count && !*why; row++)
        if (isnan(row->roughness) &&
            row->measured.value[IBL_FIGURE_NRMSE] > max_rendered)
            snprintf(why, size,
                     "rendered with F0 = %g, the files have an nRMSE of %.3g "
                     "+- %.1g, above %g",
                     row->f0, row->measured.value[IBL_FIGURE_NRMSE],
                     row->measured.error[IBL_FIGURE_NRMSE], max_rendered);
    return !*why;
}

/* ---- table ----------------------------------------------------------- */

static void print_names(int count, FILE *to)
{
    for (int f = 0; f < count; f++)
        fprintf(to, "  %15s", f ? ibl_figure_names[f] : "nRMSE");
}

static void print_figures(const ibl_measured *m, int count, FILE *to)
{
    for (int f = 0; f < count; f++)
        fprintf(to, "  %8.2e+-%5.0e", m->value[f], m->error[f]);
}

static void print_verdict(const ibl_verdict *v, FILE *to)
{
    const bool lut = v->level.content == IBL_OUTPUT_LUT;

    fprintf(to, "%-10s", content(v));
    if (v->level.content == IBL_OUTPUT_SPECULAR)
        fprintf(to, " %2d %6.4f", v->level.number, v->level.roughness);
    else
        fprintf(to, " %2d %6s", v->level.number, "-");
    fprintf(to, " %5d %7zu", v->level.texels.size, v->count);
    print_figures(&v->measured, SIMPLE, to);
    fprintf(to, "  %8.2e", v->worst);
    if (lut)
        fprintf(to, "  N.V %5.3f r %5.3f  ", v->worst_at[0], v->worst_at[1]);
    else
        fprintf(to, "  (%+.2f %+.2f %+.2f)", v->worst_at[0], v->worst_at[1],
                v->worst_at[2]);
    fprintf(to, " %5zu\n", v->nonfinite);
}

void ibl_report_print(const ibl_report *report, FILE *to)
{
    if (report->count) {
        fprintf(to, "%-13s %6s %5s %7s", "level", "r", "size", "texels");
        print_names(SIMPLE, to);
        fprintf(to, "  %8s  %-19s %5s\n", "worst", "towards", "NaN");
    }
    for (const ibl_verdict *v = report->rows; v < report->rows + report->count;
         v++) {
        print_verdict(v, to);
        if (v->level.content == IBL_OUTPUT_JSON)
            fprintf(to,
                    "  of degree %d; without the degrees above, coefficients "
                    "are off by %.2e\n",
                    v->level.number, v->coefficients);
        if (v->over)
            fprintf(to, "  has light above %.9g, the most that %s holds\n",
                    (double)ibl_pixel_max(v->level.pixel),
                    ibl_pixel_name(v->level.pixel));
    }
    if (report->drawn_count) {
        fprintf(to, "as rendered by %s: %d directions\n%-5s %6s",
                ibl_shader_names[report->shader], report->directions, "F0",
                "r");
        print_names(IBL_FIGURES, to);
        fputc('\n', to);
    }
    for (const ibl_drawn_row *row = report->drawn;
         row < report->drawn + report->drawn_count; row++) {
        if (isnan(row->roughness))
            fprintf(to, "%-5g %6s", row->f0, "mean");
        else
            fprintf(to, "%-5g %6.4f", row->f0, row->roughness);
        print_figures(&row->measured, IBL_FIGURES, to);
        fputs(ibl_measured_is_vague(&row->measured) ? " *\n" : "\n", to);
    }
    if (report->vague)
        fputs("* the standard error of nRMSE is above a tenth of it\n", to);
    /* Keeps the table before later messages on standard error in a log. */
    fflush(to);
}

/* ---- JSON ------------------------------------------------------------ */

/* Adds figures, and their standard errors as an object. */
static void put_figures(json_t **j, const ibl_measured *m, int count)
{
    json_t *errors = json_object();

    for (int f = 0; f < count; f++) {
        put(j, ibl_figure_names[f], json_real(ibl_json_digits(m->value[f])));
        put(&errors, ibl_figure_names[f],
            json_real(ibl_json_digits(m->error[f])));
    }
    put(j, "standard_error", errors);
}

static json_t *verdict_json(const ibl_verdict *v)
{
    json_t *j = json_pack(
        "{ss si si sI sI sf s[fff]}", "content", content(v), "level",
        v->level.number, "size", v->level.texels.size, "texels",
        (json_int_t)v->count, "nonfinite", (json_int_t)v->nonfinite, "worst",
        ibl_json_digits(v->worst), "worst_at", ibl_json_digits(v->worst_at[0]),
        ibl_json_digits(v->worst_at[1]), ibl_json_digits(v->worst_at[2]));

    put_figures(&j, &v->measured, SIMPLE);
    if (v->level.content == IBL_OUTPUT_SPECULAR) {
        put(&j, "lobe", json_string(ibl_lobe_name(v->level.lobe)));
        put(&j, "roughness", json_real(v->level.roughness));
    }
    if (v->level.content == IBL_OUTPUT_JSON)
        put(&j, "coefficients", json_real(ibl_json_digits(v->coefficients)));
    return j;
}

json_t *ibl_report_json(const ibl_report *report)
{
    const ibl_judge_options *o = &report->options;
    json_t *j = json_object(), *levels = json_array(), *rows = json_array();
    json_t *means = json_array();

    put(&j, "seed", json_integer(o->seed));
    if (report->count)
        put(&j, "texels",
            o->all ? json_string("all") : json_integer(o->texels));
    for (const ibl_verdict *v = report->rows; v < report->rows + report->count;
         v++) {
        if (v->level.content < IBL_OUTPUT_LUT)
            append(&levels, verdict_json(v));
        else
            put(&j, v->level.content == IBL_OUTPUT_LUT ? "lut" : "harmonics",
                verdict_json(v));
    }
    put(&j, "levels", levels);
    for (const ibl_drawn_row *row = report->drawn;
         row < report->drawn + report->drawn_count; row++) {
        json_t *r = json_object();
        put(&r, "f0", json_real(row->f0));
        if (!isnan(row->roughness))
            put(&r, "roughness", json_real(row->roughness));
        put_figures(&r, &row->measured, IBL_FIGURES);
        append(isnan(row->roughness) ? &means : &rows, r);
    }
    put(&j, "rendered",
        json_pack("{ss si si so so}", "shader",
                  ibl_shader_names[report->shader], "directions",
                  report->directions, "vague", report->vague, "rows", rows,
                  "means", means));
    if (!report->drawn_count)
        json_object_del(j, "rendered");
    return j;
}

/* ---- picture ---------------------------------------------------------- */

enum {
    FACE = IBL_SHEET_FACE,
    CELL = 6, /* pixels */
    CELLS = FACE / CELL,
    BAR = 14, /* height of the scale in pixels */
    FOOTER = BAR + 6 * IBL_SHEET_DOT + IBL_SHEET_GAP,
    DECADES = 4 /* decades of error on the scale; its upper end is 1 */
};

/* The colour of a relative error on the scale, from 1e-4 to 1: the map
 * "inferno" of matplotlib (van der Walt and Smith 2015), with evenly growing
 * lightness; polynomial fit of Zucker 2019. */
static void inferno(double error, unsigned char rgb[3])
{
    static const double c[7][3] = {
        {0.0002189403691192265, 0.001651004631001012, -0.01948089843709184},
        {0.1065134194856116, 0.5639564367884091, 3.932712388889277},
        {11.60249308247187, -3.972853965665698, -15.9423941062914},
        {-41.70399613139459, 17.43639888205313, 44.35414519872813},
        {77.162935699427, -33.40235894210092, -81.80730925738993},
        {-71.31942824499214, 32.62606426397723, 73.20951985803202},
        {25.13112622477341, -12.24266895238567, -23.07032500287172}};
    const double t =
        error > 0 ? fmin(fmax(1 + log10(error) / DECADES, 0), 1) : 0;

    for (int k = 0; k < 3; k++) {
        double x = 0;
        for (int i = 6; i >= 0; i--)
            x = x * t + c[i][k];
        rgb[k] = (unsigned char)(255 * fmin(fmax(x, 0), 1) + 0.5);
    }
}

static void draw_level(const ibl_sheet *s, int panel, const ibl_verdict *v)
{
    double cells[IBL_FACES][CELLS][CELLS] = {{{0}}};
    char text[64];
    int left, top;

    ibl_sheet_place(s, panel, &left, &top);
    for (const ibl_judged *t = v->texels; t < v->texels + v->texel_count; t++) {
        const ibl_texel at = ibl_face_texel(CELLS, t->direction);
        double *cell = &cells[at.face][at.y][at.x];
        *cell = fmax(*cell, t->error);
    }
    for (int i = 0; i < IBL_FACES * FACE * FACE; i++) {
        const int face = i / FACE / FACE, y = i / FACE % FACE, x = i % FACE;
        inferno(cells[face][y / CELL][x / CELL],
                ibl_sheet_pixel(s, left + FACE * ibl_cross_place[face][0] + x,
                                top + FACE * ibl_cross_place[face][1] + y));
    }
    snprintf(text, sizeof text, "%s %d", content(v), v->level.number);
    left += 2 * FACE + IBL_SHEET_GLYPH;
    ibl_sheet_write(s, left, top, text);
    snprintf(text, sizeof text, "r = %.4g", v->level.roughness);
    if (v->level.content == IBL_OUTPUT_SPECULAR)
        ibl_sheet_write(s, left, top + IBL_SHEET_LINE, text);
}

static void draw_scale(const ibl_sheet *s)
{
    static const char *const labels[DECADES + 1] = {"1E-4", "1E-3", "1E-2",
                                                    "1E-1", "1"};
    const int left = IBL_SHEET_GAP, width = s->width - 2 * left;
    const int top = s->height - FOOTER;

    for (int i = 0; i < BAR * width; i++)
        inferno(pow(10, DECADES * ((double)(i % width) / (width - 1) - 1)),
                ibl_sheet_pixel(s, left + i % width, top + i / width));
    for (int i = 0; i <= DECADES; i++) {
        const int length =
            (int)strlen(labels[i]) * IBL_SHEET_GLYPH - IBL_SHEET_DOT;
        ibl_sheet_write(s, left + i * (width - length) / DECADES,
                        top + BAR + IBL_SHEET_DOT, labels[i]);
    }
}

bool ibl_heatmap_png(const ibl_report *report, void **png, size_t *size)
{
    ibl_sheet s = {0};
    int panels = 0;

    for (int i = 0; i < report->count; i++)
        panels += report->rows[i].level.content < IBL_OUTPUT_LUT;
    bool ok = ibl_sheet_create(&s, panels, FOOTER);
    for (int i = 0, panel = 0; i < report->count && ok; i++)
        if (report->rows[i].level.content < IBL_OUTPUT_LUT)
            draw_level(&s, panel++, &report->rows[i]);
    if (ok)
        draw_scale(&s);
    ok = ok && ibl_png_encode_rgb(s.pixels, s.width, s.height, png, size);
    ibl_sheet_free(&s);
    return ok;
}
