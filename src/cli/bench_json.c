/* SPDX-License-Identifier: MIT */
/* Everything that was measured, for programs. */
#include <math.h>

#include "cli/bench.h"
#include "cli/json_put.h"
#include "cli/json_text.h"

/* null for what is no number. */
static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *machine(const ibl_bench *b)
{
    const ibl_bench_machine *m = &b->machine;
    json_t *j = json_object();

    put(&j, "cpu", ibl_json_string(m->cpu));
    put(&j, "cpus", json_integer(m->cpus));
    put(&j, "online_cpus", json_integer(m->online_cpus));
    put(&j, "memory_bytes", json_integer((json_int_t)m->memory_bytes));
    put(&j, "system", ibl_json_string(m->system));
    put(&j, "compiler", ibl_json_string(m->compiler));
    put(&j, "load", m->load < 0 ? json_null() : json_real(m->load));
    return j;
}

static json_t *stat_of(const ibl_bench *b, const ibl_bench_stat *stat,
                       const double *values)
{
    json_t *j = json_object(), *rounds = json_array();

    put(&j, "median", number(stat->median));
    put(&j, "q1", number(stat->low));
    put(&j, "q3", number(stat->high));
    for (int i = 0; i < b->opts->rounds; i++)
        append(&rounds, number(values[i]));
    put(&j, "rounds", rounds);
    return j;
}

static json_t *levels(const ibl_bench_point *p)
{
    json_t *j = json_array();

    for (int i = 0; i < p->level_count; i++) {
        const ibl_bench_level *l = &p->level[i];
        json_t *level = json_object();
        put(&level, "content", json_string(l->content));
        put(&level, "level", json_integer(l->level));
        put(&level, "size", json_integer(l->size));
        put(&level, "roughness", number(l->roughness));
        put(&level, "nrmse", number(l->nrmse));
        put(&level, "median", number(l->median));
        put(&level, "p95", number(l->p95));
        put(&level, "worst", number(l->worst));
        put(&level, "bias", number(l->bias));
        append(&j, level);
    }
    return j;
}

static void put_settings(json_t **j, const ibl_bench_point *p)
{
    json_t *sweeps = json_array();

    put(j, "method",
        json_string(ibl_bench_method_name(p->at[IBL_BENCH_METHOD])));
    if (ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]))
        put(j, "samples", json_integer(p->at[IBL_BENCH_SAMPLES]));
    put(j, "size", json_integer(p->at[IBL_BENCH_SIZE]));
    put(j, "threads", json_integer(p->at[IBL_BENCH_THREADS]));
    put(j, "isa", json_string(ibl_isa_name((ibl_isa)p->at[IBL_BENCH_ISA])));
    for (int axis = 0; axis < IBL_BENCH_AXES; axis++)
        if (p->sweeps & 1u << axis)
            append(&sweeps,
                   json_string(ibl_bench_axis_name((ibl_bench_axis)axis)));
    put(j, "sweeps", sweeps);
}

static json_t *point(const ibl_bench *b, const ibl_bench_point *p)
{
    static const char *const kinds[] = {"bake", "variant", "peer"};
    const ibl_bench_source *source = &b->sources[p->source];
    json_t *j = json_object(), *command = json_array();
    json_t *stages = json_object();

    put(&j, "name", ibl_json_string(p->name));
    put(&j, "kind", json_string(kinds[p->kind]));
    put(&j, "base", json_boolean(p->base));
    put(&j, "special", json_boolean(ibl_bench_is_special(b, p)));
    put(&j, "rival", json_boolean(ibl_bench_is_rival(b, p)));
    put(&j, "env", ibl_json_string(b->opts->envs[source->env]));
    put(&j, "source",
        json_pack("{s:i,s:i,s:b}", "width", source->width, "height",
                  source->height, "resampled", source->resampled));
    if (p->kind == IBL_BENCH_BAKE)
        put_settings(&j, p);
    for (char **word = p->argv; *word; word++)
        append(&command, ibl_json_string(*word));
    put(&j, "command", command);
    put(&j, "wall_s", stat_of(b, &p->wall, p->wall_s));
    put(&j, "cpu_s", stat_of(b, &p->cpu, p->cpu_s));
    put(&j, "peak_bytes", json_integer((json_int_t)p->peak_bytes));
    put(&j, "output_bytes", json_integer((json_int_t)p->output_bytes));
    for (int i = 0; i < p->stage_count; i++)
        put(&stages, p->stages[i].name,
            stat_of(b, &p->stages[i].stat, p->stages[i].seconds));
    put(&j, "stages_s", stages);
    if (p->judged) {
        put(&j, "error", number(p->error));
        put(&j, "worst_p95", number(p->worst_p95));
        put(&j, "front", json_boolean(p->pareto));
        put(&j, "levels", levels(p));
    }
    return j;
}

char *ibl_bench_json(const ibl_bench *b)
{
    json_t *root = json_object(), *points = json_array();

    put(&root, "generator", json_string("iblbake bench " IBL_VERSION));
    put(&root, "revision", ibl_json_string(b->machine.revision));
    put(&root, "date", json_string(b->machine.date));
    put(&root, "machine", machine(b));
    put(&root, "rounds", json_integer(b->opts->rounds));
    put(&root, "seconds", json_real(b->seconds));
    put(&root, "error",
        json_string("root mean square of the nRMSE of the specular levels "
                    "with roughness above 0, against <ibl/reference.h>"));
    for (int i = 0; i < b->point_count; i++)
        append(&points, point(b, &b->points[i]));
    put(&root, "points", points);
    char *text = ibl_json_text(root);
    json_decref(root);
    return text;
}
