/* SPDX-License-Identifier: MIT */
/* Plans the commands of a run. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"
#include "cli/common_options.h"
#include "cli/shell_words.h"
#include "common/names.h"
#include "json/text.h"

enum {
    FORMATS_ZSTD = 19 /* the highest that does without --ultra */
};

static bool no_memory(const ibl_bench *b)
{
    return ibl_console_fail(b->console, "no memory for the plan: sweep less");
}

/* ---- commands -------------------------------------------------------- */

char *ibl_bench_fill(const ibl_bench *b, const ibl_bench_point *p,
                     const char *text)
{
    const ibl_bench_opts *o = b->opts;
    const bool peer = p->kind == IBL_BENCH_PEER;
    const char *path = b->sources[p->source].path;
    char stem[256], *filled = NULL;
    char *env = ibl_words_quote(path), *out = ibl_words_quote(p->directory);
    char *name =
        ibl_stem(path, stem, sizeof stem) ? ibl_words_quote(stem) : NULL;

    if (env && out && name) {
        const ibl_placeholder holders[] = {{"env", env},
                                           {"out", out},
                                           {"name", name},
                                           {"bake", o->bake ? o->bake : ""},
                                           {"variant", p->given}};
        filled = ibl_words_fill(text, holders, peer ? 3 : 5);
    }
    free(env);
    free(out);
    free(name);
    return filled;
}

/* The command of a bake by this program. */
static char *bake_command(const ibl_bench *b, const ibl_bench_point *p)
{
    const int method = p->at[IBL_BENCH_METHOD];
    const bool nomip = method == IBL_BENCH_SAMPLED_NOMIP;
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);
    const char *only = p->given ? strstr(p->given, "--only") : NULL;

    if (!to)
        return NULL;
    if (!only && b->opts->bake)
        only = strstr(b->opts->bake, "--only");
    fputs(" --quiet --output={out} --name=bake", to);
    if (!only || strstr(only, "json")) /* the sidecar has them */
        fputs(" --timings", to);
    fprintf(to, " --method=%s%s",
            ibl_bench_method_names[nomip ? IBL_BENCH_SAMPLED : method],
            nomip ? " --pdf-mip=no" : "");
    for (int axis = ibl_bench_takes_samples(method) ? IBL_BENCH_SAMPLES
                                                    : IBL_BENCH_SIZE;
         axis < IBL_BENCH_SOURCE; axis++) {
        char value[16];
        ibl_bench_value(axis, p->at[axis], value, sizeof value);
        fprintf(to, " --%s=%s", ibl_bench_axis_name(axis), value);
    }
    fputs(" {bake} {variant} -- {env}", to);
    char *text = ibl_memory_close(to, &file);
    char *filled = text ? ibl_bench_fill(b, p, text) : NULL;
    char *reading = b->sources[p->source].resampled
                        ? strdup(" --any-aspect")
                        : ibl_common_reading(&b->opts->common);
    char *command = filled && reading
                        ? ibl_format("/proc/self/exe%s%s", reading, filled)
                        : NULL;
    free(reading);
    free(filled);
    free(text);
    return command;
}

static char *peer_command(const ibl_bench *b, const ibl_bench_point *p)
{
    char *filled = ibl_bench_fill(b, p, p->given);
    char *quoted = filled ? ibl_words_quote(filled) : NULL;
    char *command = quoted ? ibl_format("/bin/sh -c %s", quoted) : NULL;

    free(quoted);
    free(filled);
    return command;
}

/* ---- points ---------------------------------------------------------- */

static void extend(ibl_bench_point *p, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
static void extend(ibl_bench_point *p, const char *fmt, ...)
{
    const size_t used = strlen(p->name);
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(p->name + used, sizeof p->name - used, fmt, ap);
    va_end(ap);
}

/* "sampled 1024, size 512": the method, samples if it takes them, and the other
 * differences from the base. */
static void name_bake(const ibl_bench *b, ibl_bench_point *p)
{
    const ibl_bench_source *source = &b->sources[p->source];

    extend(p, "%s", ibl_bench_method_names[p->at[IBL_BENCH_METHOD]]);
    if (ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]))
        extend(p, " %d", p->at[IBL_BENCH_SAMPLES]);
    for (int axis = IBL_BENCH_SIZE; axis < IBL_BENCH_SOURCE; axis++) {
        char value[16];
        ibl_bench_value(axis, p->at[axis], value, sizeof value);
        if (p->at[axis] != b->base[axis])
            extend(p, ", %s %s", ibl_bench_axis_name(axis), value);
    }
    if (source->resampled)
        extend(p, ", source %d", source->width);
}

/* Adds a point; sets its name and its command. */
static bool add_point(ibl_bench *b, const ibl_bench_point *like)
{
    const int number = b->point_count;
    const size_t size = (size_t)(number + 1) * sizeof *b->points;
    ibl_bench_point *points = realloc(b->points, size);

    if (!points)
        return no_memory(b);
    b->points = points;
    ibl_bench_point *p = &points[b->point_count++];
    *p = *like;
    p->directory = ibl_format("%s/%d", b->directory, number);
    if (!p->directory)
        return no_memory(b);
    char *command =
        p->kind == IBL_BENCH_PEER ? peer_command(b, p) : bake_command(b, p);
    p->argv = command ? ibl_words_split(command) : NULL;
    free(command);
    if (!p->argv)
        return no_memory(b);
    p->base = p->kind == IBL_BENCH_BAKE && !b->sources[p->source].resampled &&
              !memcmp(p->at, b->base, sizeof p->at);
    if (p->kind == IBL_BENCH_BAKE)
        name_bake(b, p);
    return ibl_bench_check_output(b, p);
}

/* ---- sweeps ---------------------------------------------------------- */

/* Returns value if the list has it, else the first of the list. */
static int find_base(const ibl_bench_list *list, int value)
{
    for (int i = 0; i < list->count; i++)
        if (list->values[i] == value)
            return value;
    return list->values[0];
}

static void find_bases(ibl_bench *b)
{
    const ibl_specular_options o = ibl_specular_options_default();
    const int standard[IBL_BENCH_SOURCE] = {IBL_BENCH_AUTO, o.samples, o.size,
                                            ibl_cpu_count(),
                                            (int)ibl_isa_best()};

    for (int axis = 0; axis < IBL_BENCH_SOURCE; axis++)
        b->base[axis] = find_base(&b->opts->lists[axis], standard[axis]);
}

/* The sweeps a bake belongs to: an axis counts if the bake differs from the
 * base on that axis only. For the samples axis the method may differ, too. */
static unsigned find_sweeps(const ibl_bench_point *p, const ibl_bench *b)
{
    unsigned sweeps = 0, differs = 0;

    for (int axis = 0; axis < IBL_BENCH_SOURCE; axis++)
        if (p->at[axis] != b->base[axis])
            differs |= 1u << axis;
    for (int axis = 0; axis < IBL_BENCH_SOURCE; axis++) {
        unsigned own = 1u << axis;
        if (axis == IBL_BENCH_SAMPLES)
            own |= 1u << IBL_BENCH_METHOD;
        if (!(differs & ~own))
            sweeps |= 1u << axis;
    }
    if (!ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]))
        sweeps &= ~(1u << IBL_BENCH_SAMPLES);
    return sweeps;
}

/* Adds a bake if it belongs to a sweep, or always with --full. Skips samples
 * that the method ignores, since they would repeat the same bake. */
static bool plan_bake(ibl_bench *b, ibl_bench_point *p)
{
    p->sweeps = find_sweeps(p, b);
    if (!p->sweeps && !b->opts->full)
        return true;
    if (!ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]) &&
        p->at[IBL_BENCH_SAMPLES] != b->base[IBL_BENCH_SAMPLES])
        return true;
    return add_point(b, p);
}

/* Plans every combination of the values of axes[0] and the following axes; the
 * other axes keep p's values. A sweep begins at the base. */
static bool plan_axes(ibl_bench *b, ibl_bench_point *p,
                      const ibl_bench_axis *axes)
{
    const ibl_bench_axis axis = *axes;
    const bool sweep = axis >= IBL_BENCH_SIZE && !b->opts->full;
    bool ok = true;

    if (axis == IBL_BENCH_AXES)
        return plan_bake(b, p);
    const ibl_bench_list *list = &b->opts->lists[axis];
    const int base = b->base[axis];
    if (sweep) {
        p->at[axis] = base;
        ok = plan_axes(b, p, axes + 1);
    }
    for (int i = 0; i < list->count && ok; i++) {
        p->at[axis] = list->values[i];
        if (!sweep || p->at[axis] != base)
            ok = plan_axes(b, p, axes + 1);
    }
    return ok;
}

/* Plans the variants or the peers. */
static bool plan_named(ibl_bench *b, ibl_bench_point p, ibl_bench_kind kind,
                       const ibl_bench_names *names)
{
    bool ok = true;

    p.kind = kind;
    for (int i = 0; i < names->count && ok; i++) {
        snprintf(p.name, sizeof p.name, "%s", names->name[i]);
        p.given = names->text[i];
        ok = add_point(b, &p);
    }
    return ok;
}

/* Plans a pixel format: in a quality, with a level of Zstandard. */
static bool plan_format(ibl_bench *b, ibl_bench_point p, ibl_pixel pixel,
                        ibl_quality quality, int zstd)
{
    const bool usual = quality == IBL_QUALITY_NORMAL;
    char options[64];

    p.kind = IBL_BENCH_FORMAT;
    p.given = options;
    snprintf(options, sizeof options, "--pixel %s%s%s --zstd %d",
             ibl_pixel_name(pixel), usual ? "" : " --quality ",
             usual ? "" : ibl_quality_name(quality), zstd);
    snprintf(p.name, sizeof p.name, "%s%s%s%s", ibl_pixel_name(pixel),
             usual ? "" : " ", usual ? "" : ibl_quality_name(quality),
             zstd ? " zstd" : "");
    if (!add_point(b, &p))
        return false;
    b->points[b->point_count - 1].given = "";
    return true;
}

/* Plans every pixel format of cubes. ASTC's blocks are UASTC HDR's, of which
 * each quality is measured. */
static bool plan_formats(ibl_bench *b, ibl_bench_point p)
{
    bool ok = true;

    for (ibl_pixel x = 0; ibl_pixel_names[x] && ok; x++) {
        const bool each = ibl_pixel_block(x) > 1 && x != IBL_PIXEL_ASTC4X4HDR;
        ok = plan_format(b, p, x, IBL_QUALITY_NORMAL, 0) &&
             plan_format(b, p, x, IBL_QUALITY_NORMAL, FORMATS_ZSTD) &&
             (!each || (plan_format(b, p, x, IBL_QUALITY_FAST, 0) &&
                        plan_format(b, p, x, IBL_QUALITY_BEST, 0)));
    }
    return ok;
}

/* Plans all bakes of a source that is not resampled. */
static bool plan_env(ibl_bench *b, int source)
{
    static const ibl_bench_axis axes[] = {IBL_BENCH_ISA,     IBL_BENCH_THREADS,
                                          IBL_BENCH_SIZE,    IBL_BENCH_METHOD,
                                          IBL_BENCH_SAMPLES, IBL_BENCH_AXES};
    ibl_bench_point base = {
        .kind = IBL_BENCH_BAKE, .given = "", .source = source};
    const int env = b->sources[source].env;

    memcpy(base.at, b->base, sizeof base.at);
    ibl_bench_point p = base;
    bool ok = plan_axes(b, &p, axes);
    for (int s = 0; s < b->source_count && ok; s++)
        if (b->sources[s].env == env && b->sources[s].resampled) {
            p = base;
            p.source = s;
            p.sweeps = 1u << IBL_BENCH_SOURCE;
            ok = add_point(b, &p);
        }
    ok = ok && plan_named(b, base, IBL_BENCH_VARIANT, &b->opts->variants);
    ok = ok && (!b->opts->formats || plan_formats(b, base));
    for (int axis = 0; axis < IBL_BENCH_AXES; axis++)
        base.at[axis] = -1;
    return ok && plan_named(b, base, IBL_BENCH_PEER, &b->opts->peers);
}

bool ibl_bench_plan(ibl_bench *b)
{
    bool ok = true;

    find_bases(b);
    for (int s = 0; s < b->source_count && ok; s++)
        if (!b->sources[s].resampled)
            ok = plan_env(b, s);
    return ok;
}
