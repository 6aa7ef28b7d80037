/* SPDX-License-Identifier: MIT */
/* All measurements for programs: JSON, CSV, and a page that draws the JSON. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"
#include "json/json_text.h"
#include "json/text.h"

/* ---- JSON ------------------------------------------------------------ */

static json_t *series(const ibl_bench_series *s, int rounds)
{
    json_t *values = json_array();

    for (int i = 0; i < rounds; i++)
        append(&values, json_real(s->rounds[i]));
    return json_pack("{sf sf sf so}", "median", s->median, "q1", s->low, "q3",
                     s->high, "rounds", values);
}

static void put_settings(json_t **j, const ibl_bench_point *p)
{
    json_t *sweeps = json_array();

    for (int axis = 0; axis < IBL_BENCH_SOURCE; axis++) {
        char text[32];
        ibl_bench_value(axis, p->at[axis], text, sizeof text);
        if (axis == IBL_BENCH_METHOD || axis == IBL_BENCH_ISA)
            put(j, ibl_bench_axis_name(axis), json_string(text));
        else if (axis != IBL_BENCH_SAMPLES ||
                 ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]))
            put(j, ibl_bench_axis_name(axis), json_integer(p->at[axis]));
    }
    for (int axis = 0; axis < IBL_BENCH_AXES; axis++)
        if (p->sweeps & 1u << axis)
            append(&sweeps, json_string(ibl_bench_axis_name(axis)));
    put(j, "sweeps", sweeps);
}

static json_t *point(const ibl_bench *b, const ibl_bench_point *p)
{
    const ibl_bench_source *source = &b->sources[p->source];
    const int rounds = b->opts->rounds;
    json_t *command = json_array(), *stages = json_object();

    for (char **word = p->argv; *word; word++)
        append(&command, ibl_json_string(*word));
    for (int i = IBL_BENCH_STAGES; i < p->series_count; i++)
        put(&stages, p->series[i].name, series(&p->series[i], rounds));
    json_t *j = json_pack(
        "{so ss sb sb sb so s{si si sb}}", "name", ibl_json_string(p->name),
        "kind", ibl_bench_kind_names[p->kind], "base", p->base, "special",
        ibl_bench_is_special(b, p), "rival", ibl_bench_is_rival(b, p), "env",
        ibl_json_string(b->opts->envs[source->env]), "source", "width",
        source->width, "height", source->height, "resampled",
        source->resampled);
    if (p->kind == IBL_BENCH_BAKE)
        put_settings(&j, p);
    put(&j, "command", command);
    put(&j, "wall_s", series(&p->series[IBL_BENCH_WALL_S], rounds));
    put(&j, "cpu_s", series(&p->series[IBL_BENCH_CPU_S], rounds));
    put(&j, "peak_bytes",
        json_integer((json_int_t)p->series[IBL_BENCH_PEAK_BYTES].median));
    put(&j, "output_bytes", json_integer((json_int_t)p->output_bytes));
    if (p->specular_bytes) {
        put(&j, "specular_bytes", json_integer((json_int_t)p->specular_bytes));
        put(&j, "pixel_error", ibl_json_pixel_error(&p->loss));
    }
    put(&j, "stages_s", stages);
    if (p->judged) {
        put(&j, "error", json_real(p->error));
        put(&j, "worst_p95", json_real(p->worst_p95));
        put(&j, "whole_error", json_real(p->whole_error));
        put(&j, "front", json_boolean(p->pareto));
        put(&j, "levels", json_incref(p->levels));
    }
    if (p->rendered_rows) {
        put(&j, "rendered", json_real(p->rendered));
        put(&j, "rendered_rows", json_incref(p->rendered_rows));
    }
    return j;
}

json_t *ibl_bench_document(const ibl_bench *b)
{
    json_t *points = json_array();

    for (int i = 0; i < b->point_count; i++)
        append(&points, point(b, &b->points[i]));
    return json_pack(
        "{ss so ss so si sf ss so}", "generator", "iblbake bench " IBL_VERSION,
        "revision", ibl_json_string(ibl_version_revision()), "date", b->date,
        "machine", json_incref(b->machine), "rounds", b->opts->rounds,
        "seconds", b->seconds, "error",
        "root mean square of the nRMSE of the specular levels with roughness "
        "above 0, against <ibl/reference.h>",
        "points", points);
}

/* ---- HTML ------------------------------------------------------------ */

/* Generated from bench_page.html by the build. */
extern const char ibl_bench_page[];

/* Writes JSON for a script element: escapes whatever would end the element. */
static void put_json(const char *json, FILE *to)
{
    for (; *json; json++)
        if (*json == '<')
            fputs("\\u003c", to);
        else
            fputc(*json, to);
}

char *ibl_bench_html(const json_t *document)
{
    static const char marker[] = "@JSON@";
    const char *place = strstr(ibl_bench_page, marker);
    char *json = ibl_json_text(document);
    ibl_memory_file page;
    FILE *to = json ? ibl_memory_open(&page) : NULL;

    if (to) {
        fwrite(ibl_bench_page, 1, (size_t)(place - ibl_bench_page), to);
        put_json(json, to);
        fputs(place + sizeof marker - 1, to);
    }
    free(json);
    return ibl_memory_close(to, &page);
}

/* ---- CSV ------------------------------------------------------------- */

/* A column: its name, and the member of a point, or part of it, it shows. */
static const struct {
    const char *name, *member, *part;
} columns[] = {
    {"env", "env", NULL},
    {"source_width", "source", "width"},
    {"source_height", "source", "height"},
    {"name", "name", NULL},
    {"kind", "kind", NULL},
    {"method", "method", NULL},
    {"samples", "samples", NULL},
    {"size", "size", NULL},
    {"threads", "threads", NULL},
    {"isa", "isa", NULL},
    {"sweeps", "sweeps", NULL},
    {"rounds", "wall_s", "rounds"},
    {"wall_s", "wall_s", "median"},
    {"wall_q1_s", "wall_s", "q1"},
    {"wall_q3_s", "wall_s", "q3"},
    {"cpu_s", "cpu_s", "median"},
    {"peak_bytes", "peak_bytes", NULL},
    {"output_bytes", "output_bytes", NULL},
    {"specular_bytes", "specular_bytes", NULL},
    {"pixel_nrmse", "pixel_error", "nrmse"},
    {"pixel_relative", "pixel_error", "relative"},
    {"whole_error", "whole_error", NULL},
};

/* The columns for a level, after those for the stages and "front". */
static const char *const members[] = {"content", "level",  "size", "roughness",
                                      "nrmse",   "median", "p95",  "worst",
                                      "bias",    "f0"};

enum {
    COLUMNS = sizeof columns / sizeof *columns,
    MEMBERS = sizeof members / sizeof *members
};

/* Collects the stages of all points, keeping each point's order where possible.
 * Returns their number. */
static int find_stages(const json_t *points, const char **names, int most)
{
    const json_t *point;
    int count = 0;
    size_t i;

    json_array_foreach((json_t *)points, i, point)
    {
        const char *stage;
        json_t *seconds;
        int next = 0;
        json_object_foreach(json_object_get(point, "stages_s"), stage, seconds)
        {
            int at = 0;
            while (at < count && strcmp(names[at], stage) != 0)
                at++;
            if (at == count && count == most)
                continue;
            if (at == count) {
                at = next;
                memmove(names + at + 1, names + at,
                        (size_t)(count++ - at) * sizeof *names);
                names[at] = stage;
            }
            next = at + 1;
        }
    }
    return count;
}

static void put_text(const char *text, FILE *to)
{
    if (!strpbrk(text, ",\"\n\r")) {
        fputs(text, to);
        return;
    }
    fputc('"', to);
    for (; *text; text++) {
        if (*text == '"')
            fputc('"', to);
        fputc(*text, to);
    }
    fputc('"', to);
}

/* Writes a field and its end character; null and missing values are empty. */
static void put_field(const json_t *value, char end, FILE *to)
{
    if (json_is_string(value))
        put_text(json_string_value(value), to);
    else if (json_is_boolean(value))
        fputc(json_is_true(value) ? '1' : '0', to);
    else if (json_is_integer(value))
        fprintf(to, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
    else if (json_is_real(value))
        fprintf(to, "%.9g", json_real_value(value));
    else if (json_is_real(json_array_get(value, 0)))
        fprintf(to, "%zu", json_array_size(value));
    else
        for (size_t i = 0; i < json_array_size(value); i++)
            fprintf(to, "%s%s", i ? " " : "",
                    json_string_value(json_array_get(value, i)));
    fputc(end, to);
}

/* Writes a line: a point with one of its levels. */
static void put_line(const json_t *point, const json_t *level,
                     const char **stages, int count, FILE *to)
{
    const json_t *seconds = json_object_get(point, "stages_s");

    for (int i = 0; i < COLUMNS; i++) {
        const json_t *value = json_object_get(point, columns[i].member);
        put_field(columns[i].part ? json_object_get(value, columns[i].part)
                                  : value,
                  ',', to);
    }
    for (int i = 0; i < count; i++)
        put_field(
            json_object_get(json_object_get(seconds, stages[i]), "median"), ',',
            to);
    put_field(json_object_get(point, "front"), ',', to);
    for (int i = 0; i < MEMBERS; i++)
        put_field(json_object_get(level, members[i]),
                  i + 1 < MEMBERS ? ',' : '\n', to);
}

/* Writes the lines of a point: one for all its levels, then one for each, and
 * one for each roughness and F0 that was rendered. */
static bool put_point(const json_t *point, const char **stages, int count,
                      FILE *to)
{
    const json_t *levels = json_object_get(point, "levels"), *level;
    const json_t *rows = json_object_get(point, "rendered_rows");
    json_t *all = json_pack("{ss sO* sO*}", "content", "all", "nrmse",
                            json_object_get(point, "error"), "p95",
                            json_object_get(point, "worst_p95"));
    size_t i;

    if (!all)
        return false;
    put_line(point, all, stages, count, to);
    json_array_foreach((json_t *)levels, i, level)
    {
        put_line(point, level, stages, count, to);
    }
    json_array_foreach((json_t *)rows, i, level)
    {
        put_line(point, level, stages, count, to);
    }
    json_decref(all);
    return true;
}

char *ibl_bench_csv(const json_t *document)
{
    const json_t *points = json_object_get(document, "points"), *point;
    const char *stages[IBL_BENCH_SERIES];
    const int count = find_stages(points, stages, IBL_BENCH_SERIES);
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);
    bool ok = to;
    size_t i;

    for (int k = 0; k < COLUMNS && ok; k++)
        fprintf(to, "%s,", columns[k].name);
    for (int k = 0; k < count && ok; k++)
        fprintf(to, "%s_s,", stages[k]);
    if (ok)
        fputs("front,content,level,level_size,roughness,nrmse,median,p95,"
              "worst,bias,f0\n",
              to);
    json_array_foreach((json_t *)points, i, point)
    {
        ok = ok && put_point(point, stages, count, to);
    }
    char *text = ibl_memory_close(to, &file);
    if (ok)
        return text;
    free(text);
    return NULL;
}
