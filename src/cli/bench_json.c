/* SPDX-License-Identifier: MIT */
/* Everything that was measured, for programs. */
#include <math.h>

#include "cli/bench.h"
#include "cli/json_text.h"

/* Builds; notes a failure for the end. */
typedef struct builder {
    const ibl_bench *b;
    bool failed;
} builder;

static void put(builder *s, json_t *object, const char *key, json_t *value)
{
    s->failed |= !value || json_object_set_new(object, key, value);
}

static void append(builder *s, json_t *array, json_t *value)
{
    s->failed |= !value || json_array_append_new(array, value);
}

/* null for what is no number. */
static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *machine(builder *s)
{
    const ibl_bench_machine *m = &s->b->machine;
    json_t *j = json_object();

    put(s, j, "cpu", ibl_json_string(m->cpu));
    put(s, j, "cpus", json_integer(m->cpus));
    put(s, j, "online_cpus", json_integer(m->online_cpus));
    put(s, j, "memory_bytes", json_integer((json_int_t)m->memory_bytes));
    put(s, j, "system", ibl_json_string(m->system));
    put(s, j, "compiler", ibl_json_string(m->compiler));
    put(s, j, "load", m->load < 0 ? json_null() : json_real(m->load));
    return j;
}

static json_t *stat_of(builder *s, const ibl_bench_stat *stat,
                       const double *values)
{
    json_t *j = json_object(), *rounds = json_array();

    put(s, j, "median", number(stat->median));
    put(s, j, "q1", number(stat->low));
    put(s, j, "q3", number(stat->high));
    for (int i = 0; i < s->b->opts->rounds; i++)
        append(s, rounds, number(values[i]));
    put(s, j, "rounds", rounds);
    return j;
}

static json_t *levels(builder *s, const ibl_bench_point *p)
{
    json_t *j = json_array();

    for (int i = 0; i < p->level_count; i++) {
        const ibl_bench_level *l = &p->level[i];
        json_t *level = json_object();
        put(s, level, "content", json_string(l->content));
        put(s, level, "level", json_integer(l->level));
        put(s, level, "size", json_integer(l->size));
        put(s, level, "roughness", number(l->roughness));
        put(s, level, "nrmse", number(l->nrmse));
        put(s, level, "median", number(l->median));
        put(s, level, "p95", number(l->p95));
        put(s, level, "worst", number(l->worst));
        put(s, level, "bias", number(l->bias));
        append(s, j, level);
    }
    return j;
}

static void put_settings(builder *s, json_t *j, const ibl_bench_point *p)
{
    json_t *sweeps = json_array();

    put(s, j, "method",
        json_string(ibl_bench_method_name(p->at[IBL_BENCH_METHOD])));
    if (ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]))
        put(s, j, "samples", json_integer(p->at[IBL_BENCH_SAMPLES]));
    put(s, j, "size", json_integer(p->at[IBL_BENCH_SIZE]));
    put(s, j, "threads", json_integer(p->at[IBL_BENCH_THREADS]));
    put(s, j, "isa", json_string(ibl_isa_name((ibl_isa)p->at[IBL_BENCH_ISA])));
    for (int axis = 0; axis < IBL_BENCH_AXES; axis++)
        if (p->sweeps & 1u << axis)
            append(s, sweeps,
                   json_string(ibl_bench_axis_name((ibl_bench_axis)axis)));
    put(s, j, "sweeps", sweeps);
}

static json_t *point(builder *s, const ibl_bench_point *p)
{
    static const char *const kinds[] = {"bake", "variant", "peer"};
    const ibl_bench_source *source = &s->b->sources[p->source];
    json_t *j = json_object(), *command = json_array();
    json_t *stages = json_object();

    put(s, j, "name", ibl_json_string(p->name));
    put(s, j, "kind", json_string(kinds[p->kind]));
    put(s, j, "env", ibl_json_string(s->b->opts->envs[source->env]));
    put(s, j, "source",
        json_pack("{s:i,s:i,s:b}", "width", source->width, "height",
                  source->height, "resampled", source->resampled));
    if (p->kind == IBL_BENCH_BAKE)
        put_settings(s, j, p);
    for (char **word = p->argv; *word; word++)
        append(s, command, ibl_json_string(*word));
    put(s, j, "command", command);
    put(s, j, "wall_s", stat_of(s, &p->wall, p->wall_s));
    put(s, j, "cpu_s", stat_of(s, &p->cpu, p->cpu_s));
    put(s, j, "peak_bytes", json_integer((json_int_t)p->peak_bytes));
    put(s, j, "output_bytes", json_integer((json_int_t)p->output_bytes));
    for (int i = 0; i < p->stage_count; i++)
        put(s, stages, p->stages[i].name,
            stat_of(s, &p->stages[i].stat, p->stages[i].seconds));
    put(s, j, "stages_s", stages);
    if (p->judged) {
        put(s, j, "error", number(p->error));
        put(s, j, "worst_p95", number(p->worst_p95));
        put(s, j, "front", json_boolean(p->pareto));
        put(s, j, "levels", levels(s, p));
    }
    return j;
}

char *ibl_bench_json(const ibl_bench *b)
{
    builder s = {.b = b};
    json_t *root = json_object(), *points = json_array();
    char *text = NULL;

    put(&s, root, "generator", json_string("iblbake bench " IBL_VERSION));
    put(&s, root, "revision", ibl_json_string(b->machine.revision));
    put(&s, root, "date", json_string(b->machine.date));
    put(&s, root, "machine", machine(&s));
    put(&s, root, "rounds", json_integer(b->opts->rounds));
    put(&s, root, "seconds", json_real(b->seconds));
    put(&s, root, "error",
        json_string("root mean square of the nRMSE of the specular levels "
                    "with roughness above 0, against <ibl/reference.h>"));
    for (int i = 0; i < b->point_count; i++)
        append(&s, points, point(&s, &b->points[i]));
    put(&s, root, "points", points);
    if (!s.failed)
        text = ibl_json_text(root);
    json_decref(root);
    return text;
}
