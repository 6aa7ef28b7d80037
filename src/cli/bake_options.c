/* SPDX-License-Identifier: MIT */
#include "cli/job.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli/words.h"
#include "common/names.h"
#include "common/signals.h"

static const char *const progress_names[] = {"auto", "json", NULL};
static const char *const no_yes[] = {"no", "yes", NULL};
static const char *const lobes_names[] = {"prior", "no", NULL};

/* Options of the bakes that tutorials describe; 0: none. */
static const char *const preset_names[] = {"none", "learnopengl", NULL};
static const char *const preset_options[] = {
    "",
    "--method sampled --size 128 --levels 5 --mapping linear --samples 1024 "
    "--lod-bias 0 --irradiance-size 32 --irradiance-step .025 "
    "--lut-size 512 --lut-samples 1024 --geometry schlick-ibl --lobe-table no"};

/* ---- values ---------------------------------------------------------- */

static bool parse_only(void *field, const char *value)
{
    return ibl_words_bits(value, ibl_output_names, field);
}

/* A:B, each 0 to 1, the smaller first. */
static bool parse_range(void *field, const char *value)
{
    ibl_specular_options *o = field;
    const char *end;

    return ibl_number_real(value, 0, 1, &o->roughness_min, &end) &&
           *end == ':' &&
           ibl_number_real(end + 1, o->roughness_min, 1, &o->roughness_max,
                           &end) &&
           !*end;
}

/* Adds a scene, which must be a file. */
static bool parse_scene(void *field, const char *value)
{
    ibl_scene_list *scenes = field;

    if (!*value || !strcmp(value, "-") || scenes->count == IBL_MAX_SCENES)
        return false;
    scenes->path[scenes->count++] = value;
    return true;
}

static bool parse_window(void *field, const char *value)
{
    double *window = field;
    const char *end;

    *window = 0;
    return !strcmp(value, "auto") ||
           (ibl_number_real(value, 1, 1000, window, &end) && !*end);
}

/* NULL: --sun. */
static bool parse_lights(void *field, const char *value)
{
    int *lights = field;
    const char *end = "";

    *lights = value ? IBL_LIGHTS_AUTO : 1;
    return !value || !strcmp(value, "auto") ||
           (ibl_number_int(value, 0, IBL_MAX_LIGHTS, lights, &end) && !*end);
}

/* ---- the table ------------------------------------------------------- */

#define IBL_SETTINGS ibl_opts

/* clang-format off */
static const ibl_option outputs[] = {
    {"output", 'o', IBL_DIR(directory), .standard = "",
     .help = "directory of the outputs, created if missing; required",
     .aside = true},
    {"name", 0, IBL_TEXT(name, "NAME"),
     .standard = "ENV without directory and extension",
     .help = "outputs are NAME_specular.EXT and so on"},
    {"target", 0, IBL_OTHER(targets, "LIST", ibl_targets_parse),
     .allowed = ibl_targets_allowed,
     .standard = "none",
     .help = "make files that these engines load as they are; sets other "
             "defaults, which list prints. Several are written to DIR/TARGET",
     .aside = true},
    {"explain", 0, IBL_FLAG(explain),
     .help = "print the program that loads the files of --target; without "
             "ENV, only that",
     .aside = true},
    {"preset", 0, IBL_CHOICE(preset, preset_names),
     .help = "learnopengl: levels, irradiance and table as its tutorial makes "
             "them, to be compared; options beside it count more"},
    {"format", 0, IBL_CHOICE(file, ibl_format_names),
     .help = "container, and the extension of its files; env, gltf and "
             "playcanvas: one set for Babylon, glTF or PlayCanvas; exr, hdr "
             "and png: a picture for each level and face"},
    {"tone", 0, IBL_CHOICE(tone, ibl_tone_names),
     .help = "what png files make of light before sRGB's curve: film, or clip "
             "it at 1"},
    {"zstd", 0, IBL_INT(zstd, 0, IBL_MAX_ZSTD),
     .help = "compress ktx2 files with Zstandard of level N; 0: do not"},
    {"pixel", 0, IBL_CHOICE(texels.pixel, ibl_pixel_names),
     .help = "texels of the cubes; the LUT is rg32f with rgba32f, else rg16f"},
    IBL_TEXEL_OPTIONS
    {"layout", 0, IBL_CHOICE(layout, ibl_layout_names),
     .help = "a cube, or one flat image a level: equirectangular, 4N x 2N "
             "texels for N along an edge, or octahedral, 2N x 2N; cross: a "
             "cube's faces in one picture, 4N x 3N"},
    {"only", 0, IBL_OTHER(only, "LIST", parse_only),
     .allowed =
         "a list of specular, irradiance, lut, lobe-table, skybox, json",
     .standard = "all", .help = "make only these outputs"},
    {"skybox", 0, IBL_INT(bake.skybox, 1, IBL_MAX_CUBE_SIZE),
     .standard = "none",
     .help = "also write the environment as a cube with mips, N texels along "
             "an edge"},
    {"preview", 0, IBL_PNG(preview, "FILE"),
     .help = "a PNG picture of all outputs",
     .aside = true},
    {"depfile", 0, IBL_TEXT(depfile, "FILE"), .standard = "",
     .help = "a rule for make and ninja: outputs depend on ENV",
     .aside = true},
    {"sync", 0, IBL_FLAG(sync),
     .help = "wait until everything is on the disk, so that a power cut "
             "leaves whole files",
     .aside = true},
    {"verify", 0, IBL_FLAG(verify),
     .help = "compare the outputs with the exact sums, as iblbake verify "
             "does, print the table and add it to the sidecar",
     .aside = true},
    {"max-error", 0, IBL_REAL(max_error, "E", 0, 1000), .standard = "none",
     .help = "verify, and write nothing if the nRMSE of a level or the largest "
             "error of the table is above E",
     .aside = true},
    {"rendered-error", 0, IBL_REAL(rendered_error, "E", 1e-4, 1),
     .standard = "none",
     .help = "choose size, levels, mapping, texels, irradiance and tables of "
             "the fewest bytes with which shaders draw with a measured error "
             "of at most E (.01: 1 %), print what was chosen; options that "
             "are given are kept"},
    {"scene", 0, IBL_OTHER(scenes, "FILE", parse_scene),
     .allowed = "a .gltf or .glb file, at most 64 times",
     .standard = "",
     .help = "choose for the materials of a model of glTF, by the area that "
             "they cover, with --rendered-error .03 unless it is given; can be "
             "repeated",
     .aside = true},
    {"dry-run", 0, IBL_FLAG(dry_run),
     .help = "stop when it is chosen",
     .aside = true},
};

static const ibl_option many[] = {
    {"from", 0, IBL_TEXT(from, "LIST"), .standard = "",
     .help = "also bake the environments that a file names, one a line, or "
             "each before a NUL; - reads the names from standard input",
     .aside = true},
    {"recursive", 0, IBL_FLAG(recursive),
     .help = "also bake the environments in folders below ENV; the outputs are "
             "in folders of the same names",
     .aside = true},
    {"keep-going", 0, IBL_FLAG(keep_going),
     .help = "after a failure bake the others, and list what failed",
     .aside = true},
    {"incremental", 0, IBL_FLAG(incremental),
     .help = "bake only environments that changed since they were baked with "
             "this option, or whose outputs, options or version did",
     .aside = true},
    {"prune", 0, IBL_FLAG(prune),
     .help = "with --incremental, at the end remove the outputs of "
             "environments that are no longer there",
     .aside = true},
    {"shard", 0, IBL_OTHER(shard, "K/N", ibl_shard_parse),
     .allowed = IBL_SHARD_ALLOWED, .standard = "all environments",
     .help = "bake only part K of N of the environments; the parts of all "
             "runs go into one directory",
     .aside = true},
    {"progress", 0, IBL_CHOICE(progress, progress_names),
     .help = "auto: a line on a terminal; json: an object a line on standard "
             "output, for programs",
     .aside = true},
};

static const ibl_option input[] = {
    {"prefiltered", 0, IBL_FLAG(prefiltered),
     .help = "take a texture that is a baked map for an environment"},
    {"rotate", 0, IBL_REAL(bake.yaw_deg, "DEG", -360, 360),
     .help = "turn the environment about +Y, counter-clockwise from above"},
    {"mirror", 0, IBL_CHOICE(axes.mirror, ibl_mirror_names),
     .help = "negate an axis of the world in all outputs, or exchange two"},
    {"up", 0, IBL_CHOICE(axes.up, ibl_up_names),
     .help = "axis of the outputs that points up; z: (x, y, z) of the world "
             "is at (x, -z, y)"},
    {"lights", 0, IBL_OTHER(lights, "N", parse_lights),
     .allowed = "0 to 64, or auto",
     .standard = "0",
     .help = "take the N strongest compact sources, such as the sun, out of "
             "all outputs but the skybox, and list them in the sidecar; auto: "
             "those without which the error as drawn is a tenth less"},
    {"sun", 0, IBL_OTHER(lights, NULL, parse_lights), .standard = "",
     .help = "the same as --lights 1"},
};

static const ibl_option specular[] = {
    {"size", 0, IBL_INT(bake.specular_options.size, 1, IBL_MAX_CUBE_SIZE),
     .help = "edge of the largest level in texels"},
    {"levels", 0, IBL_INT(bake.specular_options.levels, 1, IBL_MAX_LEVELS),
     .standard = "down to 8x8", .help = "number of levels"},
    {"lobe", 0, IBL_CHOICE(bake.specular_options.lobe, ibl_lobe_names),
     .help = "lobe of the convolution: GGX, the sheen of glTF, or a cosine "
             "power"},
    {"mapping", 0, IBL_CHOICE(bake.specular_options.mapping, ibl_mapping_names),
     .help = "roughness of the levels: lod = r (levels - 1), or "
             "r (2 - r) (levels - 1), or 0.8 log2(size r r) as Babylon.js has "
             "it"},
    {"roughness-range", 0, IBL_OTHER(bake.specular_options, "A:B", parse_range),
     .allowed = "two numbers from 0 to 1, the smaller first",
     .standard = "0:1",
     .help = "make only the levels that these roughnesses need"},
    {"method", 0, IBL_CHOICE(bake.specular_options.method, ibl_method_names),
     .help = "method for the levels: exact, or importance sampling"},
    {"samples", 0, IBL_INT(bake.specular_options.samples, 1, 1048576),
     .help = "samples for each texel of a sampled level"},
    {"tolerance", 0, IBL_REAL(bake.specular_options.tolerance, "E", 1e-6, 1),
     .help = "relative error accepted for 95 % of the texels of each level; "
             "a larger one takes less time"},
    {"lod-bias", 0, IBL_REAL(bake.specular_options.lod_bias, "BIAS", -4, 4),
     .standard = "by the number of samples",
     .help = "added to the mip level of each sample's lookup"},
    {"jitter", 0, IBL_FLAG(bake.specular_options.jitter),
     .help = "rotate the sample pattern from texel to texel: noise instead "
             "of structure, the same in every run"},
    {"pdf-mip", 0, IBL_CHOICE(bake.specular_options.pdf_mip, no_yes),
     .help = "choose the mip level of a lookup by the sample's density; no: "
             "always use the full resolution"},
};

static const ibl_option irradiance[] = {
    {"irradiance-size", 0,
     IBL_INT(bake.irradiance_options.size, 1, IBL_MAX_CUBE_SIZE),
     .help = "edge of the faces in texels"},
    {"irradiance-step", 0,
     IBL_REAL(bake.irradiance_options.step, "RAD", 0.001, 0.5),
     .standard = "none: exact",
     .help = "use the classic grid over the hemisphere, with this step in "
             "radians"},
    {"sh", 0,
     IBL_INT(bake.sh_degree, 0, IBL_MAX_SH_DEGREE),
     .help = "degree of the coefficients in the sidecar; 2 gives 9 of them"},
    {"sh-window", 0, IBL_OTHER(sh_window, "W", parse_window),
     .allowed = "auto, or 1 to 1000", .standard = "none",
     .help = "multiply degree l of the coefficients by sinc(l / W)^4, against "
             "ringing; auto: by the widest W with which no light is negative"},
    {"sh-format", 0, IBL_CHOICE(sh_format, ibl_sh_format_names),
     .help = "also write nine coefficients to NAME_sh.txt, as a tool's code "
             "takes them"},
};

static const ibl_option lut[] = {
    {"lut-kind", 0, IBL_CHOICE(lut.kind, ibl_lut_names),
     .help = "split: scale and bias of F0; multiscatter: Filament's, with "
             "cloth; charlie: the albedos of glTF's sheen"},
    {"lut-size", 0, IBL_INT(lut.size, 1, 4096),
     .help = "edge in texels"},
    {"lut-samples", 0, IBL_INT(lut.samples, 0, 1048576),
     .help = "sample each texel with N points; 0: exact quadrature"},
    {"geometry", 0, IBL_CHOICE(lut.geometry, ibl_geometry_names),
     .help = "shadowing and masking: Smith height-correlated, or Schlick "
             "with k = r r / 2"},
};
static const ibl_option lobes[] = {
    {"lobe-table", 0, IBL_CHOICE(lobe_table, lobes_names),
     .standard = "prior",
     .help = "where a shader looks up reflections of any view, fitted to the "
             "levels; of GGX levels only"},
    {"lobe-table-size", 0, IBL_INT(lobe_table_size, 4, 256),
     .help = "edge in texels"},
};
/* clang-format on */

static const ibl_gone gone[] = {
    {"level-samples", "--method sampled takes --samples for all levels"},
    {"timings", "-v prints the time of each stage"},
    {"method=auto", "spectral is the default"},
    {"mapping=best", "--rendered-error E chooses the levels"},
    {"rotate=learnopengl rotate=threejs rotate=cmgen",
     "give degrees: 0, for cmgen -90"},
    {.words = NULL}};

static const ibl_section *const sections[] = {
    IBL_SECTION("Outputs", outputs),
    IBL_SECTION("Many environments", many),
    IBL_SECTION("Input", input),
    &ibl_input_section,
    IBL_SECTION("Specular", specular),
    IBL_SECTION("Irradiance and spherical harmonics", irradiance),
    IBL_SECTION("BRDF table", lut),
    IBL_SECTION("Lobe table", lobes),
    &ibl_running_section,
    NULL,
};

static void defaults(void *settings)
{
    *(ibl_opts *)settings = (ibl_opts){
        .common = ibl_common_default(),
        .file = IBL_CONTAINER_KTX2,
        .texels = ibl_texel_options_default(),
        .only = IBL_ALL_OUTPUTS,
        .bake = ibl_bake_options_default(),
        .lut = ibl_lut_options_default(),
        .lobe_table = IBL_LOBES_USUAL,
        .lobe_table_size = ibl_lobe_table_options_default().size,
        .sh_window = INFINITY,
        .max_error = NAN,
        .rendered_error = NAN,
        .judge = ibl_judge_options_default(),
    };
}

/* ---- completion ------------------------------------------------------- */

void ibl_opts_select(ibl_opts *o)
{
    /* KTX files of levels have them for Filament. */
    const bool harmonics = ibl_opts_want(o, IBL_OUTPUT_JSON) || o->sh_format ||
                           o->engine ||
                           (o->format == IBL_CONTAINER_KTX &&
                            ibl_opts_want(o, IBL_OUTPUT_SPECULAR));

    if (o->bake.skybox)
        o->only |= 1u << IBL_OUTPUT_SKYBOX;
    else
        o->only &= ~(1u << IBL_OUTPUT_SKYBOX);
    if (!harmonics)
        o->bake.sh_degree = -1;
    if (o->lobe_table == IBL_LOBES_NO)
        o->only &= ~(1u << IBL_OUTPUT_LOBES);
    o->bake.specular = ibl_opts_want(o, IBL_OUTPUT_SPECULAR);
    o->bake.irradiance = ibl_opts_want(o, IBL_OUTPUT_IRRADIANCE) ||
                         o->engine == IBL_ENGINE_ENV ||
                         o->engine == IBL_ENGINE_PLAYCANVAS ||
                         (o->of && o->of->harmonics);
}

/* Fills in what follows from other options. */
static bool complete(ibl_opts *o)
{
    const int other = o->file - IBL_CONTAINER_COUNT; /* below 0: a container */
    const bool only_lobes =
        o->only != IBL_ALL_OUTPUTS && ibl_opts_want(o, IBL_OUTPUT_LOBES);

    if (other < 0)
        o->format = (ibl_container)o->file;
    else if (other < IBL_ENGINE_PLAYCANVAS)
        o->engine = (ibl_engine)(IBL_ENGINE_ENV + other);
    else
        o->picture =
            (ibl_picture)(IBL_PICTURE_EXR + other - IBL_ENGINE_PLAYCANVAS);
    if (o->file != IBL_CONTAINER_KTX2)
        o->zstd = 0;
    if (o->engine || o->picture > IBL_PICTURE_EXR)
        o->texels.pixel = IBL_PIXEL_RGBA32F;
    if (o->engine) {
        const double most = (double)ibl_engine_max(o->engine);
        if (!(o->texels.largest > 0 && o->texels.largest < most))
            o->texels.largest = most;
        /* Its own file has no others beside it but the sidecar. */
        if (o->only == IBL_ALL_OUTPUTS && !o->bake.skybox)
            o->only = 1u << IBL_OUTPUT_SPECULAR | 1u << IBL_OUTPUT_JSON;
    }
    if (o->layout != IBL_LAYOUT_CROSS)
        o->bake.skybox_projection = o->bake.specular_options.projection =
            o->bake.irradiance_options.projection = (ibl_projection)o->layout;
    /* A sheen has no table unless one was asked for, and pictures, and DDS with
     * the legacy header, have no layers for it. */
    if (o->lobe_table == IBL_LOBES_USUAL)
        o->lobe_table =
            only_lobes || (o->bake.specular_options.lobe == IBL_LOBE_GGX &&
                           o->format != IBL_CONTAINER_DDS_LEGACY && !o->picture)
                ? IBL_LOBES_PRIOR
                : IBL_LOBES_NO;
    if (o->scenes.count && isnan(o->rendered_error))
        o->rendered_error = 0.03;
    o->asked = o->only;
    o->texels.alike = o->zstd > 0;
    o->common.read.refuse_prefiltered = !o->prefiltered;
    o->verify |= !isnan(o->max_error);
    if (o->name)
        return true;
    o->name = o->stem;
    return ibl_stem(o->input, o->stem, sizeof o->stem);
}

bool ibl_opts_of_none(const ibl_opts *o)
{
    const unsigned tables = 1u << IBL_OUTPUT_LUT | 1u << IBL_OUTPUT_LOBES;

    return !(o->only & ~tables) && !o->sh_format && !o->bake.skybox;
}

/* ---- the command line ------------------------------------------------- */

static bool take(void *settings, const char *word)
{
    ibl_cmdline *line = settings;
    const size_t count = (size_t)line->given_count;

    if (!*word)
        return ibl_misuse(
            "the environment's name is empty: give a file, or - for "
            "standard input");
    line->given =
        ibl_need(realloc(line->given, (count + 1) * sizeof *line->given));
    line->given[line->given_count++] = word;
    line->set->input = line->given[0];
    return true;
}

static void release(void *settings)
{
    free(((ibl_cmdline *)settings)->given);
}

/* What a target or preset sets falls away where the command line has no place
 * for it. */
static void drop_unfit(ibl_opts *o)
{
    ibl_specular_options *s = &o->bake.specular_options;

    if (o->preset && o->lut.kind) { /* these are no more than integrals */
        o->lut.samples = 0;
        o->lut.geometry = IBL_GEOMETRY_SMITH;
    }
    if (o->of && o->file >= IBL_CONTAINER_COUNT) /* level 0 is the background */
        o->bake.skybox = 0;
    if (!o->of || ibl_is_given(&o->given, "levels"))
        return;
    /* The last one lights matte surfaces, which show blocks of 8x8 texels. */
    const int least = ibl_pixel_block(o->texels.pixel) > 1 ? 16 : 8;
    while (o->file != IBL_CONTAINER_COUNT + IBL_ENGINE_PLAYCANVAS - 1 &&
           s->levels > 2 && s->size >> (s->levels - 1) < least)
        s->levels--;
    if (s->levels > ibl_most_levels(s->size))
        s->levels = 0;
}

/* Adds the set of a target; NULL: the only set. */
static bool add_set(ibl_cmdline *line, const ibl_opts *typed,
                    const ibl_target *target)
{
    static const ibl_command more = {.sections = sections};
    ibl_opts *o = &line->set[line->count++], want;
    const char *options =
        target ? target->options : preset_options[typed->preset];
    char prefix[32] = "";

    *o = *typed;
    if (*options) {
        char **words = ibl_need(ibl_words_split(options));
        defaults(&want);
        const bool ok = ibl_command_line(&more, words, &want, NULL);
        free(words); /* no option of a target keeps its word */
        *o = want;
        if (!ok || !ibl_command_line(&more, line->words, o, NULL))
            return false;
        o->given = typed->given;
        o->input = typed->input;
    }
    o->of = target;
    drop_unfit(o);
    if (target || typed->preset)
        snprintf(prefix, sizeof prefix,
                 "--%s %s: ", target ? "target" : "preset",
                 target ? target->name : preset_names[typed->preset]);
    ibl_misuse_prefix(prefix);
    const bool ok = (!target || ibl_opts_fit_target(o, &want)) && complete(o) &&
                    ibl_opts_check(o);
    ibl_misuse_prefix("");
    if (ok)
        ibl_opts_select(o);
    return ok;
}

static bool validate(void *settings)
{
    ibl_cmdline *line = settings;
    ibl_opts typed = *line->set;
    bool ok = true;
    struct stat st;

    if (typed.targets & IBL_TARGET_LIST)
        return (typed.given.count == 1 && !line->given_count) ||
               ibl_misuse("--target list: prints what targets set, and "
                          "nothing else: leave out the rest");
    if (typed.incremental && !typed.input && !typed.from)
        return ibl_misuse("--incremental: of which environments? Add them");
    line->batch =
        line->given_count > 1 || typed.from || typed.incremental ||
        (typed.input && !stat(typed.input, &st) && S_ISDIR(st.st_mode));
    if (line->batch && !typed.input)
        typed.input = typed.from;
    for (int i = 0; line->batch && i < line->given_count; i++)
        if (!strcmp(line->given[i], "-"))
            return ibl_misuse("-: standard input is one environment: bake it "
                              "alone, or give ./- if that is its name");
    if (!typed.targets)
        ok = add_set(line, &typed, NULL);
    for (int i = 0; i < ibl_target_count && ok; i++)
        if (typed.targets & 1u << i)
            ok = add_set(line, &typed, &ibl_targets[i]);
    return ok && ibl_opts_check_uses(line);
}

const ibl_command ibl_bake_command = {
    .usage = "[options] ENV... -o DIR",
    .intro =
        "Bakes an equirectangular HDR environment (.hdr, .exr and others; - "
        "reads\n"
        "standard input) into the textures of image-based lighting:\n"
        "  DIR/NAME_specular.EXT    prefiltered cube, one roughness per "
        "level\n"
        "  DIR/NAME_irradiance.EXT  diffuse cube, E/pi\n"
        "  DIR/brdf_lut.EXT         scale and bias of F0 over N.V and "
        "roughness\n"
        "  DIR/lobe_lut.EXT         --lobe-table: where to look up reflections "
        "of any\n"
        "                           view (NAME_lobe_lut.EXT of other levels "
        "or of\n"
        "                           other levels than the default ones)\n"
        "  DIR/NAME.json            spherical harmonics and what was done\n",
    .statuses = "0 done, 1 failed, 2 wrong usage",
    .sections = sections,
    .gone = gone,
    .settings_size = sizeof(ibl_cmdline),
    .given = offsetof(ibl_opts, given),
    .words = offsetof(ibl_cmdline, words),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = ibl_bake_run,
    .release = release,
};
