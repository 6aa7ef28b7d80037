/* SPDX-License-Identifier: MIT */
#include "cli/bake_record.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli/shell_words.h"
#include "common/names.h"

enum {
    ALL_OUTPUTS = (1 << IBL_OUTPUT_COUNT) - 1
};

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
    unsigned only = 0;

    while (*value) {
        const size_t length = strcspn(value, ",");
        int kind = 0;
        while (kind < IBL_OUTPUT_COUNT &&
               (strncmp(ibl_output_name(kind), value, length) != 0 ||
                ibl_output_name(kind)[length]))
            kind++;
        if (kind == IBL_OUTPUT_COUNT)
            return false;
        only |= 1u << kind;
        value += length;
        if (*value == ',' && !*++value)
            return false;
    }
    *(unsigned *)field = only;
    return only != 0;
}

/* LEVEL=N[,LEVEL=N]...; check_level_samples checks that the levels exist. */
static bool parse_level_samples(void *field, const char *value)
{
    int *level_samples = field;

    for (;;) {
        const char *end;
        int level;
        if (!ibl_number_int(value, 0, IBL_MAX_LEVELS - 1, &level, &end) ||
            *end != '=' ||
            !ibl_number_int(end + 1, 1, 1048576, &level_samples[level], &end))
            return false;
        if (!*end)
            return true;
        if (*end != ',')
            return false;
        value = end + 1;
    }
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
    {"quality", 0, IBL_CHOICE(texels.quality, ibl_quality_names),
     .help = "of bc6h, uastc-hdr and astc4x4hdr: more time, less error"},
    {"overflow", 0, IBL_CHOICE(texels.overflow, ibl_overflow_names),
     .help = "light above the largest value of the pixel format: spread over "
             "the texels around it, or clip"},
    {"largest", 0, IBL_REAL(texels.largest, "MAX", 1e-6, 1e30),
     .standard = "what the pixel format holds",
     .help = "treat light above MAX in the same way"},
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
    {"timings", 0, IBL_FLAG(timings),
     .help = "add the time of each stage to the sidecar, which then differs "
             "from run to run",
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
    {"keep-going", 0, IBL_FLAG(keep_going),
     .help = "after a failure bake the others, and list what failed",
     .aside = true},
    {"incremental", 0, IBL_FLAG(incremental),
     .help = "bake only environments that changed since they were baked with "
             "this option, or whose outputs, options or version did",
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
    {"rotate", 0, IBL_OTHER(bake.yaw_deg, "DEG", ibl_rotate_parse),
     .allowed = IBL_ROTATE_ALLOWED,
     .standard = "0",
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
     .help = "method for the levels: exact (spectral), or importance "
             "sampling; auto: exact, except for the levels of --level-samples"},
    {"samples", 0, IBL_INT(bake.specular_options.samples, 1, 1048576),
     .help = "samples for each texel of a sampled level"},
    {"level-samples", 0, IBL_OTHER(bake.specular_options.level_samples, "LIST",
     parse_level_samples),
     .allowed = "LEVEL=N,..., with N from 1 to 1048576",
     .standard = "",
     .help = "samples of single levels, in place of --samples; auto samples "
             "these levels"},
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
        .only = ALL_OUTPUTS,
        .bake = ibl_bake_options_default(),
        .lut = ibl_lut_options_default(),
        .lobe_table = IBL_LOBES_USUAL,
        .lobe_table_size = ibl_lobe_table_options_default().size,
        .max_error = NAN,
        .rendered_error = NAN,
        .judge = ibl_judge_options_default(),
    };
}

/* ---- checks ---------------------------------------------------------- */

static bool take(void *settings, const char *word)
{
    ibl_bake_line *line = settings;
    const size_t count = (size_t)line->given_count;

    if (!*word)
        return ibl_misuse(
            "the environment's name is empty: give a file, or - for "
            "standard input");
    /* Doubled when it is full, at powers of two. */
    if (!(count & (count - 1))) {
        const size_t room = count ? 2 * count : 1;
        const char **given = realloc(line->given, room * sizeof *given);
        if (!given)
            return ibl_misuse_memory("the environments");
        line->given = given;
    }
    line->given[line->given_count++] = word;
    line->one.input = line->given[0];
    return true;
}

static void release(void *settings)
{
    free(((ibl_bake_line *)settings)->given);
}

static bool check_level_samples(const ibl_specular_options *s, int levels)
{
    for (int l = 0; l < IBL_MAX_LEVELS; l++) {
        const int n = s->level_samples[l];
        if (!n)
            continue;
        if (l == 0 && s->roughness_min <= 0)
            return ibl_misuse("--level-samples 0=%d: level 0 is the "
                              "environment itself and takes none: levels from "
                              "1 do",
                              n);
        if (s->method == IBL_METHOD_SPECTRAL)
            return ibl_misuse("--level-samples %d=%d: --method spectral "
                              "samples no level: leave one of them out",
                              l, n);
        if (l >= levels)
            return ibl_misuse("--level-samples %d=%d: there is no such level: "
                              "they are 0 to %d",
                              l, n, levels - 1);
    }
    return true;
}

static bool check_levels(const ibl_specular_options *s)
{
    ibl_specular_layout layout;
    const int most = ibl_most_levels(s->size);

    if (s->levels > most)
        return ibl_misuse("--levels %d: a cube of size %d has 1 to %d levels",
                          s->levels, s->size, most);
    if (ibl_specular_layout_of(s, &layout))
        return ibl_misuse("--levels %d: --roughness-range %g:%g is one "
                          "roughness, which has one level",
                          s->levels, s->roughness_min, s->roughness_max);
    return check_level_samples(s, layout.levels);
}

/* KTX files of levels have them for Filament. */
static bool needs_harmonics(const ibl_opts *o)
{
    return o->only & 1u << IBL_OUTPUT_JSON || o->sh_format || o->engine ||
           (o->format == IBL_CONTAINER_KTX &&
            o->only & 1u << IBL_OUTPUT_SPECULAR);
}

void ibl_opts_select(ibl_opts *o)
{
    if (o->bake.skybox)
        o->only |= 1u << IBL_OUTPUT_SKYBOX;
    else
        o->only &= ~(1u << IBL_OUTPUT_SKYBOX);
    if (!needs_harmonics(o))
        o->bake.sh_degree = -1;
    if (o->lobe_table == IBL_LOBES_NO)
        o->only &= ~(1u << IBL_OUTPUT_LOBES);
    o->bake.specular = (o->only & 1u << IBL_OUTPUT_SPECULAR) != 0;
    o->bake.irradiance =
        o->only & 1u << IBL_OUTPUT_IRRADIANCE || o->engine == IBL_ENGINE_ENV ||
        o->engine == IBL_ENGINE_PLAYCANVAS || (o->of && o->of->harmonics);
}

static bool check_lobes(const ibl_opts *o)
{
    const bool asked =
        o->only != ALL_OUTPUTS && (o->only & 1u << IBL_OUTPUT_LOBES);

    if (asked && o->lobe_table == IBL_LOBES_NO)
        return ibl_misuse("--only lobe-table: with --lobe-table no there is "
                          "none: leave one of them out");
    if (o->lobe_table != IBL_LOBES_NO && o->only & 1u << IBL_OUTPUT_LOBES &&
        (o->format == IBL_CONTAINER_DDS_LEGACY || o->picture))
        return ibl_misuse("--format %s: has no layers for a lobe table: leave "
                          "it out, or take --format dds",
                          ibl_format_names[o->file]);
    if (o->lobe_table != IBL_LOBES_NO &&
        o->bake.specular_options.lobe != IBL_LOBE_GGX)
        return ibl_misuse("--lobe %s: a lobe table is for GGX: add "
                          "--lobe-table no",
                          ibl_lobe_name(o->bake.specular_options.lobe));
    return true;
}

static bool check_mapping(const ibl_opts *o)
{
    const ibl_specular_options *s = &o->bake.specular_options;

    return s->mapping != IBL_ROUGHNESS_BABYLON ||
           (s->roughness_min <= 0 && s->roughness_max >= 1) ||
           ibl_misuse("--mapping %s: is for the whole range of roughness: "
                      "leave --roughness-range out",
                      ibl_roughness_map_name(s->mapping));
}

static bool check_texels(const ibl_opts *o)
{
    const ibl_texel_options *t = &o->texels;

    return ibl_container_holds(o->format, t->pixel) ||
           ibl_misuse("--pixel %s: %s files cannot hold it: take %s",
                      ibl_pixel_name(t->pixel), ibl_container_name(o->format),
                      ibl_container_holds(IBL_CONTAINER_KTX, t->pixel)
                          ? "--format ktx2 or ktx"
                          : "--format ktx2");
}

/* Whether every level of a flat map halves the one before. */
static bool check_halves(const ibl_opts *o)
{
    ibl_specular_layout l;

    if (!o->bake.specular ||
        ibl_specular_layout_of(&o->bake.specular_options, &l) ||
        !(l.size % (1 << (l.levels - 1))))
        return true;
    return ibl_misuse("--layout %s: %d levels from a size of %d do not halve "
                      "each other: take a --size that is a multiple of %d",
                      ibl_projection_names[o->bake.skybox_projection], l.levels,
                      l.size, 1 << (l.levels - 1));
}

/* Spreads the layout to all outputs. Flat ones are exact, and stay as they
 * are. */
static bool set_layout(ibl_opts *o)
{
    const ibl_projection layout = o->bake.skybox_projection;
    const ibl_specular_options *s = &o->bake.specular_options;
    bool sampled = s->method == IBL_METHOD_SAMPLED;

    for (int l = 0; l < IBL_MAX_LEVELS; l++)
        sampled |= s->level_samples[l] != 0;
    o->bake.specular_options.projection = layout;
    o->bake.irradiance_options.projection = layout;
    if (layout == IBL_PROJECTION_CUBE)
        return true;
    if (sampled || o->bake.irradiance_options.step > 0)
        return ibl_misuse("--layout %s: is never sampled: leave out --%s",
                          ibl_projection_names[layout],
                          !sampled                          ? "irradiance-step"
                          : s->method == IBL_METHOD_SAMPLED ? "method sampled"
                                                            : "level-samples");
    return check_halves(o) &&
           (o->axes.up == IBL_UP_Y ||
            ibl_misuse("--up z: turns cubes: leave out --layout %s",
                       ibl_projection_names[layout])) &&
           (!o->preview ||
            ibl_misuse("--preview %s: shows cubes: leave out --layout %s",
                       o->preview, ibl_projection_names[layout]));
}

static bool check_harmonics(const ibl_opts *o)
{
    if (o->engine && o->engine != IBL_ENGINE_PLAYCANVAS &&
        o->bake.sh_degree < 2)
        return ibl_misuse("--format %s: takes nine coefficients: leave out "
                          "--sh %d",
                          ibl_format_names[o->file], o->bake.sh_degree);
    return !o->sh_format || o->bake.sh_degree >= 2 ||
           ibl_misuse("--sh-format %s: takes nine coefficients: leave out --sh "
                      "%d",
                      ibl_sh_format_names[o->sh_format], o->bake.sh_degree);
}

/* What the engine looks the levels up by. */
static bool check_engine_levels(const ibl_opts *o)
{
    const ibl_specular_options *s = &o->bake.specular_options;
    const char *name = ibl_format_names[o->file];
    const ibl_roughness_map map = o->engine == IBL_ENGINE_ENV
                                      ? IBL_ROUGHNESS_BABYLON
                                      : IBL_ROUGHNESS_LINEAR;
    ibl_specular_layout layout = {0};

    ibl_specular_layout_of(s, &layout);
    if (s->mapping != map)
        return ibl_misuse("--format %s: its levels are of --mapping %s", name,
                          ibl_roughness_map_name(map));
    if (s->roughness_min > 0 || s->roughness_max < 1)
        return ibl_misuse("--format %s: has all roughnesses: leave out "
                          "--roughness-range",
                          name);
    if (o->engine == IBL_ENGINE_PLAYCANVAS)
        return (layout.levels == 6 && s->size >= 32) ||
               ibl_misuse("--format playcanvas: has 6 levels: add --levels 6, "
                          "and a --size of 32 or more");
    if (s->size & (s->size - 1))
        return ibl_misuse("--size %d: %s files need a power of two", s->size,
                          name);
    const int matte = o->bake.irradiance_options.size;
    if (o->engine == IBL_ENGINE_ENV && matte & (matte - 1))
        return ibl_misuse("--irradiance-size %d: .env files need a power of "
                          "two",
                          matte);
    return o->engine != IBL_ENGINE_ENV || 1 == s->size >> (layout.levels - 1) ||
           ibl_misuse("--levels %d: .env files have all down to 1x1",
                      layout.levels);
}

/* Pictures have texels that lose nothing more of what they hold. */
static bool settle_pictures(ibl_opts *o)
{
    const ibl_pixel pixel = o->texels.pixel;

    o->picture = (ibl_picture)(o->file - IBL_CONTAINER_COUNT -
                               IBL_ENGINE_PLAYCANVAS + IBL_PICTURE_EXR);
    if (!isnan(o->rendered_error) || o->scenes.count)
        return ibl_misuse("--format %s: is not what shaders look up: leave out "
                          "--scene and --rendered-error",
                          ibl_format_names[o->file]);
    if (o->picture != IBL_PICTURE_EXR)
        o->texels.pixel = IBL_PIXEL_RGBA32F;
    else if (pixel > IBL_PIXEL_RGBA32F)
        return ibl_misuse("--pixel %s: exr files hold rgba16f or rgba32f",
                          ibl_pixel_name(pixel));
    return true;
}

/* Completes the options of an engine's own file, which has no others beside
 * it but the sidecar. */
static bool settle_file(ibl_opts *o)
{
    const unsigned held = 1u << IBL_OUTPUT_SPECULAR | 1u << IBL_OUTPUT_JSON;

    o->format = o->file < IBL_CONTAINER_COUNT ? (ibl_container)o->file
                                              : IBL_CONTAINER_KTX2;
    if (o->format != IBL_CONTAINER_KTX2 || o->file != (int)o->format)
        o->zstd = 0;
    o->bake.skybox_projection = o->layout == IBL_LAYOUT_CROSS
                                    ? IBL_PROJECTION_CUBE
                                    : (ibl_projection)o->layout;
    if (o->file >= IBL_CONTAINER_COUNT + IBL_ENGINE_PLAYCANVAS)
        return settle_pictures(o);
    if (o->layout == IBL_LAYOUT_CROSS)
        return ibl_misuse("--layout cross: is for pictures: add --format exr, "
                          "hdr or png");
    if (o->file < IBL_CONTAINER_COUNT)
        return true;
    o->engine = (ibl_engine)(o->file - IBL_CONTAINER_COUNT + IBL_ENGINE_ENV);
    if (o->only == ALL_OUTPUTS && !o->bake.skybox)
        o->only = held;
    if (o->only & ~held || o->bake.skybox)
        return ibl_misuse("--format %s: is one file, with --only specular,json "
                          "at most",
                          ibl_format_names[o->file]);
    if (o->layout)
        return ibl_misuse("--layout %s: %s files hold cubes: leave it out",
                          ibl_layout_names[o->layout],
                          ibl_format_names[o->file]);
    o->texels.pixel = IBL_PIXEL_RGBA32F;
    const double most = (double)ibl_engine_max(o->engine);
    if (!(o->texels.largest > 0 && o->texels.largest < most))
        o->texels.largest = most;
    return check_engine_levels(o);
}

/* A sheen has no table unless one was asked for, and DDS with the legacy header
 * has no layers for it. */
static void choose_lobes(ibl_opts *o)
{
    const bool asked =
        o->only != ALL_OUTPUTS && (o->only & 1u << IBL_OUTPUT_LOBES);
    const bool usual = o->bake.specular_options.lobe == IBL_LOBE_GGX &&
                       o->format != IBL_CONTAINER_DDS_LEGACY && !o->picture;

    if (o->lobe_table == IBL_LOBES_USUAL)
        o->lobe_table = usual || asked ? IBL_LOBES_PRIOR : IBL_LOBES_NO;
}

/* Whether nothing that is wanted depends on an environment. */
static bool is_of_none(const ibl_opts *o)
{
    unsigned tables = 1u << IBL_OUTPUT_LUT;
    if (o->lobe_table == IBL_LOBES_PRIOR)
        tables |= 1u << IBL_OUTPUT_LOBES;
    return !(o->only & ~tables) && !o->sh_format && !o->bake.skybox;
}

static bool check_paths(const ibl_opts *o)
{
    if (o->explain && !o->input)
        return true;
    if (!o->input && !is_of_none(o))
        return ibl_misuse(
            "no environment: iblbake [options] ENV... -o DIR, see "
            "iblbake --help");
    if (o->directory || o->dry_run)
        return true;
    if (ibl_is_command(o->input))
        return ibl_misuse("%s: a command comes first: iblbake %s [options]",
                          o->input, o->input);
    return ibl_misuse("no output directory: add -o DIR");
}

static bool check_choice(ibl_opts *o)
{
    char what[64];

    if (o->scenes.count && isnan(o->rendered_error))
        o->rendered_error = 0.03;
    if (isnan(o->rendered_error) && o->lights != IBL_LIGHTS_AUTO)
        return true;
    if (o->scenes.count)
        snprintf(what, sizeof what, "--scene %.40s", o->scenes.path[0]);
    else if (!isnan(o->rendered_error))
        snprintf(what, sizeof what, "--rendered-error %g", o->rendered_error);
    else
        snprintf(what, sizeof what, "--lights auto");
    if (!o->input && !isnan(o->rendered_error))
        return ibl_misuse("%s: in which environment? Add ENV", what);
    if (!(o->only & 1u << IBL_OUTPUT_SPECULAR) ||
        o->bake.specular_options.lobe != IBL_LOBE_GGX)
        return ibl_misuse("%s: is for GGX levels: leave out --lobe, and --only "
                          "without specular",
                          what);
    return true;
}

static bool check_skybox(const ibl_opts *o)
{
    return !(o->only & 1u << IBL_OUTPUT_SKYBOX) || o->only == ALL_OUTPUTS ||
           o->bake.skybox ||
           ibl_misuse("--only skybox: its size is not known: add --skybox N");
}

/* ---- what options mean something ---------------------------------------- */

/* Facts of what a command line makes, of all sets together. */
enum {
    LEVELS = 1 << 0,
    TABLED_LEVELS = 1 << 1, /* levels, or a lobe table for such */
    TAKES_SAMPLES = 1 << 2, /* by --samples */
    SAMPLED = 1 << 3,       /* a level is sampled */
    EXACT = 1 << 4,         /* levels or irradiance are not */
    IRRADIANCE = 1 << 5,
    LUT = 1 << 6,
    SPLIT = 1 << 7, /* a LUT for the split sum */
    LOBES = 1 << 8,
    MAY_HAVE_LOBES = 1 << 9, /* but for --lobe-table no */
    JSON = 1 << 10,
    CUBES = 1 << 11,
    PIXELS = 1 << 12,  /* textures that --pixel is for */
    BLOCKS = 1 << 13,  /* cubes of pixels with a quality */
    LIMITED = 1 << 14, /* cubes of pixels with a largest value */
    LOWERED = 1 << 15, /* below that of the format */
    TEXTURES = 1 << 16,
    ZSTD = 1 << 17, /* files that can be compressed */
    HARMONICS = 1 << 18,
    OF_MAP = 1 << 19,  /* something depends on the environment */
    OF_NAME = 1 << 20, /* something is named by it */
    JUDGED = 1 << 21,  /* by --verify */
    CHOSEN = 1 << 22,  /* by --rendered-error */
    UNCHOSEN = 1 << 23,
    MANY = 1 << 24, /* environments */
    ONE = 1 << 25,
    ONE_GIVEN = 1 << 26, /* by its name */
    ONE_SET = 1 << 27,
    TARGET = 1 << 28,
    PRESETS = 1 << 29, /* something that a preset sets */
    PNG = 1 << 30
};

#define OR_LEAVE_IT " to --only, or leave it out"

static const ibl_rule rules[] = {
    {"keep-going progress shard", MANY,
     "is for many environments: add them, or a folder or --from LIST"},
    {"preview explain scene rendered-error", ONE,
     "is for one environment: bake it alone, without --from and "
     "--incremental"},
    {"name", ONE_GIVEN, "is for one environment: bake it alone"},
    {"explain", TARGET, "the lines of which engine? Add --target NAME"},
    {"preview", ONE_SET, "shows one set: give one --target"},
    {"dry-run", CHOSEN,
     "nothing is chosen: add --rendered-error E or --scene FILE"},
    {"preset", PRESETS,
     "sets levels, irradiance and BRDF table: leave out --target, --scene, "
     "--rendered-error, and --only without these"},
    {"level-samples", UNCHOSEN,
     "the levels are chosen, and exact: leave it out"},
    {"method samples level-samples", LEVELS,
     "there are no levels: add specular" OR_LEAVE_IT},
    {"size levels lobe mapping roughness-range", TABLED_LEVELS,
     "there are no levels: add specular" OR_LEAVE_IT},
    {"samples", TAKES_SAMPLES,
     "no level takes so many: add --method sampled, or leave it out"},
    {"lod-bias jitter pdf-mip", SAMPLED,
     "no level is sampled: add --method sampled, or leave it out"},
    {"tolerance", EXACT, "nothing is made by the exact method: leave it out"},
    {"irradiance-size irradiance-step", IRRADIANCE,
     "there is no irradiance map: add irradiance" OR_LEAVE_IT},
    {"sh", HARMONICS, "there are no harmonics: add json" OR_LEAVE_IT},
    {"lut-kind lut-size lut-samples geometry", LUT,
     "there is no BRDF table: add lut" OR_LEAVE_IT},
    {"lut-samples geometry", SPLIT,
     "is of --lut-kind split: the others are integrated exactly, with their "
     "own geometry"},
    {"lobe-table", MAY_HAVE_LOBES,
     "there is no lobe table: add lobe-table" OR_LEAVE_IT},
    {"lobe-table-size", LOBES,
     "there is no lobe table: add lobe-table" OR_LEAVE_IT},
    {"lights sun", JSON, "the sidecar lists them: add json to --only"},
    {"timings", JSON, "the sidecar has them: add json to --only"},
    {"layout overflow largest quality", CUBES,
     "no map is made: add specular, irradiance or skybox" OR_LEAVE_IT},
    {"pixel", PIXELS, "no texels of that format are made: leave it out"},
    {"quality", BLOCKS,
     "is for --pixel bc6h, uastc-hdr and astc4x4hdr: leave it out"},
    {"overflow", LIMITED, "rgba32f holds all light: leave it out"},
    {"largest", LOWERED, "the pixel format holds no more: leave it out"},
    {"tone", PNG, "is for maps in --format png: leave it out"},
    {"format zstd", TEXTURES, "no texture is made: leave it out"},
    {"zstd", ZSTD, "only ktx2 files can hold it: take --format ktx2"},
    {"rotate mirror up", CUBES | HARMONICS,
     "nothing that is made has directions: leave it out"},
    {"layer part any-aspect input-layout strict primaries exposure clamp",
     OF_MAP, "nothing that is made depends on the environment: leave it out"},
    {"name", OF_NAME, "no file has a name of its own: leave it out"},
    {"verify max-error", JUDGED,
     "nothing that is made can be judged: add a map or lut to --only"},
    {.options = NULL}};

/* A fact, if it holds. */
static unsigned fact(bool holds, unsigned bit)
{
    return holds ? bit : 0;
}

static unsigned facts_of_levels(const ibl_opts *o)
{
    const ibl_specular_options *s = &o->bake.specular_options;
    bool sampled = s->method == IBL_METHOD_SAMPLED;

    if (!o->bake.specular)
        return 0;
    for (int l = 0; l < IBL_MAX_LEVELS; l++)
        sampled |= s->level_samples[l] != 0;
    return LEVELS | TABLED_LEVELS | fact(sampled, SAMPLED) |
           (s->method == IBL_METHOD_SAMPLED ? TAKES_SAMPLES : EXACT);
}

static unsigned facts_of_texels(const ibl_opts *o)
{
    const ibl_texel_options *t = &o->texels;
    const double most = o->engine ? (double)ibl_engine_max(o->engine)
                                  : (double)ibl_pixel_max(t->pixel);
    const bool lowered = t->largest > 0 && t->largest < most;

    return CUBES | fact(!o->engine && o->picture < IBL_PICTURE_HDR, PIXELS) |
           fact(o->picture == IBL_PICTURE_PNG, PNG) |
           fact(ibl_pixel_block(t->pixel) > 1, BLOCKS) |
           fact(lowered, LOWERED) |
           fact(lowered || o->engine || t->pixel != IBL_PIXEL_RGBA32F, LIMITED);
}

/* Of a set whose outputs are selected. */
static unsigned facts_of(const ibl_opts *o)
{
    const unsigned cubes = 1u << IBL_OUTPUT_SKYBOX | 1u << IBL_OUTPUT_SPECULAR |
                           1u << IBL_OUTPUT_IRRADIANCE;
    const bool table = o->only & 1u << IBL_OUTPUT_LUT;
    const bool textures = o->only & ~(1u << IBL_OUTPUT_JSON);
    bool named = o->sh_format;

    for (int kind = 0; kind < IBL_OUTPUT_COUNT; kind++)
        named |= o->only & 1u << kind &&
                 !ibl_bake_is_shared(o, (ibl_output_kind)kind);
    return facts_of_levels(o) |
           (o->only & cubes ? facts_of_texels(o) | JUDGED : 0) |
           fact(o->bake.irradiance && !(o->of && o->of->harmonics),
                IRRADIANCE) |
           fact(o->bake.irradiance && !(o->bake.irradiance_options.step > 0),
                EXACT) |
           fact(table, LUT | JUDGED) |
           fact(table && o->picture < IBL_PICTURE_HDR, PIXELS) |
           fact(table && !o->lut.kind, SPLIT) |
           fact(o->only & 1u << IBL_OUTPUT_LOBES, LOBES | TABLED_LEVELS) |
           fact(o->only & 1u << IBL_OUTPUT_JSON, JSON) |
           fact(textures, TEXTURES) |
           fact(textures && o->file == IBL_CONTAINER_KTX2, ZSTD) |
           fact(o->bake.sh_degree >= 0, HARMONICS) |
           fact(!is_of_none(o), OF_MAP) | fact(named, OF_NAME) |
           fact(!o->preset || (!o->of && isnan(o->rendered_error) &&
                               o->only & (1u << IBL_OUTPUT_SPECULAR |
                                          1u << IBL_OUTPUT_IRRADIANCE |
                                          1u << IBL_OUTPUT_LUT)),
                PRESETS) |
           (isnan(o->rendered_error) ? UNCHOSEN : CHOSEN);
}

static unsigned facts_of_line(const ibl_bake_line *line)
{
    const bool one = line->given_count == 1 && !line->one.from;

    return (line->batch ? MANY : ONE) | fact(one || !line->batch, ONE_GIVEN) |
           fact(line->count < 2, ONE_SET) | fact(line->count, TARGET);
}

/* Adds the set's facts. */
static bool check_set(ibl_opts *o, unsigned *facts)
{
    if (!settle_file(o))
        return false;
    choose_lobes(o);
    if (!check_paths(o) || !check_skybox(o) || !check_choice(o) ||
        !ibl_common_validate(&o->common) || !check_mapping(o) ||
        !check_lobes(o) || !check_texels(o) || !check_harmonics(o) ||
        !check_levels(&o->bake.specular_options))
        return false;
    if (!o->name) {
        if (!ibl_stem(o->input, o->stem, sizeof o->stem))
            return false;
        o->name = o->stem;
    }
    if (strchr(o->name, '/'))
        return ibl_misuse("--name %s: has a '/': the directory is set by "
                          "--output",
                          o->name);
    *facts |= fact(o->only & 1u << IBL_OUTPUT_LOBES, MAY_HAVE_LOBES);
    ibl_opts_select(o);
    o->texels.alike = o->zstd > 0;
    if (!set_layout(o))
        return false;
    o->verify |= !isnan(o->max_error);
    *facts |= facts_of(o);
    return true;
}

/* ---- targets ---------------------------------------------------------- */

static bool accept(void *settings)
{
    (void)settings;
    return true;
}

/* The environments were taken when the words were read first. */
static bool pass(void *settings, const char *word)
{
    (void)settings;
    return *word;
}

/* Reads the options of a target, then those of the command line. */
static bool read_words(const char *first, char **words, ibl_opts *o)
{
    const ibl_command set = {.sections = sections,
                             .settings_size = sizeof *o,
                             .defaults = defaults,
                             .take = pass,
                             .validate = accept};
    char **options = ibl_words_split(first), **all = NULL;
    int count = 0, more = 0;

    while (options && options[count])
        count++;
    while (words[more])
        more++;
    if (options)
        all = malloc((size_t)(count + more + 1) * sizeof *all);
    if (all) {
        memcpy(all, options, (size_t)count * sizeof *all);
        memcpy(all + count, words, (size_t)(more + 1) * sizeof *all);
    }
    /* No option of a target keeps its word. */
    const bool ok = all ? ibl_command_line(&set, all, o, NULL)
                        : ibl_misuse_memory("the options");
    free(all);
    free(options);
    return ok;
}

/* What a target sets falls away where the command line has no place for it. */
static void drop_unfit(ibl_opts *o)
{
    ibl_specular_options *s = &o->bake.specular_options;

    if (o->file >= IBL_CONTAINER_COUNT) /* level 0 is the background */
        o->bake.skybox = 0;
    if (ibl_is_given(&o->given, "levels"))
        return;
    /* The last one lights matte surfaces, which show blocks of 8x8 texels. */
    const int least = ibl_pixel_block(o->texels.pixel) > 1 ? 16 : 8;
    while (o->file != IBL_CONTAINER_COUNT + IBL_ENGINE_PLAYCANVAS - 1 &&
           s->levels > 2 && s->size >> (s->levels - 1) < least)
        s->levels--;
    if (s->levels > ibl_most_levels(s->size))
        s->levels = 0;
}

static bool add_set(ibl_bake_line *line, const ibl_target *target,
                    unsigned *facts)
{
    ibl_opts *o = &line->set[line->count++];
    static char *none[] = {NULL};
    const char *options = target->options;
    ibl_opts want;
    char prefix[32];

    if (!read_words(options, none, &want) ||
        !read_words(options, line->words, o))
        return false;
    o->given = line->one.given;
    o->input = line->one.input;
    o->of = target;
    o->filament = target->filament;
    drop_unfit(o);
    snprintf(prefix, sizeof prefix, "--target %s: ", target->name);
    ibl_misuse_prefix(prefix);
    const bool ok = ibl_opts_fit_target(o, &want) && check_set(o, facts);
    ibl_misuse_prefix("");
    return ok;
}

/* Reads the options of the preset before those of the command line. */
static bool add_preset(ibl_bake_line *line)
{
    const int preset = line->one.preset;
    static char prefix[32]; /* of messages to come */
    ibl_opts o;

    if (!read_words(preset_options[preset], line->words, &o))
        return false;
    if (o.layout)
        return ibl_misuse("--preset %s: samples cubes: leave out --layout %s",
                          preset_names[preset], ibl_layout_names[o.layout]);
    if (o.lut.kind) { /* others have no more than their integrals */
        o.lut.samples = 0;
        o.lut.geometry = IBL_GEOMETRY_SMITH;
    }
    o.given = line->one.given;
    o.input = line->one.input;
    line->one = o;
    snprintf(prefix, sizeof prefix, "--preset %s: ", preset_names[preset]);
    ibl_misuse_prefix(prefix);
    return true;
}

/* Decides whether the line is a batch. */
static bool settle_batch(ibl_bake_line *line)
{
    ibl_opts *o = &line->one;
    struct stat st;

    line->batch = line->given_count > 1 || o->from || o->incremental ||
                  (o->input && !stat(o->input, &st) && S_ISDIR(st.st_mode));
    if (o->incremental && !o->input && !o->from)
        return ibl_misuse("--incremental: of which environments? Add them");
    if (!line->batch)
        return true;
    if (!o->input)
        o->input = o->from;
    for (int i = 0; i < line->given_count; i++)
        if (!strcmp(line->given[i], "-"))
            return ibl_misuse("-: standard input is one environment: bake it "
                              "alone, or give ./- if that is its name");
    return true;
}

static bool validate(void *settings)
{
    ibl_bake_line *line = settings;
    const unsigned targets = line->one.targets;
    unsigned facts = 0;

    if (targets & IBL_TARGET_LIST)
        return line->one.given.count == 1 && !line->given_count
                   ? true
                   : ibl_misuse("--target list: prints what targets set, and "
                                "nothing else: leave out the rest");
    if (!settle_batch(line) ||
        (line->one.preset && !targets && !add_preset(line)))
        return false;
    if (!targets && !check_set(&line->one, &facts))
        return false;
    ibl_misuse_prefix("");
    for (int i = 0; i < ibl_target_count; i++)
        if (targets & 1u << i && !add_set(line, &ibl_targets[i], &facts))
            return false;
    return ibl_check_rules(&line->one.given, rules,
                           facts | facts_of_line(line));
}

static void keep_words(void *settings, char **words)
{
    ((ibl_bake_line *)settings)->words = words;
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
    .settings_size = sizeof(ibl_bake_line),
    .given = offsetof(ibl_opts, given),
    .defaults = defaults,
    .keep_words = keep_words,
    .take = take,
    .validate = validate,
    .run = ibl_bake_run,
    .release = release,
};
