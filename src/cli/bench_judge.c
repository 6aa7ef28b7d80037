/* SPDX-License-Identifier: MIT */
/* The error of what the last round left. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"
#include "cli/session.h"
#include "cli/verify_files.h"
#include "cli/shell_words.h"

/* The run's judging: a map, and its truth for each rotation that occurs. */
typedef struct judging {
    const ibl_bench *b;
    ibl_ctx *ctx;
    int source; /* that env and judges are of; -1: none */
    ibl_image env;
    int count;
    double yaw_deg[IBL_BENCH_NAMED + 1];
    ibl_judge *judges[IBL_BENCH_NAMED + 1];
} judging;

static const char *output_of(const ibl_bench *b, const ibl_bench_point *p)
{
    const ibl_bench_names *outputs = &b->opts->outputs;

    for (int i = 0; i < outputs->count; i++)
        if (!strcmp(outputs->name[i], b->opts->peers.name[p->index]))
            return outputs->text[i];
    return NULL;
}

static bool is_judged(const ibl_bench *b, const ibl_bench_point *p)
{
    return b->opts->texels && !b->sources[p->source].resampled &&
           (p->kind != IBL_BENCH_PEER || output_of(b, p));
}

/* ENV and the rest of iblbake verify's arguments; free with ibl_words_free.
 * NULL: no memory. */
static char **arguments(const ibl_bench *b, const ibl_bench_point *p)
{
    char *env = ibl_words_quote(b->sources[p->source].path), *rest, *all = NULL;
    char **words = NULL;
    int length;

    rest = ibl_bench_fill(b, p,
                          p->kind == IBL_BENCH_PEER ? output_of(b, p)
                                                    : "{out} --name bake");
    if (env && rest) {
        length = snprintf(NULL, 0, "%s %s", env, rest);
        all = malloc((size_t)length + 1);
        if (all)
            snprintf(all, (size_t)length + 1, "%s %s", env, rest);
    }
    if (all)
        words = ibl_words_split(all);
    free(all);
    free(rest);
    free(env);
    return words;
}

/* Settings of verify for a point; *words has their strings. */
static bool settings_of(const ibl_bench *b, const ibl_bench_point *p,
                        ibl_verify_opts *opts, char ***words)
{
    *words = arguments(b, p);
    if (!*words) {
        ibl_console_fail(b->console,
                         "%s: its output's arguments have an open "
                         "quote, or no memory: close it",
                         p->name);
        return false;
    }
    if (!ibl_command_parse(&ibl_verify_command, *words, opts))
        return false;
    opts->common = b->opts->common;
    opts->judge.texels = b->opts->texels;
    return true;
}

bool ibl_bench_check_output(const ibl_bench *b, const ibl_bench_point *p)
{
    ibl_verify_opts opts;
    char **words = NULL;
    const bool ok = !is_judged(b, p) || settings_of(b, p, &opts, &words);

    ibl_words_free(words);
    return ok;
}

/* ---- truths ---------------------------------------------------------- */

static void drop_source(judging *j)
{
    for (int i = 0; i < j->count; i++)
        ibl_judge_free(j->judges[i]);
    j->count = 0;
    ibl_image_free(&j->env);
    j->source = -1;
}

static ibl_status take_source(judging *j, int source)
{
    if (j->source == source)
        return IBL_OK;
    drop_source(j);
    const ibl_status status =
        ibl_image_read(j->ctx, j->b->sources[source].path,
                       &j->b->opts->common.read, &j->env, NULL);
    if (!status)
        j->source = source;
    return status;
}

/* The judge of the map with a rotation; it keeps what it worked out. */
static ibl_status find_judge(judging *j, double yaw_deg,
                             const ibl_judge_options *options,
                             ibl_judge **judge)
{
    int i = 0;

    while (i < j->count && j->yaw_deg[i] != yaw_deg)
        i++;
    if (i == j->count) {
        if (i > IBL_BENCH_NAMED)
            ibl_judge_free(j->judges[--i]);
        j->count = i;
        const ibl_status status =
            ibl_judge_create(j->ctx, &j->env, yaw_deg, options, &j->judges[i]);
        if (status)
            return status;
        j->yaw_deg[i] = yaw_deg;
        j->count = i + 1;
    }
    *judge = j->judges[i];
    return IBL_OK;
}

/* ---- verdicts -------------------------------------------------------- */

static ibl_status keep(ibl_bench_point *p, const ibl_report *report)
{
    double sum = 0, worst = 0;
    int rough = 0;

    p->level = calloc((size_t)report->count + 1, sizeof *p->level);
    if (!p->level)
        return IBL_ERR_MEMORY;
    for (int i = 0; i < report->count; i++) {
        const ibl_verdict *v = &report->rows[i].verdict;
        ibl_bench_level *l = &p->level[p->level_count++];
        *l = (ibl_bench_level){.level = report->rows[i].level,
                               .size = v->size,
                               .roughness = v->roughness,
                               .nrmse = v->nrmse,
                               .median = v->median,
                               .p95 = v->p95,
                               .worst = v->worst,
                               .bias = v->bias};
        snprintf(l->content, sizeof l->content, "%s", report->rows[i].content);
        if (v->role == IBL_ROLE_IRRADIANCE)
            l->roughness = 1; /* which has the same lobe */
        if (strcmp(l->content, "specular") != 0 || !(v->roughness > 0))
            continue;
        sum += v->nrmse * v->nrmse;
        worst = fmax(worst, v->p95);
        rough++;
    }
    p->judged = rough > 0;
    p->error = rough ? sqrt(sum / rough) : (double)NAN;
    p->worst_p95 = rough ? worst : (double)NAN;
    return IBL_OK;
}

static void keep_lut(ibl_bench_point *p, const ibl_lut_verdict *v)
{
    ibl_bench_level *l = &p->level[p->level_count++];

    *l = (ibl_bench_level){.size = v->size,
                           .roughness = NAN,
                           .nrmse = v->rms,
                           .median = NAN,
                           .p95 = NAN,
                           .worst = v->max,
                           .bias = NAN};
    snprintf(l->content, sizeof l->content, "lut");
}

static ibl_status judge_files(judging *j, ibl_bench_point *p,
                              const ibl_verify_opts *opts,
                              ibl_verify_files *files, ibl_report *report)
{
    ibl_judge *judge = NULL;
    ibl_status status =
        ibl_verify_files_read(opts, j->ctx, j->b->console, files);

    if (!status)
        status = take_source(j, p->source);
    if (!status)
        status = find_judge(j, files->yaw_deg, &opts->judge, &judge);
    if (!status)
        status = ibl_verify_judge(files, judge, j->b->console, report);
    if (!status)
        status = keep(p, report);
    /* What is swept has no part in the table. */
    if (!status && files->lut_path && (p->base || p->kind != IBL_BENCH_BAKE)) {
        ibl_lut_verdict v;
        status = ibl_judge_lut(j->ctx, &files->lut, files->lut_pixel,
                               files->geometry, &opts->judge, &v);
        if (!status)
            keep_lut(p, &v);
    }
    return status;
}

static bool judge_point(judging *j, ibl_bench_point *p)
{
    ibl_verify_opts opts;
    ibl_verify_files files = {0};
    ibl_report report = {0};
    char **words = NULL;
    bool ok = settings_of(j->b, p, &opts, &words);

    if (ok) {
        const ibl_status status = judge_files(j, p, &opts, &files, &report);
        if (status)
            ibl_console_fail(j->b->console,
                             "%s: its output cannot be judged: "
                             "%s",
                             p->name, ibl_status_text(status));
        ok = !status;
    }
    ibl_report_free(&report);
    ibl_verify_files_free(&files);
    ibl_words_free(words);
    return ok;
}

bool ibl_bench_judge(ibl_bench *b)
{
    judging j = {.b = b, .source = -1};
    bool ok = !ibl_start(&b->opts->common, b->console, &j.ctx);

    for (int i = 0; i < b->point_count && ok; i++)
        if (is_judged(b, &b->points[i]))
            ok = judge_point(&j, &b->points[i]);
    drop_source(&j);
    ibl_ctx_free(j.ctx);
    return ok;
}
