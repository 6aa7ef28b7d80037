/* SPDX-License-Identifier: MIT */
#include "cli/bench.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "cli/child.h"
#include "cli/console.h"
#include "common/path.h"
#include "common/signals.h"
#include "json/json_text.h"

static void free_bench(ibl_bench *b)
{
    for (int i = 0; i < b->point_count; i++) {
        ibl_bench_point *p = &b->points[i];
        for (int k = 0; k < p->series_count; k++)
            free(p->series[k].rounds);
        json_decref(p->levels);
        json_decref(p->rendered_rows);
        free(p->argv);
        free(p->directory);
    }
    for (int i = 0; i < b->source_count; i++)
        free(b->sources[i].path);
    free(b->points);
    json_decref(b->machine);
}

/* ---- files ----------------------------------------------------------- */

typedef struct report {
    const char *path;
    char *(*text)(const json_t *document);
} report;

/* Checks the report files before the minutes of work, not after them. */
static bool check_reports(const ibl_bench *b, const report *reports, int count)
{
    for (int i = 0; i < count; i++) {
        const char *path = reports[i].path;
        if (path && !ibl_path_is_open(path)) {
            ibl_console_fail(b->console,
                             "%s: cannot be written: %s: choose another "
                             "directory",
                             path, strerror(errno));
            return false;
        }
    }
    return true;
}

static bool write_reports(const ibl_bench *b, const report *reports, int count)
{
    json_t *document = ibl_bench_document(b);
    ibl_ctx *ctx = NULL;
    ibl_outputs *outputs = NULL;
    bool ok = document && !ibl_start(&b->opts->common, b->console, &ctx) &&
              !ibl_start_outputs(ctx, 0, &outputs);

    for (int i = 0; i < count && ok; i++) {
        const char *path = reports[i].path;
        char *text = path ? reports[i].text(document) : NULL;
        if (path)
            ok = text && !ibl_outputs_add(outputs, path, text, strlen(text));
        free(text);
    }
    ok = ok && !ibl_commit_outputs(outputs);
    if (!ok)
        ibl_console_fail(b->console, "the reports: %s",
                         ibl_status_text(IBL_ERR_MEMORY));
    ibl_end_outputs(outputs);
    ibl_ctx_free(ctx);
    json_decref(document);
    return ok;
}

/* ---- the run --------------------------------------------------------- */

/* Whether q is as fast and good as p, and strictly better in one of them. */
static bool is_beaten(const ibl_bench_point *p, const ibl_bench_point *q)
{
    const double time = p->series[IBL_BENCH_WALL_S].median;
    const double other = q->series[IBL_BENCH_WALL_S].median;

    return q->source == p->source && q->error <= p->error && other <= time &&
           (q->error < p->error || other < time);
}

/* Marks the Pareto front of each map: points that no other point beats. */
static void mark_front(ibl_bench *b)
{
    for (int i = 0; i < b->point_count; i++) {
        ibl_bench_point *p = &b->points[i];
        p->pareto = ibl_bench_is_rival(b, p);
        for (int k = 0; k < b->point_count && p->pareto; k++)
            p->pareto = !ibl_bench_is_rival(b, &b->points[k]) ||
                        !is_beaten(p, &b->points[k]);
    }
}

bool ibl_bench_is_rival(const ibl_bench *b, const ibl_bench_point *p)
{
    if (!p->judged || b->sources[p->source].resampled ||
        p->kind == IBL_BENCH_FORMAT)
        return false;
    if (p->kind != IBL_BENCH_BAKE)
        return true;
    for (int axis = IBL_BENCH_SIZE; axis < IBL_BENCH_SOURCE; axis++)
        if (p->at[axis] != b->base[axis])
            return false;
    return true;
}

bool ibl_bench_is_special(const ibl_bench *b, const ibl_bench_point *p)
{
    return p->base || p->kind == IBL_BENCH_VARIANT ||
           p->kind == IBL_BENCH_PEER ||
           (p->sweeps & 1u << IBL_BENCH_METHOD &&
            !b->sources[p->source].resampled);
}

/* Does the work in the private directory. */
static int work(const void *cookie, const char *directory)
{
    const ibl_bench_opts *opts = cookie;
    const report reports[] = {{opts->csv, ibl_bench_csv},
                              {opts->json, ibl_json_text},
                              {opts->html, ibl_bench_html}};
    const int count = (int)(sizeof reports / sizeof *reports);
    ibl_console console;
    ibl_bench b = {.opts = opts,
                   .console = &console,
                   .directory = directory,
                   .machine = ibl_bench_machine()};
    const time_t now = time(NULL);
    struct tm utc;

    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    if (gmtime_r(&now, &utc))
        strftime(b.date, sizeof b.date, "%Y-%m-%d %H:%M UTC", &utc);
    bool ok = check_reports(&b, reports, count) && ibl_bench_sources_make(&b) &&
              ibl_bench_plan(&b) && ibl_bench_measure(&b) &&
              ibl_bench_judge(&b);
    ibl_console_finish(&console);
    mark_front(&b);
    ok = ok && write_reports(&b, reports, count);
    if (ok)
        ibl_bench_print(&b, stdout);
    free_bench(&b);
    return ok ? 0 : 1;
}

int ibl_bench_run(const void *opts)
{
    return ibl_scratch_run(work, opts);
}
