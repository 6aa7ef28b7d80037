/* SPDX-License-Identifier: MIT */
/* iblbake verify: compares baked files with the exact sums. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/console.h"
#include "cli/judge.h"
#include "cli/probes.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "json/json_text.h"

typedef struct verify_opts {
    ibl_common common;
    const char *input;     /* the environment; NULL: judge only a table */
    const char *directory; /* NULL: use only files */
    const char *probe;     /* for messages: of a set's probe, or NULL */
    ibl_set_options set;
    ibl_set_facts facts; /* those that were given are known */
    int scale;           /* of irradiance, in scale_names */
    ibl_judge_options judge;
    int rendered; /* 1: judge what a shader draws, not texels */
    int directions;
    ibl_shader shader;
    double max_error, max_rendered_error; /* NAN: no limit */
    const char *json;                     /* "-": standard output */
    char stem[256]; /* buffer of the set's name if it comes from input */
    ibl_given given;
} verify_opts;

/* ---- options --------------------------------------------------------- */

static const char *const scale_names[] = {"E/pi", "E", NULL};

static bool parse_roughness_map(void *field, const char *value)
{
    ibl_set_facts *f = field;
    const int named = ibl_names_find(ibl_mapping_names, value);

    f->known &= ~(unsigned)(IBL_KNOWN_MAPPING | IBL_KNOWN_ROUGHNESS);
    f->known |= named >= 0 ? IBL_KNOWN_MAPPING : IBL_KNOWN_ROUGHNESS;
    f->mapping = named >= 0 ? (ibl_roughness_map)named : IBL_ROUGHNESS_LINEAR;
    f->levels = named >= 0 ? 0
                           : ibl_number_list(value, ',', 0, 1, f->roughness,
                                             IBL_MAX_LEVELS);
    return named >= 0 || f->levels;
}

#define IBL_SETTINGS verify_opts

/* clang-format off */
static const ibl_option files[] = {
    {"name", 0, IBL_TEXT(set.name, "NAME"),
     .standard = "ENV without directory and extension",
     .help = "the files in DIR are NAME_specular.EXT and so on"},
    {"specular", 0,
     IBL_TEXT(set.file[IBL_CONTENT_SPECULAR], "FILE"), .standard = "",
     .help = "a specular cube: KTX2, KTX or DDS"},
    {"irradiance", 0, IBL_TEXT(set.file[IBL_CONTENT_IRRADIANCE], "FILE"),
     .standard = "", .help = "a diffuse cube"},
    {"skybox", 0, IBL_TEXT(set.file[IBL_CONTENT_SKYBOX], "FILE"),
     .standard = "", .help = "the environment as a cube"},
    {"lut", 0, IBL_TEXT(set.file[IBL_CONTENT_LUT], "FILE"), .standard = "",
     .help = "a BRDF table; without other files it needs no ENV"},
    {"array-layer", 0, IBL_INT(set.layer, 0, IBL_MAX_PROBES - 1),
     .standard = "none",
     .help = "the layer that is judged of arrays of cubes"},
};

static const ibl_option meaning[] = {
    {"lobe", 0, IBL_CHOICE(facts.lobe, ibl_lobe_names),
     .standard = "what the files say, else ggx",
     .help = "lobe of the specular levels"},
    {"roughness-map", 0, IBL_OTHER(facts, "MAP", parse_roughness_map),
     .allowed = "linear, filament, babylon or a list of each level's, as "
                "0,0.5,1",
     .standard = "what the files say, else linear",
     .help = "roughness of the specular levels"},
    {"rotate", 0, IBL_REAL(facts.yaw_deg, "DEG", -360, 360),
     .standard = "what the files say, else 0",
     .help = "rotation of the environment about +Y in the bake"},
    {"lights", 0, IBL_INT(facts.lights, 0, IBL_MAX_LIGHTS),
     .standard = "what the files say, else 0",
     .help = "compact sources that the bake took out of all but the skybox"},
    {"mirror", 0, IBL_CHOICE(facts.axes.mirror, ibl_mirror_names),
     .standard = "what the files say, else none",
     .help = "axis of the world that the files have negated, or two exchanged"},
    {"up", 0, IBL_CHOICE(facts.axes.up, ibl_up_names),
     .standard = "what the files say, else y",
     .help = "axis of the files that points up"},
    {"irradiance-scale", 0, IBL_CHOICE(scale, scale_names),
     .standard = "what the files say, else E/pi",
     .help = "scale of the irradiance"},
    {"lut-kind", 0, IBL_CHOICE(facts.table, ibl_lut_names),
     .standard = "what the files say, else split",
     .help = "what the table holds"},
    {"geometry", 0, IBL_CHOICE(facts.geometry, ibl_geometry_names),
     .standard = "what the files say, else smith",
     .help = "shadowing and masking of the table"},
};

static const ibl_option judging[] = {
    {"texels", 0, IBL_INT(judge.texels, 24, 1000000),
     .help = "approximate number of texels to judge in each level"},
    {"all", 0, IBL_FLAG(judge.all), .help = "judge every texel; slow"},
    {"seed", 0, IBL_INT(judge.seed, 0, 1000000000),
     .help = "another seed judges other texels"},
    {"max-error", 0, IBL_REAL(max_error, "E", 0, 1000), .standard = "none",
     .help = "exit with status 1 if the nRMSE of a level, the largest error "
             "of the table or that of the harmonics is above E, or a texel is "
             "not finite"},
};

static const ibl_option rendering[] = {
    {"rendered", 0, IBL_FLAG(rendered),
     .help = "judge what a shader draws with the files, not their texels"},
    {"shader", 0, IBL_CHOICE(shader, ibl_shader_names),
     .help = "how the shader looks up reflections, as in ibl.glsl; auto: by "
             "the lobe table if there is one, else split"},
    {"lobe-table", 0, IBL_TEXT(set.file[IBL_CONTENT_LOBE_TABLE], "FILE"),
     .standard = "", .help = "the lobe table"},
    {"directions", 0, IBL_INT(directions, IBL_RENDERED_LEAST, 65536),
     .help = "pairs of a normal and a view"},
    {"max-rendered-error", 0, IBL_REAL(max_rendered_error, "E", 0, 1000),
     .standard = "none",
     .help = "exit with status 1 if the nRMSE of an F0, the mean over the "
             "roughnesses, is above E"},
};

static const ibl_option results[] = {
    {"json", 0, IBL_TEXT(json, "FILE"), .standard = "",
     .help = "the table as JSON; -: to standard output, in place of the table"},
};
/* clang-format on */

static const ibl_gone gone[] = {
    {"axes", "give --mirror and --up"},
    {"heatmap", "the table says where the largest error is"},
    {"plot", "--json has the figures"},
    {"f0 roughness lod", "the table has both F0 and all roughnesses"},
    {"overflow", "the bake warns of it"},
    {"face-names", "give a KTX2, KTX or DDS file"},
    {"lobe=auto mirror=auto up=auto irradiance-scale=auto lut-kind=auto "
     "geometry=auto",
     "leave it out"},
    {"rotate=learnopengl rotate=threejs rotate=cmgen",
     "give degrees: 0, for cmgen -90"},
    {.words = NULL}};

static const ibl_section *const sections[] = {
    IBL_SECTION("Files", files),
    IBL_SECTION("What the files mean", meaning),
    IBL_SECTION("Judging", judging),
    IBL_SECTION("Judging what is rendered", rendering),
    IBL_SECTION("Results", results),
    &ibl_input_section,
    &ibl_running_section,
    NULL,
};

static void defaults(void *settings)
{
    *(verify_opts *)settings =
        (verify_opts){.common = ibl_common_default(),
                      .set = ibl_set_options_default(),
                      .judge = ibl_judge_options_default(),
                      .directions = IBL_RENDERED_DIRECTIONS,
                      .max_rendered_error = NAN,
                      .max_error = NAN};
}

static bool take(void *settings, const char *word)
{
    verify_opts *o = settings;

    if (!*word)
        return ibl_misuse("an empty argument: verify takes ENV and DIR");
    if (o->directory)
        return ibl_misuse("%s: a third argument after %s and %s: verify takes "
                          "ENV and DIR",
                          word, o->input, o->directory);
    *(o->input ? &o->directory : &o->input) = word;
    return true;
}

/* What is judged, for the rules: 1 << ibl_content of files that were found, */
enum {
    FOUND_SPLIT = 1 << IBL_CONTENTS, /* a table of the split sum, */
    FOUND = 2 * FOUND_SPLIT - 1,
    OF_TEXELS = 2 * FOUND_SPLIT,   /* and what was asked */
    SOME_TEXELS = 4 * FOUND_SPLIT, /* not all of each level */
    OF_RENDERED = 8 * FOUND_SPLIT,
    OF_MAP = 16 * FOUND_SPLIT,
    IN_DIRECTORY = 32 * FOUND_SPLIT
};
#define SPECULAR (1u << IBL_CONTENT_SPECULAR)
#define IRRADIANCE (1u << IBL_CONTENT_IRRADIANCE)

static const ibl_rule rules[] = {
    {"texels all max-error skybox", OF_TEXELS,
     "--rendered judges no texels: leave one of them out"},
    {"texels seed", SOME_TEXELS | OF_RENDERED, "--all judges every texel"},
    {"shader lobe-table directions max-rendered-error", OF_RENDERED,
     "is for what is drawn: add --rendered"},
    {"rotate lights " IBL_INPUT_OPTIONS, OF_MAP,
     "a table needs no environment: leave it out"},
    {"name", IN_DIRECTORY, "is of files in a directory: add it"},
    {"lobe roughness-map", SPECULAR, "there is no specular map: leave it out"},
    {"irradiance-scale", IRRADIANCE,
     "there is no irradiance map: leave it out"},
    {"lut-kind", 1u << IBL_CONTENT_LUT, "there is no table: leave it out"},
    {"geometry", FOUND_SPLIT,
     "there is no table of the split sum: leave it out"},
    {"lights", SPECULAR | IRRADIANCE,
     "there is no specular or irradiance map: leave it out"},
    {"rotate mirror up " IBL_INPUT_OPTIONS,
     SPECULAR | IRRADIANCE | 1u << IBL_CONTENT_SKYBOX,
     "there is no map: leave it out"},
    {.options = NULL}};

/* A set of probes, as of iblbake probes, in place of an environment. */
static bool is_of_probes(const verify_opts *o)
{
    const char *dot = o->input ? strrchr(o->input, '.') : NULL;

    return dot && !strcmp(dot, ".json");
}

static bool validate(void *settings)
{
    static const struct {
        const char *options;
        unsigned bit;
    } known[] = {
        {"lobe", IBL_KNOWN_LOBE},      {"irradiance-scale", IBL_KNOWN_SCALE},
        {"lut-kind", IBL_KNOWN_TABLE}, {"geometry", IBL_KNOWN_GEOMETRY},
        {"mirror up", IBL_KNOWN_AXES}, {"lights", IBL_KNOWN_LIGHTS},
        {"rotate", IBL_KNOWN_YAW}};
    verify_opts *o = settings;
    ibl_set_facts *f = &o->facts;
    const bool lut = o->set.file[IBL_CONTENT_LUT];
    bool cubes = false;

    for (int c = 0; c < IBL_CONTENT_LUT; c++)
        cubes |= o->set.file[c] != NULL;
    if (is_of_probes(o) && (!o->directory || cubes || lut || o->json ||
                            o->set.layer >= 0 || o->set.name))
        return ibl_misuse("%s: a set of probes is judged by the directory of "
                          "its bake, without --name, --array-layer, files and "
                          "--json",
                          o->input);
    if (!o->input && (cubes || !lut || o->rendered))
        return ibl_misuse("no environment: iblbake verify [options] ENV DIR, "
                          "see iblbake verify --help");
    if (!o->directory && !cubes && !lut)
        return ibl_misuse("nothing to judge: add the directory of the bake, or "
                          "--specular, --irradiance, --skybox or --lut");
    if (!ibl_common_validate(&o->common) ||
        !ibl_check_rules(&o->given, rules,
                         FOUND | (o->rendered ? OF_RENDERED : OF_TEXELS) |
                             (o->judge.all ? 0 : SOME_TEXELS) |
                             (o->input ? OF_MAP : 0) |
                             (o->directory ? IN_DIRECTORY : 0)))
        return false;
    if (!o->set.name && !is_of_probes(o)) {
        if (!ibl_stem(o->input, o->stem, sizeof o->stem))
            return false;
        o->set.name = o->stem;
    }
    f->irradiance_scale = o->scale ? 1 / M_PI : 1;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (ibl_given_of(&o->given, known[i].options))
            f->known |= known[i].bit;
    o->set.facts = f;
    o->set.leave =
        1u << (o->rendered ? IBL_CONTENT_SKYBOX : IBL_CONTENT_LOBE_TABLE);
    return true;
}

/* ---- files ----------------------------------------------------------- */

typedef struct verify {
    const verify_opts *o;
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_set set;
    ibl_cube cube[IBL_CONTENT_LUT]; /* of the set, without textures */
    ibl_lut lut;
    ibl_image env, rest; /* rest: without the lights */
    double yaw_deg;
    ibl_light lights[IBL_MAX_LIGHTS];
    int light_count;
} verify;

/* Only level 0 of irradiance is judged. */
static void scale(const ibl_cube *irradiance, float by)
{
    const ibl_level_shape s =
        ibl_level_shape_of(irradiance->projection, irradiance->size);

    for (size_t i = 0; i < (size_t)3 * s.faces * s.width * s.height; i++)
        irradiance->data[i] *= by;
}

/* Reads the set, and what of it is judged as cubes and a table. */
static bool read_files(verify *v)
{
    const verify_opts *o = v->o;
    double need = IBL_PROGRAM_BYTES;
    unsigned found = o->rendered ? FOUND_SPLIT : 0;

    ibl_console_progress(v->console, "read", 0);
    if (ibl_set_open(v->ctx, o->directory, &o->set, &v->set))
        return false;
    for (int c = 0; c < IBL_CONTENTS; c++)
        need += 3.0 * sizeof(float) * (double)v->set.file[c].texture.bytes /
                (double)ibl_pixel_bytes(v->set.file[c].texture.pixel);
    bool ok = ibl_console_fits(
        v->console, &o->common, o->directory ? o->directory : o->input, need,
        "judge fewer files at once, by --specular and its like");
    for (int c = 0; c < IBL_CONTENTS && ok; c++) {
        ibl_set_file *f = &v->set.file[c];
        found |= f->path ? 1u << c : 0;
        if (f->missing)
            ok = ibl_console_fail(
                v->console, "%s: %s names it, but it is not there: bake again",
                f->path, v->set.sidecar);
        else if (f->path && c == IBL_CONTENT_LUT)
            ok = !ibl_texture_to_lut(v->ctx, &f->texture, &v->lut);
        else if (f->path && c < IBL_CONTENT_LUT) {
            ok = !ibl_texture_to_cube(v->ctx, &f->texture, &v->cube[c]);
            if (ok && c == IBL_CONTENT_IRRADIANCE)
                scale(&v->cube[c], (float)f->facts.irradiance_scale);
            ibl_bytes_free(f->texture.data); /* as floats from here on */
            f->texture.data = NULL;
        }
    }
    found |= v->lut.data && !v->lut.kind ? FOUND_SPLIT : 0;
    if (ok && !ibl_check_rules(&o->given, rules, found | ~FOUND))
        v->console->failed = true;
    return ok && !v->console->failed;
}

/* Reads the environment, as the files say that it was read. */
static bool read_map(verify *v)
{
    const ibl_set_file *file = v->set.file;
    const ibl_read_options *said = &v->set.read;
    ibl_read_options read = v->o->common.read;
    const ibl_set_file *first = NULL;
    int lights = 0;

    for (int c = IBL_CONTENT_LUT - 1; c >= 0; c--) {
        const ibl_set_facts *f = &file[c].facts;
        const int own = c == IBL_CONTENT_SKYBOX ? lights : f->lights;
        if (!file[c].path)
            continue;
        if (first &&
            (fabs(f->yaw_deg - first->facts.yaw_deg) > 0 || own != lights))
            return ibl_console_fail(
                v->console,
                "%s: baked with --rotate %g and %d lights taken out, another "
                "file with %g and %d: judge one at a time",
                file[c].path, f->yaw_deg, own, first->facts.yaw_deg, lights);
        first = &file[c];
        lights = own;
    }
    v->yaw_deg = v->o->facts.known & IBL_KNOWN_YAW ? v->o->facts.yaw_deg
                                                   : v->set.yaw_deg;
    read.transfer = read.transfer ? read.transfer : said->transfer;
    read.primaries = read.primaries ? read.primaries : said->primaries;
    read.exposure = fabs(read.exposure) > 0 ? read.exposure : said->exposure;
    read.clamp = read.clamp > 0 ? read.clamp : said->clamp;
    ibl_console_progress(v->console, "decode", 0);
    if (ibl_image_read(v->ctx, v->o->input, &read, &v->env, NULL))
        return false;
    if (lights <= 0)
        return true;
    const size_t n = (size_t)v->env.width * (size_t)v->env.height;
    if (ibl_image_alloc(v->ctx, v->env.width, v->env.height, &v->rest))
        return false;
    memcpy(v->rest.data, v->env.data, 3 * sizeof(float) * n);
    return !ibl_image_take_lights(v->ctx, &v->rest, v->yaw_deg, lights,
                                  v->lights, &v->light_count);
}

/* ---- judging --------------------------------------------------------- */

static bool judge_texels(const verify *v, ibl_report *report)
{
    const ibl_image *images[2] = {&v->env, &v->rest};
    ibl_judge *judges[2] = {NULL, NULL};
    bool ok = true;

    for (int k = 0; k < 2 && ok; k++)
        ok = !images[k]->data ||
             (judges[k] = ibl_judge_create(v->ctx, images[k], v->yaw_deg));
    const ibl_judge *rest = judges[v->rest.data != NULL];
    for (int c = 0; c < IBL_CONTENT_LUT && ok; c++) {
        const ibl_set_facts *facts = &v->set.file[c].facts;
        const ibl_cube *cube = &v->cube[c];
        /* Mips of irradiance serve minification. */
        const ibl_judged judged = {
            .content = (ibl_output_kind)c,
            .chain = *cube,
            .levels = c == IBL_CONTENT_IRRADIANCE ? 1 : cube->levels,
            .lobe = facts->lobe,
            .roughness = c == IBL_CONTENT_SPECULAR ? facts->roughness : NULL};
        if (!cube->data)
            continue;
        ibl_console_progress(v->console, ibl_output_names[judged.content], 0);
        ok = ibl_report_levels(
            report, c == IBL_CONTENT_SKYBOX ? judges[0] : rest, &judged);
    }
    if (ok && rest && v->set.sh_degree >= 0)
        ok = ibl_report_sh(report, rest, v->set.sh_degree, v->set.sh);
    ibl_console_progress(v->console, "lut", 0);
    if (ok && v->lut.data)
        ok = ibl_report_lut(report, v->ctx, &v->lut,
                            v->set.file[IBL_CONTENT_LUT].facts.geometry);
    ibl_judge_free(judges[0]);
    ibl_judge_free(judges[1]);
    return ok;
}

/* RGBA decodes without alpha: each texel is two of two channels. */
static bool decode_lobes(const verify *v, ibl_lobe_table *lobes)
{
    const ibl_texture *t = &v->set.file[IBL_CONTENT_LOBE_TABLE].texture;
    const size_t texels =
        (size_t)t->layers * (size_t)t->width * (size_t)t->width;

    *lobes = (ibl_lobe_table){
        t->width, ibl_need(malloc(texels * 4 * sizeof(float))), t->layers};
    ibl_pixel_decode(t->pixel == IBL_PIXEL_RGBA16F ? IBL_PIXEL_RG16F
                                                   : IBL_PIXEL_RG32F,
                     t->data, 2 * texels, lobes->data);
    for (size_t i = 0; i < 4 * texels; i++)
        if (!isfinite(lobes->data[i]))
            return ibl_console_fail(v->console,
                                    "%s: holds values that are not finite",
                                    v->set.file[IBL_CONTENT_LOBE_TABLE].path);
    return true;
}

/* Finds what the shader draws with. */
static bool find_drawn(const verify *v, ibl_drawn *set)
{
    const ibl_set_file *levels = &v->set.file[IBL_CONTENT_SPECULAR];
    const ibl_cube *specular = &v->cube[IBL_CONTENT_SPECULAR];
    const ibl_cube *irradiance = &v->cube[IBL_CONTENT_IRRADIANCE];
    const bool table = v->set.file[IBL_CONTENT_LOBE_TABLE].path;
    const bool lit = irradiance->data || v->set.sh_degree >= 0;
    const ibl_shader shader = v->o->shader   ? v->o->shader
                              : table && lit ? IBL_SHADER_TABLE
                                             : IBL_SHADER_SPLIT;

    if (!specular->data)
        return ibl_console_fail(v->console,
                                "no specular cube, which is what --rendered "
                                "judges: add --specular");
    if (levels->facts.lobe != IBL_LOBE_GGX)
        return ibl_console_fail(
            v->console, "%s: of the lobe %s: --rendered judges ggx",
            levels->path, ibl_lobe_name(levels->facts.lobe));
    if (shader >= IBL_SHADER_FIT &&
        (!lit || (shader > IBL_SHADER_FIT && !table)))
        return ibl_console_fail(v->console,
                                "--shader %s: there is no %s: name it with "
                                "--%s",
                                ibl_shader_names[shader],
                                lit ? "lobe table" : "irradiance map",
                                lit ? "lobe-table" : "irradiance");
    *set = (ibl_drawn){.shader = shader,
                       .chain = levels->facts,
                       .specular = *specular,
                       .lights = v->lights,
                       .light_count = v->light_count};
    if (!v->lut.kind)
        set->lut = v->lut;
    if (irradiance->data) {
        set->irradiance = *irradiance;
    } else if (lit) {
        set->sh = v->set.sh;
        set->sh_degree = v->set.sh_degree;
    }
    return !table || decode_lobes(v, &set->lobes);
}

static bool judge_rendered(const verify *v, ibl_report *report)
{
    ibl_truth_options o = ibl_truth_options_default();
    ibl_truth truth = {0};
    ibl_drawn set = {.chain = {.levels = 0}};
    json_t *row;
    size_t i;

    o.directions = v->o->directions;
    o.seed = v->o->judge.seed;
    o.geometry = v->o->facts.known & IBL_KNOWN_GEOMETRY
                     ? v->o->facts.geometry
                     : v->set.file[IBL_CONTENT_LUT].facts.geometry;
    ibl_console_progress(v->console, "truth", 0);
    bool ok = find_drawn(v, &set) &&
              ibl_truth_make(v->ctx, &v->env, v->yaw_deg, &o, &truth);
    if (ok)
        ibl_report_drawn(report, &truth, &set);
    json_array_foreach(
        json_object_get(json_object_get(report->json, "rendered"), "rows"), i,
        row)
    {
        if (ok && !json_is_number(json_object_get(row, "nrmse")))
            ok = ibl_console_fail(v->console,
                                  "%s: it or what is drawn with it holds "
                                  "values that are not finite",
                                  v->set.file[IBL_CONTENT_SPECULAR].path);
    }
    ibl_truth_free(&truth);
    free(set.lobes.data);
    return ok;
}

/* Fails if --json would replace what is judged. */
static bool check_output(const verify *v)
{
    const char *inputs[IBL_CONTENTS + 2] = {v->o->input, v->set.sidecar};
    bool ok = true;

    for (int c = 0; c < IBL_CONTENTS; c++)
        inputs[c + 2] = v->set.file[c].path;
    for (int i = 0; i < IBL_CONTENTS + 2 && ok && v->o->json; i++)
        ok = !inputs[i] ||
             ibl_console_differ(v->console, inputs[i], v->o->json, "file");
    return ok;
}

/* ---- results --------------------------------------------------------- */

/* The text of --json. What is NULL, as a number that is none, is left out. */
static char *text_of_report(const verify *v, const ibl_report *report,
                            bool passed)
{
    const verify_opts *o = v->o;
    const bool limited = !isnan(o->max_error) || !isnan(o->max_rendered_error);
    json_t *paths = json_object();

    for (int c = 0; c < IBL_CONTENTS; c++)
        if (v->set.file[c].path)
            put(&paths, ibl_content_name((ibl_content)c),
                ibl_json_string(v->set.file[c].path));
    json_t *root =
        json_pack("{so* so sf so* so* so*}", "environment",
                  o->input ? ibl_json_string(o->input) : NULL, "files", paths,
                  "yaw_deg", v->yaw_deg, "max_error", json_real(o->max_error),
                  "max_rendered_error", json_real(o->max_rendered_error),
                  "passed", limited ? json_boolean(passed) : NULL);
    put_all(&root, json_incref(report->json));
    char *text = ibl_need(ibl_json_text(root));
    json_decref(root);
    return text;
}

static int run_one(const verify_opts *o)
{
    ibl_console console;
    verify v = {.o = o, .console = &console};
    ibl_outputs *outputs = NULL;
    ibl_report report = {.options = o->judge};
    const bool print_json = o->json && !strcmp(o->json, "-");
    bool needs_map = o->rendered;
    char why[200] = "";

    ibl_console_init(&console, o->common.quiet, o->common.verbose);
    bool ok = !ibl_start(&o->common, &console, &v.ctx) &&
              !ibl_outputs_create(v.ctx, 0, &outputs) && read_files(&v) &&
              check_output(&v);
    for (int c = 0; c < IBL_CONTENT_LUT; c++)
        needs_map |= v.cube[c].data != NULL;
    ok = ok && (!needs_map || read_map(&v)) &&
         (o->rendered ? judge_rendered : judge_texels)(&v, &report);
    ibl_console_finish(&console);
    if (ok) {
        const bool passed = ibl_report_passes(
            &report, o->max_error, o->max_rendered_error, why, sizeof why);
        char *json = o->json ? text_of_report(&v, &report, passed) : NULL;
        char *table = ibl_report_text(&report);
        if (o->json && !print_json)
            ok = !ibl_outputs_add(outputs, o->json, json, strlen(json));
        if (print_json || (ok && !o->common.quiet))
            fputs(print_json ? json : table, stdout);
        fflush(stdout); /* before later messages in a log */
        free(json);
        free(table);
        ok = ok && ibl_console_commit(&console, outputs) &&
             (passed ||
              ibl_console_fail(&console, "%s%s%s", o->probe ? o->probe : "",
                               o->probe ? ": " : "", why));
    }
    const int status = ibl_console_end(&console, ok);
    ibl_outputs_free(outputs);
    json_decref(report.json);
    for (int c = 0; c < IBL_CONTENT_LUT; c++)
        ibl_cube_free(&v.cube[c]);
    ibl_lut_free(&v.lut);
    ibl_image_free(&v.env);
    ibl_image_free(&v.rest);
    ibl_set_free(&v.set);
    ibl_ctx_free(v.ctx);
    return status;
}

/* Judges all layers of a set of probes by their captures, the table with the
 * first. */
static int run_probes(const verify_opts *opts)
{
    ibl_console console;
    ibl_probe_set set = {0};
    ibl_probe_index index = {0};
    verify_opts o = *opts;
    ibl_ctx *ctx = NULL;
    char *path = ibl_need(ibl_path_join(o.directory, "index.json"));
    bool passed = true;

    ibl_console_init(&console, o.common.quiet, o.common.verbose);
    bool ok = !ibl_start(&o.common, &console, &ctx) &&
              ibl_probe_set_read(o.input, &console, &set) &&
              !ibl_probe_index_read(ctx, path, &index);
    o.directory = path;
    for (int i = 0; i < set.layers && ok; i++) {
        const ibl_set_entry *e = &set.entry[i]; /* in the index's order */
        ok = (i == set.count ? i == index.global
                             : i < index.count && index.name[i] &&
                                   !strcmp(index.name[i], e->name)) ||
             ibl_console_fail(&console,
                              "%s: is not the set of %s: bake it again",
                              o.input, path);
        if (!ok)
            break;
        o.input = e->capture;
        o.set.layer = i;
        o.probe = *e->name ? e->name : "(global)";
        o.common.read.alpha = ibl_probes_alpha(&set, i);
        if (!o.common.quiet)
            printf("%.60s, layer %d: %s\n", o.probe, i, o.input);
        passed = !run_one(&o) && passed;
        o.set.leave |= 1u << IBL_CONTENT_LUT;
        o.input = opts->input;
    }
    free(path);
    ibl_probe_set_free(&set);
    ibl_probe_index_free(&index);
    ibl_ctx_free(ctx);
    return ibl_console_end(&console, ok) || !passed;
}

static int run(const void *settings)
{
    return (is_of_probes(settings) ? run_probes : run_one)(settings);
}

const ibl_command ibl_verify_command = {
    .name = "verify",
    .usage = "[options] ENV DIR",
    .brief = "measure the errors of a bake of ENV against the exact sums",
    .intro = "Compares the textures in DIR, or those of another program, with "
             "the exact sums\n"
             "over every pixel of the environment that they were baked from, "
             "and prints the\n"
             "errors of each level.\n",
    .statuses = "0 done, 1 failed or above --max-error, 2 wrong usage",
    .sections = sections,
    .gone = gone,
    .settings_size = sizeof(verify_opts),
    .given = offsetof(verify_opts, given),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = run,
};
