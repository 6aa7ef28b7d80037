/* SPDX-License-Identifier: MIT */
/* The report as one page: no scripts, nothing from elsewhere. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench_plots.h"
#include "common/memory_file.h"

static const char css[] =
    "body{margin:0;background:var(--bg);color:var(--fg);"
    "font:15px/1.5 system-ui,sans-serif}\n"
    "main{max-width:1520px;margin:0 auto;padding:24px}\n"
    "h1{font-size:24px;margin:0 0 8px}h2{font-size:20px;margin:40px 0 8px}"
    "h3{font-size:15px;margin:0 0 4px}\n"
    "p,li{max-width:80ch}.dim{color:var(--dim)}\n"
    "dl{display:grid;grid-template-columns:max-content 1fr;gap:2px 16px;"
    "margin:12px 0}dt{color:var(--dim)}dd{margin:0}\n"
    ".plots{display:grid;grid-template-columns:repeat(auto-fit,"
    "minmax(min(100%,560px),1fr));gap:16px;margin:20px 0}\n"
    "figure{margin:0;border:1px solid var(--grid);border-radius:8px;"
    "padding:12px}figure svg{width:100%;height:auto;display:block}\n"
    ".wide{overflow-x:auto;margin:12px 0}"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums}\n"
    "th,td{padding:3px 12px 3px 0;text-align:right;white-space:nowrap;"
    "border-bottom:1px solid var(--grid)}"
    "th{color:var(--dim);font-weight:500}\n"
    "th:first-child,td:first-child{text-align:left}"
    "tr.f td:first-child{font-weight:600}\n"
    "summary{cursor:pointer;margin:12px 0 4px}"
    "code{font:13px ui-monospace,monospace;word-break:break-word}\n";

static void text(FILE *to, const char *s)
{
    ibl_plot_escape(s, to);
}

static void fact(FILE *to, const char *name, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
static void fact(FILE *to, const char *name, const char *fmt, ...)
{
    char value[512];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(value, sizeof value, fmt, ap);
    va_end(ap);
    fprintf(to, "<dt>%s</dt><dd>", name);
    text(to, value);
    fputs("</dd>\n", to);
}

static void put_head(const ibl_bench *b, FILE *to)
{
    const ibl_bench_machine *m = &b->machine;

    fprintf(to,
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n"
            "<meta charset=\"utf-8\"/>\n"
            "<meta name=\"viewport\" content=\"width=device-width\"/>\n"
            "<meta name=\"color-scheme\" content=\"light dark\"/>\n"
            "<title>iblbake bench</title>\n<style>\n%s%s</style>\n</head>\n"
            "<body>\n<main>\n<h1>iblbake bench</h1>\n<dl>\n",
            ibl_plot_css, css);
    fact(to, "Date", "%s", m->date);
    fact(to, "CPU", "%s; %d of %d CPUs for this process", m->cpu, m->cpus,
         m->online_cpus);
    fact(to, "System", "%s, %.1f GiB", m->system, m->memory_bytes / (1 << 30));
    if (m->load >= 0)
        fact(to, "Load", "%.2f when the run began", m->load);
    fact(to, "iblbake", "%s%s%s", IBL_VERSION,
         *m->revision ? ", revision " : "", m->revision);
    fact(to, "Compiler", "%s", m->compiler);
    fact(to, "Run",
         "%d commands, %d rounds in turns after one that is not counted, "
         "%.0f s",
         b->point_count, b->opts->rounds, b->seconds);
    fputs("</dl>\n", to);
}

static void put_notes(FILE *to)
{
    fputs("<p class=\"dim\">Times are medians of whole processes, with the "
          "quartiles: reading, baking and writing every output, "
          "and for peers the start of a shell. Memory is the largest resident "
          "set. Error is the root mean square, over the specular levels with "
          "roughness above 0, of the normalised root mean square error of "
          "the texels against the sum over every pixel of the source in "
          "double precision; p95 is the worst of their 95th percentiles of "
          "the relative error. Bold: no other method, count of samples, "
          "variant or peer is both faster and better.</p>\n",
          to);
}

static void put_value(FILE *to, ibl_plot_unit unit, double value)
{
    char s[40];

    if (!isfinite(value)) {
        fputs("<td></td>", to);
        return;
    }
    ibl_plot_format(unit, value, s, sizeof s);
    fprintf(to, "<td>%s</td>", s);
}

/* ---- tables ---------------------------------------------------------- */

static void put_row(const ibl_bench_point *p, FILE *to)
{
    const double none = NAN;

    fprintf(to, "<tr%s><td>", p->pareto ? " class=\"f\"" : "");
    text(to, p->name);
    fputs(p->base ? " <span class=\"dim\">(base)</span></td>" : "</td>", to);
    put_value(to, IBL_PLOT_SECONDS, p->wall.median);
    put_value(to, IBL_PLOT_SECONDS, p->wall.low);
    put_value(to, IBL_PLOT_SECONDS, p->wall.high);
    put_value(to, IBL_PLOT_SECONDS, p->cpu.median);
    fprintf(to, "<td>%.1f MiB</td>", (double)p->peak_bytes / (1 << 20));
    put_value(to, IBL_PLOT_PERCENT, p->judged ? p->error : none);
    put_value(to, IBL_PLOT_PERCENT, p->judged ? p->worst_p95 : none);
    fputs("</tr>\n", to);
}

static void put_summary(const ibl_bench *b, int source, FILE *to)
{
    fputs("<div class=\"wide\"><table>\n<tr><th></th><th>time</th>"
          "<th>1st quartile</th><th>3rd</th><th>CPU time</th>"
          "<th>peak memory</th><th>error</th><th>p95</th></tr>\n",
          to);
    for (int i = 0; i < b->point_count; i++)
        if (ibl_bench_is_of(b, &b->points[i], source))
            put_row(&b->points[i], to);
    fputs("</table></div>\n", to);
}

static bool is_staged(const ibl_bench *b, const ibl_bench_point *p, int source)
{
    return ibl_bench_is_of(b, p, source) && ibl_bench_is_special(b, p) &&
           p->stage_count;
}

static void put_stages(const ibl_bench *b, int source, FILE *to)
{
    char groups[IBL_BENCH_STAGES][32];
    const int count = ibl_bench_groups(b, groups, IBL_BENCH_STAGES);

    if (!count)
        return;
    fputs("<h3>Stages</h3>\n<div class=\"wide\"><table>\n<tr><th></th>", to);
    for (int i = 0; i < count; i++) {
        fputs("<th>", to);
        text(to, groups[i]);
        fputs("</th>", to);
    }
    fputs("<th>all</th></tr>\n", to);
    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        if (!ibl_bench_is_of(b, p, source) || !p->stage_count)
            continue;
        fputs("<tr><td>", to);
        text(to, p->name);
        fputs("</td>", to);
        for (int k = 0; k < count; k++)
            put_value(to, IBL_PLOT_SECONDS,
                      ibl_bench_group_seconds(p, groups[k]));
        put_value(to, IBL_PLOT_SECONDS, p->wall.median);
        fputs("</tr>\n", to);
    }
    fputs("</table></div>\n<p class=\"dim\">rest: start and end of the "
          "process, the renaming of the files.</p>\n",
          to);
}

/* Each stage by itself, of the points that the levels are listed of. */
static void put_every_stage(const ibl_bench *b, int source, FILE *to)
{
    char names[IBL_BENCH_STAGES][32];
    const int count = ibl_bench_stages(b, names, IBL_BENCH_STAGES);

    fputs("<details open><summary>Every stage</summary>\n<div class=\"wide\">"
          "<table>\n<tr><th></th>",
          to);
    for (int i = 0; i < b->point_count; i++)
        if (is_staged(b, &b->points[i], source)) {
            fputs("<th>", to);
            text(to, b->points[i].name);
            fputs("</th>", to);
        }
    fputs("</tr>\n", to);
    for (int k = 0; k < count; k++) {
        fputs("<tr><td>", to);
        text(to, names[k]);
        fputs("</td>", to);
        for (int i = 0; i < b->point_count; i++)
            if (is_staged(b, &b->points[i], source))
                put_value(to, IBL_PLOT_SECONDS,
                          ibl_bench_stage_seconds(&b->points[i], names[k]));
        fputs("</tr>\n", to);
    }
    fputs("</table></div></details>\n", to);
}

static void put_levels(const ibl_bench *b, int source, FILE *to)
{
    fputs("<details><summary>Every level</summary>\n<div class=\"wide\">"
          "<table>\n<tr><th></th><th>output</th><th>level</th><th>size</th>"
          "<th>roughness</th><th>nRMSE</th><th>median</th><th>p95</th>"
          "<th>worst</th><th>bias</th></tr>\n",
          to);
    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        for (int k = 0; k < p->level_count && p->source == source; k++) {
            const ibl_bench_level *l = &p->level[k];
            fputs("<tr><td>", to);
            text(to, k ? "" : p->name);
            fprintf(to, "</td><td>%s</td><td>%d</td><td>%d</td>", l->content,
                    l->level, l->size);
            if (!strcmp(l->content, "lut")) {
                fprintf(to,
                        "<td colspan=\"6\">rms %.2g, largest %.2g, "
                        "absolute</td></tr>\n",
                        l->nrmse, l->worst);
                continue;
            }
            put_value(to, IBL_PLOT_NUMBER, l->roughness);
            put_value(to, IBL_PLOT_PERCENT, l->nrmse);
            put_value(to, IBL_PLOT_PERCENT, l->median);
            put_value(to, IBL_PLOT_PERCENT, l->p95);
            put_value(to, IBL_PLOT_PERCENT, l->worst);
            put_value(to, IBL_PLOT_PERCENT, l->bias);
            fputs("</tr>\n", to);
        }
    }
    fputs("</table></div></details>\n", to);
}

static void put_commands(const ibl_bench *b, int source, FILE *to)
{
    fputs("<details><summary>Commands</summary>\n<ul>\n", to);
    for (int i = 0; i < b->point_count; i++) {
        const ibl_bench_point *p = &b->points[i];
        if (!ibl_bench_is_of(b, p, source))
            continue;
        fputs("<li>", to);
        text(to, p->name);
        fputs(": <code>", to);
        text(to, p->kind == IBL_BENCH_PEER ? b->opts->peers.text[p->index]
                                           : "iblbake");
        for (char **w = p->argv + 1; *w && p->kind != IBL_BENCH_PEER; w++) {
            fputc(' ', to);
            text(to, *w);
        }
        fputs("</code></li>\n", to);
    }
    fputs("</ul></details>\n", to);
}

/* ---- the page -------------------------------------------------------- */

static void put_plot(ibl_plot plot, FILE *to)
{
    if (plot.count) {
        fputs("<figure><h3>", to);
        text(to, plot.title);
        fputs("</h3>\n", to);
        ibl_plot_write(&plot, false, to);
        fputs("</figure>\n", to);
    }
    ibl_bench_plot_free(&plot);
}

static void put_environment(const ibl_bench *b, int source, FILE *to)
{
    const ibl_bench_source *s = &b->sources[source];

    fputs("<h2>", to);
    text(to, b->opts->envs[s->env]);
    fprintf(to, " <span class=\"dim\">%d&#215;%d</span></h2>\n", s->width,
            s->height);
    fprintf(to, "<p>The base: %s",
            ibl_bench_method_name(b->base[IBL_BENCH_METHOD]));
    if (ibl_bench_takes_samples(b->base[IBL_BENCH_METHOD]))
        fprintf(to, " with %d samples", b->base[IBL_BENCH_SAMPLES]);
    fprintf(to, ", a cube of %d texels an edge, %d threads, %s",
            b->base[IBL_BENCH_SIZE], b->base[IBL_BENCH_THREADS],
            ibl_isa_name((ibl_isa)b->base[IBL_BENCH_ISA]));
    if (b->opts->bake) {
        fputs("; <code>", to);
        text(to, b->opts->bake);
        fputs("</code>", to);
    }
    fputs(". Every sweep goes round it.</p>\n<div class=\"plots\">\n", to);
    put_plot(ibl_bench_plot_error(b, source), to);
    put_plot(ibl_bench_plot_roughness(b, source), to);
    put_plot(ibl_bench_plot_axis(b, source, IBL_BENCH_SAMPLES), to);
    put_plot(ibl_bench_plot_axis(b, source, IBL_BENCH_SIZE), to);
    put_plot(ibl_bench_plot_axis(b, source, IBL_BENCH_SOURCE), to);
    put_plot(ibl_bench_plot_axis(b, source, IBL_BENCH_THREADS), to);
    fputs("</div>\n", to);
    put_summary(b, source, to);
    put_stages(b, source, to);
    put_every_stage(b, source, to);
    put_levels(b, source, to);
    put_commands(b, source, to);
}

char *ibl_bench_html(const ibl_bench *b)
{
    ibl_memory_file page;
    FILE *to = ibl_memory_open(&page);

    if (!to)
        return NULL;
    put_head(b, to);
    put_notes(to);
    for (int s = 0; s < b->source_count; s++)
        if (!b->sources[s].resampled)
            put_environment(b, s, to);
    fputs("</main>\n</body>\n</html>\n", to);
    return ibl_memory_close(to, &page);
}

char *ibl_bench_svg(const ibl_bench *b)
{
    ibl_plot plot = ibl_bench_plot_error(b, 0);
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);

    if (to)
        ibl_plot_write(&plot, true, to);
    ibl_bench_plot_free(&plot);
    return ibl_memory_close(to, &file);
}
