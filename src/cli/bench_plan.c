/* SPDX-License-Identifier: MIT */
/* Which commands a run has. */
#define _GNU_SOURCE /* vasprintf */
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"
#include "cli/common_options.h"
#include "cli/shell_words.h"

char *ibl_bench_text(const char *fmt, ...)
{
    char *text;
    va_list ap;

    va_start(ap, fmt);
    const int length = vasprintf(&text, fmt, ap);
    va_end(ap);
    return length < 0 ? NULL : text;
}

static bool no_memory(const ibl_bench *b)
{
    ibl_console_fail(b->console, "no memory for the plan: sweep less");
    return false;
}

/* ---- commands -------------------------------------------------------- */

char *ibl_bench_fill(const ibl_bench *b, const ibl_bench_point *p,
                     const char *text)
{
    const char *path = b->sources[p->source].path;
    char stem[256], *filled = NULL;
    char *env = ibl_words_quote(path), *out = ibl_words_quote(p->directory);
    char *name =
        ibl_stem(path, stem, sizeof stem) ? ibl_words_quote(stem) : NULL;

    if (env && out && name) {
        const ibl_placeholder holders[] = {
            {"env", env}, {"out", out}, {"name", name}};
        filled = ibl_words_fill(text, holders, 3);
    }
    free(env);
    free(out);
    free(name);
    return filled;
}

/* A bake by this program, whatever it is called by now. */
static char *bake_command(const ibl_bench *b, const ibl_bench_point *p)
{
    const ibl_bench_source *source = &b->sources[p->source];
    const ibl_read_options plain = {.part = -1, .any_aspect = 1};
    const ibl_read_options *read =
        source->resampled ? &plain : &b->opts->common.read;
    const int method = p->at[IBL_BENCH_METHOD];
    const bool nomip = method == IBL_BENCH_SAMPLED_NOMIP;
    const char *variant =
        p->kind == IBL_BENCH_VARIANT ? b->opts->variants.text[p->index] : "";
    char *layer = ibl_words_quote(read->layer ? read->layer : "");
    char *out = ibl_words_quote(p->directory);
    char *env = ibl_words_quote(source->path);
    char part[32] = "", *command = NULL;

    if (read->part >= 0)
        snprintf(part, sizeof part, "--part=%d", read->part);
    if (layer && out && env)
        command = ibl_bench_text(
            "/proc/self/exe --quiet --timings --output=%s --name=bake %s%s %s "
            "%s %s --method=%s --pdf-mip=%s --samples=%d --size=%d "
            "--threads=%d --isa=%s %s %s -- %s",
            out, read->layer ? "--layer=" : "", read->layer ? layer : "", part,
            read->any_aspect ? "--any-aspect" : "",
            read->strict ? "--strict" : "",
            ibl_bench_method_name(nomip ? IBL_BENCH_SAMPLED : method),
            nomip ? "no" : "yes", p->at[IBL_BENCH_SAMPLES],
            p->at[IBL_BENCH_SIZE], p->at[IBL_BENCH_THREADS],
            ibl_isa_name((ibl_isa)p->at[IBL_BENCH_ISA]),
            b->opts->bake ? b->opts->bake : "", variant, env);
    free(layer);
    free(out);
    free(env);
    return command;
}

static char *peer_command(const ibl_bench *b, const ibl_bench_point *p)
{
    char *filled = ibl_bench_fill(b, p, b->opts->peers.text[p->index]);
    char *quoted = filled ? ibl_words_quote(filled) : NULL;
    char *command = quoted ? ibl_bench_text("/bin/sh -c %s", quoted) : NULL;

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

/* "sampled 1024, size 512": method, samples where it takes them, and what else
 * differs from the base. */
static void name_bake(const ibl_bench *b, ibl_bench_point *p)
{
    const ibl_bench_source *source = &b->sources[p->source];

    extend(p, "%s", ibl_bench_method_name(p->at[IBL_BENCH_METHOD]));
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

static bool is_same(const ibl_bench_point *p, const ibl_bench_point *q)
{
    return p->kind == q->kind && p->index == q->index &&
           p->source == q->source && !memcmp(p->at, q->at, sizeof p->at);
}

/* Adds a point, or its sweep to the point that is there already. */
static bool keep(ibl_bench *b, const ibl_bench_point *like)
{
    for (int i = 0; i < b->point_count; i++)
        if (is_same(&b->points[i], like)) {
            b->points[i].sweeps |= like->sweeps;
            return true;
        }
    ibl_bench_point *points =
        realloc(b->points, (size_t)(b->point_count + 1) * sizeof *b->points);
    if (!points)
        return no_memory(b);
    b->points = points;
    b->points[b->point_count++] = *like;
    return true;
}

static bool complete(ibl_bench *b, ibl_bench_point *p, int number)
{
    p->directory = ibl_bench_text("%s/%d", b->directory, number);
    p->log = ibl_bench_text("%s/%d.log", b->directory, number);
    if (!p->directory || !p->log)
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
    else if (p->kind == IBL_BENCH_VARIANT)
        extend(p, "%s", b->opts->variants.name[p->index]);
    else
        extend(p, "%s", b->opts->peers.name[p->index]);
    return ibl_bench_check_output(b, p);
}

/* ---- sweeps ---------------------------------------------------------- */

/* The value if the list has it, else the list's first. */
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

/* The sweeps that a bake belongs to: those of the axes by which alone it
 * differs from the base, where samples are swept for each method. */
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

/* Every combination of the values of some axes (a bit each), samples first,
 * with the base's of the others. */
static bool plan_axes(ibl_bench *b, const ibl_bench_point *base, unsigned axes)
{
    static const int order[] = {IBL_BENCH_SAMPLES, IBL_BENCH_METHOD,
                                IBL_BENCH_SIZE, IBL_BENCH_THREADS,
                                IBL_BENCH_ISA};
    const ibl_bench_list *lists = b->opts->lists;
    int at[IBL_BENCH_SOURCE] = {0}, k = 0;

    while (k < IBL_BENCH_SOURCE) {
        ibl_bench_point p = *base;
        for (int axis = 0; axis < IBL_BENCH_SOURCE; axis++)
            if (axes >> axis & 1)
                p.at[axis] = lists[axis].values[at[axis]];
        p.sweeps = find_sweeps(&p, b);
        /* Samples that a method does not take make the same bake again. */
        if ((ibl_bench_takes_samples(p.at[IBL_BENCH_METHOD]) ||
             p.at[IBL_BENCH_SAMPLES] == b->base[IBL_BENCH_SAMPLES]) &&
            !keep(b, &p))
            return false;
        for (k = 0; k < IBL_BENCH_SOURCE; k++) {
            const int axis = order[k];
            if (axes >> axis & 1 && ++at[axis] < lists[axis].count)
                break;
            at[axis] = 0;
        }
    }
    return true;
}

/* One axis at a time, but samples for every method, or all at once. */
static bool plan_sweeps(ibl_bench *b, const ibl_bench_point *base)
{
    const unsigned methods = 1u << IBL_BENCH_METHOD | 1u << IBL_BENCH_SAMPLES;

    if (b->opts->full)
        return plan_axes(b, base, (1u << IBL_BENCH_SOURCE) - 1);
    bool ok = plan_axes(b, base, methods);
    for (int axis = IBL_BENCH_SIZE; axis < IBL_BENCH_SOURCE && ok; axis++)
        ok = plan_axes(b, base, 1u << axis);
    return ok;
}

/* The variants or the peers. */
static bool plan_named(ibl_bench *b, const ibl_bench_point *like,
                       ibl_bench_kind kind, int count)
{
    ibl_bench_point p = *like;
    bool ok = true;

    p.kind = kind;
    for (p.index = 0; p.index < count && ok; p.index++)
        ok = keep(b, &p);
    return ok;
}

/* Of the source with this index, which is an environment as it is. */
static bool plan_env(ibl_bench *b, int source)
{
    ibl_bench_point base = {.kind = IBL_BENCH_BAKE, .source = source};
    const int env = b->sources[source].env;

    memcpy(base.at, b->base, sizeof base.at);
    bool ok = plan_sweeps(b, &base);
    for (int s = 0; s < b->source_count && ok; s++)
        if (b->sources[s].env == env && b->sources[s].resampled) {
            ibl_bench_point p = base;
            p.source = s;
            p.sweeps = 1u << IBL_BENCH_SOURCE;
            ok = keep(b, &p);
        }
    ok = ok && plan_named(b, &base, IBL_BENCH_VARIANT, b->opts->variants.count);
    for (int axis = 0; axis < IBL_BENCH_AXES; axis++)
        base.at[axis] = -1;
    return ok && plan_named(b, &base, IBL_BENCH_PEER, b->opts->peers.count);
}

bool ibl_bench_plan(ibl_bench *b)
{
    bool ok = true;

    find_bases(b);
    for (int s = 0; s < b->source_count && ok; s++)
        if (!b->sources[s].resampled)
            ok = plan_env(b, s);
    for (int i = 0; i < b->point_count && ok; i++)
        ok = complete(b, &b->points[i], i);
    return ok;
}
