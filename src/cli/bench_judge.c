/* SPDX-License-Identifier: MIT */
/* Judges the output of the last round. */
#include <math.h>
#include <stdlib.h>

#include "cli/bench.h"
#include "cli/console.h"
#include "cli/rendered_report.h"
#include "cli/shell_words.h"
#include "cli/verify_files.h"
#include "json/json_text.h"
#include "json/text.h"

/* State of judging the points. The map's judges keep the reference values, for
 * later points with the same map, rotation and lights. */
typedef struct judging {
    const ibl_bench *b;
    ibl_ctx *ctx;
    ibl_judged_map map; /* zeroed, or of these: */
    int source, lights;
    double yaw_deg;
} judging;

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
        opts->shading.directions = b->opts->rendered;
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

/* ---- truths ---------------------------------------------------------- */

/* Makes j->map that of a source with a rotation and lights. */
static bool take_map(judging *j, int source, const ibl_verify_files *files,
                     const ibl_judge_options *options)
{
    if (j->map.by_env && j->source == source && j->yaw_deg == files->yaw_deg &&
        j->lights == files->lights)
        return true;
    ibl_judged_map_free(&j->map);
    j->source = source;
    j->yaw_deg = files->yaw_deg;
    j->lights = files->lights;
    ibl_source *rows = NULL;
    const bool ok = !ibl_source_open(j->ctx, j->b->sources[source].path,
                                     &j->b->opts->common.read, &rows) &&
                    ibl_judged_map_read(j->ctx, rows, files->yaw_deg,
                                        files->lights, &j->map) &&
                    ibl_judged_map_prepare(j->ctx, options, &j->map);
    ibl_source_close(rows);
    return ok;
}

/* ---- verdicts -------------------------------------------------------- */

static json_t *level_json(const ibl_verdict *v)
{
    const bool irradiance = v->level.content == IBL_OUTPUT_IRRADIANCE;

    /* Irradiance has the lobe of roughness 1. */
    return json_pack("{ss si si sf sf sf sf sf sf}", "content",
                     ibl_output_content(v->level.content), "level",
                     v->level.number, "size", v->level.size, "roughness",
                     irradiance ? 1 : v->level.roughness, "nrmse", v->nrmse,
                     "median", v->error.median, "p95", v->error.p95, "worst",
                     v->error.worst, "bias", v->bias);
}

static json_t *lut_json(const ibl_lut_verdict *v)
{
    return json_pack("{ss si si sn sf sn sn sf sn}", "content", "lut", "level",
                     0, "size", v->size, "roughness", "nrmse", v->rms, "median",
                     "p95", "worst", v->max, "bias");
}

/* Copies the errors of a point from its report. */
static bool keep(ibl_bench_point *p, const ibl_report *report)
{
    double sum = 0, worst = 0, all = 0;
    int rough = 0, specular = 0;

    p->levels = json_array();
    for (int i = 0; i < report->count; i++) {
        const ibl_verdict *v = &report->rows[i];
        append(&p->levels, level_json(v));
        if (v->level.content == IBL_OUTPUT_SPECULAR) {
            all += v->nrmse * v->nrmse;
            specular++;
        }
        if (v->level.content == IBL_OUTPUT_SPECULAR && v->level.roughness > 0) {
            sum += v->nrmse * v->nrmse;
            worst = fmax(worst, v->error.p95);
            rough++;
        }
    }
    if (report->has_lut)
        append(&p->levels, lut_json(&report->lut));
    p->judged = rough > 0;
    if (rough) {
        p->error = sqrt(sum / rough);
        p->worst_p95 = worst;
        p->whole_error = sqrt(all / specular);
    }
    return p->levels;
}

/* Copies the rendered errors. */
static bool keep_rendered(ibl_bench_point *p, const ibl_rendered *rendered)
{
    p->rendered_rows = json_array();
    for (int i = 0; i < rendered->count; i++) {
        const ibl_rendered_row *row = &rendered->rows[i];
        if (isnan(row->roughness))
            p->rendered += row->measured.value[IBL_FIGURE_NRMSE] /
                           rendered->options.f0_count;
        else
            append(&p->rendered_rows,
                   json_pack("{ss sf sf sf sf sf}", "content", "rendered", "f0",
                             row->f0, "roughness", row->roughness, "nrmse",
                             row->measured.value[IBL_FIGURE_NRMSE], "median",
                             row->measured.value[IBL_FIGURE_MEDIAN], "p95",
                             row->measured.value[IBL_FIGURE_P95]));
    }
    return p->rendered_rows;
}

/* Only GGX has a truth to be rendered. */
static bool is_drawn(const judging *j, const ibl_verify_files *files)
{
    bool ggx = false;

    for (int i = 0; i < files->count; i++)
        if (files->level[i].content == IBL_OUTPUT_SPECULAR)
            ggx = files->level[i].lobe == IBL_LOBE_GGX;
    return j->b->opts->rendered && ggx;
}

static bool judge_rendered(judging *j, ibl_bench_point *p,
                           const ibl_verify_opts *opts,
                           const ibl_verify_files *files)
{
    ibl_rendered rendered = {0};
    const bool ok =
        !is_drawn(j, files) ||
        (ibl_rendered_judge(files, j->ctx, &j->map, &opts->shading,
                            opts->shader, j->b->console, &rendered) &&
         keep_rendered(p, &rendered));

    ibl_rendered_free(&rendered);
    return ok;
}

static bool judge_files(judging *j, ibl_bench_point *p,
                        const ibl_verify_opts *opts, ibl_verify_files *files,
                        ibl_report *report)
{
    ibl_console *console = j->b->console;

    if (!ibl_verify_files_read(opts, j->ctx, console, files))
        return false;
    if (!take_map(j, p->source, files, &opts->judge) ||
        !judge_rendered(j, p, opts, files))
        return false;
    /* The swept settings do not affect the table. */
    if ((p->kind == IBL_BENCH_BAKE && !p->base) || p->kind == IBL_BENCH_FORMAT)
        ibl_lut_free(&files->lut);
    report->options = opts->judge;
    return ibl_verify_judge(files, j->ctx, &j->map, console, report) &&
           keep(p, report);
}

static bool judge_point(judging *j, ibl_bench_point *p)
{
    ibl_verify_opts opts;
    ibl_verify_files files = {0};
    ibl_report report = {0};
    char **words = NULL;
    bool ok = settings_of(j->b, p, &opts, &words);

    if (ok && !judge_files(j, p, &opts, &files, &report))
        ok = ibl_console_fail(j->b->console,
                              "%s: its output cannot be judged: %s", p->name,
                              ibl_status_text(IBL_ERR_MEMORY));
    ibl_report_free(&report);
    ibl_verify_files_free(&files);
    free(words);
    return ok;
}

bool ibl_bench_judge(ibl_bench *b)
{
    judging j = {.b = b};
    bool ok = !ibl_start(&b->opts->common, b->console, &j.ctx);

    for (int i = 0; i < b->point_count && ok; i++)
        if (is_judged(b, &b->points[i]))
            ok = judge_point(&j, &b->points[i]);
    ibl_judged_map_free(&j.map);
    ibl_ctx_free(j.ctx);
    return ok;
}
