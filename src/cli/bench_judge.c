/* SPDX-License-Identifier: MIT */
/* Judges the output of the last round. */
#include <math.h>
#include <stdlib.h>

#include "cli/bench.h"
#include "cli/console.h"
#include "cli/shell_words.h"
#include "cli/verify.h"
#include "json/json_text.h"
#include "json/text.h"

/* The arguments after ENV for judging a point's output; NULL: not judged. */
static const char *output_of(const ibl_bench *b, const ibl_bench_point *p)
{
    const ibl_bench_names *outputs = &b->opts->outputs;

    if (p->kind != IBL_BENCH_PEER)
        return "{out} --name bake";
    const int i = ibl_bench_find_name(outputs, p->name);
    return i < 0 ? NULL : outputs->text[i];
}

static bool is_judged(const ibl_bench *b, const ibl_bench_point *p)
{
    return b->opts->texels && !b->sources[p->source].resampled &&
           output_of(b, p);
}

/* ENV and the other arguments of iblbake verify. The caller must free them;
 * NULL: no memory, or an open quote. */
static char **arguments(const ibl_bench *b, const ibl_bench_point *p)
{
    char *text = ibl_format("{env} %s%s", output_of(b, p),
                            b->opts->rendered ? " --rendered" : "");
    char *filled = text ? ibl_bench_fill(b, p, text) : NULL;
    char **words = filled ? ibl_words_split(filled) : NULL;

    free(filled);
    free(text);
    return words;
}

/* Settings of verify for a point; *words holds their strings. */
static bool settings_of(const ibl_bench *b, const ibl_bench_point *p,
                        ibl_verify_opts *opts, char ***words)
{
    *words = arguments(b, p);
    if (!*words)
        return ibl_console_fail(b->console,
                                "%s: its output's arguments have an open "
                                "quote, or no memory: close it",
                                p->name);
    if (!ibl_command_line(&ibl_verify_command, *words, opts, NULL))
        return false;
    opts->common = b->opts->common;
    opts->judge.texels = b->opts->texels;
    if (b->opts->rendered)
        opts->directions = b->opts->rendered;
    return true;
}

bool ibl_bench_check_output(const ibl_bench *b, const ibl_bench_point *p)
{
    ibl_verify_opts opts;
    char **words = NULL;
    const bool ok = !is_judged(b, p) || settings_of(b, p, &opts, &words);

    free(words);
    return ok;
}

/* ---- verdicts -------------------------------------------------------- */

static json_t *row_json(const char *content, int level, int size,
                        double roughness, const ibl_measured *m)
{
    return json_pack(
        "{ss si si sf sf sf sf sf}", "content", content, "level", level, "size",
        size, "roughness", roughness, "nrmse", m->value[IBL_FIGURE_NRMSE],
        "median", m->value[IBL_FIGURE_MEDIAN], "p95", m->value[IBL_FIGURE_P95],
        "bias", m->value[IBL_FIGURE_BIAS]);
}

/* Copies the errors of a point from its report. */
static bool keep(ibl_bench_point *p, const ibl_report *report)
{
    double sum = 0, all = 0;
    int rough = 0, specular = 0;

    p->levels = json_array();
    for (int i = 0; i < report->count; i++) {
        const ibl_verdict *v = &report->rows[i];
        const double nrmse = v->measured.value[IBL_FIGURE_NRMSE];
        const bool irradiance = v->level.content == IBL_OUTPUT_IRRADIANCE;
        if (v->level.content == IBL_OUTPUT_JSON)
            continue;
        /* Irradiance has the lobe of roughness 1. */
        json_t *row =
            row_json(ibl_output_name(v->level.content), v->level.number,
                     v->level.texels.size, irradiance ? 1 : v->level.roughness,
                     &v->measured);
        put(&row, "worst", json_real(v->worst));
        append(&p->levels, row);
        if (v->level.content != IBL_OUTPUT_SPECULAR)
            continue;
        all += nrmse * nrmse;
        specular++;
        if (v->level.roughness > 0) {
            sum += nrmse * nrmse;
            p->worst_p95 =
                fmax(p->worst_p95, v->measured.value[IBL_FIGURE_P95]);
            rough++;
        }
    }
    p->judged = rough > 0;
    if (rough) {
        p->error = sqrt(sum / rough);
        p->whole_error = sqrt(all / specular);
    }
    return p->levels;
}

/* Copies the rendered errors. */
static bool keep_rendered(ibl_bench_point *p, const ibl_report *report)
{
    p->rendered_rows = json_array();
    for (int i = 0; i < report->drawn_count; i++) {
        const ibl_drawn_row *d = &report->drawn[i];
        if (isnan(d->roughness)) {
            p->rendered += d->measured.value[IBL_FIGURE_NRMSE] / 2;
            continue;
        }
        json_t *row = row_json("rendered", 0, 0, d->roughness, &d->measured);
        put(&row, "f0", json_real(d->f0));
        append(&p->rendered_rows, row);
    }
    return p->rendered_rows;
}

static bool judge_point(const ibl_bench *b, ibl_ctx *ctx, ibl_bench_point *p)
{
    ibl_verify_opts opts;
    ibl_report *report = calloc(1, sizeof *report);
    json_t *about = json_object();
    char **words = NULL;
    bool ok = report && settings_of(b, p, &opts, &words);

    opts.rendered = 0;
    ok = ok && ibl_verify(&opts, ctx, b->console, report, about) &&
         keep(p, report);
    if (ok && b->opts->rendered && p->judged &&
        report->rows[0].level.lobe == IBL_LOBE_GGX) {
        opts.rendered = 1;
        ok = ibl_verify(&opts, ctx, b->console, report, about) &&
             keep_rendered(p, report);
    }
    if (report)
        ibl_report_free(report);
    free(report);
    json_decref(about);
    free(words);
    return ok ||
           ibl_console_fail(b->console, "%s: its output cannot be judged: %s",
                            p->name, ibl_status_text(IBL_ERR_MEMORY));
}

bool ibl_bench_judge(ibl_bench *b)
{
    ibl_ctx *ctx = NULL;
    bool ok = !ibl_start(&b->opts->common, b->console, &ctx);

    for (int i = 0; i < b->point_count && ok; i++)
        if (is_judged(b, &b->points[i]))
            ok = judge_point(b, ctx, &b->points[i]);
    ibl_ctx_free(ctx);
    return ok;
}
