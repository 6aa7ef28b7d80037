/* SPDX-License-Identifier: MIT */
#include "cli/verify_files.h"

#include <errno.h>
#include <float.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/faces.h"
#include "common/about.h"
#include "common/names.h"
#include "common/path.h"
#include "common/sidecar.h"
#include "engine/engine.h"
#include "json/text.h"

typedef struct reader {
    const ibl_verify_opts *opts;
    ibl_ctx *ctx;
    ibl_console *console;
    char *sidecar_path;
    json_t *sidecar; /* NULL: no sidecar */
    ibl_verify_files *files;
    ibl_output_kind kind; /* output being searched or read */
    char *path;           /* file of that output */
    int first;            /* index of its first level in files */
    ibl_about about;      /* that file */
} reader;

/* ---- finding --------------------------------------------------------- */

/* The path of a file in the directory; NULL: no memory. */
static char *in_directory(const reader *r, const char *stem, const char *rest)
{
    char name[1024];

    snprintf(name, sizeof name, "%s%s", stem, rest);
    return ibl_path_join(r->opts->directory, name);
}

/* The sidecar's entry for the output; NULL: none, or an option has the file. */
static json_t *find_output(const reader *r)
{
    return r->opts->files[r->kind]
               ? NULL
               : ibl_sidecar_output(r->sidecar, "content",
                                    ibl_output_content(r->kind));
}

static bool open_sidecar(reader *r)
{
    const char *directory = r->opts->directory;
    ibl_json_why why;
    struct stat st;

    if (stat(directory, &st))
        return ibl_console_fail(r->console,
                                "%s: %s: give the directory of a bake",
                                directory, strerror(errno));
    if (!S_ISDIR(st.st_mode))
        return ibl_console_fail(
            r->console,
            "%s: not a directory: give the environment first, then "
            "the directory of its bake",
            directory);
    r->sidecar_path = in_directory(r, r->opts->name, ".json");
    if (!r->sidecar_path || access(r->sidecar_path, F_OK))
        return r->sidecar_path;
    r->sidecar = ibl_sidecar_load(r->sidecar_path, &why);
    return r->sidecar ||
           ibl_console_fail(r->console, "%s%s", why.line,
                            why.status == IBL_ERR_FORMAT
                                ? ": bake again, or remove it and say "
                                  "what the files mean"
                                : "");
}

/* Takes the file named stem and rest if it is there. Fails if there is another
 * one already. */
static bool take_there(reader *r, const char *stem, const char *rest)
{
    char *candidate = in_directory(r, stem, rest);

    if (!candidate)
        return false;
    if (!r->path && !access(candidate, F_OK)) {
        r->path = candidate;
        return true;
    }
    const bool alone =
        access(candidate, F_OK) ||
        ibl_console_fail(r->console,
                         "%s: %s is there, too: name the one to judge "
                         "with --%s",
                         candidate, r->path, ibl_output_name(r->kind));
    free(candidate);
    return alone;
}

/* Finds the one file named stem, suffix and a container's extension. */
static bool find_there(reader *r, const char *stem, const char *suffix)
{
    bool ok = true;

    for (int c = 0; ibl_array_container_names[c] && ok; c++) {
        char rest[32];
        snprintf(rest, sizeof rest, "%s.%s", suffix,
                 ibl_array_container_names[c]);
        ok = take_there(r, stem, rest);
    }
    return ok;
}

/* The levels may be in an engine's own file, which has another name. */
static bool find_levels(reader *r)
{
    bool ok = find_there(r, r->opts->name, "_specular");

    for (int e = IBL_ENGINE_ENV; e <= IBL_ENGINE_PLAYCANVAS && ok; e++)
        ok = take_there(r, r->opts->name, ibl_engine_suffix((ibl_engine)e));
    return ok;
}

/* Finds the file of the output by the option, the sidecar or its name. r->path
 * stays NULL if there is none. */
static bool find_file(reader *r)
{
    static const char *const suffixes[] = {[IBL_OUTPUT_SKYBOX] = "_skybox",
                                           [IBL_OUTPUT_IRRADIANCE] =
                                               "_irradiance"};
    const ibl_verify_opts *o = r->opts;
    const char *file;
    bool ok = true;

    if (o->files[r->kind])
        return (r->path = strdup(o->files[r->kind]));
    if (!o->directory)
        return true;
    if (!json_unpack(find_output(r), "{s:s}", "file", &file) &&
        !strchr(file, '/')) {
        r->path = in_directory(r, file, "");
        return r->path &&
               (!access(r->path, F_OK) ||
                ibl_console_fail(
                    r->console,
                    "%s: %s names it, but it is not there: bake again", r->path,
                    r->sidecar_path));
    }
    if (r->kind == IBL_OUTPUT_LOBES)
        return find_there(r, o->name, "_lobe_lut") &&
               (r->path || find_there(r, ibl_output_content(r->kind), ""));
    if (r->kind == IBL_OUTPUT_SPECULAR)
        return find_levels(r);
    if (r->kind != IBL_OUTPUT_LUT)
        return find_there(r, o->name, suffixes[r->kind]);
    for (int i = 0; ibl_lut_stems[i] && ok && !r->path; i++)
        ok = find_there(r, ibl_lut_stems[i], "");
    for (int i = 0; ibl_table_stems[i] && ok && !r->path; i++)
        ok = find_there(r, ibl_table_stems[i], "");
    return ok;
}

static bool find_files(reader *r)
{
    char **path = r->files->path;
    bool ok = true;

    for (int kind = 0; kind < IBL_VERIFY_KINDS && ok; kind++) {
        r->kind = (ibl_output_kind)kind;
        r->path = NULL;
        ok = (kind == IBL_OUTPUT_LOBES && !r->opts->rendered) || find_file(r);
        path[kind] = r->path;
    }
    return ok && (!r->opts->directory || path[IBL_OUTPUT_SKYBOX] ||
                  path[IBL_OUTPUT_SPECULAR] || path[IBL_OUTPUT_IRRADIANCE] ||
                  ibl_console_fail(
                      r->console,
                      "%s: has no %s_specular, _irradiance or _skybox (.ktx2, "
                      ".ktx, .dds), nor an engine's file (.env, .gltf, "
                      "_envatlas.png): give the --name of the bake",
                      r->opts->directory, r->opts->name));
}

/* ---- what files say -------------------------------------------------- */

/* The lod that the levels of a mapping have; false: no levels have it. */
static bool set_lod(const reader *r, ibl_lod *lod, ibl_roughness_map map,
                    double first, double last)
{
    const bool babylon = map == IBL_ROUGHNESS_BABYLON;
    const ibl_specular_options o = {
        .struct_size = sizeof o,
        .size = babylon ? r->files->level[r->first].size : IBL_MAX_CUBE_SIZE,
        .levels = r->files->count - r->first,
        .mapping = map,
        .roughness_min = babylon ? 0 : first,
        .roughness_max = babylon ? 1 : last};

    *lod = (ibl_lod){.count = 0};
    return !ibl_specular_layout_of(&o, &lod->layout);
}

/* Finds the roughness of each level in the option, the key or the sidecar. */
static bool find_roughness(const reader *r, const ibl_texture *tex, int levels,
                           double list[IBL_MAX_LEVELS])
{
    const ibl_verify_map *m = &r->opts->roughness;
    const ibl_about *a = &r->about;
    const bool key = ibl_texture_get(tex, "iblbake.roughness");
    const char *who = key ? "its key iblbake.roughness" : r->sidecar_path;
    const json_t *array = json_object_get(find_output(r), "levels");

    if (m->count && m->count != levels)
        return ibl_console_fail(
            r->console, "%s: has %d levels, but --roughness-map lists %d",
            r->path, levels, m->count);
    if (m->given || (!key && !array)) {
        ibl_lod lod;
        const bool formula = !m->count && set_lod(r, &lod, m->map, 0, 1);
        for (int l = 0; l < levels; l++)
            list[l] = formula ? lod.layout.roughness[l] : m->list[l];
        return true;
    }
    if (a->levels > 0 && a->levels != levels)
        return ibl_console_fail(
            r->console,
            "%s: has %d levels, but %s lists the roughness of %d: bake it "
            "again, or say what it is with --roughness-map",
            r->path, levels, who, a->levels);
    for (int l = 0; l < a->levels; l++)
        list[l] = a->roughness[l];
    return a->levels > 0 ||
           ibl_console_fail(
               r->console,
               "%s: %s lists no roughness that levels have: bake it again, or "
               "say what it is with --roughness-map",
               r->path, who);
}

/* Sets the lod: that of the option, else of a mapping that is named, else the
 * levels themselves, with straight lines between them. */
static void find_lod(const reader *r, const double *roughness, int levels)
{
    const ibl_verify_opts *o = r->opts;
    const ibl_verify_map *m = &o->roughness;
    ibl_lod *lod = &r->files->lod;
    const int found = r->about.value[IBL_ABOUT_MAPPING];

    *lod = o->lod.lod;
    if (o->lod.given && lod->count)
        return;
    if (o->lod.given ? set_lod(r, lod, lod->layout.mapping, 0, 1)
        : m->given   ? !m->count && set_lod(r, lod, m->map, 0, 1)
                     : r->about.word[IBL_ABOUT_MAPPING] && found >= 0 &&
                         set_lod(r, lod, (ibl_roughness_map)found, roughness[0],
                                 roughness[levels - 1]))
        return;
    *lod = (ibl_lod){.count = levels};
    for (int l = 0; l < levels; l++) {
        lod->roughness[l] = roughness[l];
        lod->lod[l] = l;
    }
}

/* Sets the lobe and the roughness of the levels. */
static bool describe_specular(const reader *r, const ibl_texture *tex)
{
    ibl_judge_level *level = r->files->level + r->first;
    const int levels = r->files->count - r->first;
    const int found = r->about.value[IBL_ABOUT_LOBE];
    double roughness[IBL_MAX_LEVELS];

    if (!r->opts->lobe && found < 0)
        return ibl_console_fail(r->console,
                                "%s: of a lobe %s, which is not known: say "
                                "what it is with --lobe",
                                r->path, r->about.word[IBL_ABOUT_LOBE]);
    if (!find_roughness(r, tex, levels, roughness))
        return false;
    for (int l = 0; l < levels; l++) {
        level[l].lobe = (ibl_lobe)(r->opts->lobe ? r->opts->lobe - 1 : found);
        level[l].roughness = roughness[l];
    }
    find_lod(r, roughness, levels);
    return true;
}

/* Checks the axes; those of the option come before. */
static bool check_axes(const reader *r)
{
    const ibl_about *a = &r->about;

    for (int i = IBL_ABOUT_MIRROR; i <= IBL_ABOUT_UP && !r->opts->axes[0]; i++)
        if (a->value[i] < 0)
            return ibl_console_fail(r->console,
                                    "%s: its %s is %s, which is not known: say "
                                    "its axes with --axes",
                                    r->path, ibl_about_words[i].member,
                                    a->word[i]);
    return true;
}

static bool note_yaw(const reader *r, const ibl_texture *tex)
{
    const char *text = ibl_texture_get(tex, "iblbake.yaw_deg"), *end;
    const double asked = r->opts->yaw_deg, before = r->files->yaw_deg;
    double yaw;

    if (!text || !ibl_number_real(text, -DBL_MAX, DBL_MAX, &yaw, &end) || *end)
        return true;
    if (isnan(asked) && !isnan(before) && yaw != before)
        return ibl_console_fail(
            r->console,
            "%s: baked with --rotate %g, another file with %g: judge one at a "
            "time",
            r->path, yaw, before);
    if (isnan(asked))
        r->files->yaw_deg = yaw;
    else if (yaw != asked)
        ibl_console_warn(r->console,
                         "%s: says --rotate %g, but is judged by --rotate %g "
                         "as asked",
                         r->path, yaw, asked);
    return true;
}

/* Lights that were taken out of the map for a texture, by the option, its key
 * or the sidecar. */
static bool note_lights(const reader *r, const ibl_texture *tex)
{
    const char *key = ibl_texture_get(tex, "iblbake.lights"), *end;
    const int before = r->files->lights;
    ibl_light listed[IBL_MAX_LIGHTS];
    int lights = find_output(r) ? ibl_sidecar_lights(r->sidecar, listed) : 0;

    if (r->kind == IBL_OUTPUT_SKYBOX)
        return true;
    if (!key && lights < 0 && r->opts->lights < 0)
        return ibl_console_fail(r->console,
                                "%s: its lights are damaged: bake again, or "
                                "say how many there are with --lights",
                                r->sidecar_path);
    if (key && (!ibl_number_int(key, 0, IBL_MAX_LIGHTS, &lights, &end) || *end))
        return ibl_console_fail(r->console,
                                "%s: its key iblbake.lights is no number of "
                                "lights: say it with --lights",
                                r->path);
    if (r->opts->lights >= 0)
        lights = r->opts->lights;
    r->files->lights = lights;
    return before < 0 || before == lights ||
           ibl_console_fail(r->console,
                            "%s: baked with %d lights taken out, another file "
                            "with %d: judge one at a time",
                            r->path, lights, before);
}

static bool odd_colour(const reader *r, const char *key)
{
    return ibl_console_fail(r->console,
                            "%s: its key iblbake.%s is not what iblbake "
                            "writes: bake it again",
                            r->path, key);
}

/* What was done to the map's colours for a texture. */
static bool note_colour(const reader *r, const ibl_texture *tex)
{
    const char *primaries = ibl_texture_get(tex, "iblbake.primaries");
    const char *exposure = ibl_texture_get(tex, "iblbake.exposure");
    const char *clamp = ibl_texture_get(tex, "iblbake.clamp"), *end = "";
    const int found =
        primaries ? ibl_names_find(ibl_primaries_names, primaries) : 0;
    ibl_read_options *read = &r->files->read;

    if (found < 0)
        return odd_colour(r, "primaries");
    if (primaries)
        read->primaries = (ibl_primaries)found;
    if (exposure &&
        (!ibl_number_real(exposure, -IBL_MAX_EXPOSURE, IBL_MAX_EXPOSURE,
                          &read->exposure, &end) ||
         *end))
        return odd_colour(r, "exposure");
    return !clamp ||
           (ibl_number_real(clamp, 0, FLT_MAX, &read->clamp, &end) && !*end) ||
           odd_colour(r, "clamp");
}

/* Options come before what files and sidecar say. */
static void settle_colour(const reader *r)
{
    const ibl_read_options *asked = &r->opts->common.read;
    ibl_read_options *read = &r->files->read;

    if (asked->transfer)
        read->transfer = asked->transfer;
    if (asked->primaries)
        read->primaries = asked->primaries;
    if (fabs(asked->exposure) > 0)
        read->exposure = asked->exposure;
    if (asked->clamp > 0)
        read->clamp = asked->clamp;
}

/* Sets the rotation from the option, else a texture, else the sidecar. */
static void settle_yaw(const reader *r)
{
    double *yaw = &r->files->yaw_deg;

    if (!isnan(r->opts->yaw_deg))
        *yaw = r->opts->yaw_deg;
    else if (isnan(*yaw) && json_unpack(r->sidecar, "{s:{s:F}}", "orientation",
                                        "yaw_deg", yaw))
        *yaw = 0;
}

/* ---- reading --------------------------------------------------------- */

/* The texel of our cube with the direction of texel `at` of the files' cube. */
static ibl_texel turn(const reader *r, const ibl_level_shape *shape,
                      ibl_texel at)
{
    double theirs[3], ours[3];

    ibl_level_direction(shape, at.face, at.x, at.y, theirs);
    if (!r->opts->axes[0])
        ibl_axes_turn(ibl_about_axes(&r->about), 1, theirs, ours);
    for (int k = 0; k < 3 && r->opts->axes[0]; k++) {
        const int axis = r->opts->axes[k];
        ours[abs(axis) - 1] = axis < 0 ? -theirs[k] : theirs[k];
    }
    return ibl_level_hit(shape, ours);
}

/* The nRMSE of a level by its pixel format, as the sidecar says; NAN: it does
 * not. */
static double find_loss(const reader *r, int level)
{
    const json_t *levels = json_object_get(find_output(r), "levels");
    const json_t *error =
        json_object_get(json_array_get(levels, (size_t)level), "pixel_error");
    const json_t *nrmse = json_object_get(error, "nrmse");

    return json_is_real(nrmse) ? json_real_value(nrmse) : NAN;
}

static bool is_turned(const reader *r)
{
    const ibl_axes axes = ibl_about_axes(&r->about);

    return r->opts->axes[0] || axes.mirror || axes.up;
}

/* Copies a level, turned to our axes. */
static bool turn_level(const reader *r, const ibl_cube *from, int level,
                       ibl_cube *to)
{
    const int n = ibl_cube_edge(from->size, level);
    const ibl_level_shape shape = ibl_level_shape_of(from->projection, n);

    if (ibl_cube_alloc_as(r->ctx, from->projection, n, 1, to))
        return false;
    const int w = shape.width, h = shape.height;
    for (int i = 0; i < shape.faces * w * h; i++) {
        const ibl_texel ours =
            turn(r, &shape, (ibl_texel){i / w / h, i % w, i / w % h});
        memcpy(ibl_level_at(to->data, &shape, ours),
               ibl_cube_face(from, level, 0) + 3 * (size_t)i,
               3 * sizeof(float));
    }
    return true;
}

/* Adds a level of `from` to the files: a copy in our axes, or, if those are the
 * files', its own texels. */
static bool add_level(const reader *r, const ibl_cube *from, int level,
                      ibl_pixel pixel, size_t mended)
{
    ibl_verify_files *f = r->files;
    const int n = ibl_cube_edge(from->size, level);
    const int first = f->count > r->first ? f->level[r->first].size : n;
    ibl_cube *to = &f->cube[f->count];

    if (is_turned(r) && !turn_level(r, from, level, to))
        return false;
    if (is_turned(r))
        f->owned[f->owned_count++] = *to;
    else
        *to = (ibl_cube){n, 1, ibl_cube_face(from, level, 0), from->projection};
    f->level[f->count] = (ibl_judge_level){
        .content = r->kind,
        .number = f->count - r->first,
        .scale = r->kind == IBL_OUTPUT_IRRADIANCE && r->opts->scale ? M_PI : 1,
        .projection = from->projection,
        .size = n,
        .base = first > n ? first : n,
        .texels = to->data,
        .pixel = pixel,
        .loss = find_loss(r, f->count - r->first),
        .mended = mended};
    f->count++;
    return true;
}

/* Flat maps lie about Y. */
static bool is_tilted(const ibl_verify_opts *o)
{
    return o->axes[0] && abs(o->axes[1]) != 2;
}

/* Checks the shape of a table, and gives it the key of its kind, which DDS
 * files and those of other tools lack. */
static bool name_kind(const reader *r, ibl_texture *tex)
{
    const char *word = r->about.word[IBL_ABOUT_TABLE];
    const int found = r->about.value[IBL_ABOUT_TABLE];
    const int kind = r->opts->table ? r->opts->table - 1 : found;

    if (kind < 0)
        return ibl_console_fail(r->console, "%s: of an unknown kind, %.40s",
                                r->path, word);
    const int channels = ibl_lut_channels((ibl_lut_kind)kind);
    if (tex->faces != 1 || tex->width != tex->height ||
        ibl_pixel_channels(tex->pixel) != channels)
        return ibl_console_fail(r->console,
                                "%s: no table of --lut-kind %s: it must be "
                                "flat, square and of %d channels",
                                r->path, ibl_lut_name((ibl_lut_kind)kind),
                                channels);
    return (!word && !kind) ||
           !ibl_texture_set(r->ctx, tex, "iblbake.table",
                            ibl_lut_name((ibl_lut_kind)kind));
}

/* What the file's keys say and, unless an option has the file, the sidecar. */
static void read_about(reader *r, const ibl_texture *tex)
{
    ibl_about_read(tex, r->sidecar, find_output(r), &r->about);
}

/* Reads a texture and checks its shape: one layer, a cube or a table. */
static bool read_texture(reader *r, ibl_texture *tex)
{
    const bool cube = r->kind != IBL_OUTPUT_LUT;

    if (ibl_engine_read(r->ctx, r->path, r->opts->layer, tex))
        return false;
    read_about(r, tex);
    if (!cube && !name_kind(r, tex))
        return false;
    if (cube && tex->faces == 1 && ibl_pixel_channels(tex->pixel) != 3)
        return ibl_console_fail(r->console,
                                "%s: a flat texture of two channels: %s has "
                                "colour",
                                r->path, ibl_output_content(r->kind));
    if (cube && tex->faces == 1 && is_tilted(r->opts))
        return ibl_console_fail(
            r->console, "%s: a flat texture: with --axes its Y must be y or -y",
            r->path);
    return tex->layers == 1 ||
           ibl_console_fail(r->console,
                            "%s: an array of %d layers: %s is a single one: "
                            "name it by --array-layer, or all by SET.json",
                            r->path, tex->layers, ibl_output_content(r->kind));
}

/* Bytes of texels as floats; all levels have at most 4/3 of the first. */
static double as_floats(int width, int height, int faces, int levels)
{
    const double first = (double)width * height * faces;

    return 3 * sizeof(float) * first * (levels > 1 ? 4 / 3.0 : 1);
}

bool ibl_verify_fits(const ibl_verify_opts *opts, ibl_console *console,
                     const ibl_verify_files *files, const char *name,
                     double more)
{
    const size_t most = ibl_memory_most(&opts->common);
    double need = IBL_PROGRAM_BYTES + more;

    for (int i = 0; i < files->owned_count; i++) {
        const ibl_cube *map = &files->owned[i];
        const ibl_level_shape s =
            ibl_level_shape_of(map->projection, map->size);
        need += as_floats(s.width, s.height, s.faces, map->levels);
    }
    return !most || need <= (double)most ||
           ibl_console_fail(console,
                            "%s: takes %.0f MiB of memory with what was read "
                            "before, more than the %.0f of --max-memory: judge "
                            "fewer files at once, by --specular and its like, "
                            "or scale the map down",
                            name, ceil(need / (1 << 20)),
                            floor((double)most / (1 << 20)));
}

/* Keeps a cube whose levels were added, or frees it if they were copied. */
static void keep(const reader *r, ibl_cube *cube)
{
    if (is_turned(r))
        ibl_cube_free(cube);
    else
        r->files->owned[r->files->owned_count++] = *cube;
}

static bool read_container(reader *r, ibl_texture *tex)
{
    ibl_cube cube = {0};

    if (strstr(r->path, "%l") && access(r->path, F_OK))
        return ibl_console_fail(
            r->console,
            "%s: has %%l but no %%f: put %%f where the names of the faces are",
            r->path);
    bool ok = read_texture(r, tex) && check_axes(r) &&
              ibl_verify_fits(r->opts, r->console, r->files, r->path,
                              (double)tex->bytes +
                                  as_floats(tex->width, tex->height, tex->faces,
                                            tex->levels)) &&
              !ibl_texture_to_cube(r->ctx, tex, &cube);
    ibl_bytes_free(tex->data); /* from here on, only its keys are needed */
    tex->data = NULL;
    /* Mips of an irradiance map serve minification and are not judged. */
    const int levels = r->kind == IBL_OUTPUT_IRRADIANCE ? 1 : cube.levels;
    for (int l = 0; l < levels && ok; l++)
        ok = add_level(r, &cube, l, tex->pixel, 0);
    keep(r, &cube);
    return ok && note_yaw(r, tex) && note_colour(r, tex);
}

/* Replaces %l by the level, %f by the face's name and %% by %. The caller must
 * free the result. */
static char *expand(const char *pattern, int level, const char *face)
{
    ibl_memory_file file;
    FILE *to = ibl_memory_open(&file);

    for (; to && *pattern; pattern++) {
        const char next = *pattern == '%' ? pattern[1] : '\0';
        if (next == 'l')
            fprintf(to, "%d", level);
        else if (next == 'f')
            fputs(face, to);
        else
            fputc(*pattern, to);
        pattern += next == 'l' || next == 'f' || next == '%';
    }
    return ibl_memory_close(to, &file);
}

/* Reads a face of a level; the first face allocates the cube. */
static bool read_face(const reader *r, const char *path, int face,
                      ibl_cube *cube, size_t *mended)
{
    const ibl_read_options read = {
        .struct_size = sizeof read, .part = -1, .any_aspect = 1};
    ibl_image image = {0};
    ibl_read_report report = {0};
    bool ok = !ibl_image_read(r->ctx, path, &read, &image, &report);
    const int n = image.width;

    if (ok && (n != image.height || n > IBL_MAX_CUBE_SIZE))
        ok = ibl_console_fail(r->console,
                              "%s: %dx%d pixels: a face is square, %d at most",
                              path, n, image.height, IBL_MAX_CUBE_SIZE);
    if (ok && !cube->data)
        ok = !ibl_cube_alloc(r->ctx, n, 1, cube);
    if (ok && n != cube->size)
        ok = ibl_console_fail(r->console,
                              "%s: %d pixels wide, but the faces before it %d",
                              path, n, cube->size);
    if (ok)
        memcpy(ibl_cube_face(cube, 0, face), image.data,
               3 * (size_t)n * (size_t)n * sizeof(float));
    *mended += report.nonfinite;
    ibl_image_free(&image);
    return ok;
}

static bool read_faces(const reader *r, int level)
{
    ibl_cube cube = {0};
    bool ok = true;
    size_t mended = 0;

    for (int face = 0; face < IBL_FACES && ok; face++) {
        char *path = expand(r->path, level, r->opts->face_names[face]);
        ok = path && read_face(r, path, face, &cube, &mended);
        free(path);
    }
    ok = ok && add_level(r, &cube, 0, IBL_PIXEL_COUNT, mended);
    keep(r, &cube);
    return ok;
}

static bool is_there(const reader *r, int level)
{
    char *path = expand(r->path, level, r->opts->face_names[0]);
    const bool there = path && !access(path, F_OK);

    free(path);
    return there;
}

static bool read_pattern(const reader *r)
{
    const bool chain =
        r->kind != IBL_OUTPUT_IRRADIANCE && strstr(r->path, "%l");
    bool ok = read_faces(r, 0);

    for (int l = 1; chain && l < IBL_MAX_LEVELS && ok && is_there(r, l); l++)
        ok = read_faces(r, l);
    return ok;
}

static bool read_cube(reader *r)
{
    ibl_texture tex = {0}; /* stays empty for a pattern */

    read_about(r, &tex);
    const bool ok =
        (strstr(r->path, "%f") ? read_pattern(r) : read_container(r, &tex)) &&
        (r->kind != IBL_OUTPUT_SPECULAR || describe_specular(r, &tex)) &&
        note_lights(r, &tex);

    ibl_texture_free(&tex);
    return ok;
}

static bool read_lut(reader *r)
{
    ibl_verify_files *f = r->files;
    ibl_texture tex = {0};
    const bool ok =
        read_texture(r, &tex) && !ibl_texture_to_lut(r->ctx, &tex, &f->lut);
    const int found = r->about.value[IBL_ABOUT_GEOMETRY];

    if (!r->opts->geometry && found > 0)
        f->geometry = (ibl_geometry)found;
    f->lut_pixel = tex.pixel;
    ibl_texture_free(&tex);
    return ok;
}

/* Whether a lobe table is for the levels of the specular cube, as far as it
 * says. Several bakes in one directory share its name. */
static bool is_of_chain(reader *r, const ibl_texture *tex)
{
    const ibl_verify_files *f = r->files;
    double roughness[IBL_MAX_LEVELS];
    int levels = 0;

    for (int i = 0; i < f->count; i++)
        if (f->level[i].content == IBL_OUTPUT_SPECULAR)
            roughness[levels++] = f->level[i].roughness;
    read_about(r, tex);
    return !levels || ibl_about_fits(&r->about, roughness, levels);
}

static bool check_lobes(const reader *r, const ibl_texture *tex)
{
    if (tex->faces == 1 && tex->width == tex->height &&
        (tex->layers == IBL_LOBE_LAYERS ||
         tex->layers == IBL_LOBE_LAYERS / 2) &&
        tex->pixel <= IBL_PIXEL_RGBA32F)
        return true;
    return ibl_console_fail(r->console,
                            "%s: no lobe table: it must be flat, square, of "
                            "%d or %d layers and of rgba16f or rgba32f",
                            r->path, IBL_LOBE_LAYERS, IBL_LOBE_LAYERS / 2);
}

/* RGBA decodes without alpha: each texel is two of two channels. */
static bool decode_lobes(ibl_verify_files *f, const ibl_texture *tex)
{
    const size_t texels =
        (size_t)tex->layers * (size_t)tex->width * (size_t)tex->width;

    f->lobes = (ibl_lobe_table){
        tex->width, malloc(texels * 4 * sizeof *f->lobes.data), tex->layers};
    if (f->lobes.data)
        ibl_pixel_decode(tex->pixel == IBL_PIXEL_RGBA16F ? IBL_PIXEL_RG16F
                                                         : IBL_PIXEL_RG32F,
                         tex->data, 2 * texels, f->lobes.data);
    return f->lobes.data;
}

/* A table of other levels is left out, unless it was asked for. */
static bool read_lobes(reader *r)
{
    static const char why[] = "for levels of other roughness than the specular "
                              "cube's";
    ibl_texture tex = {0};
    bool ok =
        !ibl_engine_read(r->ctx, r->path, -1, &tex) && check_lobes(r, &tex);

    if (ok && is_of_chain(r, &tex))
        ok = decode_lobes(r->files, &tex);
    else if (ok && r->opts->files[IBL_OUTPUT_LOBES])
        ok = ibl_console_fail(r->console, "%s: %s", r->path, why);
    else if (ok)
        ibl_console_warn(r->console, "%s: left out: %s", r->path, why);
    ibl_texture_free(&tex);
    return ok;
}

static bool read_file(reader *r)
{
    switch (r->kind) {
    case IBL_OUTPUT_LUT:
        return read_lut(r);
    case IBL_OUTPUT_LOBES:
        return read_lobes(r);
    default:
        return read_cube(r);
    }
}

bool ibl_verify_files_read(const ibl_verify_opts *opts, ibl_ctx *ctx,
                           ibl_console *console, ibl_verify_files *files)
{
    reader r = {.opts = opts, .ctx = ctx, .console = console, .files = files};

    *files = (ibl_verify_files){
        .yaw_deg = NAN,
        .lights = -1,
        .read = opts->common.read,
        .geometry = (ibl_geometry)(opts->geometry ? opts->geometry - 1 : 0)};
    bool ok = (!opts->directory || open_sidecar(&r)) && find_files(&r);
    ibl_sidecar_colour(r.sidecar, &files->read);
    for (int kind = 0; kind < IBL_VERIFY_KINDS && ok; kind++) {
        r.kind = (ibl_output_kind)kind;
        r.path = files->path[kind];
        r.first = files->count;
        if (r.path)
            ok = read_file(&r);
    }
    settle_yaw(&r);
    settle_colour(&r);
    json_decref(r.sidecar);
    free(r.sidecar_path);
    return ok;
}

void ibl_verify_files_free(ibl_verify_files *files)
{
    for (int i = 0; i < files->owned_count; i++)
        ibl_cube_free(&files->owned[i]);
    for (int kind = 0; kind < IBL_VERIFY_KINDS; kind++)
        free(files->path[kind]);
    ibl_lut_free(&files->lut);
    free(files->lobes.data);
}

bool ibl_verify_judge(const ibl_verify_files *files, ibl_ctx *ctx,
                      const ibl_judged_map *map, ibl_console *console,
                      ibl_report *report)
{
    bool ok = true;

    for (int i = 0; i < files->count && ok; i++) {
        const ibl_judge_level *level = &files->level[i];
        char stage[32];
        snprintf(stage, sizeof stage, "%s %d", ibl_output_name(level->content),
                 level->number);
        ibl_console_progress(console, stage, 0);
        ok = ibl_report_add(report, ibl_judged_map_judge(map, level->content),
                            level);
    }
    if (!ok || !files->lut.data)
        return ok;
    ibl_console_progress(console, ibl_output_name(IBL_OUTPUT_LUT), 0);
    report->has_lut =
        ibl_judge_lut(ctx, &files->lut, files->lut_pixel, files->geometry,
                      &report->options, &report->lut);
    return report->has_lut;
}
