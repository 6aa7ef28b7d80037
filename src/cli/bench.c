/* SPDX-License-Identifier: MIT */
/*
 * Bakes maps with a table of settings, in turns, and judges each.
 *
 * What is measured is a document of JSON,
 *     {"date", "cpu", .., "maps": [{"map", "width", "height", "settings":
 *         [{"group", "value", "options", FIGURE.., "report"}, ..]}, ..]}
 * A figure is [value, low, high]: of times the median and the quartiles, of
 * errors the value less and plus its standard error. "report" has the error of
 * each level, as iblbake verify writes it.
 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cli/candidate.h"
#include "cli/judge.h"
#include "cli/rendered.h"
#include "cli/shell_words.h"
#include "common/clock.h"
#include "common/path.h"
#include "common/signals.h"
#include "json/json_text.h"

/* The settings: the options of a group with each of its values. Most make one
 * part of a set, whose time and bytes are then measured; the first of all is
 * the default, which has the other parts that it is drawn with. */
#define LEVELS "--only specular,lobe-table "
static const struct {
    const char *options, *values;
} groups[] = {
    {"--preset", "none learnopengl"},
    {LEVELS "--method sampled --samples", "16 64 256 1024 4096"},
    {LEVELS "--method sampled --pdf-mip no --samples", "64 256 1024 4096"},
    {LEVELS "--tolerance", ".1 .01 .001 .0001 .00001"},
    {"--only irradiance --irradiance-step", ".2 .1 .05 .025"},
    {"--only irradiance --irradiance-size", "8 16 32 64"},
    {"--only lut --lut-samples", "16 64 256 1024 4096 0"},
    {"--size", "64 128 256 512"},
    {"--pixel", "rgba32f rgba16f rgb9e5 r11g11b10f bc6h uastc-hdr astc4x4hdr"},
};
static const char *const group_names[] = {"all",
                                          "preset",
                                          "samples",
                                          "samples-nomip",
                                          "tolerance",
                                          "irradiance-step",
                                          "irradiance-size",
                                          "lut-samples",
                                          "size",
                                          "pixel",
                                          NULL};

enum {
    GROUPS = sizeof groups / sizeof *groups,
    MAX_MAPS = 16,
    MAX_ROUNDS = 99,
    MAX_SETTINGS = 64
};

typedef struct bench_opts {
    ibl_common common;
    int map_count;
    const char *maps[MAX_MAPS];
    int only; /* in group_names */
    int rounds, texels, directions;
    const char *csv, *json, *html;
} bench_opts;

typedef struct setting {
    const char *group, *value; /* value: the end of options */
    char *options;
    ibl_opts opts;
    double time_s[MAX_ROUNDS];
    json_t *json; /* of this map */
} setting;

typedef struct bench {
    const bench_opts *opts;
    ibl_console console;
    ibl_ctx *ctx;
    setting settings[MAX_SETTINGS]; /* the first is the default */
    int count;
    /* Of this map: */
    ibl_image env;
    ibl_judge *judge;
    ibl_truth truth[2];  /* of a geometry, made when it is needed */
    ibl_candidate usual; /* the default's */
} bench;

/* ---- settings -------------------------------------------------------- */

/* Reads the options of a bake that reads and writes nothing. */
static bool read_options(const char *options, ibl_opts *o)
{
    char *text = ibl_format("%s -o. -", options);
    char **words = text ? ibl_words_split(text) : NULL;
    ibl_cmdline *line = calloc(1, sizeof *line);
    const bool ok =
        words && line && ibl_command_line(&ibl_bake_command, words, line, NULL);

    if (ok)
        *o = *line->set;
    if (line)
        ibl_bake_command.release(line);
    free(line);
    free(words);
    free(text);
    return ok;
}

static bool plan(bench *b)
{
    bool ok = true;

    for (int g = 0; g < GROUPS && ok; g++) {
        const bool wanted = !b->opts->only || b->opts->only == g + 1;
        char **values = ibl_words_split(groups[g].values);
        /* The default is needed also where its group is not. */
        for (int i = 0; values && values[i] && ok && (wanted || !b->count);
             i++) {
            setting *s = &b->settings[b->count++];
            s->group = group_names[g + 1];
            s->options = ibl_format("%s %s", groups[g].options, values[i]);
            ok = s->options && read_options(s->options, &s->opts);
            s->value = s->options + strlen(groups[g].options) + 1;
            ibl_console_info(&b->console, "%s", s->options);
        }
        ok = ok && values;
        free(values);
    }
    return ok;
}

/* ---- figures --------------------------------------------------------- */

static void put_figure(setting *s, const char *name, double value, double low,
                       double high)
{
    json_object_set_new(s->json, name,
                        json_pack("[f, f, f]", value, low, high));
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The mean nRMSE of the rows of a content, but of roughness 0, if there are
 * any. */
static void put_mean(setting *s, const char *name, const json_t *rows,
                     const char *content)
{
    double nrmse, error, sum[2] = {0};
    json_t *row;
    size_t i;
    int n = 0;

    json_array_foreach(rows, i, row)
    {
        double roughness = 1;
        if (strcmp(text_of(row, "content"), content) != 0 ||
            json_unpack(row, "{s?F sF s{sF}}", "roughness", &roughness, "nrmse",
                        &nrmse, "standard_error", "nrmse", &error) ||
            roughness <= 0)
            continue;
        sum[0] += nrmse;
        sum[1] += error;
        n++;
    }
    if (n)
        put_figure(s, name, sum[0] / n, (sum[0] - sum[1]) / n,
                   (sum[0] + sum[1]) / n);
}

/* ---- times ----------------------------------------------------------- */

/* Bakes what a setting makes, to texels as its files have them. */
static bool time_setting(const bench *b, setting *s, int round)
{
    const double begun = ibl_now();
    ibl_candidate c;
    ibl_status status = ibl_candidate_bake(b->ctx, &b->env, &s->opts, &c);
    const ibl_cube *cubes[] = {&c.made.specular, &c.made.irradiance};

    for (int i = 0; i < 2 && !status; i++) {
        ibl_texture tex = {0};
        if (cubes[i]->data)
            status = ibl_texture_from_cube(b->ctx, cubes[i], &s->opts.texels,
                                           &tex, NULL);
        ibl_texture_free(&tex);
    }
    s->time_s[round] = ibl_now() - begun;
    ibl_candidate_free(&c);
    return !status;
}

/* ---- errors ---------------------------------------------------------- */

/* Judges a candidate: its parts, and what a shader draws with it and, where it
 * lacks parts, those of the default. */
static bool judge_parts(bench *b, const ibl_opts *o, const ibl_candidate *c,
                        ibl_report *report)
{
    const ibl_judged parts[] = {{.content = IBL_OUTPUT_SPECULAR,
                                 .chain = c->made.specular,
                                 .levels = c->made.specular.levels,
                                 .roughness = c->made.report.layout.roughness},
                                {.content = IBL_OUTPUT_IRRADIANCE,
                                 .chain = c->made.irradiance,
                                 .levels = c->made.irradiance.levels}};
    ibl_truth_options options = ibl_truth_options_default();
    ibl_drawn set = {0};
    bool ok = true;

    for (int i = 0; i < 2 && ok; i++)
        ok = ibl_report_levels(report, b->judge, &parts[i]);
    if (ok && c->lut.data) {
        ok = ibl_report_lut(report, b->ctx, &c->lut, o->lut.geometry);
        options.geometry = o->lut.geometry;
    }
    options.directions = b->opts->directions;
    ibl_truth *truth = &b->truth[options.geometry];
    ibl_candidate_draw(&set, &b->usual);
    ibl_candidate_draw(&set, c);
    ok = ok &&
         (truth->sample || ibl_truth_make(b->ctx, &b->env, 0, &options, truth));
    if (ok)
        ibl_report_drawn(report, truth, &set);
    return ok;
}

/* Bakes what a setting makes into c and judges it. */
static bool judge_setting(bench *b, setting *s, ibl_candidate *c)
{
    static const char *const parts[][2] = {{"specular", "specular"},
                                           {"irradiance", "irradiance"},
                                           {"table", "brdf_lut"},
                                           {"metals", "metals"},
                                           {"dielectrics", "dielectrics"}};
    ibl_report report = {.options = ibl_judge_options_default()};
    json_t *rows, *row;
    size_t i;

    report.options.texels = b->opts->texels;
    const bool ok = !ibl_candidate_bake(b->ctx, &b->env, &s->opts, c) &&
                    !ibl_candidate_round(b->ctx, &s->opts, c) &&
                    judge_parts(b, &s->opts, c, &report);
    const json_t *drawn = json_object_get(report.json, "rendered");
    rows = json_copy(json_object_get(report.json, "levels"));
    json_array_append(rows, json_object_get(report.json, "lut"));
    json_array_foreach(json_object_get(drawn, "means"), i, row)
    {
        row = json_copy(row);
        json_object_set_new(row, "content", json_string(parts[3 + i][1]));
        json_array_append_new(rows, row);
    }
    put_figure(s, "bytes", (double)c->bytes, (double)c->bytes,
               (double)c->bytes);
    for (int k = 0; k < 5; k++)
        put_mean(s, parts[k][0], rows, parts[k][1]);
    json_object_set(s->json, "report", report.json);
    json_decref(rows);
    json_decref(report.json);
    return ok;
}

/* ---- reports --------------------------------------------------------- */

static const struct {
    const char *name, *head; /* head: in the printed table */
    double scale;
} columns[] = {
    {"time_s", "time ms", 1e3},         {"bytes", "kB", 1e-3},
    {"specular", "specular %", 100},    {"irradiance", "irradiance %", 100},
    {"table", "table %", 100},          {"metals", "metals %", 100},
    {"dielectrics", "plastics %", 100},
};
enum {
    COLUMNS = sizeof columns / sizeof *columns
};

/* The settings of all maps, a line each: for people, or as CSV. */
static void put_rows(const json_t *document, bool csv, FILE *to)
{
    json_t *map, *s;
    size_t m, i;
    double f[3];

    json_array_foreach(json_object_get(document, "maps"), m, map)
    {
        const char *path = text_of(map, "map");
        if (!csv)
            fprintf(to, "\n%-26s", ibl_path_name(path));
        for (int k = 0; !csv && k < COLUMNS; k++)
            fprintf(to, " %17s", columns[k].head);
        json_array_foreach(json_object_get(map, "settings"), i, s)
        {
            fputs(csv ? "\n\"" : "\n", to);
            for (const char *c = csv ? path : ""; *c; c++)
                fprintf(to, *c == '"' ? "\"\"" : "%c", *c);
            fprintf(to, csv ? "\",%s,%s,\"%s\"" : "%-16s%-10s%.0s",
                    text_of(s, "group"), text_of(s, "value"),
                    text_of(s, "options"));
            for (int k = 0; k < COLUMNS; k++) {
                const double x = columns[k].scale;
                if (json_unpack(json_object_get(s, columns[k].name),
                                "[F, F, F]", &f[0], &f[1], &f[2]))
                    fprintf(to, "%s", csv ? ",,," : "                  ");
                else if (csv)
                    fprintf(to, ",%.6g,%.6g,%.6g", f[0], f[1], f[2]);
                else
                    fprintf(to, " %7.4g +-%-7.2g", x * f[0],
                            x * (f[2] - f[1]) / 2);
            }
        }
    }
    fputc('\n', to);
}

static void put_csv(const json_t *document, FILE *to)
{
    fputs("map,group,value,options", to); /* and figures: */
    for (int k = 0; k < COLUMNS; k++)
        fprintf(to, ",%1$s,%1$s_low,%1$s_high", columns[k].name);
    put_rows(document, true, to);
}

static void print_document(const json_t *document, FILE *to)
{
    fprintf(to, "%s, %d threads; iblbake %s, %s\n", text_of(document, "cpu"),
            (int)json_integer_value(json_object_get(document, "threads")),
            IBL_VERSION, text_of(document, "date"));
    put_rows(document, false, to);
    fputs("\nTimes are medians, +- half the distance of the quartiles; of "
          "errors +- is a\nstandard error. Levels, irradiance and table: nRMSE "
          "of texels; metals and\nplastics: of what a shader draws with F0 of "
          "1 and .04, with the parts of\nthe default where a setting makes "
          "only one.\n",
          to);
}

/* Also for a page, whose element "<" would end. */
static void put_json(const json_t *document, FILE *to)
{
    char *text = ibl_json_text(document);

    for (const char *c = text ? text : ""; *c; c++)
        fprintf(to, *c == '<' ? "\\u003c" : "%c", *c);
    free(text);
}

/* Generated from bench_page.html by the build. */
extern const char ibl_bench_page[];

static void put_page(const json_t *document, FILE *to)
{
    const char *place = strstr(ibl_bench_page, "@JSON@");

    fwrite(ibl_bench_page, 1, (size_t)(place - ibl_bench_page), to);
    put_json(document, to);
    fputs(place + strlen("@JSON@"), to);
}

/* ---- the run --------------------------------------------------------- */

/* Measures map number m and adds it to the list. */
static bool measure_map(bench *b, int m, json_t *maps)
{
    const int n = b->opts->rounds;
    const char *path = b->opts->maps[m];
    json_t *list = json_array();

    bool ok =
        !ibl_image_read(b->ctx, path, &b->opts->common.read, &b->env, NULL) &&
        (b->judge = ibl_judge_create(b->ctx, &b->env, 0));
    b->console.quiet = true; /* of warnings, with each bake anew */
    for (int i = 0; i < b->count && ok; i++) {
        setting *s = &b->settings[i];
        ibl_candidate own = {0};
        ibl_console_progress(&b->console, "judge", (double)i / b->count);
        s->json = json_pack("{ss ss ss}", "group", s->group, "value", s->value,
                            "options", s->options);
        ok = s->json && judge_setting(b, s, i ? &own : &b->usual);
        ibl_candidate_free(&own);
    }
    for (int i = 0; i < n * b->count && ok; i++) {
        ibl_console_progress(&b->console, "measure", i / (n * b->count + 0.));
        ok = time_setting(b, &b->settings[i % b->count], i / b->count);
    }
    b->console.quiet = b->opts->common.quiet;
    for (int i = 0; i < b->count && ok; i++) {
        setting *s = &b->settings[i];
        double *t = s->time_s;
        qsort(t, (size_t)n, sizeof *t, by_value);
        put_figure(s, "time_s", t[n / 2], t[n / 4], t[n - 1 - n / 4]);
        json_array_append(list, s->json);
    }
    json_array_append_new(maps, json_pack("{so si si so}", "map",
                                          ibl_json_string(path), "width",
                                          b->env.width, "height", b->env.height,
                                          "settings", list));
    for (int i = 0; i < b->count; i++) {
        json_decref(b->settings[i].json);
        b->settings[i].json = NULL;
    }
    for (int i = 0; i < 2; i++)
        ibl_truth_free(&b->truth[i]);
    ibl_candidate_free(&b->usual);
    ibl_judge_free(b->judge);
    b->judge = NULL;
    ibl_image_free(&b->env);
    return ok;
}

/* The document; NULL: after a message, or no memory. */
static json_t *measure(bench *b)
{
    const bench_opts *o = b->opts;
    char cpu[128] = "", date[32] = "", line[512];
    FILE *f = fopen("/proc/cpuinfo", "r");
    const time_t now = time(NULL);
    struct tm utc;
    json_t *maps = json_array();
    bool ok = plan(b) && !ibl_start(&o->common, &b->console, &b->ctx);
    for (int m = 0; m < o->map_count && ok; m++)
        ok = measure_map(b, m, maps);
    while (f && !*cpu && fgets(line, sizeof line, f))
        sscanf(line, "model name : %127[^\n]", cpu);
    if (f)
        fclose(f);
    if (gmtime_r(&now, &utc))
        strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", &utc);
    json_t *document = json_pack(
        "{ss ss so ss ss si si ss si si si so}", "version", IBL_VERSION,
        "revision", ibl_version_revision(), "cpu", ibl_json_string(cpu),
        "compiler", ibl_version_compiler(), "date", date, "cpus",
        ibl_cpu_count(), "threads", ok ? ibl_ctx_threads(b->ctx) : 0, "isa",
        ok ? ibl_isa_name(ibl_ctx_isa(b->ctx)) : "", "rounds", o->rounds,
        "texels", o->texels, "directions", o->directions, "maps", maps);
    if (ok)
        return document;
    json_decref(document);
    return NULL;
}

static int run(const void *settings)
{
    const bench_opts *o = settings;
    const struct {
        const char *path;
        void (*write)(const json_t *document, FILE *to);
    } reports[] = {{o->csv, put_csv}, {o->json, put_json}, {o->html, put_page}};
    static bench whole;
    bench *b = &whole;
    ibl_outputs *outputs = NULL;
    bool ok = true;

    b->opts = o;
    ibl_console_init(&b->console, o->common.quiet, o->common.verbose);
    ibl_signals_catch();
    /* Before the minutes of work, not after them. */
    for (int i = 0; i < 3 && ok; i++) {
        ok = !reports[i].path || ibl_path_is_open(reports[i].path) ||
             ibl_console_fail(&b->console,
                              "%s: cannot be written: %s: choose another "
                              "directory",
                              reports[i].path, strerror(errno));
        for (int m = 0; m < o->map_count && ok && reports[i].path; m++)
            ok = ibl_console_differ(&b->console, o->maps[m], reports[i].path,
                                    "file");
    }
    json_t *document = ok ? measure(b) : NULL;
    ibl_console_finish(&b->console);
    ok = document && !ibl_outputs_create(b->ctx, 0, &outputs);
    for (int i = 0; i < 3 && ok; i++) {
        ibl_memory_file file;
        FILE *to = reports[i].path ? ibl_memory_open(&file) : NULL;
        if (to)
            reports[i].write(document, to);
        char *text = ibl_memory_close(to, &file);
        if (reports[i].path)
            ok = text &&
                 !ibl_outputs_add(outputs, reports[i].path, text, file.size);
        free(text);
    }
    if (ok)
        print_document(document, stdout);
    ok = ok && ibl_console_commit(&b->console, outputs);
    ibl_outputs_free(outputs);
    json_decref(document);
    for (int i = 0; i < b->count; i++)
        free(b->settings[i].options);
    ibl_ctx_free(b->ctx);
    return ibl_console_end(&b->console, ok);
}

/* ---- options --------------------------------------------------------- */

#define IBL_SETTINGS bench_opts
/* clang-format off */
static const ibl_option measuring[] = {
    {"only", 0, IBL_CHOICE(only, group_names),
     .help = "measure the default and these settings"},
    {"rounds", 0, IBL_INT(rounds, 1, MAX_ROUNDS),
     .help = "times that each is baked, in turns"},
    {"texels", 0, IBL_INT(texels, 24, 1048576),
     .help = "texels of each level that are compared with the exact sums"},
    {"directions", 0, IBL_INT(directions, IBL_RENDERED_LEAST, 65536),
     .help = "directions along which what a shader draws is compared"},
};

static const ibl_option reports[] = {
    {"csv", 0, IBL_TEXT(csv, "FILE"), .standard = "",
     .help = "the table for programs, a line for each setting"},
    {"json", 0, IBL_TEXT(json, "FILE"), .standard = "",
     .help = "the same, with the errors of each level"},
    {"html", 0, IBL_TEXT(html, "FILE"), .standard = "",
     .help = "a page that draws it, in one file"},
};
/* clang-format on */

static const ibl_section *const sections[] = {
    IBL_SECTION("Measuring", measuring), IBL_SECTION("Reports", reports),
    &ibl_input_section, &ibl_running_section, NULL};

static void defaults(void *settings)
{
    *(bench_opts *)settings = (bench_opts){.common = ibl_common_default(),
                                           .rounds = 5,
                                           .texels = 128,
                                           .directions = 256};
}

static bool take(void *settings, const char *word)
{
    bench_opts *o = settings;

    if (o->map_count == MAX_MAPS || !strcmp(word, "-"))
        return ibl_misuse("%s: give at most %d files: standard input can be "
                          "read only once",
                          word, MAX_MAPS);
    o->maps[o->map_count++] = word;
    return true;
}

static bool validate(void *settings)
{
    const bench_opts *o = settings;

    return o->map_count ? ibl_common_validate(&o->common)
                        : ibl_misuse("no map: iblbake bench [options] MAP..., "
                                     "see iblbake bench --help");
}

const ibl_command ibl_bench_command = {
    .name = "bench",
    .usage = "[options] MAP...",
    .brief = "measure bakes with other settings by time and by error",
    .intro = "Bakes maps with a table of settings, in turns, and prints the "
             "time of each and\nhow far it is off what is exact, with the "
             "uncertainty of every figure.\n",
    .statuses = "0 done, 1 failed, 2 wrong usage",
    .sections = sections,
    .settings_size = sizeof(bench_opts),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = run,
};
