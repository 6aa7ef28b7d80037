/* SPDX-License-Identifier: MIT */
/* Verdicts as a table. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/judge.h"
#include "common/signals.h"
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

/* Those of a row; NULL: their names. */
static void append_figures(char **text, const json_t *row)
{
    for (int f = 0; f < IBL_FIGURES; f++) {
        const char *name = ibl_figure_names[f];
        if (row)
            ibl_append(text, "  %8.2e+-%5.0e", number(row, name),
                       error_of(row, name));
        else
            ibl_append(text, "  %15s", f ? name : "nRMSE");
    }
}

static void append_roughness(char **text, const json_t *row, const char *none)
{
    if (json_object_get(row, "roughness"))
        ibl_append(text, " %6.4f", number(row, "roughness"));
    else
        ibl_append(text, " %6s", none);
}

static void append_texels(char **text, json_t *row)
{
    double at[3] = {0};

    json_unpack(row, "{s:[F,F,F]}", "worst_at", &at[0], &at[1], &at[2]);
    ibl_append(text, "%-10s %2.0f", text_of(row, "content"),
               number(row, "level"));
    append_roughness(text, row, "-");
    ibl_append(text, " %5.0f %7.0f", number(row, "size"),
               number(row, "texels"));
    append_figures(text, row);
    ibl_append(text, "  %8.2e", number(row, "worst"));
    if (is_lut(row))
        ibl_append(text, "  N.V %5.3f r %5.3f  ", at[0], at[1]);
    else
        ibl_append(text, "  (%+.2f %+.2f %+.2f)", at[0], at[1], at[2]);
    ibl_append(text, " %5.0f\n", number(row, "nonfinite"));
    if (json_object_get(row, "coefficients"))
        ibl_append(text,
                   "  of degree %.0f; without the degrees above, coefficients "
                   "are off by %.2e\n",
                   number(row, "level"), number(row, "coefficients"));
}

static void append_drawn(char **text, const json_t *row)
{
    ibl_append(text, "%-5g", number(row, "f0"));
    append_roughness(text, row, "mean");
    append_figures(text, row);
    ibl_append(text, "\n");
}

char *ibl_report_text(const ibl_report *report)
{
    json_t *rows = texel_rows(report), *row;
    const json_t *drawn = json_object_get(report->json, "rendered");
    const json_t *means = json_object_get(drawn, "means");
    char *text = ibl_need(strdup(""));
    size_t i;

    if (json_array_size(rows)) {
        ibl_append(&text, "%-13s %6s %5s %7s", "level", "r", "size", "texels");
        append_figures(&text, NULL);
        ibl_append(&text, "  %8s  %-19s %5s\n", "worst", "towards", "NaN");
    }
    json_array_foreach(rows, i, row)
    {
        append_texels(&text, row);
    }
    json_decref(rows);
    if (drawn) {
        ibl_append(&text, "as rendered by %s: %.0f directions\n%-5s %6s",
                   text_of(drawn, "shader"), number(drawn, "directions"), "F0",
                   "r");
        append_figures(&text, NULL);
        ibl_append(&text, "\n");
    }
    json_array_foreach(json_object_get(drawn, "rows"), i, row)
    {
        const size_t each = json_array_size(json_object_get(drawn, "rows")) /
                            json_array_size(means);
        append_drawn(&text, row);
        if (i % each == each - 1)
            append_drawn(&text, json_array_get(means, i / each));
    }
    return text;
}
