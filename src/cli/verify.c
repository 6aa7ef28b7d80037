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

enum {
    LEAST_TEXELS = 24
};

typedef struct verify_opts {
    ibl_common common;
    const char *input;     /* the environment; NULL: judge only a table */
    const char *directory; /* NULL: use only files */
    const char *name;      /* base name of the files in directory */
    const char *probe;     /* for messages: of a set's probe, or NULL */
    int layer;             /* of arrays of cubes; -1: none */
    const char *files[IBL_CONTENTS]; /* NULL: search */
    unsigned leave;                  /* as in ibl_set_options */
    ibl_set_facts facts; /* of the options below, and roughness and axes */
    double yaw_deg;      /* NAN: what the files say; so */
    int lights;          /* -1, */
    int lobe, scale, table, geometry; /* 0; else 1 and their value */
    ibl_judge_options judge;
    int rendered;   /* 1: judge what a shader draws, not texels */
    int directions; /* 0: as many as standard errors ask for */
    ibl_shader shader;
    double max_error, max_rendered_error; /* NAN: no limit */
    const char *json;                     /* "-": standard output */
    const char *heatmap;                  /* NULL: none */
    char stem[256]; /* buffer of name if it comes from input */
    ibl_given given;
} verify_opts;

/* ---- options --------------------------------------------------------- */

static const char *const scale_names[] = {"auto", "E/pi", "E", NULL};
static const char *const lobe_names[] = {"auto", IBL_LOBE_NAMES, NULL};
static const char *const table_names[] = {"auto", IBL_LUT_NAMES, NULL};
static const char *const geometry_names[] = {"auto", "smith", "schlick-ibl",
                                             NULL};

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

static bool parse_axes(void *field, const char *value)
{
    ibl_set_facts *f = field;
    int seen = 0;

    for (int k = 0; k < 3; k++) {
        const int sign = *value == '-' ? -1 : 1;
        value += *value == '-' || *value == '+';
        if (*value < 'x' || *value > 'z' || seen & 1 << (*value - 'x'))
            return false;
        seen |= 1 << (*value - 'x');
        f->axes[k] = sign * (*value++ - 'x' + 1);
        if (*value++ != (k == 2 ? '\0' : ','))
            return false;
    }
    f->known |= IBL_KNOWN_AXES;
    return true;
}

#define IBL_SETTINGS verify_opts

/* clang-format off */
static const ibl_option files[] = {
    {"name", 0, IBL_TEXT(name, "NAME"),
     .standard = "ENV without directory and extension",
     .help = "the files in DIR are NAME_specular.EXT and so on"},
    {"specular", 0,
     IBL_TEXT(files[IBL_CONTENT_SPECULAR], "FILE"), .standard = "",
     .help = "a specular cube: KTX2, KTX or DDS"},
    {"irradiance", 0, IBL_TEXT(files[IBL_CONTENT_IRRADIANCE], "FILE"),
     .standard = "", .help = "a diffuse cube"},
    {"skybox", 0, IBL_TEXT(files[IBL_CONTENT_SKYBOX], "FILE"), .standard = "",
     .help = "the environment as a cube"},
    {"lut", 0, IBL_TEXT(files[IBL_CONTENT_LUT], "FILE"), .standard = "",
     .help = "a BRDF table; without other files it needs no ENV"},
    {"array-layer", 0, IBL_INT(layer, 0, IBL_MAX_PROBES - 1),
     .standard = "none",
     .help = "the layer that is judged of arrays of cubes"},
};

static const ibl_option meaning[] = {
    {"lobe", 0, IBL_CHOICE(lobe, lobe_names),
     .help = "lobe of the specular levels; auto: what the files say, else ggx"},
    {"roughness-map", 0, IBL_OTHER(facts, "MAP", parse_roughness_map),
     .allowed = "linear, filament, babylon or a list of each level's, as "
                "0,0.5,1",
     .standard = "what the files say, else linear",
     .help = "roughness of the specular levels"},
    {"rotate", 0, IBL_OTHER(yaw_deg, "DEG", ibl_rotate_parse),
     .allowed = IBL_ROTATE_ALLOWED,
     .standard = "what the files say, else 0",
     .help = "rotation of the environment about +Y in the bake"},
    {"lights", 0, IBL_INT(lights, 0, IBL_MAX_LIGHTS),
     .standard = "what the files say, else 0",
     .help = "compact sources that the bake took out of all but the skybox"},
    {"axes", 0, IBL_OTHER(facts, "LIST", parse_axes),
     .allowed = "a permutation of x, y and z, each with or without a minus",
     .standard = "what the files say, else x,y,z",
     .help = "axes of iblbake's world that +X, +Y and +Z of the files are"},
    {"irradiance-scale", 0, IBL_CHOICE(scale, scale_names),
     .help = "scale of the irradiance"},
    {"lut-kind", 0, IBL_CHOICE(table, table_names),
     .help = "what the table holds; auto: what the files say, else split"},
    {"geometry", 0, IBL_CHOICE(geometry, geometry_names),
     .help = "shadowing and masking of the table; auto: what the files say, "
             "else smith"},
};

static const ibl_option judging[] = {
    {"texels", 0, IBL_INT(judge.texels, LEAST_TEXELS, 1000000),
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
    {"lobe-table", 0, IBL_TEXT(files[IBL_CONTENT_LOBE_TABLE], "FILE"),
     .standard = "", .help = "the lobe table"},
    {"directions", 0, IBL_INT(directions, IBL_RENDERED_LEAST, 65536),
     .standard = "512 to 2048, until no standard error is above a tenth",
     .help = "pairs of a normal and a view"},
    {"max-rendered-error", 0, IBL_REAL(max_rendered_error, "E", 0, 1000),
     .standard = "none",
     .help = "exit with status 1 if the nRMSE of an F0, the mean over the "
             "roughnesses, is above E"},
};

static const ibl_option results[] = {
    {"json", 0, IBL_TEXT(json, "FILE"), .standard = "",
     .help = "the table as JSON; -: to standard output, in place of the table"},
    {"heatmap", 0, IBL_PNG(heatmap, "FILE"),
     .help = "a PNG picture of the errors over the faces; judges more texels"},
};
/* clang-format on */

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
                      .yaw_deg = NAN,
                      .lights = -1,
                      .layer = -1,
                      .judge = ibl_judge_options_default(),
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

/* Facts of what is judged, for the rules. */
enum {
    OF_TEXELS = 1 << 0,
    SOME_TEXELS = 1 << 1, /* not all of each level */
    OF_RENDERED = 1 << 2,
    OF_MAP = 1 << 3,
    IN_DIRECTORY = 1 << 4,
    SPLIT = 1 << 5, /* a table of the split sum */
    FILES = 6       /* and bits from here of the files there are, by content */
};
#define FILE_OF(content) (1u << (FILES + (content)))
#define LIT_FILES                                                              \
    (FILE_OF(IBL_CONTENT_SPECULAR) | FILE_OF(IBL_CONTENT_IRRADIANCE))
#define MAP_FILES (LIT_FILES | FILE_OF(IBL_CONTENT_SKYBOX))
#define ALL_FILES (SPLIT | ~0u << FILES) /* before they are known */

static const ibl_rule rules[] = {
    {"texels all max-error heatmap skybox", OF_TEXELS,
     "--rendered judges no texels: leave one of them out"},
    {"texels seed", SOME_TEXELS | OF_RENDERED, "--all judges every texel"},
    {"shader lobe-table directions max-rendered-error", OF_RENDERED,
     "is for what is drawn: add --rendered"},
    {"rotate lights layer part any-aspect input-layout face-order "
     "input-transfer strict primaries exposure clamp",
     OF_MAP, "a table needs no environment: leave it out"},
    {"name", IN_DIRECTORY, "is of files in a directory: add it"},
    {"lobe roughness-map", FILE_OF(IBL_CONTENT_SPECULAR),
     "there is no specular map: leave it out"},
    {"irradiance-scale", FILE_OF(IBL_CONTENT_IRRADIANCE),
     "there is no irradiance map: leave it out"},
    {"lut-kind", FILE_OF(IBL_CONTENT_LUT), "there is no table: leave it out"},
    {"geometry", SPLIT | OF_RENDERED,
     "there is no table of the split sum: leave it out"},
    {"lights", LIT_FILES,
     "there is no specular or irradiance map: leave it out"},
    {"rotate axes layer part any-aspect input-layout face-order input-transfer "
     "strict primaries exposure clamp",
     MAP_FILES, "there is no map: leave it out"},
    {.options = NULL}};

static bool check_rules(const verify_opts *o, unsigned there)
{
    return ibl_check_rules(&o->given, rules,
                           (o->rendered    ? OF_RENDERED
                            : o->judge.all ? OF_TEXELS
                                           : OF_TEXELS | SOME_TEXELS) |
                               (o->input ? OF_MAP : 0) |
                               (o->directory ? IN_DIRECTORY : 0) | there);
}

/* A set of probes, as of iblbake probes, in place of an environment. */
static bool is_of_probes(const verify_opts *o)
{
    const char *dot = o->input ? strrchr(o->input, '.') : NULL;

    return dot && !strcmp(dot, ".json");
}

static bool validate(void *settings)
{
    verify_opts *o = settings;
    const bool lut = o->files[IBL_CONTENT_LUT];
    bool cubes = false;

    for (int c = 0; c < IBL_CONTENT_LUT; c++)
        cubes |= o->files[c] != NULL;
    if (is_of_probes(o) && (!o->directory || cubes || lut || o->json ||
                            o->heatmap || o->layer >= 0 || o->name))
        return ibl_misuse("%s: a set of probes is judged by the directory of "
                          "its bake, without --name, --array-layer, files, "
                          "--json and --heatmap",
                          o->input);
    if (!o->input && (cubes || !lut))
        return ibl_misuse("no environment: iblbake verify [options] ENV DIR, "
                          "see iblbake verify --help");
    if (!o->directory && !cubes && !lut)
        return ibl_misuse("nothing to judge: add the directory of the bake, or "
                          "--specular, --irradiance, --skybox or --lut");
    if (!ibl_common_validate(&o->common) || !check_rules(o, ALL_FILES))
        return false;
    if (!o->name && !is_of_probes(o)) {
        if (!ibl_stem(o->input, o->stem, sizeof o->stem))
            return false;
        o->name = o->stem;
    }
    const struct {
        bool given;
        unsigned bit;
    } known[] = {{o->lobe, IBL_KNOWN_LOBE},
                 {o->scale, IBL_KNOWN_SCALE},
                 {o->table, IBL_KNOWN_TABLE},
                 {o->geometry, IBL_KNOWN_GEOMETRY},
                 {o->lights >= 0, IBL_KNOWN_LIGHTS},
                 {!isnan(o->yaw_deg), IBL_KNOWN_YAW}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        o->facts.known |= known[i].given ? known[i].bit : 0;
    o->facts.lobe = (ibl_lobe)(o->lobe ? o->lobe - 1 : 0);
    o->facts.irradiance_scale = o->scale == 2 ? 1 / M_PI : 1;
    o->facts.table = (ibl_lut_kind)(o->table ? o->table - 1 : 0);
    o->facts.geometry = (ibl_geometry)(o->geometry ? o->geometry - 1 : 0);
    o->facts.lights = o->lights;
    o->facts.yaw_deg = o->yaw_deg;
    o->judge.grid = o->heatmap != NULL;
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

/* Reads the set, and what of it is judged as cubes and a table. */
static bool read_files(verify *v)
{
    const verify_opts *o = v->o;
    ibl_set_options opts = ibl_set_options_default();
    bool ok = true;
    unsigned there = 0;

    opts.name = o->name;
    opts.layer = o->layer;
    opts.facts = &o->facts;
    opts.leave = o->leave | 1u << (o->rendered ? IBL_CONTENT_SKYBOX
                                               : IBL_CONTENT_LOBE_TABLE);
    memcpy(opts.file, o->files, sizeof opts.file);
    ibl_console_progress(v->console, "read", 0);
    if (ibl_set_open(v->ctx, o->directory, &opts, &v->set))
        return false;
    double need = IBL_PROGRAM_BYTES;
    for (int c = 0; c < IBL_CONTENTS; c++)
        need += 3.0 * sizeof(float) * (double)v->set.file[c].texture.bytes /
                (double)ibl_pixel_bytes(v->set.file[c].texture.pixel);
    const double most = (double)ibl_memory_most(&o->common);
    if (most > 0 && need > most)
        return ibl_console_fail(
            v->console,
            "%s: takes %.0f MiB of memory, more than the %.0f of "
            "--max-memory: judge fewer files at once, by --specular and its "
            "like",
            o->directory ? o->directory : o->input, ceil(need / (1 << 20)),
            floor(most / (1 << 20)));
    for (int c = 0; c < IBL_CONTENTS && ok; c++) {
        ibl_set_file *f = &v->set.file[c];
        if (f->missing)
            ok = ibl_console_fail(
                v->console, "%s: %s names it, but it is not there: bake again",
                f->path, v->set.sidecar);
        else if (f->path && c < IBL_CONTENT_LUT)
            ok = !ibl_texture_to_cube(v->ctx, &f->texture, &v->cube[c]);
        else if (f->path && c == IBL_CONTENT_LUT)
            ok = !ibl_texture_to_lut(v->ctx, &f->texture, &v->lut);
        there |= f->path ? FILE_OF(c) : 0;
        if (c < IBL_CONTENT_LUT) { /* as floats from here on */
            ibl_bytes_free(f->texture.data);
            f->texture.data = NULL;
        }
    }
    ibl_console_finish(v->console);
    there |= v->lut.data && !v->lut.kind ? SPLIT : 0;
    if (ok && !check_rules(o, there))
        ok = !(v->console->failed = true);
    return ok;
}

/* Reads the environment, as the files say that it was read. */
static bool read_map(verify *v)
{
    const ibl_read_options *said = &v->set.read;
    ibl_read_options read = v->o->common.read;
    const ibl_set_facts *first = NULL;
    int lights = 0;

    v->yaw_deg = isnan(v->o->yaw_deg) ? v->set.yaw_deg : v->o->yaw_deg;
    for (int c = IBL_CONTENT_LUT - 1; c >= 0; c--) {
        const ibl_set_facts *f = &v->set.file[c].facts;
        if (!v->cube[c].data)
            continue;
        if (first && (fabs(f->yaw_deg - first->yaw_deg) > 0 ||
                      (c && f->lights != first->lights)))
            return ibl_console_fail(
                v->console,
                "%s: baked with --rotate %g and %d lights taken out, another "
                "file with %g and %d: judge one at a time",
                v->set.file[c].path, f->yaw_deg, f->lights, first->yaw_deg,
                first->lights);
        first = f;
        lights = c == IBL_CONTENT_SKYBOX ? lights : f->lights;
    }
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

static ibl_cube level_of(const ibl_cube *cube, int level)
{
    return (ibl_cube){ibl_cube_edge(cube->size, level), 1,
                      ibl_cube_face(cube, level, 0), cube->projection};
}

static bool judge_texels(const verify *v, ibl_report *report)
{
    const ibl_image *images[2] = {&v->env, &v->rest};
    ibl_judge *judges[2] = {NULL, NULL};
    bool ok = true;

    for (int k = 0; k < 2 && ok; k++)
        ok = !images[k]->data ||
             (judges[k] = ibl_judge_create(v->ctx, images[k], v->yaw_deg,
                                           &v->o->judge));
    const ibl_judge *rest = judges[v->rest.data != NULL];
    for (int c = 0; c < IBL_CONTENT_LUT; c++) {
        const ibl_set_facts *facts = &v->set.file[c].facts;
        const ibl_cube *cube = &v->cube[c];
        /* Mips of an irradiance map serve minification and are not judged. */
        const ibl_judged judged = {
            .content = (ibl_output_kind)c,
            .chain = *cube,
            .levels =
                c == IBL_CONTENT_IRRADIANCE && cube->data ? 1 : cube->levels,
            .lobe = facts->lobe,
            .roughness = c == IBL_CONTENT_SPECULAR ? facts->roughness : NULL,
            .scale =
                c == IBL_CONTENT_IRRADIANCE ? 1 / facts->irradiance_scale : 1,
            .pixel = v->set.file[c].pixel};
        if (!cube->data)
            continue;
        ibl_console_progress(v->console, ibl_output_name(judged.content), 0);
        ok = ok && ibl_report_levels(report,
                                     c == IBL_CONTENT_SKYBOX ? judges[0] : rest,
                                     &judged);
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

    *lobes = (ibl_lobe_table){t->width, malloc(texels * 4 * sizeof(float)),
                              t->layers};
    if (lobes->data)
        ibl_pixel_decode(t->pixel == IBL_PIXEL_RGBA16F ? IBL_PIXEL_RG16F
                                                       : IBL_PIXEL_RG32F,
                         t->data, 2 * texels, lobes->data);
    for (size_t i = 0; lobes->data && i < 4 * texels; i++)
        if (!isfinite(lobes->data[i]))
            return ibl_console_fail(v->console,
                                    "%s: holds values that are not finite",
                                    v->set.file[IBL_CONTENT_LOBE_TABLE].path);
    return lobes->data;
}

/* Finds what the shader draws with. */
static bool find_drawn(const verify *v, ibl_drawn *set)
{
    const ibl_set_file *file = v->set.file;
    const ibl_cube *specular = &v->cube[IBL_CONTENT_SPECULAR];
    const ibl_cube *irradiance = &v->cube[IBL_CONTENT_IRRADIANCE];
    bool ok = true;

    if (!specular->data)
        return ibl_console_fail(v->console,
                                "no specular cube, which is what --rendered "
                                "judges: add --specular");
    if (file[IBL_CONTENT_SPECULAR].facts.lobe != IBL_LOBE_GGX)
        return ibl_console_fail(
            v->console, "%s: of the lobe %s: --rendered judges ggx",
            file[IBL_CONTENT_SPECULAR].path,
            ibl_lobe_name(file[IBL_CONTENT_SPECULAR].facts.lobe));
    *set = (ibl_drawn){.shader = v->o->shader,
                       .chain = file[IBL_CONTENT_SPECULAR].facts,
                       .irradiance_scale = 1,
                       .lights = v->lights,
                       .light_count = v->light_count};
    if (file[IBL_CONTENT_LOBE_TABLE].path)
        ok = decode_lobes(v, &set->lobes);
    if (!v->lut.kind)
        set->lut = v->lut;
    if (irradiance->data) {
        set->irradiance = level_of(irradiance, 0);
        set->irradiance_scale =
            1 / file[IBL_CONTENT_IRRADIANCE].facts.irradiance_scale;
    } else if (v->set.sh_degree >= 0) {
        set->sh = v->set.sh;
        set->sh_degree = v->set.sh_degree;
    }
    for (int l = 0; l < specular->levels; l++)
        set->level[l] = level_of(specular, l);
    const bool lit = irradiance->data || set->sh;
    if (set->shader == IBL_SHADER_AUTO)
        set->shader =
            set->lobes.data && lit ? IBL_SHADER_TABLE : IBL_SHADER_SPLIT;
    if (ok && set->shader >= IBL_SHADER_TABLE && !set->lobes.data)
        ok = ibl_console_fail(v->console,
                              "--shader %s: there is no lobe table: name it "
                              "with --lobe-table",
                              ibl_shader_names[set->shader]);
    return ok && (set->shader < IBL_SHADER_FIT || lit ||
                  ibl_console_fail(v->console,
                                   "--shader %s: there is no irradiance map: "
                                   "name it with --irradiance",
                                   ibl_shader_names[set->shader]));
}

static bool judge_rendered(const verify *v, ibl_report *report)
{
    ibl_truth_options o = ibl_truth_options_default();
    ibl_truth truth = {0};
    ibl_drawn set = {.chain = {.levels = 0}};
    json_t *row;
    size_t i;
    int vague;

    o.directions = v->o->directions ? v->o->directions : o.directions;
    o.seed = v->o->judge.seed;
    o.geometry = v->o->geometry ? v->o->facts.geometry
                 : v->lut.data  ? v->set.file[IBL_CONTENT_LUT].facts.geometry
                                : IBL_GEOMETRY_SMITH;
    ibl_console_progress(v->console, "truth", 0);
    bool ok = find_drawn(v, &set);
    do
        ok = ok && ibl_truth_make(v->ctx, &v->env, v->yaw_deg, &o, &truth) &&
             ibl_report_drawn(report, &truth, &set, &vague);
    while (ok && vague && !v->o->directions &&
           (o.directions *= 2) <= IBL_RENDERED_MOST);
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

/* Fails if a file would replace what is judged. */
static bool check_output(const verify *v, const char *path)
{
    const char *inputs[IBL_CONTENTS + 2] = {v->o->input, v->set.sidecar};
    bool ok = true;

    for (int c = 0; c < IBL_CONTENTS; c++)
        inputs[c + 2] = v->set.file[c].path;
    for (int i = 0; i < IBL_CONTENTS + 2 && ok && path; i++)
        ok = !inputs[i] ||
             ibl_console_differ(v->console, inputs[i], path, "file");
    return ok;
}

/* Reads what there is, and judges it. */
static bool judge(verify *v, ibl_report *report)
{
    bool map = v->o->rendered;

    if (!read_files(v) || !check_output(v, v->o->json) ||
        !check_output(v, v->o->heatmap))
        return false;
    for (int c = 0; c < IBL_CONTENT_LUT; c++)
        map |= v->cube[c].data != NULL;
    if (map && !v->o->input)
        return ibl_console_fail(v->console, "no environment: --rendered "
                                            "compares with its light");
    return (!map || read_map(v)) &&
           (v->o->rendered ? judge_rendered : judge_texels)(v, report);
}

/* ---- results --------------------------------------------------------- */

static bool put_json(const verify *v, const ibl_report *report, bool passed,
                     ibl_outputs *outputs)
{
    const verify_opts *o = v->o;
    json_t *root = json_object(), *paths = json_object();

    if (o->input)
        put(&root, "environment", ibl_json_string(o->input));
    for (int c = 0; c < IBL_CONTENTS; c++)
        if (v->set.file[c].path)
            put(&paths, ibl_content_name((ibl_content)c),
                ibl_json_string(v->set.file[c].path));
    put(&root, "files", paths);
    put(&root, "yaw_deg", json_real(v->yaw_deg));
    if (!isnan(o->max_error))
        put(&root, "max_error", json_real(o->max_error));
    if (!isnan(o->max_rendered_error))
        put(&root, "max_rendered_error", json_real(o->max_rendered_error));
    if (!isnan(o->max_error) || !isnan(o->max_rendered_error))
        put(&root, "passed", json_boolean(passed));
    put_all(&root, json_incref(report->json));
    char *text = ibl_json_text(root);
    bool ok = text;

    if (ok && !strcmp(o->json, "-"))
        fputs(text, stdout);
    else
        ok = ok && !ibl_outputs_add(outputs, o->json, text, strlen(text));
    free(text);
    json_decref(root);
    return ok;
}

static int run_one(const verify_opts *o)
{
    ibl_console console;
    verify v = {.o = o, .console = &console};
    ibl_outputs *outputs = NULL;
    ibl_report report = {.options = o->judge};
    void *png = NULL;
    size_t size;
    char why[200] = "";

    ibl_console_init(&console, o->common.quiet, o->common.verbose);
    ibl_signals_catch();
    bool ok = !ibl_start(&o->common, &console, &v.ctx) &&
              !ibl_outputs_create(v.ctx, 0, &outputs) && judge(&v, &report);
    const bool passed =
        ok && ibl_report_passes(&report, o->max_error, o->max_rendered_error,
                                why, sizeof why);
    ok = ok && (!o->json || put_json(&v, &report, passed, outputs)) &&
         (!o->heatmap || (ibl_heatmap_png(&report, &png, &size) &&
                          !ibl_outputs_add(outputs, o->heatmap, png, size)));
    if (ok) {
        ibl_console_finish(&console);
        if (!o->common.quiet && !(o->json && !strcmp(o->json, "-")))
            ibl_report_print(&report, stdout);
        ok = ibl_console_commit(&console, outputs) &&
             (passed ||
              ibl_console_fail(&console, "%s%s%s", o->probe ? o->probe : "",
                               o->probe ? ": " : "", why));
    }
    const int status = ibl_console_end(&console, ok);
    if (ok && o->common.verbose)
        ibl_console_print_times(&console);
    free(png);
    ibl_outputs_free(outputs);
    ibl_report_free(&report);
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
    char *path = ibl_path_join(o.directory, "index.json");
    bool passed = true;

    ibl_console_init(&console, o.common.quiet, o.common.verbose);
    bool ok = path && !ibl_start(&o.common, &console, &ctx) &&
              ibl_probe_set_read(o.input, &console, &set) &&
              !ibl_probe_index_read(ctx, path, &index);
    o.directory = path;
    for (int i = 0; i < set.layers && ok; i++) {
        const ibl_set_entry *e = &set.entry[i]; /* in the index's order */
        ok = i == set.count ? i == index.global
                            : i < index.count && index.name[i] &&
                                  !strcmp(index.name[i], e->name);
        if (!ok) {
            ibl_console_fail(&console,
                             "%s: is not the set of %s: bake it again", o.input,
                             path);
            break;
        }
        o.input = e->capture.name;
        o.layer = i;
        o.probe = *e->name ? e->name : "(global)";
        o.common.read.alpha = ibl_probes_alpha(&set, i);
        if (!o.common.quiet)
            printf("%.60s, layer %d: %s\n", o.probe, o.layer, o.input);
        passed = !run_one(&o) && passed;
        o.leave = 1u << IBL_CONTENT_LUT;
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
    .settings_size = sizeof(verify_opts),
    .given = offsetof(verify_opts, given),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = run,
};
