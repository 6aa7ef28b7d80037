/* SPDX-License-Identifier: MIT */
/* What options of a bake cannot be together, and which of them mean nothing. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/job.h"
#include "common/names.h"

/* A rule: the condition that is refused, the options that may be its reason, of
 * which the first on the line is named, and what to do. */
#define REFUSE(condition, options, ...)                                        \
    if (condition)                                                             \
    return ibl_refuse(&o->given, options, __VA_ARGS__)

enum {
    SKYBOX = 1 << IBL_OUTPUT_SKYBOX,
    SPECULAR = 1 << IBL_OUTPUT_SPECULAR,
    IRRADIANCE = 1 << IBL_OUTPUT_IRRADIANCE,
    LUT = 1 << IBL_OUTPUT_LUT,
    LOBES = 1 << IBL_OUTPUT_LOBES,
    JSON = 1 << IBL_OUTPUT_JSON,
    CUBES = SKYBOX | SPECULAR | IRRADIANCE
};

/* ---- what is refused ----------------------------------------------------- */

static bool is_power_of_two(int n)
{
    return !(n & (n - 1));
}

static bool has_all_roughnesses(const ibl_specular_options *s)
{
    return s->roughness_min <= 0 && s->roughness_max >= 1;
}

/* An engine's own file. */
static bool check_file(const ibl_opts *o)
{
    const ibl_specular_options *s = &o->bake.specular_options;
    const char *name = ibl_format_names[o->file];
    const bool env = o->engine == IBL_ENGINE_ENV;
    const bool atlas = o->engine == IBL_ENGINE_PLAYCANVAS;
    const ibl_roughness_map map =
        env ? IBL_ROUGHNESS_BABYLON : IBL_ROUGHNESS_LINEAR;
    ibl_specular_layout layout = {0};

    ibl_specular_layout_of(s, &layout);
    REFUSE(o->only & ~(SPECULAR | JSON) || o->bake.skybox, "format only skybox",
           "%s is one file, with --only specular,json at most", name);
    REFUSE(o->layout, "layout", "%s files hold cubes: leave it out", name);
    REFUSE(s->mapping != map, "format", "its levels are of --mapping %s",
           ibl_roughness_map_name(map));
    REFUSE(!has_all_roughnesses(s), "format",
           "has all roughnesses: leave out --roughness-range");
    REFUSE(!atlas && o->bake.sh_degree < 2, "sh",
           "%s files have nine coefficients: leave it out", name);
    REFUSE(atlas && (layout.levels != 6 || s->size < 32), "format levels size",
           "an atlas has 6 levels: take --levels 6 and a --size of 32 or more");
    REFUSE(!atlas && !is_power_of_two(s->size), "size",
           "%s files need a power of two", name);
    REFUSE(env && !is_power_of_two(o->bake.irradiance_options.size),
           "irradiance-size", ".env files need a power of two");
    REFUSE(env && s->size >> (layout.levels - 1) != 1, "levels size",
           ".env files have all levels down to 1x1");
    return true;
}

/* Flat ones are exact, and stay as they are. */
static bool check_flat(const ibl_opts *o)
{
    const ibl_specular_options *s = &o->bake.specular_options;
    ibl_specular_layout l = {.levels = 1};

    if (o->only & SPECULAR)
        ibl_specular_layout_of(s, &l);
    REFUSE(s->method == IBL_METHOD_SAMPLED ||
               o->bake.irradiance_options.step > 0,
           "layout",
           "flat maps are never sampled: leave it out, or --method sampled "
           "and --irradiance-step");
    REFUSE(l.size % (1 << (l.levels - 1)), "layout",
           "%d levels from a size of %d do not halve each other: take a "
           "--size that is a multiple of %d",
           l.levels, l.size, 1 << (l.levels - 1));
    REFUSE(o->axes.up != IBL_UP_Y, "up", "turns cubes: leave out --layout");
    REFUSE(o->preview, "preview", "shows cubes: leave out --layout");
    return true;
}

bool ibl_opts_check(const ibl_opts *o)
{
    const ibl_specular_options *s = &o->bake.specular_options;
    const int most = ibl_most_levels(s->size);
    const ibl_lobe lobe = s->lobe;
    const bool all = o->only == IBL_ALL_OUTPUTS;
    const bool chosen = !isnan(o->rendered_error);
    const ibl_pixel pixel = o->texels.pixel;
    ibl_specular_layout layout;

    if (o->explain && !o->input)
        return true;
    if (!o->input && !ibl_opts_of_none(o))
        return ibl_misuse("no environment: iblbake [options] ENV... -o DIR, "
                          "see iblbake --help");
    if (!o->directory && !o->dry_run && ibl_is_command(o->input))
        return ibl_misuse("%s: a command comes first: iblbake %s [options]",
                          o->input, o->input);
    if (!o->directory && !o->dry_run)
        return ibl_misuse("no output directory: add -o DIR");
    if (!ibl_common_validate(&o->common))
        return false;
    REFUSE(strchr(o->name, '/'), "name",
           "has a '/': the directory is set by --output");
    REFUSE(o->only & SKYBOX && !all && !o->bake.skybox, "only",
           "the size of the skybox is not known: add --skybox N");
    REFUSE(chosen && !o->input, "scene rendered-error",
           "in which environment? Add ENV");
    REFUSE((chosen || o->lights == IBL_LIGHTS_AUTO) &&
               (!(o->only & SPECULAR) || lobe != IBL_LOBE_GGX),
           "scene rendered-error lights",
           "is for GGX levels: leave out --lobe, and --only without specular");
    REFUSE(!all && o->only & LOBES && o->lobe_table == IBL_LOBES_NO, "only",
           "with --lobe-table no there is no lobe table: leave one of them "
           "out");
    REFUSE(o->lobe_table != IBL_LOBES_NO && o->only & LOBES &&
               (o->format == IBL_CONTAINER_DDS_LEGACY || o->picture),
           "format",
           "has no layers for a lobe table: leave it out, or take --format "
           "dds");
    REFUSE(o->lobe_table != IBL_LOBES_NO && lobe != IBL_LOBE_GGX, "lobe",
           "a lobe table is for GGX: add --lobe-table no");
    REFUSE(chosen && o->picture, "format",
           "is not what shaders look up: leave out --scene and "
           "--rendered-error");
    REFUSE(o->layout == IBL_LAYOUT_CROSS && !o->picture, "layout",
           "is for pictures: add --format exr, hdr or png");
    REFUSE(o->picture && pixel > IBL_PIXEL_RGBA32F, "pixel",
           "exr files hold rgba16f or rgba32f");
    REFUSE(!ibl_container_holds(o->format, pixel), "pixel",
           "%s files cannot hold it: take %s", ibl_container_name(o->format),
           ibl_container_holds(IBL_CONTAINER_KTX, pixel)
               ? "--format ktx2 or ktx"
               : "--format ktx2");
    REFUSE(!(o->sh_window > 0) && o->bake.sh_degree < 2, "sh",
           "--sh-window auto looks at nine coefficients: leave it out");
    REFUSE(o->sh_format && o->bake.sh_degree < 2, "sh",
           "--sh-format %s has nine coefficients: leave it out",
           ibl_sh_format_names[o->sh_format]);
    if (o->engine && !check_file(o))
        return false;
    REFUSE(s->levels > most, "levels size",
           "a cube of size %d has 1 to %d levels", s->size, most);
    REFUSE(s->mapping == IBL_ROUGHNESS_BABYLON && !has_all_roughnesses(s),
           "mapping",
           "is for the whole range of roughness: leave --roughness-range out");
    REFUSE(ibl_specular_layout_of(s, &layout), "levels roughness-range",
           "a --roughness-range of one value has one level");
    return !o->bake.skybox_projection || check_flat(o);
}

/* Whether a word of a list begins so. */
static bool takes_word(const char *list, const char *start)
{
    const char *at = list;

    while ((at = strstr(at, start)) && at > list && at[-1] != ' ')
        at++;
    return at != NULL;
}

bool ibl_opts_fit_target(const ibl_opts *o, const ibl_opts *want)
{
    const ibl_specular_options *s = &o->bake.specular_options;
    const char *takes = o->of->takes, *load = o->of->load;
    const bool texture = o->file < IBL_CONTAINER_COUNT;
    const int most = ibl_most_levels(s->size);
    const int levels = s->levels ? s->levels : most;
    const int block = texture ? ibl_pixel_block(o->texels.pixel) : 1;
    const int blocks = levels ? block << (levels - 1) : 1;
    char format[32], pair[64];

    snprintf(format, sizeof format, "%s%s", ibl_format_names[o->file],
             texture ? "/" : "");
    snprintf(pair, sizeof pair, "%s%s", format,
             ibl_pixel_name(o->texels.pixel));
    REFUSE(s->mapping != want->bake.specular_options.mapping, "mapping",
           "the engine has other levels: leave it out");
    REFUSE(s->lobe != want->bake.specular_options.lobe, "lobe",
           "the engine has other levels: leave it out");
    REFUSE(o->axes.mirror != want->axes.mirror, "mirror",
           "the engine has other axes: leave it out");
    REFUSE(o->axes.up != want->axes.up, "up",
           "the engine has other axes: leave it out");
    REFUSE(o->layout != want->layout, "layout",
           "the engine has other cubes: leave it out");
    REFUSE(o->of->harmonics && o->sh_format != want->sh_format, "sh-format",
           "the engine reads another: leave it out");
    REFUSE(o->of->filament && o->bake.sh_degree < 2, "sh",
           "the engine reads nine coefficients: leave it out");
    REFUSE(!takes_word(takes, format), "format", "the engine loads %s", takes);
    REFUSE(texture && !takes_word(takes, pair), "pixel", "the engine loads %s",
           takes);
    REFUSE(o->zstd && o->file == IBL_CONTAINER_KTX2 && !strstr(takes, "zstd"),
           "zstd", "the engine loads %s without it", takes);
    REFUSE(!has_all_roughnesses(s), "roughness-range",
           "the engine looks up levels of all roughnesses: leave it out");
    REFUSE(o->of->filters && s->levels != 1, "levels",
           "the engine makes levels of its own: leave it out");
    REFUSE(levels < 2 && !o->of->filters, most < 2 ? "size" : "levels",
           "is a mirror, for every roughness: take 2 or more");
    REFUSE(o->of->whole && !is_power_of_two(s->size), "size",
           "the engine needs a power of two");
    REFUSE(o->of->whole && levels < most, "levels",
           "the engine needs all %d, down to 1x1", most);
    REFUSE(block > 1 && s->size % blocks, "size levels pixel",
           "graphics need whole blocks of %dx%d texels in %d levels: take a "
           "--size that is a multiple of %d",
           block, block, levels, blocks);
    REFUSE(o->explain && strstr(load, "{specular}") && !(o->only & SPECULAR),
           "explain", "the program loads specular: add it to --only");
    REFUSE(o->explain && strstr(load, "{irradiance}") &&
               !(o->only & IRRADIANCE),
           "explain", "the program loads irradiance: add it to --only");
    return true;
}

/* ---- what means nothing -------------------------------------------------- */

#define OR_LEAVE_IT " to --only, or leave it out"

bool ibl_opts_check_uses(const ibl_cmdline *line)
{
    bool used[64] = {false};
    const bool one_env = line->given_count == 1 && !line->set->from;

    for (int i = 0; i < line->count; i++) {
        const ibl_opts *o = &line->set[i];
        const ibl_specular_options *s = &o->bake.specular_options;
        const unsigned only = o->only;
        if (only & IRRADIANCE && o->layout != line->set->layout)
            return ibl_refuse(&o->given, "only",
                              "irradiance of targets with other layouts: bake "
                              "for each alone");
        const bool levels = o->bake.specular, cubes = only & CUBES;
        const bool sampled = s->method == IBL_METHOD_SAMPLED;
        const bool irradiance = o->bake.irradiance;
        const bool chosen = !isnan(o->rendered_error);
        const bool sh = o->bake.sh_degree >= 0;
        const bool lowered =
            o->texels.largest > 0 &&
            o->texels.largest < (o->engine
                                     ? (double)ibl_engine_max(o->engine)
                                     : (double)ibl_pixel_max(o->texels.pixel));
        /* One set in which a rule holds is enough. */
        const ibl_rule uses[] = {
            {"keep-going progress shard", line->batch,
             "is for many environments: add them, or a folder or --from LIST"},
            {"recursive", line->batch, "is for folders: name one"},
            {"prune", o->incremental && !o->shard.count,
             "is for all environments at once: add --incremental, and leave "
             "out --shard"},
            {"preview explain scene rendered-error", !line->batch,
             "is for one environment: bake it alone, without --from and "
             "--incremental"},
            {"name", one_env || !line->batch,
             "is for one environment: bake it alone"},
            {"explain", o->of != NULL,
             "the lines of which engine? Add --target NAME"},
            {"preview", line->count == 1, "shows one set: give one --target"},
            {"dry-run", chosen,
             "nothing is chosen: add --rendered-error E or --scene FILE"},
            {"preset",
             !o->preset ||
                 (!o->of && !chosen && only & (SPECULAR | IRRADIANCE | LUT)),
             "sets levels, irradiance and BRDF table: leave out --target, "
             "--scene, --rendered-error, and --only without these"},
            {"method samples", levels,
             "there are no levels: add specular" OR_LEAVE_IT},
            {"size levels lobe mapping roughness-range", levels || only & LOBES,
             "there are no levels: add specular" OR_LEAVE_IT},
            {"samples lod-bias jitter pdf-mip", levels && sampled,
             "no level is sampled: add --method sampled, or leave it out"},
            {"tolerance",
             (levels && !sampled) ||
                 (irradiance && !(o->bake.irradiance_options.step > 0)),
             "nothing is made by the exact method: leave it out"},
            {"irradiance-size irradiance-step",
             irradiance && !(o->of && o->of->harmonics),
             "there is no irradiance map: add irradiance" OR_LEAVE_IT},
            {"sh sh-window", sh,
             "there are no harmonics: add json" OR_LEAVE_IT},
            {"lut-kind lut-size lut-samples geometry", only & LUT,
             "there is no BRDF table: add lut" OR_LEAVE_IT},
            {"lut-samples geometry", only & LUT && !o->lut.kind,
             "is of --lut-kind split: the others are integrated exactly, with "
             "their own geometry"},
            {"lobe-table", o->asked & LOBES,
             "there is no lobe table: add lobe-table" OR_LEAVE_IT},
            {"lobe-table-size", only & LOBES,
             "there is no lobe table: add lobe-table" OR_LEAVE_IT},
            {"lights sun", only & JSON,
             "the sidecar lists them: add json to --only"},
            {"layout overflow largest quality", cubes,
             "no map is made: add specular, irradiance or skybox" OR_LEAVE_IT},
            {"pixel",
             o->picture < IBL_PICTURE_HDR &&
                 (only & LUT || (cubes && !o->engine)),
             "no texels of that format are made: leave it out"},
            {"tone", cubes && o->picture == IBL_PICTURE_PNG,
             "is for maps in --format png: leave it out"},
            {"quality", cubes && ibl_pixel_block(o->texels.pixel) > 1,
             "is for --pixel bc6h, uastc-hdr and astc4x4hdr: leave it out"},
            {"overflow",
             cubes &&
                 (lowered || o->engine || o->texels.pixel != IBL_PIXEL_RGBA32F),
             "rgba32f holds all light: leave it out"},
            {"largest", cubes && lowered,
             "the pixel format holds no more: leave it out"},
            {"format zstd", only & ~JSON, "no texture is made: leave it out"},
            {"zstd", only & ~JSON && o->file == IBL_CONTAINER_KTX2,
             "only ktx2 files can hold it: take --format ktx2"},
            {"rotate mirror up", cubes || sh,
             "nothing that is made has directions: leave it out"},
            {"prefiltered " IBL_INPUT_OPTIONS, !ibl_opts_of_none(o),
             "nothing that is made depends on the environment: leave it out"},
            {"name", ibl_set_is_named(o),
             "no file has a name of its own: leave it out"},
            {"verify max-error", cubes || only & LUT,
             "nothing that is made can be judged: add a map or lut to "
             "--only"}};
        for (size_t n = 0; n < sizeof uses / sizeof *uses; n++) {
            used[n] |= uses[n].where != 0;
            if (i == line->count - 1 && !used[n] &&
                ibl_given_of(&o->given, uses[n].options))
                return ibl_refuse(&o->given, uses[n].options, "%s",
                                  uses[n].why);
        }
    }
    return true;
}
