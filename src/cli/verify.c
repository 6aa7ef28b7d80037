/* SPDX-License-Identifier: MIT */
/* iblbake verify: compares baked files with the exact sums. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/console.h"
#include "cli/probes.h"
#include "cli/rendered_report.h"
#include "cli/verify_files.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "json/json_text.h"

/* ---- options --------------------------------------------------------- */

static const char *const scale_names[] = {"E/pi", "E", NULL};
static const char *const lobe_names[] = {"auto", IBL_LOBE_NAMES, NULL};
static const char *const table_names[] = {"auto", IBL_LUT_NAMES, NULL};
static const char *const geometry_names[] = {"auto", "smith", "schlick-ibl",
                                             NULL};

static bool parse_face_names(void *field, const char *value)
{
    char(*names)[16] = field;

    for (int face = 0; face < IBL_FACES; face++) {
        const size_t length = strcspn(value, ",");
        if (length < 1 || length >= sizeof names[face])
            return false;
        memcpy(names[face], value, length);
        names[face][length] = '\0';
        value += length;
        if (*value != (face == IBL_FACES - 1 ? '\0' : ','))
            return false;
        value++;
    }
    return true;
}

static bool parse_roughness_map(void *field, const char *value)
{
    ibl_verify_map *m = field;
    const int named = ibl_names_find(ibl_formula_names, value);

    *m = (ibl_verify_map){.given = 1};
    if (named >= 0)
        m->map = (ibl_roughness_map)named;
    else
        m->count = ibl_number_list(value, ',', 0, 1, m->list, IBL_MAX_LEVELS);
    return named >= 0 || m->count;
}

/* "0:0,0.5:2.5,1:5": roughness and lod, rising. */
static bool parse_lod(void *field, const char *value)
{
    ibl_verify_lod *l = field;
    const int named = ibl_names_find(ibl_formula_names, value);
    ibl_lod *lod = &l->lod;
    const char *end = value;

    *l = (ibl_verify_lod){.given = 1};
    if (named >= 0) {
        lod->layout.mapping = (ibl_roughness_map)named;
        return true;
    }
    for (int k = 0; k < IBL_LOD_POINTS; k++, value = end + 1) {
        if (!ibl_number_real(value, 0, 1, &lod->roughness[k], &end) ||
            *end != ':' ||
            !ibl_number_real(end + 1, 0, IBL_MAX_LEVELS, &lod->lod[k], &end) ||
            (k && lod->roughness[k] <= lod->roughness[k - 1]))
            return false;
        lod->count = k + 1;
        if (*end != ',')
            return !*end;
    }
    return false;
}

static bool parse_roughness(void *field, const char *value)
{
    ibl_truth_options *o = field;
    const int n =
        ibl_number_list(value, ',', 0, 1, o->roughness, IBL_RENDERED_LIST);

    o->roughness_count = n;
    for (int k = 1; k < n; k++)
        if (o->roughness[k] <= o->roughness[k - 1])
            return false;
    return n;
}

static bool parse_f0(void *field, const char *value)
{
    ibl_truth_options *o = field;

    return (o->f0_count =
                ibl_number_list(value, ',', 0, 1, o->f0, IBL_RENDERED_LIST));
}

static bool parse_axes(void *field, const char *value)
{
    int axes[3] = {0}, seen = 0;

    for (int k = 0; k < 3; k++) {
        const int sign = *value == '-' ? -1 : 1;
        value += *value == '-' || *value == '+';
        if (*value < 'x' || *value > 'z' || seen & 1 << (*value - 'x'))
            return false;
        seen |= 1 << (*value - 'x');
        axes[k] = sign * (*value - 'x' + 1);
        if (*++value != (k == 2 ? '\0' : ','))
            return false;
        value++;
    }
    memcpy(field, axes, sizeof axes);
    return true;
}

#define IBL_SETTINGS ibl_verify_opts

/* clang-format off */
static const ibl_option files[] = {
    {"name", 0, IBL_TEXT(name, "NAME"),
     .standard = "ENV without directory and extension",
     .help = "the files in DIR are NAME_specular.EXT and so on"},
    {"specular", 0,
     IBL_TEXT(files[IBL_OUTPUT_SPECULAR], "FILE"), .standard = "",
     .help = "a specular cube: KTX2, KTX or DDS, or six images a level, named "
             "by a pattern with %l for the level and %f for the face"},
    {"irradiance", 0, IBL_TEXT(files[IBL_OUTPUT_IRRADIANCE], "FILE"),
     .standard = "", .help = "a diffuse cube, or a pattern with %f"},
    {"skybox", 0, IBL_TEXT(files[IBL_OUTPUT_SKYBOX], "FILE"), .standard = "",
     .help = "the environment as a cube, or a pattern with %f"},
    {"lut", 0, IBL_TEXT(files[IBL_OUTPUT_LUT], "FILE"), .standard = "",
     .help = "a BRDF table; without other files it needs no ENV"},
    {"array-layer", 0, IBL_INT(layer, 0, IBL_MAX_PROBES - 1),
     .standard = "none",
     .help = "the layer that is judged of arrays of cubes"},
    {"face-names", 0, IBL_OTHER(face_names, "LIST", parse_face_names),
     .allowed = "six names in the order +X -X +Y -Y +Z -Z",
     .standard = "px,nx,py,ny,pz,nz", .help = "names that replace %f"},
};

static const ibl_option meaning[] = {
    {"lobe", 0, IBL_CHOICE(lobe, lobe_names),
     .help = "lobe of the specular levels; auto: what the files say, else ggx"},
    {"roughness-map", 0, IBL_OTHER(roughness, "MAP", parse_roughness_map),
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
    {"axes", 0, IBL_OTHER(axes, "LIST", parse_axes),
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
    {"texels", 0, IBL_INT(judge.texels, IBL_JUDGE_MIN_TEXELS, 1000000),
     .help = "approximate number of texels to judge in each level"},
    {"all", 0, IBL_FLAG(judge.all), .help = "judge every texel; slow"},
    {"seed", 0, IBL_INT(judge.seed, 0, 1000000000),
     .help = "another seed judges other texels"},
    {"max-error", 0, IBL_REAL(max_error, "E", 0, 1000), .standard = "none",
     .help = "exit with status 1 if the nRMSE of a level or the largest "
             "error of the table is above E, or a texel is not finite"},
};

static const ibl_option rendering[] = {
    {"rendered", 0, IBL_FLAG(rendered),
     .help = "judge what a shader draws with the files, not their texels"},
    {"shader", 0, IBL_CHOICE(shader, ibl_shader_names),
     .help = "how the shader looks up reflections, as in ibl.glsl; auto: by "
             "the lobe table if there is one and no --lod, else split"},
    {"lobe-table", 0, IBL_TEXT(files[IBL_OUTPUT_LOBES], "FILE"),
     .standard = "", .help = "the lobe table"},
    {"lod", 0, IBL_OTHER(lod, "LOD", parse_lod),
     .allowed = "linear, filament, babylon or a list of ROUGHNESS:LOD",
     .standard = "what the files say, else their levels' roughness",
     .help = "the shader's lod of a roughness; straight lines join a list"},
    {"roughness", 0, IBL_OTHER(shading, "LIST", parse_roughness),
     .allowed = "rising numbers from 0 to 1",
     .standard = "0.1,0.2,0.3,0.4,0.5,0.7,0.85,1",
     .help = "roughnesses of the surface"},
    {"f0", 0, IBL_OTHER(shading, "LIST", parse_f0),
     .allowed = "numbers from 0 to 1", .standard = "1,0.04",
     .help = "reflectances of the surface at normal incidence"},
    {"directions", 0, IBL_INT(shading.directions, IBL_RENDERED_LEAST, 65536),
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
    ibl_verify_opts *o = settings;

    *o = (ibl_verify_opts){.common = ibl_common_default(),
                           .yaw_deg = NAN,
                           .lights = -1,
                           .layer = -1,
                           .judge = ibl_judge_options_default(),
                           .shading = ibl_truth_options_default(),
                           .max_rendered_error = NAN,
                           .max_error = NAN};
    parse_face_names(o->face_names, "px,nx,py,ny,pz,nz");
}

static bool take(void *settings, const char *word)
{
    ibl_verify_opts *o = settings;

    if (!*word)
        return ibl_misuse("an empty argument: verify takes ENV and DIR");
    if (!o->input)
        o->input = word;
    else if (!o->directory)
        o->directory = word;
    else
        return ibl_misuse("%s: a third argument after %s and %s: verify takes "
                          "ENV and DIR",
                          word, o->input, o->directory);
    return true;
}

/* Facts of what is judged, for the rules. */
enum {
    OF_TEXELS = 1 << 0,
    SOME_TEXELS = 1 << 1, /* not all of each level */
    OF_RENDERED = 1 << 2,
    PATTERN = 1 << 3, /* names of faces in the names of files */
    OF_MAP = 1 << 4,
    IN_DIRECTORY = 1 << 5,
    SPLIT = 1 << 6, /* a table of the split sum */
    FILES = 7       /* and bits from here of the files there are, by kind */
};
#define FILE_OF(kind) (1u << (FILES + (kind)))
#define LIT_FILES                                                              \
    (FILE_OF(IBL_OUTPUT_SPECULAR) | FILE_OF(IBL_OUTPUT_IRRADIANCE))
#define MAP_FILES (LIT_FILES | FILE_OF(IBL_OUTPUT_SKYBOX))

static const ibl_rule rules[] = {
    {"texels all max-error heatmap skybox", OF_TEXELS,
     "--rendered judges no texels: leave one of them out"},
    {"texels seed", SOME_TEXELS | OF_RENDERED, "--all judges every texel"},
    {"shader lobe-table lod roughness f0 directions max-rendered-error",
     OF_RENDERED, "is for what is drawn: add --rendered"},
    {"face-names", PATTERN, "no file is named by a pattern with %f"},
    {"rotate lights layer part any-aspect input-layout strict primaries "
     "exposure clamp",
     OF_MAP, "a table needs no environment: leave it out"},
    {"name", IN_DIRECTORY, "is of files in a directory: add it"},
    {.options = NULL}};

/* The same, once the files are found. */
static const ibl_rule rules_of_files[] = {
    {"lobe roughness-map", FILE_OF(IBL_OUTPUT_SPECULAR),
     "there is no specular map: leave it out"},
    {"irradiance-scale", FILE_OF(IBL_OUTPUT_IRRADIANCE),
     "there is no irradiance map: leave it out"},
    {"lut-kind", FILE_OF(IBL_OUTPUT_LUT), "there is no table: leave it out"},
    {"geometry", SPLIT | OF_RENDERED,
     "there is no table of the split sum: leave it out"},
    {"lights", LIT_FILES,
     "there is no specular or irradiance map: leave it out"},
    {"rotate axes layer part any-aspect input-layout strict primaries exposure "
     "clamp",
     MAP_FILES, "there is no map: leave it out"},
    {.options = NULL}};

static bool check_rules(const ibl_verify_opts *o)
{
    unsigned facts = o->rendered    ? OF_RENDERED
                     : o->judge.all ? OF_TEXELS
                                    : OF_TEXELS | SOME_TEXELS;

    for (int kind = 0; kind < IBL_VERIFY_KINDS; kind++)
        if (o->files[kind] && strstr(o->files[kind], "%f"))
            facts |= PATTERN;
    if (o->input && strstr(o->input, "%f"))
        facts |= PATTERN;
    return ibl_check_rules(&o->given, rules,
                           facts | (o->input ? OF_MAP : 0) |
                               (o->directory ? IN_DIRECTORY : 0));
}

/* A set of probes, as of iblbake probes, in place of an environment. */
static bool is_set(const ibl_verify_opts *o)
{
    const char *dot = o->input ? strrchr(o->input, '.') : NULL;

    return dot && !strcmp(dot, ".json");
}

static bool check_set(const ibl_verify_opts *o)
{
    bool other = o->json || o->heatmap || o->layer >= 0 || o->name;

    for (int kind = 0; kind < IBL_VERIFY_KINDS; kind++)
        other |= o->files[kind] != NULL;
    return (o->directory && !other) ||
           ibl_misuse("%s: a set of probes is judged by the directory of its "
                      "bake, without --name, --array-layer, files, --json "
                      "and --heatmap",
                      o->input);
}

/* A table has lods of its own. */
static bool settle_lod(ibl_verify_opts *o)
{
    ibl_shader *shader = &o->shader;

    if (!o->lod.given)
        return true;
    if (*shader == IBL_SHADER_AUTO)
        *shader = IBL_SHADER_SPLIT;
    return *shader < IBL_SHADER_TABLE ||
           ibl_misuse("--lod: --shader %s has those of the lobe table: leave "
                      "one out",
                      ibl_shader_names[*shader]);
}

static bool validate(void *settings)
{
    ibl_verify_opts *o = settings;
    const bool cubes = o->files[IBL_OUTPUT_SKYBOX] ||
                       o->files[IBL_OUTPUT_SPECULAR] ||
                       o->files[IBL_OUTPUT_IRRADIANCE];
    const bool lut = o->files[IBL_OUTPUT_LUT] != NULL;

    if (is_set(o) && !check_set(o))
        return false;
    if (!o->input && (cubes || !lut))
        return ibl_misuse("no environment: iblbake verify [options] ENV DIR, "
                          "see iblbake verify --help");
    if (!o->directory && !cubes && !lut)
        return ibl_misuse("nothing to judge: add the directory of the bake, or "
                          "--specular, --irradiance, --skybox or --lut");
    o->shading.seed = o->judge.seed;
    if (!ibl_common_validate(&o->common) || !check_rules(o) || !settle_lod(o))
        return false;
    if (!o->name) {
        if (!ibl_stem(o->input, o->stem, sizeof o->stem))
            return false;
        o->name = o->stem;
    }
    return true;
}

/* ---- judging --------------------------------------------------------- */

typedef struct verify {
    const ibl_verify_opts *opts;
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_outputs *outputs;
    ibl_judged_map map;
    ibl_verify_files files;
    ibl_report report;
    ibl_rendered rendered;
} verify;

static bool check_files(verify *v)
{
    unsigned facts = v->opts->rendered ? OF_RENDERED : 0;

    for (int kind = 0; kind < IBL_VERIFY_KINDS; kind++)
        facts |= v->files.path[kind] ? FILE_OF(kind) : 0;
    if (v->files.lut.data && v->files.lut.kind == IBL_LUT_SPLIT)
        facts |= SPLIT;
    ibl_console_finish(v->console);
    v->console->failed =
        !ibl_check_rules(&v->opts->given, rules_of_files, facts);
    return !v->console->failed;
}

static bool read_map(verify *v)
{
    const ibl_verify_opts *o = v->opts;
    ibl_source *source = NULL;

    ibl_console_progress(v->console, "decode", 0);
    const bool ok =
        !ibl_source_open(v->ctx, o->input, &v->files.read, &source) &&
        ibl_verify_fits(
            o, v->console, &v->files, o->input,
            (double)ibl_judged_map_bytes(source, v->files.lights)) &&
        ibl_judged_map_read(v->ctx, source, v->files.yaw_deg, v->files.lights,
                            &v->map);
    ibl_source_close(source);
    return ok;
}

static bool judge_rendered(verify *v)
{
    return v->opts->input
               ? read_map(v) &&
                     ibl_rendered_judge(&v->files, v->ctx, &v->map,
                                        &v->opts->shading, v->opts->shader,
                                        v->console, &v->rendered)
               : ibl_console_fail(v->console, "no environment: --rendered "
                                              "compares with its light");
}

static bool judge_texels(verify *v)
{
    const ibl_verify_opts *o = v->opts;
    ibl_judge_options *options = &v->report.options;

    *options = o->judge;
    if (o->heatmap)
        options->grid = IBL_HEATMAP_GRID;
    if (v->files.count &&
        !(read_map(v) && ibl_judged_map_prepare(v->ctx, options, &v->map)))
        return false;
    return ibl_verify_judge(&v->files, v->ctx, &v->map, v->console, &v->report);
}

/* ---- results --------------------------------------------------------- */

/* The report, preceded by its inputs; NULL: no memory. */
static char *json_report(const verify *v, bool passed)
{
    const ibl_verify_opts *o = v->opts;
    json_t *root = json_object(), *paths = json_object();

    if (o->input)
        put(&root, "environment", ibl_json_string(o->input));
    put(&root, "yaw_deg", json_real(v->files.yaw_deg));
    for (int kind = 0; kind < IBL_VERIFY_KINDS; kind++)
        if (v->files.path[kind])
            put(&paths, ibl_output_content((ibl_output_kind)kind),
                ibl_json_string(v->files.path[kind]));
    put(&root, "files", paths);
    if (!isnan(o->max_error))
        put(&root, "max_error", json_real(o->max_error));
    if (!isnan(o->max_rendered_error))
        put(&root, "max_rendered_error", json_real(o->max_rendered_error));
    if (!isnan(o->max_error) || !isnan(o->max_rendered_error))
        put(&root, "passed", json_boolean(passed));
    if (o->rendered)
        put(&root, "rendered", ibl_rendered_json(&v->rendered));
    else
        put_all(&root, ibl_report_json(&v->report));
    char *text = ibl_json_text(root);
    json_decref(root);
    return text;
}

static bool put_json(verify *v, bool passed)
{
    const char *path = v->opts->json;
    char *text = json_report(v, passed);
    bool ok = text;

    if (ok && !strcmp(path, "-"))
        fputs(text, stdout);
    else
        ok = ok && !ibl_outputs_add(v->outputs, path, text, strlen(text));
    free(text);
    return ok;
}

static bool put_heatmap(verify *v)
{
    void *png = NULL;
    size_t size;

    ibl_console_progress(v->console, "heatmap", 0);
    const bool ok = ibl_heatmap_png(&v->report, &png, &size) &&
                    !ibl_outputs_add(v->outputs, v->opts->heatmap, png, size);
    free(png);
    return ok;
}

static void print(const verify *v)
{
    if (v->opts->rendered)
        ibl_rendered_print(&v->rendered, stdout);
    else
        ibl_report_print(&v->report, stdout);
}

static bool put_results(verify *v, bool passed)
{
    const ibl_verify_opts *o = v->opts;

    if ((o->json && !put_json(v, passed)) || (o->heatmap && !put_heatmap(v)))
        return false;
    ibl_console_finish(v->console);
    if (!o->common.quiet && !(o->json && !strcmp(o->json, "-")))
        print(v);
    return ibl_console_commit(v->console, v->outputs);
}

static void free_verify(verify *v)
{
    ibl_end_outputs(v->outputs);
    ibl_report_free(&v->report);
    ibl_rendered_free(&v->rendered);
    ibl_judged_map_free(&v->map);
    ibl_verify_files_free(&v->files);
    ibl_ctx_free(v->ctx);
}

static int run_one(const ibl_verify_opts *opts)
{
    ibl_console console;
    verify v = {.opts = opts, .console = &console};
    char why[160] = "";

    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    ibl_signals_catch();
    bool ok = !ibl_start(&opts->common, &console, &v.ctx) &&
              !ibl_start_outputs(v.ctx, 0, &v.outputs) &&
              ibl_verify_files_read(opts, v.ctx, &console, &v.files) &&
              check_files(&v) &&
              (opts->rendered ? judge_rendered(&v) : judge_texels(&v));
    const bool passed =
        ok && ibl_report_passes(&v.report, opts->max_error, why, sizeof why) &&
        (!opts->rendered ||
         ibl_rendered_passes(&v.rendered, opts->max_rendered_error, why,
                             sizeof why));
    ok = ok && put_results(&v, passed) &&
         (passed ||
          ibl_console_fail(&console, "%s%s%s", opts->probe ? opts->probe : "",
                           opts->probe ? ": " : "", why));
    const int status = ibl_console_end(&console, ok);
    if (ok && opts->common.verbose)
        ibl_console_print_times(&console);
    free_verify(&v);
    return status;
}

/* Judges a layer by its capture, whose files are one environment. */
static bool judge_layer(ibl_verify_opts o, const ibl_set_entry *e)
{
    char capture[IBL_FACES * 1024] = "";

    for (int i = 0; i < e->capture.count; i++)
        snprintf(capture + strlen(capture), sizeof capture - strlen(capture),
                 "%s%s", i ? "," : "", e->capture.file[i]);
    o.input = capture;
    o.probe = *e->name ? e->name : "(global)";
    if (!o.common.quiet)
        printf("%.60s, layer %d: %s\n", o.probe, o.layer, capture);
    return !run_one(&o);
}

/* Judges all layers of a set, the table with the first. */
static int run_set(const ibl_verify_opts *opts)
{
    ibl_console console;
    ibl_probe_set set = {0};
    ibl_probe_index index = {0};
    ibl_verify_opts o = *opts;
    ibl_ctx *ctx = NULL;
    char *path[4] = {ibl_path_join(o.directory, "index.json")};
    bool passed = true;

    ibl_console_init(&console, o.common.quiet, o.common.verbose);
    bool ok = path[0] && !ibl_start(&o.common, &console, &ctx) &&
              ibl_probe_set_read(o.input, &console, &set) &&
              !ibl_probe_index_read(ctx, path[0], &index);
    const char *const names[] = {index.specular.name, index.irradiance.name,
                                 index.lut};
    for (int k = 0; k < 3 && ok; k++)
        ok = !names[k] || (path[k + 1] = ibl_path_join(o.directory, names[k]));
    o.directory = NULL;
    o.files[IBL_OUTPUT_SPECULAR] = path[1];
    o.files[IBL_OUTPUT_IRRADIANCE] = path[2];
    o.files[IBL_OUTPUT_LUT] = path[3];
    for (int i = 0; i < set.layers && ok; i++) {
        const ibl_set_entry *e = &set.entry[i]; /* in the index's order */
        ok = i == set.count ? i == index.global
                            : i < index.count && index.name[i] &&
                                  !strcmp(index.name[i], e->name);
        if (!ok)
            ibl_console_fail(&console,
                             "%s: is not the set of %s: bake it again", o.input,
                             path[0]);
        o.layer = i;
        o.common.read.alpha = ibl_probes_alpha(&set, i);
        passed = ok && judge_layer(o, e) && passed;
        o.files[IBL_OUTPUT_LUT] = NULL;
    }
    for (int k = 0; k < 4; k++)
        free(path[k]);
    ibl_probe_set_free(&set);
    ibl_probe_index_free(&index);
    ibl_ctx_free(ctx);
    return ibl_console_end(&console, ok) || !passed;
}

static int run(const void *settings)
{
    return (is_set(settings) ? run_set : run_one)(settings);
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
    .settings_size = sizeof(ibl_verify_opts),
    .given = offsetof(ibl_verify_opts, given),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = run,
};
