/* SPDX-License-Identifier: MIT */
/* The command line of iblbake probes. */
#include <string.h>

#include "cli/probes.h"
#include "common/names.h"
#include "json/text.h"

#define FROM_SET "what the set says"

static const char *const alphas[] = {"ignore", "file", "straight", NULL};
static const char *const mappings[] = {"linear", "filament", NULL};

static bool parse_irradiance(void *field, const char *value)
{
    const char *end;

    if (!strcmp(value, "sh")) {
        *(int *)field = 0;
        return true;
    }
    return ibl_number_int(value, 1, IBL_MAX_CUBE_SIZE, field, &end) && !*end;
}

#define IBL_SETTINGS ibl_probes_opts

/* clang-format off */
static const ibl_option outputs[] = {
    {"output", 'o', IBL_DIR(output), .standard = "",
     .help = "directory of the outputs, made if it is not there; required. Of "
             "several sets each has one there, of its name. With --grid the "
             "file that the set is written to, or else standard output",
     .aside = true},
    {"force", 0, IBL_FLAG(force),
     .help = "bake also what did not change since a former run", .aside = true},
    {"shard", 0, IBL_OTHER(shard, "K/N", ibl_shard_parse),
     .allowed = IBL_SHARD_ALLOWED, .standard = "all sets",
     .help = "bake part K of N of the sets, for N runs on any machines",
     .aside = true},
    {"grid", 0, IBL_FLAG(grid),
     .help = "bake nothing: SET.json describes a grid, of which a set is made"},
    {"sync", 0, IBL_FLAG(sync),
     .help = "wait until everything is on the disk, so that a power cut "
             "leaves whole files",
     .aside = true},
};

static const ibl_option settings[] = {
    {"alpha", 0, IBL_CHOICE(said.alpha, alphas), .standard = FROM_SET,
     .help = "alpha of captures: drop it, take colours as the file's format "
             "says, or as not yet multiplied by it"},
    {"container", 0, IBL_CHOICE(said.container, ibl_array_container_names),
     .standard = FROM_SET,
     .help = "container of the arrays, and the extension of their files"},
    {"zstd", 0, IBL_INT(said.zstd, 0, IBL_MAX_ZSTD), .standard = FROM_SET,
     .help = "compress ktx2 files with Zstandard of level N; 0: do not"},
    {"pixel", 0, IBL_CHOICE(said.texels.pixel, ibl_pixel_names),
     .standard = FROM_SET,
     .help = "texels of the arrays"},
    {"quality", 0, IBL_CHOICE(said.texels.quality, ibl_quality_names),
     .standard = FROM_SET,
     .help = "of bc6h, uastc-hdr and astc4x4hdr: more time, less error"},
    {"overflow", 0,
     IBL_CHOICE(said.texels.overflow, ibl_overflow_names), .standard = FROM_SET,
     .help = "light of texels brighter than the pixel holds: spread over the "
             "texels around them, or clip"},
    {"size", 0,
     IBL_INT(said.options.specular_options.size, 1, IBL_MAX_CUBE_SIZE),
     .standard = FROM_SET,
     .help = "edge of the largest specular level in texels"},
    {"levels", 0,
     IBL_INT(said.options.specular_options.levels, 1, IBL_MAX_LEVELS),
     .standard = FROM_SET, .help = "number of specular levels"},
    {"irradiance", 0,
     IBL_OTHER(said.options.irradiance_options.size, "N", parse_irradiance),
     .allowed = "1 to 16384 or sh", .standard = FROM_SET,
     .help = "edge of the irradiance cubes; sh: spherical harmonics in the "
             "index instead"},
    /* Members of "defaults" only: */
    {"mapping", 0,
     IBL_CHOICE(said.options.specular_options.mapping, mappings)},
    {"method", 0,
     IBL_CHOICE(said.options.specular_options.method, ibl_method_names)},
    {"samples", 0, IBL_INT(said.options.specular_options.samples, 1, 1048576)},
    {"tolerance", 0,
     IBL_REAL(said.options.specular_options.tolerance, "T", 1e-6, 1)},
    {"lut_size", 0, IBL_INT(said.lut_size, 1, 4096)},
};
/* clang-format on */

enum {
    SETTINGS = sizeof settings / sizeof *settings,
    OFFERED = SETTINGS - 5 /* on the command line */
};

static const ibl_section *const sections[] = {
    IBL_SECTION("Outputs", outputs),
    &(const ibl_section){"In place of what the set says", settings, OFFERED,
                         sizeof *settings},
    &ibl_input_section,
    &ibl_running_section,
    NULL,
};

static void defaults(void *opts)
{
    *(ibl_probes_opts *)opts =
        (ibl_probes_opts){.common = ibl_common_default()};
}

/* The field of a setting. */
static void *field_of(const ibl_option *o, ibl_set_bake *bake)
{
    return (char *)bake + (o->offset - offsetof(ibl_probes_opts, said));
}

void ibl_probes_override(const ibl_probes_opts *o, ibl_set_bake *bake)
{
    /* The set's number of levels belongs to the set's size. */
    if (ibl_is_given(&o->given, "size"))
        bake->options.specular_options.levels = 0;
    for (int i = 0; i < SETTINGS; i++)
        if (ibl_is_given(&o->given, settings[i].name))
            memcpy(field_of(&settings[i], bake),
                   (const char *)o + settings[i].offset, sizeof(int));
}

bool ibl_probes_defaults(ibl_json_at at, ibl_set_bake *bake)
{
    const char *keys[SETTINGS + 1] = {0};
    bool ok = true;

    for (int i = 0; i < SETTINGS && ok; i++) {
        const ibl_option *o = &settings[i];
        const ibl_json_at m = ibl_json_optional(&at, o->name);
        void *field = field_of(o, bake);
        char text[32];
        keys[i] = o->name;
        if (o->kind == IBL_OPTION_INT) {
            ok = ibl_json_int(m, (int)o->low, (int)o->high, field);
        } else if (o->kind == IBL_OPTION_REAL) {
            ok = ibl_json_real(m, o->low, o->high, false, field);
        } else if (o->kind == IBL_OPTION_CHOICE) {
            ok = ibl_json_choice(m, o->choices, field);
        } else if (m.value) {
            const char *word = json_string_value(m.value);
            snprintf(text, sizeof text, "%" JSON_INTEGER_FORMAT,
                     json_integer_value(m.value));
            ok = o->parse(field, word ? word : text) ||
                 ibl_json_wrong(m, "%s", o->allowed);
        }
    }
    return ok && ibl_json_object(at, keys);
}

static bool take(void *opts, const char *word)
{
    ibl_probes_opts *o = opts;

    if (!*word || !strcmp(word, "-"))
        return ibl_misuse("a set is a file, beside which its captures are "
                          "looked for: give its name");
    if (o->count == IBL_MOST_SETS)
        return ibl_misuse("%s: more than %d sets: give them to several calls",
                          word, IBL_MOST_SETS);
    o->input[o->count++] = word;
    return true;
}

enum {
    BAKES = 1 << 0,
    WRITES = 1 << 1 /* files */
};

static const ibl_rule rules[] = {
    {"force shard alpha container zstd pixel quality overflow size levels "
     "irradiance " IBL_INPUT_OPTIONS,
     BAKES, "--grid bakes nothing: leave out one of them"},
    {"sync", WRITES, "standard output is no file: add -o FILE"},
    {.options = NULL}};

static bool validate(void *opts)
{
    const ibl_probes_opts *o = opts;

    if (!o->count)
        return ibl_misuse("no set: iblbake probes [options] SET.json... -o "
                          "DIR, see iblbake probes --help");
    if (o->count > 1 && o->grid)
        return ibl_misuse("%s: a second grid after %s: make sets of one at a "
                          "time",
                          o->input[1], o->input[0]);
    if (!o->output && !o->grid)
        return ibl_misuse("no output directory: add -o DIR");
    if (o->shard.count > o->count)
        return ibl_misuse("--shard %d/%d: parts are of whole sets, of which "
                          "there are %d: take at most %d shards",
                          o->shard.number, o->shard.count, o->count, o->count);
    return ibl_check_rules(&o->given, rules,
                           (o->grid ? 0 : (unsigned)BAKES) |
                               (o->output ? (unsigned)WRITES : 0)) &&
           ibl_common_validate(&o->common);
}

const ibl_command ibl_probes_command = {
    .name = "probes",
    .usage = "[options] SET.json... -o DIR",
    .brief = "bake sets of reflection probes into cube arrays",
    .intro =
        "Bakes the reflection probes that SET.json names, if anything changed "
        "since the\n"
        "last time, into what an engine loads:\n"
        "  DIR/probes_specular.EXT    cube array, a layer for each probe\n"
        "  DIR/probes_irradiance.EXT  cube array, E/pi\n"
        "  DIR/brdf_lut.EXT           scale and bias of F0\n"
        "  DIR/index.json             probes with their layers and volumes\n",
    .statuses = "0 done, 1 failed, 2 wrong usage",
    .sections = sections,
    .settings_size = sizeof(ibl_probes_opts),
    .given = offsetof(ibl_probes_opts, given),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = ibl_probes_run,
};
