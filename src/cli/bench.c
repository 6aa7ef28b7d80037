/* SPDX-License-Identifier: MIT */
/* Bakes maps with a table of settings, in turns, and judges each. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cli/candidate.h"
#include "cli/judge.h"
#include "cli/rendered.h"
#include "cli/words.h"
#include "common/path.h"
#include "common/process.h"
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
    const char *csv, *html;
} bench_opts;

/* What is measured of a setting. */
enum {
    TIME,
    BYTES,
    SPECULAR,
    IRRADIANCE,
    TABLE,
    METALS,
    DIELECTRICS,
    COLUMNS
};
static const struct {
    const char *name, *head; /* head: in the printed table */
    double scale;
} columns[COLUMNS] = {
    {"time_s", "time ms", 1e3},         {"bytes", "kB", 1e-3},
    {"specular", "specular %", 100},    {"irradiance", "irradiance %", 100},
    {"table", "table %", 100},          {"metals", "metals %", 100},
    {"dielectrics", "plastics %", 100},
};

/* Of times the median and the quartiles, of errors the value less and plus its
 * standard error. */
typedef struct figure {
    double value, low, high; /* value NAN: there is none */
} figure;

typedef struct setting {
    const char *group, *value; /* value: the end of options */
    char *options;
    ibl_opts opts;
    double time_s[MAX_ROUNDS];
    figure figure[COLUMNS]; /* of this map */
} setting;

typedef struct bench {
    const bench_opts *opts;
    ibl_console console;
    ibl_ctx *ctx;
    setting settings[MAX_SETTINGS]; /* the first is the default */
    int count;
    char *csv, *table; /* of all maps */
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
    char *text = ibl_need(ibl_format("%s -o. -", options));
    char **words = ibl_need(ibl_words_split(text));
    ibl_cmdline *line = ibl_need(calloc(1, sizeof *line));
    const bool ok = ibl_command_line(&ibl_bake_command, words, line, NULL);

    *o = *line->set;
    ibl_bake_command.release(line);
    free(line);
    free(words);
    free(text);
    return ok;
}

static bool plan(bench *b)
{
    bool ok = true;

    for (int g = 0; g < GROUPS; g++) {
        const bool wanted = !b->opts->only || b->opts->only == g + 1;
        char **values = ibl_need(ibl_words_split(groups[g].values));
        /* The default is needed also where its group is not. */
        for (int i = 0; values[i] && ok && (wanted || !b->count); i++) {
            setting *s = &b->settings[b->count++];
            s->group = group_names[g + 1];
            s->options =
                ibl_need(ibl_format("%s %s", groups[g].options, values[i]));
            s->value = s->options + strlen(groups[g].options) + 1;
            ok = read_options(s->options, &s->opts);
            ibl_console_info(&b->console, "%s", s->options);
        }
        free(values);
    }
    return ok;
}

/* ---- figures --------------------------------------------------------- */

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The mean nRMSE of the rows of a content, but of roughness 0; NAN without any.
 */
static figure mean_of(const json_t *rows, ibl_output_kind kind)
{
    double nrmse, error, sum[2] = {0}, n = 0;
    json_t *row;
    size_t i;

    json_array_foreach(rows, i, row)
    {
        double roughness = 1;
        if (strcmp(text_of(row, "content"), ibl_output_content(kind)) != 0 ||
            json_unpack(row, "{s?F sF s{sF}}", "roughness", &roughness, "nrmse",
                        &nrmse, "standard_error", "nrmse", &error) ||
            roughness <= 0)
            continue;
        sum[0] += nrmse;
        sum[1] += error;
        n++;
    }
    return (figure){sum[0] / n, (sum[0] - sum[1]) / n, (sum[0] + sum[1]) / n};
}

/* ---- times ----------------------------------------------------------- */

/* Bakes what a setting makes, to texels as its files have them. */
static bool time_setting(const bench *b, setting *s, int round)
{
    const double begun = ibl_now();
    ibl_candidate c;
    bool ok = ibl_candidate_bake(b->ctx, &b->env, &s->opts, &c);
    const ibl_cube *cubes[] = {&c.made.specular, &c.made.irradiance};

    for (int i = 0; i < 2 && ok; i++) {
        ibl_texture tex = {0};
        ok = !cubes[i]->data ||
             !ibl_texture_from_cube(b->ctx, cubes[i], &s->opts.texels, &tex,
                                    NULL);
        ibl_texture_free(&tex);
    }
    s->time_s[round] = ibl_now() - begun;
    ibl_candidate_free(&c);
    return ok;
}

/* ---- errors ---------------------------------------------------------- */

/* Bakes what a setting makes into c and judges its parts, and what a shader
 * draws with it and, where it lacks parts, those of the default. */
static bool judge_setting(bench *b, setting *s, ibl_candidate *c)
{
    ibl_report report = {.options = ibl_judge_options_default()};
    ibl_truth_options options = ibl_truth_options_default();
    ibl_measured rows[2 * IBL_RENDERED_LIST];
    ibl_drawn set = {0};

    report.options.texels = b->opts->texels;
    options.directions = b->opts->directions;
    bool ok = ibl_candidate_bake(b->ctx, &b->env, &s->opts, c) &&
              ibl_candidate_round(b->ctx, &s->opts, c);
    const ibl_cube *specular = &c->made.specular,
                   *diffuse = &c->made.irradiance;
    const ibl_judged parts[] = {{.content = IBL_OUTPUT_SPECULAR,
                                 .chain = *specular,
                                 .levels = specular->levels,
                                 .roughness = c->made.report.layout.roughness},
                                {.content = IBL_OUTPUT_IRRADIANCE,
                                 .chain = *diffuse,
                                 .levels = diffuse->levels}};
    for (int i = 0; i < 2 && ok; i++)
        ok = ibl_report_levels(&report, b->judge, &parts[i]);
    if (ok && c->lut.data) {
        options.geometry = s->opts.lut.geometry;
        ok = ibl_report_lut(&report, b->ctx, &c->lut, options.geometry);
    }
    ibl_truth *truth = &b->truth[options.geometry];
    ibl_candidate_draw(&set, &b->usual);
    ibl_candidate_draw(&set, c);
    ok = ok &&
         (truth->sample || ibl_truth_make(b->ctx, &b->env, 0, &options, truth));
    if (ok)
        ibl_measure(truth, &set, rows);

    json_t *levels = json_object_get(report.json, "levels");
    json_array_append(levels, json_object_get(report.json, "lut"));
    s->figure[SPECULAR] = mean_of(levels, IBL_OUTPUT_SPECULAR);
    s->figure[IRRADIANCE] = mean_of(levels, IBL_OUTPUT_IRRADIANCE);
    s->figure[TABLE] = mean_of(levels, IBL_OUTPUT_LUT);
    for (int f = 0; f < options.f0_count && ok; f++) {
        const int n = options.roughness_count;
        const ibl_measured m = ibl_measured_mean(rows + f * n, n);
        const double x = m.value[IBL_FIGURE_NRMSE];
        const double e = m.error[IBL_FIGURE_NRMSE];
        s->figure[METALS + f] = (figure){x, x - e, x + e};
    }
    const double bytes = (double)ibl_candidate_bytes(&s->opts);
    s->figure[BYTES] = (figure){bytes, bytes, bytes};
    json_decref(report.json);
    return ok;
}

/* ---- reports --------------------------------------------------------- */

/* Adds the lines of a map to both tables. */
static void put_map(bench *b, const char *path)
{
    char *name = NULL; /* with its quotes doubled */

    for (const char *c = path; *c; c++)
        ibl_append(&name, *c == '"' ? "\"\"" : "%c", *c);
    ibl_append(&b->table, "\n%-26s", ibl_path_name(path));
    for (int k = 0; k < COLUMNS; k++)
        ibl_append(&b->table, " %17s", columns[k].head);
    for (int i = 0; i < b->count; i++) {
        const setting *s = &b->settings[i];
        ibl_append(&b->csv, "\"%s\",%s,%s,\"%s\"", name, s->group, s->value,
                   s->options);
        ibl_append(&b->table, "\n%-16s%-10s", s->group, s->value);
        for (int k = 0; k < COLUMNS; k++) {
            const figure *f = &s->figure[k];
            const double x = columns[k].scale;
            if (isnan(f->value)) {
                ibl_append(&b->csv, ",,,");
                ibl_append(&b->table, "%18s", "");
                continue;
            }
            ibl_append(&b->csv, ",%.6g,%.6g,%.6g", f->value, f->low, f->high);
            ibl_append(&b->table, " %7.4g +-%-7.2g", x * f->value,
                       x * (f->high - f->low) / 2);
        }
        ibl_append(&b->csv, "\n");
    }
    ibl_append(&b->table, "\n");
    free(name);
}

/* Generated from bench_page.html by the build. */
extern const char ibl_bench_page[];

/* The page has its words between characters that it has nowhere else. */
static char *make_page(const char *about, const char *csv)
{
    const char *const words[] = {about, csv};
    const char *page = ibl_bench_page;
    char *text = NULL;

    for (int i = 0; i < 2; i++) {
        const int length = (int)strcspn(page, "@");
        ibl_append(&text, "%.*s", length, page);
        page += length + 1;
        for (const char *c = words[i]; *c;) {
            const int plain = (int)strcspn(c, "<&");
            ibl_append(&text, "%.*s", plain, c);
            c += plain;
            if (*c)
                ibl_append(&text, *c++ == '<' ? "&lt;" : "&amp;");
        }
    }
    ibl_append(&text, "%s", page);
    return text;
}

/* Where, by what and when it was measured. */
static char *describe(const bench *b)
{
    char cpu[128] = "", date[32] = "", line[512];
    FILE *f = fopen("/proc/cpuinfo", "r");
    const time_t now = time(NULL);
    struct tm utc;

    while (f && !*cpu && fgets(line, sizeof line, f))
        sscanf(line, "model name : %127[^\n]", cpu);
    if (f)
        fclose(f);
    if (gmtime_r(&now, &utc))
        strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", &utc);
    return ibl_need(ibl_format(
        "%s, %d threads, %s; iblbake %s %s, %s; %s; %d rounds", cpu,
        ibl_ctx_threads(b->ctx), ibl_isa_name(ibl_ctx_isa(b->ctx)), IBL_VERSION,
        IBL_REVISION, IBL_COMPILER, date, b->opts->rounds));
}

static bool write_reports(bench *b)
{
    const bench_opts *o = b->opts;
    char *about = describe(b), *page = make_page(about, b->csv);
    ibl_outputs *outputs = NULL;

    bool ok =
        !ibl_outputs_create(b->ctx, 0, &outputs) &&
        (!o->csv ||
         !ibl_outputs_add(outputs, o->csv, b->csv, strlen(b->csv))) &&
        (!o->html || !ibl_outputs_add(outputs, o->html, page, strlen(page)));
    if (ok)
        printf("%s\n%s\nTimes are medians, +- half the distance of the "
               "quartiles; of errors +- is a\nstandard error. Levels, "
               "irradiance and table: nRMSE of texels; metals and\nplastics: "
               "of what a shader draws with F0 of 1 and .04, with the parts "
               "of\nthe default where a setting makes only one.\n",
               about, b->table);
    ok = ok && ibl_console_commit(&b->console, outputs);
    ibl_outputs_free(outputs);
    free(about);
    free(page);
    return ok;
}

/* ---- the run --------------------------------------------------------- */

static bool measure_map(bench *b, const char *path)
{
    const int n = b->opts->rounds;

    bool ok =
        !ibl_image_read(b->ctx, path, &b->opts->common.read, &b->env, NULL) &&
        (b->judge = ibl_judge_create(b->ctx, &b->env, 0));
    b->console.quiet = true; /* of warnings, with each bake anew */
    for (int i = 0; i < b->count && ok; i++) {
        ibl_candidate own = {0};
        ibl_console_progress(&b->console, "judge", (double)i / b->count);
        ok = judge_setting(b, &b->settings[i], i ? &own : &b->usual);
        ibl_candidate_free(&own);
    }
    for (int i = 0; i < n * b->count && ok; i++) {
        ibl_console_progress(&b->console, "measure", i / (n * b->count + 0.));
        ok = time_setting(b, &b->settings[i % b->count], i / b->count);
    }
    b->console.quiet = b->opts->common.quiet;
    for (int i = 0; i < b->count && ok; i++) {
        double *t = b->settings[i].time_s;
        qsort(t, (size_t)n, sizeof *t, by_value);
        b->settings[i].figure[TIME] =
            (figure){t[n / 2], t[n / 4], t[n - 1 - n / 4]};
    }
    if (ok)
        put_map(b, path);
    for (int i = 0; i < 2; i++)
        ibl_truth_free(&b->truth[i]);
    ibl_candidate_free(&b->usual);
    ibl_judge_free(b->judge);
    b->judge = NULL;
    ibl_image_free(&b->env);
    return ok;
}

/* Before the minutes of work, not after them. */
static bool check_report(bench *b, const char *path)
{
    if (path && !ibl_path_is_open(path))
        return ibl_console_fail(&b->console,
                                "%s: cannot be written: %s: choose another "
                                "directory",
                                path, strerror(errno));
    for (int m = 0; m < b->opts->map_count && path; m++)
        if (!ibl_console_differ(&b->console, b->opts->maps[m], path, "file"))
            return false;
    return true;
}

static int run(const void *settings)
{
    const bench_opts *o = settings;
    static bench whole;
    bench *b = &whole;

    b->opts = o;
    ibl_append(&b->csv, "map,group,value,options"); /* and figures: */
    for (int k = 0; k < COLUMNS; k++)
        ibl_append(&b->csv, ",%1$s,%1$s_low,%1$s_high", columns[k].name);
    ibl_append(&b->csv, "\n");
    ibl_console_init(&b->console, o->common.quiet, o->common.verbose);
    bool ok = check_report(b, o->csv) && check_report(b, o->html) && plan(b) &&
              !ibl_start(&o->common, &b->console, &b->ctx);
    /* Before the minutes that each takes. */
    b->console.quiet = true;
    for (int m = 0; m < o->map_count && ok; m++) {
        ok =
            !ibl_image_read(b->ctx, o->maps[m], &o->common.read, &b->env, NULL);
        ibl_image_free(&b->env);
    }
    b->console.quiet = o->common.quiet;
    for (int m = 0; m < o->map_count && ok; m++)
        ok = measure_map(b, o->maps[m]);
    ibl_console_finish(&b->console);
    ok = ok && write_reports(b);
    free(b->csv);
    free(b->table);
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
    {"html", 0, IBL_TEXT(html, "FILE"), .standard = "",
     .help = "a page that draws it, in one file"},
};
/* clang-format on */

static const ibl_gone gone[] = {
    {"bake variant formats full methods sizes source-sizes quality zstd "
     "rendered shader lod",
     "what is measured is a table: see --only"},
    {"peer peer-output timeout timings",
     "tests/bench-peers.sh measures other programs"},
    {"json", "--csv has all figures"},
    {.words = NULL}};

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
    .gone = gone,
    .settings_size = sizeof(bench_opts),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = run,
};
