/* SPDX-License-Identifier: MIT */
#include "cli/judge_report.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/json_put.h"

ibl_status ibl_report_add(ibl_report *report, ibl_judge *judge,
                          ibl_output_kind kind, int number,
                          const ibl_judge_level *level)
{
    assert(report->count < IBL_REPORT_ROWS);
    ibl_report_row *row = &report->rows[report->count];
    const ibl_status status = ibl_judge_cube_level(judge, level, &row->verdict);

    if (!status) {
        row->content = ibl_output_content(kind);
        row->level = number;
        report->count++;
    }
    return status;
}

void ibl_report_free(ibl_report *report)
{
    for (int i = 0; i < report->count; i++)
        ibl_verdict_free(&report->rows[i].verdict);
    report->count = 0;
}

bool ibl_report_passes(const ibl_report *report, double max_error, char *why,
                       size_t size)
{
    for (int i = 0; i < report->count; i++) {
        const ibl_report_row *row = &report->rows[i];
        const ibl_verdict *v = &row->verdict;
        if (v->nonfinite) {
            snprintf(why, size, "level %d of %s has %zu texels of NaN or Inf",
                     row->level, row->content, v->nonfinite);
            return false;
        }
        if (!(v->nrmse <= max_error)) {
            snprintf(why, size,
                     "level %d of %s has an nRMSE of %.3g, above %g%s",
                     row->level, row->content, v->nrmse, max_error,
                     v->overflow_share > 0.5
                         ? ": most of it is light that its pixel cannot hold: "
                           "use --pixel rgba32f"
                         : "");
            return false;
        }
    }
    if (report->has_lut && report->lut.nonfinite) {
        snprintf(why, size, "the BRDF table has %zu texels of NaN or Inf",
                 report->lut.nonfinite);
        return false;
    }
    if (report->has_lut && !(report->lut.max <= max_error)) {
        snprintf(why, size,
                 "the BRDF table is off by %.3g at N.V = %.3g, r = %.3g, more "
                 "than %g",
                 report->lut.max, report->lut.worst_n_dot_v,
                 report->lut.worst_roughness, max_error);
        return false;
    }
    return true;
}

/* ---- table ----------------------------------------------------------- */

static void print_row(const ibl_report_row *row, FILE *to)
{
    const ibl_verdict *v = &row->verdict;

    fprintf(to, "%-10s %2d", row->content, row->level);
    if (v->role == IBL_ROLE_SPECULAR)
        fprintf(to, " %6.4f", v->roughness);
    else
        fprintf(to, " %6s", "-");
    fprintf(to,
            " %5d %7zu  %8.2e %8.2e %8.2e %8.2e  (%+.2f %+.2f %+.2f)"
            "  %+9.1e %5zu %5.1f %%\n",
            v->size, v->count, v->nrmse, v->median, v->p95, v->worst,
            v->worst_dir[0], v->worst_dir[1], v->worst_dir[2], v->bias,
            v->nonfinite, 100 * v->rounding_share);
}

static void print_dark(const ibl_report *report, FILE *to)
{
    fprintf(to, "%-26s %7s  %8s %8s %8s %8s\n", "darkest tenth", "texels", "",
            "median", "p95", "worst");
    for (int i = 0; i < report->count; i++) {
        const ibl_report_row *row = &report->rows[i];
        const ibl_dark_verdict *dark = &row->verdict.dark;
        fprintf(to, "%-10s %2d %13s %7zu  %8s %8.2e %8.2e %8.2e\n",
                row->content, row->level, "", dark->count, "", dark->median,
                dark->p95, dark->worst);
    }
}

/* With and without what the pixel format cannot hold. */
static void print_overflow(const ibl_report *report, FILE *to)
{
    for (int i = 0; i < report->count; i++) {
        const ibl_report_row *row = &report->rows[i];
        const ibl_verdict *v = &row->verdict;
        if (v->overflow > 0)
            fprintf(to,
                    "%-10s %2d light above %.9g, the most that %s holds, makes "
                    "%.1f %% of the squared error: without it nRMSE is %.2e\n",
                    row->content, row->level, (double)ibl_pixel_max(v->pixel),
                    ibl_pixel_name(v->pixel), 100 * v->overflow_share,
                    v->nrmse * sqrt(fmax(0, 1 - v->overflow_share)));
    }
}

void ibl_report_print(const ibl_report *report, FILE *to)
{
    const ibl_lut_verdict *lut = &report->lut;

    if (report->count)
        fprintf(to, "%-13s %6s %5s %7s  %8s %8s %8s %8s  %-19s  %9s %5s %7s\n",
                "level", "r", "size", "texels", "nRMSE", "median", "p95",
                "worst", "towards", "bias", "NaN", "rounded");
    for (int i = 0; i < report->count; i++)
        print_row(&report->rows[i], to);
    if (report->count)
        print_dark(report, to);
    print_overflow(report, to);
    if (report->has_lut)
        fprintf(to,
                "BRDF table   size %d, %zu texels: largest error %.2e at N.V "
                "= %.3f, r = %.3f; rms %.2e (rounding alone %.2e); NaN %zu\n",
                lut->size, lut->count, lut->max, lut->worst_n_dot_v,
                lut->worst_roughness, lut->rms, lut->rounding, lut->nonfinite);
    /* What is then said on standard error comes after it in a log, too. */
    fflush(to);
}

/* ---- JSON ------------------------------------------------------------ */

/* Four digits: what is measured at chosen texels has no more. */
static json_t *real(double x)
{
    char text[32];
    snprintf(text, sizeof text, "%.3e", x);
    return json_real(strtod(text, NULL));
}

static json_t *row_json(const ibl_report_row *row)
{
    const ibl_verdict *v = &row->verdict;
    json_t *j = json_object();

    put(&j, "content", json_string(row->content));
    put(&j, "level", json_integer(row->level));
    put(&j, "size", json_integer(v->size));
    if (v->role == IBL_ROLE_SPECULAR) {
        put(&j, "lobe", json_string(ibl_lobe_name(v->lobe)));
        put(&j, "roughness", json_real(v->roughness));
    }
    put(&j, "texels", json_integer((json_int_t)v->count));
    put(&j, "nrmse", real(v->nrmse));
    put(&j, "median", real(v->median));
    put(&j, "p95", real(v->p95));
    put(&j, "worst", real(v->worst));
    put(&j, "worst_direction",
        json_pack("[ooo]", real(v->worst_dir[0]), real(v->worst_dir[1]),
                  real(v->worst_dir[2])));
    put(&j, "darkest_tenth",
        json_pack("{s:I,s:o,s:o,s:o}", "texels", (json_int_t)v->dark.count,
                  "median", real(v->dark.median), "p95", real(v->dark.p95),
                  "worst", real(v->dark.worst)));
    put(&j, "bias", real(v->bias));
    put(&j, "nonfinite", json_integer((json_int_t)v->nonfinite));
    put(&j, "rounding_nrmse", real(v->rounding));
    put(&j, "rounding_share", real(v->rounding_share));
    put(&j, "overflow_nrmse", real(v->overflow));
    put(&j, "overflow_share", real(v->overflow_share));
    return j;
}

static json_t *lut_json(const ibl_lut_verdict *v)
{
    json_t *j = json_object();

    put(&j, "size", json_integer(v->size));
    put(&j, "texels", json_integer((json_int_t)v->count));
    put(&j, "max", real(v->max));
    put(&j, "worst_n_dot_v", real(v->worst_n_dot_v));
    put(&j, "worst_roughness", real(v->worst_roughness));
    put(&j, "rms", real(v->rms));
    put(&j, "rounding_rms", real(v->rounding));
    put(&j, "nonfinite", json_integer((json_int_t)v->nonfinite));
    return j;
}

json_t *ibl_report_json(const ibl_report *report)
{
    json_t *j = json_object(), *levels = json_array();

    if (report->options.all)
        put(&j, "texels", json_string("all"));
    else
        put(&j, "texels", json_integer(report->options.texels));
    put(&j, "seed", json_integer(report->options.seed));
    for (int i = 0; i < report->count; i++)
        append(&levels, row_json(&report->rows[i]));
    put(&j, "levels", levels);
    if (report->has_lut)
        put(&j, "lut", lut_json(&report->lut));
    return j;
}
