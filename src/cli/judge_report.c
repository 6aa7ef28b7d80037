/* SPDX-License-Identifier: MIT */
/* Verdicts as a table. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/judge.h"
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
            snprintf(why, size, "level %.0f of %s has an %s of %.3g, above %g",
                     number(row, "level"), text_of(row, "content"),
                     is_lut(row) ? "error" : "nRMSE", number(row, figure),
                     max_error);
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
