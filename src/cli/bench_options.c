/* SPDX-License-Identifier: MIT */
/* The command line of iblbake bench. */
#include <string.h>

#include "cli/bench.h"
#include "cli/rendered.h"
#include "cli/shell_words.h"
#include "common/names.h"

#define STANDARD_METHODS "auto,spectral,sampled,sampled-nomip"
#define STANDARD_SAMPLES "16,64,256,1024,4096"
#define STANDARD_SIZES "64,128,256,512"

const char *const ibl_bench_method_names[] = {"auto", "spectral", "sampled",
                                              "sampled-nomip", NULL};
const char *const ibl_bench_kind_names[] = {"bake", "variant", "format",
                                            "peer"};
static const char *const isa_names[] = {"c", "sse2", "avx2", "neon", NULL};

bool ibl_bench_takes_samples(int method)
{
    return method == IBL_BENCH_SAMPLED || method == IBL_BENCH_SAMPLED_NOMIP;
}

/* ---- lists ----------------------------------------------------------- */

static const struct {
    const char *name;
    int low, high;
    const char *const *words; /* from low on; NULL: values are numbers */
    const char *standard; /* default; NULL: depends on the machine or maps */
} axes[IBL_BENCH_AXES] = {
    {"method", 0, IBL_BENCH_METHODS - 1, ibl_bench_method_names,
     STANDARD_METHODS},
    {"samples", 1, 1048576, NULL, STANDARD_SAMPLES},
    {"size", 1, IBL_MAX_CUBE_SIZE, NULL, STANDARD_SIZES},
    {"threads", 1, 1024, NULL, NULL},
    {"isa", IBL_ISA_C, IBL_ISA_NEON, isa_names, NULL},
    {"source", 2, IBL_MAX_EDGE, NULL, NULL},
};

const char *ibl_bench_axis_name(int axis)
{
    return axes[axis].name;
}

void ibl_bench_value(int axis, int value, char *text, size_t size)
{
    if (axes[axis].words)
        snprintf(text, size, "%s", axes[axis].words[value - axes[axis].low]);
    else
        snprintf(text, size, "%d", value);
}

static bool put(ibl_bench_list *list, int value)
{
    for (int i = 0; i < list->count; i++)
        if (list->values[i] == value)
            return true;
    if (list->count == IBL_BENCH_VALUES)
        return false;
    list->values[list->count++] = value;
    return true;
}

/* Parses the value at the start of text; *end points behind it. */
static bool take_value(int axis, const char *text, int *value, const char **end)
{
    const int length = (int)strcspn(text, ",");
    char word[16];

    if (!axes[axis].words)
        return ibl_number_int(text, axes[axis].low, axes[axis].high, value,
                              end);
    *end = text + length;
    snprintf(word, sizeof word, "%.*s", length, text);
    const int found = ibl_names_find(axes[axis].words, word);
    *value = axes[axis].low + found;
    return found >= 0;
}

/* Parses values separated by commas; for sources also "none". */
static bool parse_list(void *field, const char *text)
{
    ibl_bench_list *list = field;
    int value;

    list->count = 0;
    if (list->axis == IBL_BENCH_SOURCE && !strcmp(text, "none"))
        return put(list, 0);
    while (take_value(list->axis, text, &value, &text) && put(list, value)) {
        if (*text != ',')
            return !*text;
        text++;
    }
    return false;
}

/* Parses NAME=TEXT. */
static bool parse_name(void *field, const char *value)
{
    ibl_bench_names *names = field;
    const size_t length = strcspn(value, "=");
    char *name = names->name[names->count];

    if (names->count == IBL_BENCH_NAMED || !length || !value[length] ||
        !value[length + 1] || length >= sizeof names->name[0])
        return false;
    memcpy(name, value, length);
    name[length] = '\0';
    if (strpbrk(name, ",\"\n/"))
        return false;
    names->text[names->count++] = value + length + 1;
    return true;
}

#define IBL_SETTINGS ibl_bench_opts
#define LIST(axis) IBL_OTHER(lists[axis], "LIST", parse_list)
#define NAMED(field, what) IBL_OTHER(field, what, parse_name)

/* clang-format off */
static const ibl_option sweep[] = {
    {"methods", 0, LIST(IBL_BENCH_METHOD),
     .allowed = "a list of auto, spectral, sampled, sampled-nomip",
     .standard = "all",
     .help = "the bake's --method; sampled-nomip is sampled with --pdf-mip no"},
    {"samples", 0, LIST(IBL_BENCH_SAMPLES),
     .allowed = "numbers from 1 to 1048576, separated by commas",
     .standard = STANDARD_SAMPLES,
     .help = "samples for each texel, with the methods that take some"},
    {"sizes", 0, LIST(IBL_BENCH_SIZE),
     .allowed = "numbers from 1 to 16384", .standard = STANDARD_SIZES,
     .help = "edges of the largest specular level"},
    {"threads", 0, LIST(IBL_BENCH_THREADS),
     .allowed = "numbers from 1 to 1024",
     .standard = "powers of two up to the CPUs for this process, and those",
     .help = "threads of a bake"},
    {"isa", 0, LIST(IBL_BENCH_ISA),
     .allowed = "a list of c, sse2, avx2, neon",
     .standard = "those of this CPU",
     .help = "instruction sets of the hot loops"},
    {"source-sizes", 0, LIST(IBL_BENCH_SOURCE),
     .allowed = "none, or widths from 2 to 65536 pixels",
     .standard = "a half of, once, twice and four times the map's, up to 8192",
     .help = "bake the map resampled to these widths, too, from Radiance "
             ".hdr files made for it"},
    {"full", 0, IBL_FLAG(full),
     .help = "every combination of the lists, not one list at a time round "
             "the base"},
    {"bake", 0, IBL_TEXT(bake, "OPTIONS"), .standard = "none",
     .help = "more options of every bake, as in a shell; not those that are "
             "swept"},
    {"variant", 0, NAMED(variants, "NAME=OPTIONS"),
     .allowed = "a name, = and options; up to 16 times", .standard = "none",
     .help = "also the base bake with these options added"},
    {"formats", 0, IBL_FLAG(formats),
     .help = "also the base bake in every pixel format and quality, without "
             "and with --zstd 19: bytes, error and time"},
};

static const ibl_option peers[] = {
    {"peer", 0, NAMED(peers, "NAME=COMMAND"),
     .allowed = "a name, = and a command; up to 16 times", .standard = "none",
     .help = "another tool, run through sh in the same turns; {env}, {out} "
             "and {name} stand for the environment, an empty directory and "
             "the environment's name"},
    {"peer-output", 0, NAMED(outputs, "NAME=ARGUMENTS"),
     .allowed = "a peer's name, = and arguments; up to 16 times",
     .standard = "none",
     .help = "what that peer leaves, as the arguments of iblbake verify after "
             "ENV, with {out} and {name} in them; then it is judged as well"},
};

static const ibl_option runs[] = {
    {"rounds", 0, IBL_INT(rounds, 1, IBL_BENCH_ROUNDS),
     .help = "counted rounds; one more before them is not counted"},
    {"timeout", 0, IBL_REAL(timeout_s, "SECONDS", 0.1, 86400),
     .help = "give up on a command that takes longer"},
    {"texels", 0, IBL_INT(texels, 0, 1048576),
     .allowed = "0 or 24 to 1048576",
     .help = "texels of each level that are compared with the reference; 0: "
             "none, only times"},
    {"rendered", 0, IBL_INT(rendered, 0, 65536),
     .allowed = "0 or 24 to 65536",
     .help = "also judge what a shader draws with the files, by so many "
             "directions; takes seconds for each command; 0: not"},
    {"quiet", 'q', IBL_FLAG(common.quiet),
     .help = "print only errors and the table"},
    {"verbose", 'v', IBL_FLAG(common.verbose),
     .help = "print each command before the first round"},
    {"help", 'h', .kind = IBL_OPTION_HELP, .help = "print this text"},
    {"version", 0, .kind = IBL_OPTION_PRINT, .print = ibl_version_print,
     .help = "print the version and what it was built with"},
};

static const ibl_option reports[] = {
    {"csv", 0, IBL_TEXT(csv, "FILE"), .standard = "",
     .help = "the table for programs, one line a level"},
    {"json", 0, IBL_TEXT(json, "FILE"), .standard = "",
     .help = "everything that was measured, each round of it"},
    {"html", 0, IBL_TEXT(html, "FILE"), .standard = "",
     .help = "a report with plots, in one file"},
};
/* clang-format on */

static const ibl_section *const sections[] = {
    IBL_SECTION("Sweep", sweep),     IBL_SECTION("Peers", peers),
    IBL_SECTION("Reports", reports), &ibl_input_section,
    IBL_SECTION("Running", runs),    NULL,
};

static void defaults(void *settings)
{
    ibl_bench_opts *o = settings;

    *o = (ibl_bench_opts){.common = ibl_common_default(),
                          .rounds = 3,
                          .timeout_s = 600,
                          .texels = 128};
    for (int axis = 0; axis < IBL_BENCH_AXES; axis++)
        o->lists[axis].axis = (ibl_bench_axis)axis;
}

/* Fills the lists that were not given, except sources: their default depends on
 * the maps. */
static void fill_defaults(ibl_bench_opts *o)
{
    ibl_bench_list *threads = &o->lists[IBL_BENCH_THREADS];
    ibl_bench_list *isas = &o->lists[IBL_BENCH_ISA];
    const int cpus = ibl_cpu_count();

    for (int axis = 0; axis < IBL_BENCH_AXES; axis++)
        if (!o->lists[axis].count && axes[axis].standard)
            parse_list(&o->lists[axis], axes[axis].standard);
    if (!threads->count) {
        for (int n = 1; n < cpus; n *= 2)
            put(threads, n);
        put(threads, cpus);
    }
    if (!isas->count)
        for (int isa = IBL_ISA_C; isa < IBL_ISA_COUNT; isa++)
            if (ibl_isa_supported((ibl_isa)isa))
                put(isas, isa);
}

static bool take(void *settings, const char *word)
{
    ibl_bench_opts *o = settings;

    if (o->env_count == IBL_BENCH_NAMED)
        return ibl_misuse("%s: more than %d environments: leave some out", word,
                          IBL_BENCH_NAMED);
    if (!strcmp(word, "-"))
        return ibl_misuse("-: standard input can be read only once: give a "
                          "file");
    if (!*word)
        return ibl_misuse("the environment's name is empty: give a file");
    o->envs[o->env_count++] = word;
    return true;
}

static bool check_isas(const ibl_bench_opts *o)
{
    const ibl_bench_list *list = &o->lists[IBL_BENCH_ISA];

    for (int i = 0; i < list->count; i++)
        if (!ibl_isa_supported((ibl_isa)list->values[i]))
            return ibl_misuse("--isa %s: the best that this CPU has is %s",
                              ibl_isa_name((ibl_isa)list->values[i]),
                              ibl_isa_name(ibl_isa_best()));
    return true;
}

/* Options that this command sets: for every bake, then for swept ones. */
static const char *const own[] = {
    "--output", "-o",     "--name", "--timings", "--depfile", "--preview",
    "--verify", "--help", "-h",     "--version", "--method",  "--samples",
    "--size",   "-j",     "--isa",  "--pdf-mip", "--threads"};
enum {
    OWN_OF_EACH = 10,
    OWN = sizeof own / sizeof *own
};

/* Whether a word is an option, maybe with its value: --long=VALUE, -sVALUE. */
static bool is_option(const char *word, const char *option)
{
    const size_t length = strlen(option);

    return !strncmp(word, option, length) &&
           (option[1] != '-' || !word[length] || word[length] == '=');
}

/* Rejects the first `count` options of own in the options for a bake. */
static bool check_bake(const char *option, const char *text, int count)
{
    char **words = text ? ibl_words_split(text) : NULL;
    bool ok = true;

    if (text && !words)
        return ibl_misuse("%s %s: an open quote, or no memory: close it",
                          option, text);
    for (int i = 0; words && words[i] && ok; i++)
        for (int j = 0; j < count && ok; j++)
            if (is_option(words[i], own[j]))
                ok = ibl_misuse("%s %s: %s is set by iblbake bench: leave it "
                                "out",
                                option, text, own[j]);
    free(words);
    return ok;
}

int ibl_bench_find_name(const ibl_bench_names *names, const char *name)
{
    for (int i = 0; i < names->count; i++)
        if (!strcmp(names->name[i], name))
            return i;
    return -1;
}

static bool check_twice(const char *option, const ibl_bench_names *names)
{
    for (int i = 0; i < names->count; i++)
        if (ibl_bench_find_name(names, names->name[i]) < i)
            return ibl_misuse("%s %s=...: that name twice: choose another",
                              option, names->name[i]);
    return true;
}

static bool check_names(const ibl_bench_opts *o)
{
    bool ok = check_bake("--bake", o->bake, OWN);

    for (int i = 0; i < o->variants.count && ok; i++)
        ok = check_bake("--variant", o->variants.text[i], OWN_OF_EACH);
    ok = ok && check_twice("--variant", &o->variants) &&
         check_twice("--peer", &o->peers) &&
         check_twice("--peer-output", &o->outputs);
    for (int i = 0; i < o->outputs.count && ok; i++)
        if (ibl_bench_find_name(&o->peers, o->outputs.name[i]) < 0)
            ok = ibl_misuse("--peer-output %s=...: there is no --peer of "
                            "that name",
                            o->outputs.name[i]);
    return ok;
}

static bool validate(void *settings)
{
    ibl_bench_opts *o = settings;

    if (!o->env_count)
        return ibl_misuse("no environment: iblbake bench [options] ENV..., see "
                          "iblbake bench --help");
    if (o->texels && o->texels < 24)
        return ibl_misuse("--texels %d: too few to tell: %d or more, or 0 for "
                          "none",
                          o->texels, 24);
    if (o->rendered && o->rendered < IBL_RENDERED_LEAST)
        return ibl_misuse("--rendered %d: too few to tell: %d or more, or 0 "
                          "for none",
                          o->rendered, IBL_RENDERED_LEAST);
    if (!o->texels && (o->rendered || o->outputs.count))
        return ibl_misuse("--%s: --texels 0 judges nothing: leave one of them "
                          "out",
                          o->rendered ? "rendered" : "peer-output");
    bool sampled = !o->lists[IBL_BENCH_SAMPLES].count;
    fill_defaults(o);
    for (int i = 0; i < o->lists[IBL_BENCH_METHOD].count; i++)
        sampled |=
            ibl_bench_takes_samples(o->lists[IBL_BENCH_METHOD].values[i]);
    if (!sampled)
        return ibl_misuse("--samples: no method takes so many: add sampled to "
                          "--methods, or leave it out");
    return check_isas(o) && check_names(o) && ibl_common_validate(&o->common);
}

const ibl_command ibl_bench_command = {
    .name = "bench",
    .usage = "[options] ENV...",
    .brief = "measure bakes, and other tools, by time and by error",
    .intro =
        "Bakes the environments with many settings, and lets other tools do "
        "the\n"
        "same, all in turns, and prints how long each took (medians), its "
        "memory\n"
        "and how far it is off the reference. The base that the sweeps go "
        "round is\n"
        "the bake's default where the lists have it, else their first value.\n",
    .statuses = "0 done, 1 failed, 2 wrong usage",
    .sections = sections,
    .settings_size = sizeof(ibl_bench_opts),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = ibl_bench_run,
};
