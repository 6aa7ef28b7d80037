/* SPDX-License-Identifier: MIT */
/* Which commands a run has. */
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"
#include "cli/common_options.h"
#include "cli/shell_words.h"

static bool no_memory(const ibl_bench *b)
{
    ibl_console_fail(b->console, "no memory for the plan: sweep less");
    return false;
}

/* An argv that grows; its words are its own. */
typedef struct arguments {
    char **words;
    size_t count, room;
    bool failed;
} arguments;

static void add(arguments *a, const char *fmt, ...)
    __attribute__((format(printf, 2, 3)));
static void add(arguments *a, const char *fmt, ...)
{
    va_list ap;

    if (a->count + 2 > a->room) {
        const size_t room = 2 * a->room + 32;
        char **words = realloc(a->words, room * sizeof *words);
        if (!words) {
            a->failed = true;
            return;
        }
        a->words = words;
        a->room = room;
    }
    va_start(ap, fmt);
    const int length = vsnprintf(NULL, 0, fmt, ap);
    va_end(ap);
    char *word = malloc((size_t)length + 1);
    if (word) {
        va_start(ap, fmt);
        vsnprintf(word, (size_t)length + 1, fmt, ap);
        va_end(ap);
        a->words[a->count++] = word;
    }
    a->words[a->count] = NULL;
    a->failed |= !word;
}

static void add_split(arguments *a, const char *text)
{
    char **words = text ? ibl_words_split(text) : NULL;

    if (text && !words)
        a->failed = true;
    for (size_t i = 0; words && words[i]; i++)
        add(a, "%s", words[i]);
    ibl_words_free(words);
}

static void add_input(arguments *a, const ibl_read_options *read)
{
    const ibl_read_options defaults = ibl_read_options_default();

    if (read->layer)
        add(a, "--layer=%s", read->layer);
    if (read->part != defaults.part)
        add(a, "--part=%d", read->part);
    if (read->any_aspect)
        add(a, "--any-aspect");
    if (read->strict)
        add(a, "--strict");
}

/* The program itself, whatever it is called by now. */
static void add_bake(arguments *a, const ibl_bench *b, const ibl_bench_point *p)
{
    const ibl_bench_source *source = &b->sources[p->source];
    const int method = p->at[IBL_BENCH_METHOD];

    add(a, "/proc/self/exe");
    add(a, "--quiet");
    add(a, "--timings");
    add(a, "--output=%s", p->directory);
    add(a, "--name=bake");
    if (!source->resampled)
        add_input(a, &b->opts->common.read);
    else
        add(a, "--any-aspect");
    add(a, "--method=%s",
        method == IBL_BENCH_SAMPLED_NOMIP ? "sampled"
                                          : ibl_bench_method_name(method));
    add(a, "--pdf-mip=%s", method == IBL_BENCH_SAMPLED_NOMIP ? "no" : "yes");
    add(a, "--samples=%d", p->at[IBL_BENCH_SAMPLES]);
    add(a, "--size=%d", p->at[IBL_BENCH_SIZE]);
    add(a, "--threads=%d", p->at[IBL_BENCH_THREADS]);
    add(a, "--isa=%s", ibl_isa_name((ibl_isa)p->at[IBL_BENCH_ISA]));
    add_split(a, b->opts->bake);
    if (p->kind == IBL_BENCH_VARIANT)
        add_split(a, b->opts->variants.text[p->index]);
    add(a, "--");
    add(a, "%s", source->path);
}

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

static void add_peer(arguments *a, const ibl_bench *b, const ibl_bench_point *p)
{
    char *command = ibl_bench_fill(b, p, b->opts->peers.text[p->index]);

    add(a, "/bin/sh");
    add(a, "-c");
    if (command)
        add(a, "%s", command);
    a->failed |= !command;
    free(command);
}

static bool is_same(const ibl_bench_point *p, const ibl_bench_point *q)
{
    return p->kind == q->kind && p->index == q->index &&
           p->source == q->source && !memcmp(p->at, q->at, sizeof p->at);
}

/* "sampled 1024, size 512": method, samples where it takes them, and what else
 * is not as in the base. */
static void name_bake(const ibl_bench *b, ibl_bench_point *p)
{
    char *to = p->name;
    const char *end = p->name + sizeof p->name;

    to += snprintf(to, (size_t)(end - to), "%s",
                   ibl_bench_method_name(p->at[IBL_BENCH_METHOD]));
    if (ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]))
        to += snprintf(to, (size_t)(end - to), " %d", p->at[IBL_BENCH_SAMPLES]);
    for (int axis = IBL_BENCH_SIZE; axis < IBL_BENCH_SOURCE; axis++)
        if (p->at[axis] != b->base[axis] && to < end) {
            to += snprintf(to, (size_t)(end - to), ", %s ",
                           ibl_bench_axis_name((ibl_bench_axis)axis));
            if (to < end && axis == IBL_BENCH_ISA)
                to += snprintf(to, (size_t)(end - to), "%s",
                               ibl_isa_name((ibl_isa)p->at[axis]));
            else if (to < end)
                to += snprintf(to, (size_t)(end - to), "%d", p->at[axis]);
        }
    if (b->sources[p->source].resampled && to < end)
        snprintf(to, (size_t)(end - to), ", source %d",
                 b->sources[p->source].width);
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
    const size_t size = strlen(b->directory) + 32;
    const size_t rounds = (size_t)b->opts->rounds;
    arguments a = {0};

    p->directory = malloc(size);
    p->log = malloc(size);
    p->wall_s = calloc(rounds, sizeof *p->wall_s);
    p->cpu_s = calloc(rounds, sizeof *p->cpu_s);
    if (!p->directory || !p->log || !p->wall_s || !p->cpu_s)
        return no_memory(b);
    snprintf(p->directory, size, "%s/%d", b->directory, number);
    snprintf(p->log, size, "%s/%d.log", b->directory, number);
    if (p->kind == IBL_BENCH_PEER)
        add_peer(&a, b, p);
    else
        add_bake(&a, b, p);
    p->argv = a.words;
    p->base = p->kind == IBL_BENCH_BAKE && !b->sources[p->source].resampled &&
              !memcmp(p->at, b->base, sizeof p->at);
    if (p->kind == IBL_BENCH_BAKE)
        name_bake(b, p);
    else
        snprintf(p->name, sizeof p->name, "%s",
                 p->kind == IBL_BENCH_PEER ? b->opts->peers.name[p->index]
                                           : b->opts->variants.name[p->index]);
    return a.failed ? no_memory(b) : ibl_bench_check_output(b, p);
}

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
    const ibl_bench_list *lists = b->opts->lists;

    b->base[IBL_BENCH_METHOD] =
        find_base(&lists[IBL_BENCH_METHOD], IBL_BENCH_AUTO);
    b->base[IBL_BENCH_SAMPLES] =
        find_base(&lists[IBL_BENCH_SAMPLES], o.samples);
    b->base[IBL_BENCH_SIZE] = find_base(&lists[IBL_BENCH_SIZE], o.size);
    b->base[IBL_BENCH_THREADS] =
        find_base(&lists[IBL_BENCH_THREADS], ibl_cpu_count());
    b->base[IBL_BENCH_ISA] =
        find_base(&lists[IBL_BENCH_ISA], (int)ibl_isa_best());
}

/* Whether a bake would be the same as with other samples, and is not the one
 * that stands for all. */
static bool is_again(const ibl_bench_point *p, const ibl_bench_point *base)
{
    return !ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]) &&
           p->at[IBL_BENCH_SAMPLES] != base->at[IBL_BENCH_SAMPLES];
}

/* One axis at a time; samples for every method that takes them. */
static bool plan_sweeps(ibl_bench *b, const ibl_bench_point *base)
{
    const ibl_bench_list *lists = b->opts->lists;
    const ibl_bench_list *methods = &lists[IBL_BENCH_METHOD];
    bool ok = true;

    for (int m = 0; m < methods->count; m++)
        for (int i = 0; i < lists[IBL_BENCH_SAMPLES].count && ok; i++) {
            ibl_bench_point p = *base;
            p.at[IBL_BENCH_METHOD] = methods->values[m];
            p.at[IBL_BENCH_SAMPLES] = lists[IBL_BENCH_SAMPLES].values[i];
            if (is_again(&p, base))
                continue;
            if (ibl_bench_takes_samples(p.at[IBL_BENCH_METHOD]))
                p.sweeps = 1u << IBL_BENCH_SAMPLES;
            if (p.at[IBL_BENCH_SAMPLES] == base->at[IBL_BENCH_SAMPLES])
                p.sweeps |= 1u << IBL_BENCH_METHOD;
            ok = keep(b, &p);
        }
    for (int axis = IBL_BENCH_SIZE; axis < IBL_BENCH_SOURCE; axis++)
        for (int i = 0; i < lists[axis].count && ok; i++) {
            ibl_bench_point p = *base;
            p.at[axis] = lists[axis].values[i];
            p.sweeps = 1u << axis;
            ok = keep(b, &p);
        }
    return ok;
}

static bool plan_product(ibl_bench *b, const ibl_bench_point *base)
{
    const ibl_bench_list *lists = b->opts->lists;
    int at[IBL_BENCH_SOURCE] = {0};
    bool ok = true;

    while (ok) {
        ibl_bench_point p = *base;
        int axis = 0;
        for (int i = 0; i < IBL_BENCH_SOURCE; i++)
            p.at[i] = lists[i].values[at[i]];
        for (int i = 0; i < IBL_BENCH_SOURCE; i++) {
            bool others = true;
            for (int j = 0; j < IBL_BENCH_SOURCE; j++)
                others &= j == i || p.at[j] == base->at[j] ||
                          (i == IBL_BENCH_SAMPLES && j == IBL_BENCH_METHOD);
            p.sweeps |= others ? 1u << i : 0;
        }
        if (!ibl_bench_takes_samples(p.at[IBL_BENCH_METHOD]))
            p.sweeps &= ~(1u << IBL_BENCH_SAMPLES);
        ok = is_again(&p, base) || keep(b, &p);
        while (axis < IBL_BENCH_SOURCE && ++at[axis] == lists[axis].count)
            at[axis++] = 0;
        if (axis == IBL_BENCH_SOURCE)
            return ok;
    }
    return false;
}

/* Of the source with this index, which is an environment as it is. */
static bool plan_env(ibl_bench *b, int source)
{
    ibl_bench_point base = {.kind = IBL_BENCH_BAKE, .source = source};
    const int env = b->sources[source].env;
    bool ok;

    memcpy(base.at, b->base, sizeof base.at);
    ok = b->opts->full ? plan_product(b, &base) : plan_sweeps(b, &base);
    for (int s = 0; s < b->source_count && ok; s++)
        if (b->sources[s].env == env && b->sources[s].resampled) {
            ibl_bench_point p = base;
            p.source = s;
            p.sweeps = 1u << IBL_BENCH_SOURCE;
            ok = keep(b, &p);
        }
    for (int i = 0; i < b->opts->variants.count && ok; i++) {
        ibl_bench_point p = base;
        p.kind = IBL_BENCH_VARIANT;
        p.index = i;
        ok = keep(b, &p);
    }
    for (int i = 0; i < b->opts->peers.count && ok; i++) {
        ibl_bench_point p = base;
        p.kind = IBL_BENCH_PEER;
        p.index = i;
        for (int axis = 0; axis < IBL_BENCH_AXES; axis++)
            p.at[axis] = -1;
        ok = keep(b, &p);
    }
    return ok;
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
