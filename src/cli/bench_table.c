/* SPDX-License-Identifier: MIT */
/* The table for people, and the one for programs. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"
#include "common/memory_file.h"

static const char *file_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

static void print_machine(const ibl_bench *b, FILE *to)
{
    const ibl_bench_machine *m = &b->machine;

    fprintf(to, "%s, %d of %d CPUs, %.1f GiB; %s\n", m->cpu, m->cpus,
            m->online_cpus, m->memory_bytes / (1 << 30), m->system);
    fprintf(to, "iblbake %s%s%s, %s; %s", IBL_VERSION, *m->revision ? " " : "",
            m->revision, m->compiler, m->date);
    if (m->load >= 0)
        fprintf(to, ", load %.1f at the start", m->load);
    fprintf(to,
            "\n%d rounds in turns in %.0f s, after one that is not "
            "counted\n",
            b->opts->rounds, b->seconds);
}

static void print_point(const ibl_bench_point *p, int width, FILE *to)
{
    char quartiles[48];

    snprintf(quartiles, sizeof quartiles, "%.1f-%.1f", 1e3 * p->wall.low,
             1e3 * p->wall.high);
    fprintf(to, "%c%-*s %9.1f %17s %9.1f %8.1f", p->pareto ? '*' : ' ', width,
            p->name, 1e3 * p->wall.median, quartiles, 1e3 * p->cpu.median,
            (double)p->peak_bytes / (1 << 20));
    if (p->judged)
        fprintf(to, " %9.3g %9.3g", 100 * p->error, 100 * p->worst_p95);
    fputc('\n', to);
}

static void print_level(const ibl_bench_level *l, const char *name, int width,
                        FILE *to)
{
    fprintf(to, " %-*s %-10s", width, name, l->content);
    if (!strcmp(l->content, "lut"))
        fprintf(to, "       rms %.2g, largest %.2g, absolute\n", l->nrmse,
                l->worst);
    else
        fprintf(to, " %5.3f %9.3g %9.3g %9.3g %9.3g %9.2g\n", l->roughness,
                100 * l->nrmse, 100 * l->median, 100 * l->p95, 100 * l->worst,
                100 * l->bias);
}

static void print_levels(const ibl_bench *b, int env, int width, FILE *to)
{
    const ibl_bench_point *named = NULL;
    bool any = false;

    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        if (b->sources[p->source].env != env || !ibl_bench_is_special(b, p))
            continue;
        for (int k = 0; k < p->level_count; k++) {
            /* The mips of a skybox are not what was swept. */
            if (!strcmp(p->level[k].content, "skybox"))
                continue;
            if (!any)
                fprintf(to, "\n %-*s %-10s %5s %9s %9s %9s %9s %9s\n", width,
                        "levels", "", "r", "nRMSE %", "median %", "p95 %",
                        "worst %", "bias %");
            any = true;
            print_level(&p->level[k], named == p ? "" : p->name, width, to);
            named = p;
        }
    }
}

/* Stages downwards: a point has more of them than there are points. */
static void print_stages(const ibl_bench *b, int env, int width, FILE *to)
{
    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        if (b->sources[p->source].env != env || !ibl_bench_is_special(b, p) ||
            !p->stage_count)
            continue;
        fprintf(to, "\n %-*s %-16s %9s %7s\n", width, "stages", "", "ms", "%");
        for (int k = 0; k < p->stage_count; k++)
            fprintf(to, " %-*s %-16s %9.2f %7.1f\n", width, k ? "" : p->name,
                    p->stages[k].name, 1e3 * p->stages[k].stat.median,
                    100 * p->stages[k].stat.median / p->wall.median);
    }
}

void ibl_bench_print(const ibl_bench *b, FILE *to)
{
    int width = 10;

    for (int i = 0; i < b->point_count; i++)
        if ((int)strlen(b->points[i].name) > width)
            width = (int)strlen(b->points[i].name);
    print_machine(b, to);
    for (int s = 0; s < b->source_count; s++) {
        const ibl_bench_source *source = &b->sources[s];
        if (source->resampled)
            continue;
        fprintf(to, "\n%s, %dx%d; base: %s, size %d, %d threads, %s\n",
                file_name(source->path), source->width, source->height,
                ibl_bench_method_name(b->base[IBL_BENCH_METHOD]),
                b->base[IBL_BENCH_SIZE], b->base[IBL_BENCH_THREADS],
                ibl_isa_name((ibl_isa)b->base[IBL_BENCH_ISA]));
        fprintf(to, " %-*s %9s %17s %9s %8s %9s %9s\n", width, "", "time ms",
                "quartiles", "CPU ms", "peak MiB", "error %", "p95 %");
        for (int i = 0; i < b->point_count; i++)
            if (b->sources[b->points[i].source].env == source->env)
                print_point(&b->points[i], width, to);
        print_levels(b, source->env, width, to);
        print_stages(b, source->env, width, to);
    }
    fputs("\nTimes are medians of whole processes. error: root mean square of "
          "the nRMSE of\nthe specular levels with r > 0; p95: the worst of "
          "their 95th percentiles of the\nrelative error. * no other method, "
          "count of samples, variant or peer is faster\nand better.\n",
          to);
}

/* ---- CSV ------------------------------------------------------------- */

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

/* A comma, and the number unless it is NAN. */
static void put_number(double value, FILE *to)
{
    fputc(',', to);
    if (isfinite(value))
        fprintf(to, "%.9g", value);
}

static void put_settings(const ibl_bench *b, const ibl_bench_point *p, FILE *to)
{
    static const char *const kinds[] = {"bake", "variant", "peer"};
    const ibl_bench_source *s = &b->sources[p->source];
    const bool bake = p->kind == IBL_BENCH_BAKE;

    put_text(b->opts->envs[s->env], to);
    fprintf(to, ",%d,%d,", s->width, s->height);
    put_text(p->name, to);
    fprintf(to, ",%s,%s", kinds[p->kind],
            bake ? ibl_bench_method_name(p->at[IBL_BENCH_METHOD]) : "");
    for (int axis = IBL_BENCH_SAMPLES; axis <= IBL_BENCH_THREADS; axis++)
        put_number(bake && (axis != IBL_BENCH_SAMPLES ||
                            ibl_bench_takes_samples(p->at[IBL_BENCH_METHOD]))
                       ? (double)p->at[axis]
                       : (double)NAN,
                   to);
    fprintf(to, ",%s,",
            bake ? ibl_isa_name((ibl_isa)p->at[IBL_BENCH_ISA]) : "");
    for (int axis = 0, n = 0; axis < IBL_BENCH_AXES; axis++)
        if (p->sweeps & 1u << axis)
            fprintf(to, "%s%s", n++ ? " " : "",
                    ibl_bench_axis_name((ibl_bench_axis)axis));
}

static void put_measured(const ibl_bench *b, const ibl_bench_point *p,
                         char stages[][32], int count, FILE *to)
{
    fprintf(to, ",%d", b->opts->rounds);
    put_number(p->wall.median, to);
    put_number(p->wall.low, to);
    put_number(p->wall.high, to);
    put_number(p->cpu.median, to);
    fprintf(to, ",%zu,%zu", p->peak_bytes, p->output_bytes);
    for (int i = 0; i < count; i++)
        put_number(ibl_bench_stage_seconds(p, stages[i]), to);
    fprintf(to, ",%s", !p->judged ? "" : p->pareto ? "1" : "0");
}

static void put_level(const ibl_bench_level *l, FILE *to)
{
    fprintf(to, ",%s,%d,%d", l->content, l->level, l->size);
    put_number(l->roughness, to);
    put_number(l->nrmse, to);
    put_number(l->median, to);
    put_number(l->p95, to);
    put_number(l->worst, to);
    put_number(l->bias, to);
    fputc('\n', to);
}

char *ibl_bench_csv(const ibl_bench *b)
{
    char stages[IBL_BENCH_STAGES][32];
    const int count = ibl_bench_stages(b, stages, IBL_BENCH_STAGES);
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);

    if (!to)
        return NULL;
    fputs("env,source_width,source_height,name,kind,method,samples,size,"
          "threads,isa,sweeps,rounds,wall_s,wall_q1_s,wall_q3_s,cpu_s,"
          "peak_bytes,output_bytes",
          to);
    for (int i = 0; i < count; i++)
        fprintf(to, ",%s_s", stages[i]);
    fputs(",front,content,level,level_size,roughness,nrmse,median,p95,"
          "worst,bias\n",
          to);
    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        put_settings(b, p, to);
        put_measured(b, p, stages, count, to);
        fputs(",all,,,", to);
        put_number(p->judged ? p->error : NAN, to);
        fputc(',', to);
        put_number(p->judged ? p->worst_p95 : NAN, to);
        fputs(",,\n", to);
        for (int k = 0; k < p->level_count; k++) {
            put_settings(b, p, to);
            put_measured(b, p, stages, count, to);
            put_level(&p->level[k], to);
        }
    }
    return ibl_memory_close(to, &file);
}
