/* SPDX-License-Identifier: MIT */
#include "cli/bench_plots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- building -------------------------------------------------------- */

/* A new series; NULL, with nothing changed, if there is no memory. The last
 * one that was added stays where it is until the next. */
static ibl_plot_series *add_series(ibl_plot *plot, const char *name, int style)
{
    ibl_plot_series *series =
        realloc(plot->series, (size_t)(plot->count + 1) * sizeof *series);

    if (!series)
        return NULL;
    plot->series = series;
    series += plot->count++;
    *series = (ibl_plot_series){.style = style};
    snprintf(series->name, sizeof series->name, "%s", name);
    return series;
}

static ibl_plot_point *add_point(ibl_plot_series *s, double x, double y)
{
    ibl_plot_point *points =
        s ? realloc(s->points, (size_t)(s->count + 1) * sizeof *points) : NULL;

    if (!points)
        return NULL;
    s->points = points;
    points += s->count++;
    *points = (ibl_plot_point){.x = x, .y = y};
    return points;
}

void ibl_bench_plot_free(ibl_plot *plot)
{
    for (int i = 0; i < plot->count; i++)
        free(plot->series[i].points);
    free(plot->series);
    *plot = (ibl_plot){0};
}

static int by_x(const void *a, const void *b)
{
    const ibl_plot_point *p = a, *q = b;
    return (p->x > q->x) - (p->x < q->x);
}

static void sort(ibl_plot_series *s)
{
    if (s && s->count)
        qsort(s->points, (size_t)s->count, sizeof *s->points, by_x);
}

/* Without series where all have fewer points than a picture needs: then the
 * axes alone are left. */
static ibl_plot finished(ibl_plot plot, int least)
{
    const ibl_plot axes = {.title = plot.title, .x = plot.x, .y = plot.y};
    int most = 0;

    for (int i = 0; i < plot.count; i++)
        if (plot.series[i].count > most)
            most = plot.series[i].count;
    if (most >= least)
        return plot;
    ibl_bench_plot_free(&plot);
    return axes;
}

bool ibl_bench_is_of(const ibl_bench *b, const ibl_bench_point *p, int source)
{
    return b->sources[p->source].env == b->sources[source].env;
}

/* ---- error against time ---------------------------------------------- */

static void add_rival(ibl_plot_series *s, const ibl_bench_point *p)
{
    ibl_plot_point *at = add_point(s, p->wall.median, p->error);

    if (!at)
        return;
    at->x_low = p->wall.low;
    at->x_high = p->wall.high;
    at->ring = p->pareto;
    if (p->kind == IBL_BENCH_BAKE &&
        ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]))
        snprintf(at->label, sizeof at->label, "%d", p->at[IBL_BENCH_SAMPLES]);
    else
        snprintf(at->label, sizeof at->label, "%.*s", (int)sizeof at->label - 1,
                 p->name);
}

static void add_front(ibl_plot *plot, const ibl_bench *b, int source)
{
    ibl_plot_series *s = add_series(plot, "Pareto front", 5);

    if (!s)
        return;
    s->dashed = true;
    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        if (p->source == source && p->pareto)
            add_point(s, p->wall.median, p->error);
    }
    sort(s);
}

ibl_plot ibl_bench_plot_error(const ibl_bench *b, int source)
{
    ibl_plot plot = {
        .title = "Error against time",
        .ring = "nothing is faster and better",
        .x = {.label = "time of the whole process (median, quartiles)",
              .unit = IBL_PLOT_SECONDS,
              .log = true},
        .y = {.label = "nRMSE, levels with r > 0",
              .unit = IBL_PLOT_PERCENT,
              .log = true}};
    int style = 0;

    for (int m = 0; m < IBL_BENCH_METHODS; m++) {
        char name[64];
        ibl_plot_series *s = NULL;
        snprintf(name, sizeof name, "%s%s", ibl_bench_method_name(m),
                 ibl_bench_takes_samples(m) ? ", by samples" : "");
        for (int i = 0; i < b->point_count; i++) {
            const ibl_bench_point *p = &b->points[i];
            if (p->source != source || p->kind != IBL_BENCH_BAKE ||
                p->at[IBL_BENCH_METHOD] != m || !ibl_bench_is_rival(b, p))
                continue;
            if (!s)
                s = add_series(&plot, name, style++);
            if (s)
                s->line = true;
            add_rival(s, p);
        }
    }
    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        if (p->source == source && p->kind != IBL_BENCH_BAKE &&
            ibl_bench_is_rival(b, p))
            add_rival(add_series(&plot, p->name, style++), p);
    }
    if (plot.count)
        add_front(&plot, b, source);
    return finished(plot, 1);
}

/* ---- error against roughness ----------------------------------------- */

static bool shows_levels(const ibl_bench *b, const ibl_bench_point *p,
                         int source)
{
    if (p->source != source || !ibl_bench_is_rival(b, p))
        return false;
    return p->kind != IBL_BENCH_BAKE ||
           p->at[IBL_BENCH_METHOD] == b->base[IBL_BENCH_METHOD] ||
           p->at[IBL_BENCH_SAMPLES] == b->base[IBL_BENCH_SAMPLES];
}

ibl_plot ibl_bench_plot_roughness(const ibl_bench *b, int source)
{
    ibl_plot plot = {.title = "Error against roughness",
                     .x = {.label = "perceptual roughness of the level",
                           .low = -0.02,
                           .high = 1.02},
                     .y = {.label = "nRMSE of the level",
                           .unit = IBL_PLOT_PERCENT,
                           .log = true}};
    int style = 0;

    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        ibl_plot_series *s;
        if (!shows_levels(b, p, source))
            continue;
        s = add_series(&plot, p->name, style++);
        if (!s)
            break;
        s->line = true;
        for (int k = 0; k < p->level_count; k++)
            if (!strcmp(p->level[k].content, "specular"))
                add_point(s, p->level[k].roughness, p->level[k].nrmse);
    }
    return finished(plot, 2);
}

/* ---- time against something ------------------------------------------ */

static double axis_value(const ibl_bench *b, const ibl_bench_point *p,
                         ibl_bench_axis axis)
{
    return axis == IBL_BENCH_SOURCE ? b->sources[p->source].width : p->at[axis];
}

/* With the base's method; where that takes no samples, those of sampled. */
static bool sweeps(const ibl_bench *b, const ibl_bench_point *p, int source,
                   ibl_bench_axis axis)
{
    int method = b->base[IBL_BENCH_METHOD];

    if (axis == IBL_BENCH_SAMPLES && !ibl_bench_takes_samples(method))
        method = IBL_BENCH_SAMPLED;
    return ibl_bench_is_of(b, p, source) && p->kind == IBL_BENCH_BAKE &&
           (p->sweeps & 1u << axis) && p->at[IBL_BENCH_METHOD] == method;
}

/* The part of the whole time that a group has where it has most. */
static double largest_part(const ibl_bench *b, int source, ibl_bench_axis axis,
                           const char *group)
{
    double part = 0;

    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        if (sweeps(b, p, source, axis))
            part =
                fmax(part, ibl_bench_group_seconds(p, group) / p->wall.median);
    }
    return part;
}

static void add_times(ibl_plot *plot, const ibl_bench *b, int source,
                      ibl_bench_axis axis, const char *group, int style)
{
    ibl_plot_series *s =
        add_series(plot, group ? group : "whole process", style);

    for (int i = 0; s && i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        ibl_plot_point *at;
        if (!sweeps(b, p, source, axis))
            continue;
        at = add_point(s, axis_value(b, p, axis),
                       group ? ibl_bench_group_seconds(p, group)
                             : p->wall.median);
        if (at && !group) {
            at->y_low = p->wall.low;
            at->y_high = p->wall.high;
        }
    }
    sort(s);
    if (s)
        s->line = true;
}

/* What the time were if every thread counted. */
static void add_ideal(ibl_plot *plot)
{
    ibl_plot_series *s = add_series(plot, "whole / threads", 0);
    const ibl_plot_series *whole = plot->series;

    if (!s)
        return;
    s->dashed = true;
    for (int i = 0; i < whole->count; i++)
        add_point(s, whole->points[i].x,
                  whole->points[0].y * whole->points[0].x / whole->points[i].x);
}

ibl_plot ibl_bench_plot_axis(const ibl_bench *b, int source,
                             ibl_bench_axis axis)
{
    static const char *const labels[] = {"",
                                         "samples for each texel",
                                         "edge of the largest level, texels",
                                         "threads",
                                         "",
                                         "width of the map, pixels"};
    static const char *const titles[] = {"",
                                         "Time against samples",
                                         "Time against output size",
                                         "Time against threads",
                                         "",
                                         "Time against source size"};
    ibl_plot plot = {
        .title = titles[axis],
        .x = {.label = labels[axis], .log = true, .at_values = true},
        .y = {.label = "time (median)", .unit = IBL_PLOT_SECONDS, .log = true}};
    char groups[IBL_BENCH_STAGES][32];
    const int count = ibl_bench_groups(b, groups, IBL_BENCH_STAGES);

    add_times(&plot, b, source, axis, NULL, 0);
    for (int i = 0; i < count && plot.count < IBL_PLOT_COLOURS; i++)
        if (largest_part(b, source, axis, groups[i]) > 0.02)
            add_times(&plot, b, source, axis, groups[i], i);
    if (axis == IBL_BENCH_THREADS && plot.count)
        add_ideal(&plot);
    return finished(plot, 2);
}
