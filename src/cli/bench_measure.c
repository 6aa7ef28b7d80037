/* SPDX-License-Identifier: MIT */
/* Every command in turns, and what each took. */
#include <errno.h>
#include <ftw.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli/bench.h"
#include "cli/scratch.h"
#include "common/json_load.h"

static bool empty_directory(const ibl_bench *b, const ibl_bench_point *p)
{
    if (ibl_scratch_remove(p->directory) && !mkdir(p->directory, 0700))
        return true;
    ibl_console_fail(b->console, "%s: cannot be emptied: %s", p->directory,
                     strerror(errno));
    return false;
}

static ibl_bench_stage *find_stage(const ibl_bench *b, ibl_bench_point *p,
                                   const char *name)
{
    ibl_bench_stage *s = p->stages;

    for (int i = 0; i < p->stage_count; i++, s++)
        if (!strcmp(s->name, name))
            return s;
    if (p->stage_count == IBL_BENCH_STAGES)
        return NULL;
    s->seconds = calloc((size_t)b->opts->rounds, sizeof *s->seconds);
    if (!s->seconds)
        return NULL;
    snprintf(s->name, sizeof s->name, "%s", name);
    p->stage_count++;
    return s;
}

/* The stage times that a bake of ours left in its sidecar, if it left one, and
 * what of the whole they do not cover. */
static void read_stages(const ibl_bench *b, ibl_bench_point *p, int round)
{
    double rest = p->wall_s[round];
    char path[4200];
    const char *name;
    json_t *value;
    ibl_json_why why;

    snprintf(path, sizeof path, "%s/bake.json", p->directory);
    json_t *root = ibl_json_load(path, 0, &why);
    json_t *seconds =
        json_object_get(json_object_get(root, "timings"), "seconds");
    json_object_foreach(seconds, name, value)
    {
        ibl_bench_stage *s = find_stage(b, p, name);
        if (s)
            s->seconds[round] = json_number_value(value);
        rest -= json_number_value(value);
    }
    ibl_bench_stage *s = seconds ? find_stage(b, p, "rest") : NULL;
    if (s)
        s->seconds[round] = fmax(rest, 0);
    json_decref(root);
}

/* Runs a point; round -1 is not counted. */
static bool run_point(const ibl_bench *b, ibl_bench_point *p, int round,
                      size_t *peak)
{
    char reason[600];
    ibl_child child;

    if (!empty_directory(b, p))
        return false;
    ibl_child_run((const char *const *)p->argv, p->log, b->opts->timeout_s,
                  &child);
    ibl_child_reason(&child, p->log, b->opts->timeout_s, reason, sizeof reason);
    if (*reason) {
        static const char *const kinds[] = {"bake", "variant", "peer"};
        ibl_console_fail(b->console, "%s %s: %s%s", kinds[p->kind], p->name,
                         reason,
                         child.timed_out ? ": give it more with --timeout, or "
                                           "leave it out"
                                         : "");
        return false;
    }
    if (round < 0)
        return true;
    p->wall_s[round] = child.wall_s;
    p->cpu_s[round] = child.cpu_s;
    peak[round] = child.peak_bytes;
    if (p->kind != IBL_BENCH_PEER)
        read_stages(b, p, round);
    return true;
}

static size_t found_bytes;
static int add_size(const char *path, const struct stat *st, int kind,
                    struct FTW *where)
{
    (void)path, (void)where;
    if (kind == FTW_F)
        found_bytes += (size_t)st->st_size;
    return 0;
}

static void sum_up(const ibl_bench *b, ibl_bench_point *p, const size_t *peak)
{
    double values[IBL_BENCH_ROUNDS];
    const int rounds = b->opts->rounds;

    p->wall = ibl_bench_stat_of(p->wall_s, rounds);
    p->cpu = ibl_bench_stat_of(p->cpu_s, rounds);
    for (int i = 0; i < rounds; i++)
        values[i] = (double)peak[i];
    p->peak_bytes = (size_t)ibl_bench_stat_of(values, rounds).median;
    for (int i = 0; i < p->stage_count; i++)
        p->stages[i].stat = ibl_bench_stat_of(p->stages[i].seconds, rounds);
    found_bytes = 0;
    nftw(p->directory, add_size, 16, FTW_PHYS);
    p->output_bytes = found_bytes;
}

static void print_command(const ibl_bench_point *p)
{
    fprintf(stderr, "%s:", p->name);
    for (char **word = p->argv; *word; word++)
        fprintf(stderr, " %s", *word);
    fputc('\n', stderr);
}

bool ibl_bench_measure(ibl_bench *b)
{
    const int n = b->point_count, rounds = b->opts->rounds;
    size_t *peaks = calloc((size_t)n * (size_t)rounds, sizeof *peaks);
    struct timespec from, to;
    bool ok = peaks;

    if (!ok)
        ibl_console_fail(b->console, "no memory for the measurements");
    clock_gettime(CLOCK_MONOTONIC, &from);
    for (int i = 0; i < n && ok && b->opts->common.verbose; i++)
        print_command(&b->points[i]);
    for (int round = -1; round < rounds; round++)
        for (int i = 0; i < n && ok; i++) {
            ibl_console_progress(b->console, "measure",
                                 ((round + 1) * n + i) /
                                     (double)(n * (rounds + 1)));
            ok = run_point(b, &b->points[i], round, peaks + i * rounds);
        }
    for (int i = 0; i < n && ok; i++)
        sum_up(b, &b->points[i], peaks + i * rounds);
    clock_gettime(CLOCK_MONOTONIC, &to);
    b->seconds = (double)(to.tv_sec - from.tv_sec) +
                 1e-9 * (double)(to.tv_nsec - from.tv_nsec);
    free(peaks);
    return ok;
}
