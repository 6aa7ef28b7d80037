/* SPDX-License-Identifier: MIT */
/* Runs every command in turns and measures it; describes the machine. */
#define _DEFAULT_SOURCE /* getloadavg */
#include <errno.h>
#include <ftw.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "cli/bench.h"
#include "cli/child.h"
#include "common/clock.h"
#include "json/json_load.h"
#include "json/json_text.h"

/* ---- machine --------------------------------------------------------- */

/* The first "model name" in /proc/cpuinfo; without one the machine type. */
static void find_cpu(char *cpu, size_t size, const char *machine)
{
    FILE *f = fopen("/proc/cpuinfo", "r");
    char line[512];

    snprintf(cpu, size, "%s", machine);
    while (f && fgets(line, sizeof line, f))
        if (!strncmp(line, "model name", 10) && strchr(line, ':')) {
            const char *value = strchr(line, ':') + 1;
            value += strspn(value, " \t");
            snprintf(cpu, size, "%.*s", (int)strcspn(value, "\n"), value);
            break;
        }
    if (f)
        fclose(f);
}

json_t *ibl_bench_machine(void)
{
    char cpu[128] = "", system[128] = "";
    struct utsname name;
    double load;

    if (uname(&name) >= 0) {
        snprintf(system, sizeof system, "%.40s %.60s %.20s", name.sysname,
                 name.release, name.machine);
        find_cpu(cpu, sizeof cpu, name.machine);
    }
    return json_pack("{so si si sI so so so}", "cpu", ibl_json_string(cpu),
                     "cpus", ibl_cpu_count(), "online_cpus",
                     (int)sysconf(_SC_NPROCESSORS_ONLN), "memory_bytes",
                     (json_int_t)sysconf(_SC_PHYS_PAGES) *
                         sysconf(_SC_PAGESIZE),
                     "system", ibl_json_string(system), "compiler",
                     ibl_json_string(ibl_version_compiler()), "load",
                     getloadavg(&load, 1) == 1 ? json_real(load) : json_null());
}

/* ---- one command ----------------------------------------------------- */

static bool empty_directory(const ibl_bench *b, const ibl_bench_point *p)
{
    return (ibl_scratch_remove(p->directory) && !mkdir(p->directory, 0700)) ||
           ibl_console_fail(b->console, "%s: cannot be emptied: %s",
                            p->directory, strerror(errno));
}

/* Adds a value to the series of that name; drops it if all series are used. */
static bool record(const ibl_bench *b, ibl_bench_point *p, const char *name,
                   int round, double value)
{
    ibl_bench_series *s = p->series;

    for (int i = 0; i < p->series_count && strcmp(s->name, name) != 0; i++)
        s++;
    if (s == p->series + IBL_BENCH_SERIES)
        return true;
    if (s == p->series + p->series_count) {
        s->rounds = calloc((size_t)b->opts->rounds, sizeof *s->rounds);
        if (!s->rounds)
            return ibl_console_fail(b->console,
                                    "no memory for the measurements");
        snprintf(s->name, sizeof s->name, "%s", name);
        p->series_count++;
    }
    s->rounds[round] = value;
    return true;
}

/* Takes the size of the specular cube from a sidecar, and what its levels lost
 * by their pixel format. */
static void note_loss(ibl_bench_point *p, const json_t *sidecar)
{
    const json_t *outputs = json_object_get(sidecar, "outputs"), *levels = NULL;
    ibl_pixel_error sum = {0};

    for (size_t i = 0; i < json_array_size(outputs); i++) {
        json_t *output = json_array_get(outputs, i);
        const json_t *content = json_object_get(output, "content");
        json_int_t bytes = 0;
        if (!json_is_string(content) ||
            strcmp(json_string_value(content), "specular") != 0)
            continue;
        json_unpack(output, "{sI}", "bytes", &bytes);
        p->specular_bytes = (size_t)bytes;
        levels = json_object_get(output, "levels");
    }
    const size_t count = json_array_size(levels);
    for (size_t l = 0; l < count; l++) {
        json_t *error =
            json_object_get(json_array_get(levels, l), "pixel_error");
        double nrmse = 0, relative = 0;
        json_unpack(error, "{sF sF}", "nrmse", &nrmse, "relative", &relative);
        sum.nrmse += nrmse * nrmse / (double)count;
        sum.relative += relative / (double)count;
    }
    p->loss =
        (ibl_pixel_error){.nrmse = sqrt(sum.nrmse), .relative = sum.relative};
}

/* Records the stage times from the sidecar of a bake of ours, if it wrote one,
 * and the rest of its wall_s outside all stages. */
static bool record_stages(const ibl_bench *b, ibl_bench_point *p, int round,
                          double wall_s)
{
    double rest = wall_s;
    char path[4200];
    const char *name;
    json_t *value;
    ibl_json_why why;
    bool ok = true;

    snprintf(path, sizeof path, "%s/bake.json", p->directory);
    json_t *root = ibl_json_load(path, 0, &why);
    note_loss(p, root);
    json_t *seconds =
        json_object_get(json_object_get(root, "timings"), "seconds");
    json_object_foreach(seconds, name, value)
    {
        ok = ok && record(b, p, name, round, json_number_value(value));
        rest -= json_number_value(value);
    }
    if (seconds)
        ok = ok && record(b, p, "rest", round, fmax(rest, 0));
    json_decref(root);
    return ok;
}

/* Runs a point; round -1 is a warm-up and not counted. */
static bool run_point(const ibl_bench *b, ibl_bench_point *p, int round)
{
    const double limit_s = b->opts->timeout_s;
    char log[4200];
    ibl_child child;

    if (!empty_directory(b, p))
        return false;
    snprintf(log, sizeof log, "%s.log", p->directory);
    if (!ibl_child_run(p->argv, log, limit_s, &child))
        return ibl_console_fail(
            b->console, "%s %s: %s%s", ibl_bench_kind_names[p->kind], p->name,
            child.reason,
            child.timed_out ? ": give it more with --timeout, or leave it out"
                            : "");
    return round < 0 ||
           (record(b, p, "wall_s", round, child.wall_s) &&
            record(b, p, "cpu_s", round, child.cpu_s) &&
            record(b, p, "peak_bytes", round, (double)child.peak_bytes) &&
            (p->kind == IBL_BENCH_PEER ||
             record_stages(b, p, round, child.wall_s)));
}

/* ---- all of them ----------------------------------------------------- */

static size_t found_bytes;
static int add_size(const char *path, const struct stat *st, int kind,
                    struct FTW *where)
{
    (void)path, (void)where;
    if (kind == FTW_F)
        found_bytes += (size_t)st->st_size;
    return 0;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The q-quantile of n sorted values, interpolated as R's type 7. */
static double quantile(const double *sorted, int n, double q)
{
    const double at = q * (n - 1);
    const int i = (int)at;
    return i + 1 < n ? sorted[i] + (at - i) * (sorted[i + 1] - sorted[i])
                     : sorted[n - 1];
}

/* Finds the quartiles of each series, and the output size of the last round. */
static void sum_up(const ibl_bench *b, ibl_bench_point *p)
{
    double sorted[IBL_BENCH_ROUNDS];
    const int n = b->opts->rounds;

    for (int i = 0; i < p->series_count; i++) {
        ibl_bench_series *s = &p->series[i];
        memcpy(sorted, s->rounds, (size_t)n * sizeof *sorted);
        qsort(sorted, (size_t)n, sizeof *sorted, by_value);
        s->low = quantile(sorted, n, 0.25);
        s->median = quantile(sorted, n, 0.5);
        s->high = quantile(sorted, n, 0.75);
    }
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
    const double begun = ibl_now();
    bool ok = true;

    for (int i = 0; i < n && b->opts->common.verbose; i++)
        print_command(&b->points[i]);
    for (int round = -1; round < rounds; round++)
        for (int i = 0; i < n && ok; i++) {
            ibl_console_progress(b->console, "measure",
                                 ((round + 1) * n + i) /
                                     (double)(n * (rounds + 1)));
            ok = run_point(b, &b->points[i], round);
        }
    for (int i = 0; i < n && ok; i++)
        sum_up(b, &b->points[i]);
    b->seconds = ibl_now() - begun;
    return ok;
}
