/* SPDX-License-Identifier: MIT */
/* The results as a table for people. */
#include <string.h>

#include "cli/bench.h"
#include "common/path.h"

static double number(const json_t *object, const char *key)
{
    return json_number_value(json_object_get(object, key));
}

static void print_machine(const ibl_bench *b, FILE *to)
{
    const char *cpu = "", *system = "", *revision = ibl_version_revision();
    const json_t *load = json_object_get(b->machine, "load");

    json_unpack(b->machine, "{ss ss}", "cpu", &cpu, "system", &system);
    fprintf(to, "%s, %.0f of %.0f CPUs, %.1f GiB; %s\n", cpu,
            number(b->machine, "cpus"), number(b->machine, "online_cpus"),
            number(b->machine, "memory_bytes") / (1 << 30), system);
    fprintf(to, "iblbake %s%s%s, %s; %s", IBL_VERSION, *revision ? " " : "",
            revision, ibl_version_compiler(), b->date);
    if (json_is_real(load))
        fprintf(to, ", load %.1f at the start", json_real_value(load));
    fprintf(to,
            "\n%d rounds in turns in %.0f s, after one that is not "
            "counted\n",
            b->opts->rounds, b->seconds);
}

static void print_point(const ibl_bench_point *p, int width, FILE *to)
{
    const ibl_bench_series *wall = &p->series[IBL_BENCH_WALL_S];
    char quartiles[48];

    snprintf(quartiles, sizeof quartiles, "%.1f-%.1f", 1e3 * wall->low,
             1e3 * wall->high);
    fprintf(to, "%c%-*s %9.1f %17s %9.1f %8.1f", p->pareto ? '*' : ' ', width,
            p->name, 1e3 * wall->median, quartiles,
            1e3 * p->series[IBL_BENCH_CPU_S].median,
            p->series[IBL_BENCH_PEAK_BYTES].median / (1 << 20));
    if (p->judged)
        fprintf(to, " %9.3g %9.3g", 100 * p->error, 100 * p->worst_p95);
    if (p->rendered_rows)
        fprintf(to, " %9.3g", 100 * p->rendered);
    fputc('\n', to);
}

static void print_level(const json_t *l, const char *name, int width, FILE *to)
{
    const char *content = json_string_value(json_object_get(l, "content"));

    fprintf(to, " %-*s %-10s", width, name, content);
    if (!strcmp(content, "lut"))
        fprintf(to, "       rms %.2g, largest %.2g, absolute\n",
                number(l, "nrmse"), number(l, "worst"));
    else
        fprintf(to, " %5.3f %9.3g %9.3g %9.3g %9.3g %9.2g\n",
                number(l, "roughness"), 100 * number(l, "nrmse"),
                100 * number(l, "median"), 100 * number(l, "p95"),
                100 * number(l, "worst"), 100 * number(l, "bias"));
}

static bool is_listed(const ibl_bench *b, const ibl_bench_point *p, int env)
{
    return b->sources[p->source].env == env && ibl_bench_is_special(b, p);
}

static void print_levels(const ibl_bench *b, int env, int width, FILE *to)
{
    bool any = false;

    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        const char *name = p->name;
        for (size_t k = 0; k < json_array_size(p->levels); k++) {
            const json_t *level = json_array_get(p->levels, k);
            const json_t *content = json_object_get(level, "content");
            /* The mips of a skybox do not depend on the swept settings. */
            if (!is_listed(b, p, env) ||
                !strcmp(json_string_value(content), "skybox"))
                continue;
            if (!any)
                fprintf(to, "\n %-*s %-10s %5s %9s %9s %9s %9s %9s\n", width,
                        "levels", "", "r", "nRMSE %", "median %", "p95 %",
                        "worst %", "bias %");
            any = true;
            print_level(level, name, width, to);
            name = "";
        }
    }
}

/* One row per stage, since a point has more stages than there are points. */
static void print_stages(const ibl_bench *b, int env, int width, FILE *to)
{
    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        const ibl_bench_series *s = p->series;
        if (!is_listed(b, p, env) || p->series_count == IBL_BENCH_STAGES)
            continue;
        fprintf(to, "\n %-*s %-16s %9s %7s\n", width, "stages", "", "ms", "%");
        for (int k = IBL_BENCH_STAGES; k < p->series_count; k++)
            fprintf(to, " %-*s %-16s %9.2f %7.1f\n", width,
                    k > IBL_BENCH_STAGES ? "" : p->name, s[k].name,
                    1e3 * s[k].median,
                    100 * s[k].median / s[IBL_BENCH_WALL_S].median);
    }
}

/* Bytes, error and time of the pixel formats. */
static void print_formats(const ibl_bench *b, int env, int width, FILE *to)
{
    bool any = false;

    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        if (b->sources[p->source].env != env || p->kind != IBL_BENCH_FORMAT)
            continue;
        if (!any)
            fprintf(to, "\n %-*s %9s %9s %9s %9s %9s\n", width, "formats", "KB",
                    "format %", "mean %", "error %", "time ms");
        any = true;
        fprintf(to, " %-*s %9.1f %9.3g %9.3g", width, p->name,
                1e-3 * (double)p->specular_bytes, 100 * p->loss.nrmse,
                100 * p->loss.relative);
        if (p->judged)
            fprintf(to, " %9.3g", 100 * p->whole_error);
        else
            fprintf(to, " %9s", "");
        fprintf(to, " %9.1f\n", 1e3 * p->series[IBL_BENCH_WALL_S].median);
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
                ibl_path_name(source->path), source->width, source->height,
                ibl_bench_method_names[b->base[IBL_BENCH_METHOD]],
                b->base[IBL_BENCH_SIZE], b->base[IBL_BENCH_THREADS],
                ibl_isa_name((ibl_isa)b->base[IBL_BENCH_ISA]));
        fprintf(to, " %-*s %9s %17s %9s %8s %9s %9s%s\n", width, "", "time ms",
                "quartiles", "CPU ms", "peak MiB", "error %", "p95 %",
                b->opts->rendered ? "    drawn %" : "");
        for (int i = 0; i < b->point_count; i++)
            if (b->sources[b->points[i].source].env == source->env &&
                b->points[i].kind != IBL_BENCH_FORMAT)
                print_point(&b->points[i], width, to);
        print_formats(b, source->env, width, to);
        print_levels(b, source->env, width, to);
        print_stages(b, source->env, width, to);
    }
    fputs("\nTimes are medians of whole processes. error: root mean square of "
          "the nRMSE of\nthe specular levels with r > 0; p95: the worst of "
          "their 95th percentiles of the\nrelative error. * no other method, "
          "count of samples, variant or peer is faster\nand better.\n",
          to);
    if (b->opts->formats)
        fputs(
            "KB: of the specular cube, 1000 bytes; format, mean: nRMSE and "
            "mean relative error\nby the pixel format alone, over its levels; "
            "error: nRMSE of all its levels.\n",
            to);
    if (b->opts->rendered)
        fputs("drawn: nRMSE of what a shader draws, the mean over F0 and "
              "roughness.\n",
              to);
}
