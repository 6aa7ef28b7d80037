/* SPDX-License-Identifier: MIT */
/* Verdicts as a table and as a picture. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/judge.h"
#include "cli/sheet.h"
#include "json/json_text.h"

const char *const ibl_shader_names[] = {"auto",       "split",     "bent",
                                        "fit",        "table",     "two-taps",
                                        "three-taps", "four-taps", NULL};

static double number(const json_t *object, const char *key)
{
    return json_number_value(json_object_get(object, key));
}

static double error_of(const json_t *row, const char *figure)
{
    return number(json_object_get(row, "standard_error"), figure);
}

/* The rows of levels, harmonics and a table. */
static json_t *texel_rows(const ibl_report *report)
{
    json_t *rows = json_copy(json_object_get(report->json, "levels"));

    json_array_append(rows, json_object_get(report->json, "harmonics"));
    json_array_append(rows, json_object_get(report->json, "lut"));
    return rows;
}

static bool is_lut(const json_t *row)
{
    return !strcmp(text_of(row, "content"), ibl_output_content(IBL_OUTPUT_LUT));
}

bool ibl_report_passes(const ibl_report *report, double max_error,
                       double max_rendered, char *why, size_t size)
{
    json_t *rows = texel_rows(report), *row;
    const json_t *drawn = json_object_get(report->json, "rendered");
    size_t i;

    *why = '\0';
    json_array_foreach(isnan(max_error) ? NULL : rows, i, row)
    {
        const char *figure = is_lut(row) ? "worst"
                             : json_object_get(row, "coefficients")
                                 ? "coefficients"
                                 : "nrmse";
        if (*why)
            continue;
        if (number(row, "nonfinite") > 0)
            snprintf(why, size, "%s %.0f has %.0f texels of NaN or Inf",
                     text_of(row, "content"), number(row, "level"),
                     number(row, "nonfinite"));
        else if (number(row, figure) > max_error)
            snprintf(
                why, size, "level %.0f of %s has an %s of %.3g, above %g%s",
                number(row, "level"), text_of(row, "content"),
                is_lut(row) ? "error" : "nRMSE", number(row, figure), max_error,
                json_object_get(row, "pixel")
                    ? ": it has more light than its pixel can hold: use "
                      "--pixel rgba32f"
                    : "");
    }
    json_array_foreach(json_object_get(drawn, "means"), i, row)
    {
        if (!*why && number(row, "nrmse") > max_rendered)
            snprintf(why, size,
                     "rendered with F0 = %g, the files have an nRMSE of %.3g "
                     "+- %.1g, above %g",
                     number(row, "f0"), number(row, "nrmse"),
                     error_of(row, "nrmse"), max_rendered);
    }
    json_decref(rows);
    return !*why;
}

/* ---- table ----------------------------------------------------------- */

static void print_names(FILE *to)
{
    for (int f = 0; f < IBL_FIGURES; f++)
        fprintf(to, "  %15s", f ? ibl_figure_names[f] : "nRMSE");
}

static void print_figures(const json_t *row, FILE *to)
{
    for (int f = 0; f < IBL_FIGURES; f++)
        fprintf(to, "  %8.2e+-%5.0e", number(row, ibl_figure_names[f]),
                error_of(row, ibl_figure_names[f]));
}

static void print_roughness(const json_t *row, const char *none, FILE *to)
{
    if (json_object_get(row, "roughness"))
        fprintf(to, " %6.4f", number(row, "roughness"));
    else
        fprintf(to, " %6s", none);
}

static void print_texels(const json_t *row, FILE *to)
{
    double at[3] = {0};

    fprintf(to, "%-10s %2.0f", text_of(row, "content"), number(row, "level"));
    print_roughness(row, "-", to);
    fprintf(to, " %5.0f %7.0f", number(row, "size"), number(row, "texels"));
    print_figures(row, to);
    for (size_t k = 0; k < 3; k++)
        at[k] = json_number_value(
            json_array_get(json_object_get(row, "worst_at"), k));
    fprintf(to, "  %8.2e", number(row, "worst"));
    if (is_lut(row))
        fprintf(to, "  N.V %5.3f r %5.3f  ", at[0], at[1]);
    else
        fprintf(to, "  (%+.2f %+.2f %+.2f)", at[0], at[1], at[2]);
    fprintf(to, " %5.0f\n", number(row, "nonfinite"));
    if (json_object_get(row, "coefficients"))
        fprintf(to,
                "  of degree %.0f; without the degrees above, coefficients "
                "are off by %.2e\n",
                number(row, "level"), number(row, "coefficients"));
    if (json_object_get(row, "pixel"))
        fprintf(to, "  has light above %.9g, the most that %s holds\n",
                number(row, "pixel_most"), text_of(row, "pixel"));
}

static void print_drawn(const json_t *row, FILE *to)
{
    fprintf(to, "%-5g", number(row, "f0"));
    print_roughness(row, "mean", to);
    print_figures(row, to);
    fputs(ibl_is_vague(number(row, "nrmse"), error_of(row, "nrmse")) ? " *\n"
                                                                     : "\n",
          to);
}

void ibl_report_print(const ibl_report *report, FILE *to)
{
    json_t *rows = texel_rows(report), *row;
    const json_t *drawn = json_object_get(report->json, "rendered");
    const json_t *means = json_object_get(drawn, "means");
    size_t i;

    if (json_array_size(rows)) {
        fprintf(to, "%-13s %6s %5s %7s", "level", "r", "size", "texels");
        print_names(to);
        fprintf(to, "  %8s  %-19s %5s\n", "worst", "towards", "NaN");
    }
    json_array_foreach(rows, i, row)
    {
        print_texels(row, to);
    }
    json_decref(rows);
    if (drawn) {
        fprintf(to, "as rendered by %s: %.0f directions\n%-5s %6s",
                text_of(drawn, "shader"), number(drawn, "directions"), "F0",
                "r");
        print_names(to);
        fputc('\n', to);
    }
    json_array_foreach(json_object_get(drawn, "rows"), i, row)
    {
        const size_t each = json_array_size(json_object_get(drawn, "rows")) /
                            json_array_size(means);
        print_drawn(row, to);
        if (i % each == each - 1)
            print_drawn(json_array_get(means, i / each), to);
    }
    if (number(drawn, "vague") > 0)
        fputs("* the standard error of nRMSE is above a tenth of it\n", to);
    /* Keeps the table before later messages on standard error in a log. */
    fflush(to);
}

/* ---- picture ---------------------------------------------------------- */

enum {
    BAR = 14,   /* height of the scale in pixels */
    DECADES = 4 /* decades of error on the scale; its upper end is 1 */
};

/* The colour of a relative error on the scale, from 1e-4 to 1: the map
 * "inferno" of matplotlib (van der Walt and Smith 2015), with evenly growing
 * lightness; polynomial fit of Zucker 2019. */
static double inferno(double error, int channel)
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
    double x = 0;

    for (int i = 6; i >= 0; i--)
        x = x * t + c[i][channel];
    return x;
}

static void draw_scale(const ibl_sheet *s)
{
    static const char *const labels[DECADES + 1] = {"1E-4", "1E-3", "1E-2",
                                                    "1E-1", "1"};
    const int left = IBL_SHEET_GAP, width = s->width - 2 * left;
    const int top = s->height - s->footer;

    for (int i = 0; i < BAR * width; i++) {
        const double error =
            pow(10, DECADES * ((double)(i % width) / (width - 1) - 1));
        ibl_sheet_put(s, left + i % width, top + i / width,
                      (double[]){error, error, error});
    }
    for (int i = 0; i <= DECADES; i++) {
        const int length =
            (int)strlen(labels[i]) * IBL_SHEET_GLYPH - IBL_SHEET_DOT;
        ibl_sheet_write(s, left + i * (width - length) / DECADES,
                        top + BAR + IBL_SHEET_DOT, labels[i]);
    }
}

bool ibl_heatmap_png(const ibl_report *report, void **png, size_t *size)
{
    const json_t *levels = json_object_get(report->json, "levels");
    ibl_sheet s = {.tone = inferno,
                   .cells = true,
                   .footer = BAR + 6 * IBL_SHEET_DOT + IBL_SHEET_GAP};
    ibl_panel panels[IBL_HEAT_LEVELS] = {{.cube = NULL}};
    json_t *row;
    size_t i;

    json_array_foreach(levels, i, row)
    {
        panels[i].cube = &report->heat[i];
        snprintf(panels[i].text[0], sizeof panels[i].text[0], "%s %.0f",
                 text_of(row, "content"), number(row, "level"));
        if (json_object_get(row, "roughness"))
            snprintf(panels[i].text[1], sizeof panels[i].text[1], "r = %.4g",
                     number(row, "roughness"));
    }
    bool ok = ibl_sheet_draw(&s, panels, (int)json_array_size(levels));
    if (ok)
        draw_scale(&s);
    return ibl_sheet_encode(&s, png, size) && ok;
}
