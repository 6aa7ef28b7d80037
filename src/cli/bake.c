/* SPDX-License-Identifier: MIT */
/* Runs a bake. Writes all files of all sets or none. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/batch.h"
#include "cli/choose.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "json/text.h"

/* ---- axes ------------------------------------------------------------- */

static bool has_axes(const ibl_output_set *b)
{
    return b->opts->axes.mirror || b->opts->axes.up;
}

bool ibl_bake_turn_back(const ibl_output_set *b, ibl_cube *cube)
{
    ibl_cube turned = {0};

    if (!has_axes(b))
        return true;
    const bool ok =
        !ibl_cube_turn_axes(b->ctx, cube, b->opts->axes, 1, &turned);
    ibl_cube_free(cube);
    *cube = turned;
    return ok;
}

/* Gives the set harmonics of its own in the axes of its outputs. Those that
 * others want are not its. */
static bool turn_harmonics(ibl_output_set *b)
{
    const int degree = b->opts->bake.sh_degree;
    const size_t edge = (size_t)degree + 1, bytes = 3 * edge * edge * 8;

    if (degree < 0)
        b->made.sh = NULL;
    if (!has_axes(b) || !b->made.sh)
        return true;
    b->sh = malloc(bytes);
    if (!b->sh)
        return ibl_console_fail(b->console, "no memory for the harmonics");
    memcpy(b->sh, b->made.sh, bytes);
    b->made.sh = b->sh;
    return !ibl_sh_turn_axes(b->ctx, degree, b->opts->axes, 0, b->sh);
}

/* ---- write ------------------------------------------------------------ */

/* Warns of light beyond what the format holds. */
static void warn_of_format(const ibl_output_set *b, const ibl_output *file)
{
    const ibl_texel_options *texels = &b->opts->texels;
    const char *packed =
        b->opts->engine ? ibl_engine_pixel(b->opts->engine) : NULL;
    ibl_overflow_level sum = {0};
    double dark = 0;

    for (int l = 0; l < file->shape.levels; l++) {
        ibl_overflow_add(&file->overflow.level[l], &sum);
        dark = fmax(dark, file->error[l].lost);
    }
    ibl_warn_of_underflow(b->console, file->path,
                          packed ? packed : ibl_pixel_name(texels->pixel),
                          dark);
    /* What was asked for is no reason to warn. */
    if (packed || sum.lost > 0 || !(texels->largest > 0) ||
        texels->largest > (double)ibl_pixel_max(texels->pixel))
        ibl_warn_of_overflow(b->console, file->path, texels, packed,
                             packed || b->opts->of, &sum);
}

/* Keeps the texture's shape for the record. */
static void take_shape(ibl_output *file, const ibl_texture *tex)
{
    file->shape = *tex;
    file->shape.data = NULL;
    file->shape.keys = NULL;
    file->shape.key_count = 0;
}

/* Writes a texture as pictures. */
static bool write_pictures(ibl_output_set *b, ibl_output *file,
                           const ibl_texture *tex)
{
    const ibl_opts *o = b->opts;
    const bool table = file - b->files >= IBL_OUTPUT_LUT;
    const ibl_picture_options options = {
        .kind = o->picture,
        .tone = table ? IBL_TONE_RAW : o->tone,
        .cross = !table && o->layout == IBL_LAYOUT_CROSS,
        .halves = ibl_pixel_max(tex->pixel) < 1e5F,
        .equirect = !table && o->layout == IBL_PROJECTION_EQUIRECT,
        .about = tex};
    bool ok = true;

    for (int i = 0; i < file->count && ok; i++) {
        const char *path = i ? file->more[i - 1] : file->path;
        ibl_blob blob = {0};
        ok = !ibl_picture_of_texture(b->ctx, path, tex, &options, i, &blob) &&
             !ibl_outputs_add(b->outputs, path, blob.bytes, blob.size);
        file->bytes += blob.size;
        ibl_blob_free(&blob);
    }
    return ok;
}

/* Writes and frees a texture. */
static bool write_texture(ibl_output_set *b, ibl_output_kind kind,
                          ibl_texture *tex)
{
    ibl_output *file = &b->files[kind];

    take_shape(file, tex);
    bool ok = ibl_texture_metadata(b, kind, tex) &&
              (!b->opts->verify || ibl_bake_judge(b, kind, tex));
    tex->filament = b->opts->filament;
    tex->zstd = b->opts->zstd; /* loses nothing, so --verify can do without */
    ok = ok && (b->opts->picture
                    ? write_pictures(b, file, tex)
                    : !ibl_outputs_take_texture(b->outputs, file->path, tex,
                                                b->opts->format, &file->bytes));
    ibl_texture_free(tex);
    if (ok)
        warn_of_format(b, file);
    return ok;
}

/* Adds the files of an engine to the outputs, and frees them. */
static bool add_engine_files(ibl_output_set *b, ibl_blob *main, ibl_blob *faces,
                             bool ok)
{
    ibl_output *file = &b->files[IBL_OUTPUT_SPECULAR];

    ok =
        ok && !ibl_outputs_add(b->outputs, file->path, main->bytes, main->size);
    file->bytes = main->size;
    ibl_blob_free(main);
    for (int i = 0; i < b->face_count; i++) {
        ok = ok && !ibl_outputs_add(b->outputs, file->more[i], faces[i].bytes,
                                    faces[i].size);
        file->bytes += faces[i].size;
        ibl_blob_free(&faces[i]);
    }
    return ok;
}

/* Encodes and writes an engine's own file of the levels, which are in tex, too;
 * tex then has what the file says of them. */
static bool write_engine(ibl_output_set *b, const ibl_cube *cube,
                         ibl_texture *tex)
{
    const ibl_opts *o = b->opts;
    ibl_output *file = &b->files[IBL_OUTPUT_SPECULAR];
    ibl_blob main = {0}, faces[IBL_MAX_FACES] = {0};
    ibl_cube turned = {0};
    ibl_engine_set set = {tex, &b->made.irradiance, b->made.sh, o->name};

    take_shape(file, tex);
    bool ok =
        !has_axes(b) || !b->made.irradiance.data ||
        !ibl_cube_turn_axes(b->ctx, &b->made.irradiance, o->axes, 0, &turned);
    if (turned.data)
        set.irradiance = &turned;
    ok = ok && ibl_texture_metadata(b, IBL_OUTPUT_SPECULAR, tex) &&
         !ibl_engine_encode(b->ctx, o->engine, &set, &main, faces) &&
         !ibl_texture_errors(b->ctx, tex, cube, file->error) &&
         (!o->verify || ibl_bake_judge(b, IBL_OUTPUT_SPECULAR, tex));
    ok = add_engine_files(b, &main, faces, ok);
    ibl_cube_free(&turned);
    if (ok)
        warn_of_format(b, file);
    return ok;
}

static bool write_cube(ibl_output_set *b, ibl_output_kind kind,
                       const ibl_cube *cube)
{
    ibl_output *file = &b->files[kind];
    ibl_texture tex = {0};
    ibl_cube turned = {0}, largest = *cube;

    ibl_console_progress(b->console, "write", 0);
    largest.levels = 1;
    if (b->opts->picture && kind == IBL_OUTPUT_SKYBOX)
        cube = &largest;
    if (has_axes(b) &&
        ibl_cube_turn_axes(b->ctx, cube, b->opts->axes, 0, &turned))
        return false;
    if (has_axes(b))
        cube = &turned;
    bool ok = !ibl_texture_from_cube(b->ctx, cube, &b->opts->texels, &tex,
                                     &file->overflow);
    if (ok)
        ibl_picture_round(b->opts->picture, &tex);
    if (b->opts->engine)
        ok = ok && write_engine(b, cube, &tex);
    else
        ok = ok && !ibl_texture_errors(b->ctx, &tex, cube, file->error) &&
             write_texture(b, kind, &tex);
    ibl_texture_free(&tex);
    ibl_cube_free(&turned);
    return ok;
}

/* Warns of harmonics that have less than half the least irradiance of a channel
 * somewhere. */
static void warn_of_harmonics(const ibl_output_set *b)
{
    const ibl_cube *cube = &b->made.irradiance;
    const float *texel = ibl_cube_face(cube, 0, 0);
    double exact[3] = {INFINITY, INFINITY, INFINITY}, least[3];
    int worst = 0;

    ibl_sh_least(b->from->made.sh, least);
    for (size_t i = 0; i < 3 * ibl_cube_texels(cube->size, 1); i++)
        exact[i % 3] = fmin(exact[i % 3], (double)texel[i]);
    for (int c = 1; c < 3; c++)
        if (least[c] * exact[worst] < least[worst] * exact[c])
            worst = c;
    if (least[worst] < exact[worst] / 2)
        ibl_console_warn(
            b->console,
            "%s: the engine lights matte surfaces by nine harmonics, which "
            "have %.3g of %s where the map has %.3g or more: a dark or "
            "coloured spot away from the sun: take it out with --sun, or "
            "dampen "
            "them with --sh-window auto",
            ibl_path_name(b->sh_path ? b->sh_path
                                     : b->files[IBL_OUTPUT_SPECULAR].path),
            least[worst], (const char *[]){"red", "green", "blue"}[worst],
            exact[worst]);
}

/* A target's own file has no place for the skybox that was asked for. */
static void warn_of_skybox(const ibl_output_set *b)
{
    const char *file = ibl_path_name(b->files[IBL_OUTPUT_SPECULAR].path);

    if ((b->opts->engine || (b->opts->of && b->opts->picture)) &&
        ibl_is_given(&b->opts->given, "skybox"))
        ibl_console_warn(b->console,
                         "--skybox: not in %s, whose level 0 is the "
                         "background: for a file of its own take --only "
                         "skybox without --target",
                         file);
}

static bool write_specular(ibl_output_set *b)
{
    /* Engines know their last level. */
    if (!b->opts->of && !b->opts->engine)
        ibl_warn_of_small_faces(b->console, &b->made.report.layout);
    warn_of_skybox(b);
    if (b->opts->of && b->opts->of->harmonics)
        warn_of_harmonics(b);
    return write_cube(b, IBL_OUTPUT_SPECULAR, &b->made.specular);
}

/* Whether an output is a table that was made once for all environments. */
static bool is_taken(const ibl_output_set *b, ibl_output_kind kind)
{
    return b->tables && ibl_set_is_shared(b->opts, kind);
}

static bool take_table(ibl_output_set *b, ibl_output_kind kind)
{
    const ibl_output_set *from = b->tables;
    ibl_output *file = &b->files[kind];
    char *path = file->path;

    *file = from->files[kind];
    file->path = path;
    if (kind == IBL_OUTPUT_LUT) {
        b->lut = from->lut;
        if (from->judged.json && !b->judged.json)
            b->judged.json = json_deep_copy(from->judged.json);
        else if (from->judged.json)
            json_object_set_new(
                b->judged.json, "lut",
                json_deep_copy(json_object_get(from->judged.json, "lut")));
    } else {
        b->lobes = from->lobes;
        b->lobe_layout = from->lobe_layout;
    }
    return true;
}

static bool write_lut(ibl_output_set *b)
{
    ibl_texture tex = {0};

    ibl_console_progress(b->console, "lut", 0);
    return !ibl_bake_lut(b->ctx, &b->opts->lut, &b->lut) &&
           !ibl_texture_from_lut(
               b->ctx, &b->lut,
               ibl_lut_pixel(b->opts->texels.pixel, b->lut.kind), &tex,
               &b->files[IBL_OUTPUT_LUT].overflow.values) &&
           write_texture(b, IBL_OUTPUT_LUT, &tex);
}

static bool write_lobes(ibl_output_set *b)
{
    ibl_texture tex = {0};

    b->lobe_layout = b->made.report.layout;
    if (!b->opts->bake.specular &&
        ibl_specular_layout_of(&b->opts->bake.specular_options,
                               &b->lobe_layout))
        return false;
    const ibl_lobe_table_options o = ibl_bake_lobe_options(b);
    ibl_console_progress(b->console, "lobe table", 0);
    const bool ok = !ibl_bake_lobe_table(b->ctx, &o, &b->lobes) &&
                    !ibl_texture_from_lobe_table(b->ctx, &b->lobes, &tex);
    return ok && write_texture(b, IBL_OUTPUT_LOBES, &tex);
}

/* Writes and frees bytes. If bytes is NULL, reports that memory ran out. */
static bool write_bytes(ibl_output_set *b, const char *path, void *bytes,
                        size_t size, const char *what)
{
    ibl_console_progress(b->console, "write", 0);
    if (!bytes)
        return ibl_console_fail(b->console, "no memory for %s: ask for less",
                                what);
    const bool ok = !ibl_outputs_add(b->outputs, path, bytes, size);
    free(bytes);
    return ok;
}

static bool write_text(ibl_output_set *b, const char *path, char *text,
                       const char *what)
{
    return write_bytes(b, path, text, text ? strlen(text) : 0, what);
}

static bool write_preview(ibl_output_set *b)
{
    void *png = NULL;
    size_t size = 0;

    ibl_console_progress(b->console, "preview", 0);
    if (!ibl_preview_png(b, &png, &size))
        png = NULL;
    return write_bytes(b, b->opts->preview, png, size, "the preview");
}

static bool write_sidecar(ibl_output_set *b)
{
    ibl_console_progress(b->console, "write", 0);
    char *text = ibl_set_sidecar(b);
    const bool ok =
        text && !ibl_outputs_add(b->outputs, b->files[IBL_OUTPUT_JSON].path,
                                 text, strlen(text));
    ibl_bytes_free(text);
    return ok;
}

static bool write_output(ibl_output_set *b, ibl_output_kind kind)
{
    if (is_taken(b, kind))
        return take_table(b, kind);
    switch (kind) {
    case IBL_OUTPUT_SKYBOX:
        return write_cube(b, kind, &b->made.skybox);
    case IBL_OUTPUT_SPECULAR:
        return write_specular(b);
    case IBL_OUTPUT_IRRADIANCE:
        return write_cube(b, kind, &b->made.irradiance);
    case IBL_OUTPUT_LUT:
        return write_lut(b);
    case IBL_OUTPUT_LOBES:
        return write_lobes(b);
    case IBL_OUTPUT_JSON:
    case IBL_OUTPUT_COUNT:
        break;
    }
    return false;
}

/* three.js negates x when it looks up cubes, not in harmonics. */
static bool write_harmonics(ibl_output_set *b)
{
    const ibl_sh_format format = b->opts->sh_format;
    const double *sh = format == IBL_SH_THREE ? b->from->made.sh : b->made.sh;

    return write_text(b, b->sh_path, ibl_sh_text(format, sh), "the harmonics");
}

/* The sidecar is last: where it is new, so are the others. */
static bool write_all(ibl_output_set *b)
{
    const ibl_opts *o = b->opts;
    bool ok = true;

    for (int kind = 0; kind < IBL_OUTPUT_JSON && ok; kind++)
        ok = !b->files[kind].path || write_output(b, (ibl_output_kind)kind);
    for (int kind = 0; kind < IBL_OUTPUT_JSON && ok; kind++) {
        ibl_output *file = &b->files[kind];
        if (file->path && !is_taken(b, (ibl_output_kind)kind))
            snprintf(file->hash, sizeof file->hash, "%s",
                     ibl_outputs_hash(b->outputs, file->path));
    }
    return ok && (!b->sh_path || write_harmonics(b)) &&
           (!o->preview || write_preview(b)) &&
           (!b->files[IBL_OUTPUT_JSON].path || write_sidecar(b)) &&
           (!o->verify || !b->from->print || ibl_bake_judged(b));
}

/* ---- the command ------------------------------------------------------ */

static void log_light(const ibl_bake_source *s, const ibl_light *light)
{
    const double *to = light->direction, *e = light->irradiance;

    ibl_console_info(s->console,
                     "took a light: towards %.4f %.4f %.4f, radius %.3g "
                     "degrees, irradiance %.4g %.4g %.4g",
                     to[0], to[1], to[2], light->radius * 180 / M_PI, e[0],
                     e[1], e[2]);
}

/* ", off by 2.6 1.3 0.9 %": the nRMSE of each level of a cube by its pixel
 * format; "": none is off. */
static void list_errors(const ibl_output *file, char *list, size_t size)
{
    double most = 0;
    int used = snprintf(list, size, ", off by the format");

    for (int l = 0; l < file->shape.levels; l++) {
        most = fmax(most, file->error[l].nrmse);
        used += snprintf(list + used, size - (size_t)used, " %.2g",
                         100 * file->error[l].nrmse);
    }
    snprintf(list + used, size - (size_t)used, " %%");
    if (most <= 0)
        *list = '\0';
}

/* Logs what was read, for -v. */
static void log_source(const ibl_bake_source *s)
{
    if (s->opts->input)
        ibl_console_info(s->console, "read %s: %s, %d x %d, peak %.6g",
                         s->opts->input, s->report.format, s->width, s->height,
                         (double)s->report.peak);
    for (int i = 0; i < s->light_count; i++)
        log_light(s, &s->lights[i]);
}

/* Logs the files of a set. */
static void log_set(const ibl_output_set *b)
{
    for (int kind = 0; kind < IBL_OUTPUT_JSON; kind++) {
        const ibl_output *file = &b->files[kind];
        char errors[64 + 16 * IBL_MAX_LEVELS];
        list_errors(file, errors, sizeof errors);
        if (file->path)
            ibl_console_info(
                b->console, "wrote %s: %s, %s, %d x %d, levels: %d%s",
                file->path, file->shape.faces == 6 ? "cube" : "2D",
                ibl_baked_pixel(b->opts, file->shape.pixel), file->shape.width,
                file->shape.height, file->shape.levels, errors);
    }
    if (b->files[IBL_OUTPUT_JSON].path)
        ibl_console_info(b->console, "wrote %s",
                         b->files[IBL_OUTPUT_JSON].path);
    if (b->sh_path)
        ibl_console_info(b->console, "wrote %s", b->sh_path);
}

/* Prints the program that loads a set's files. */
static void explain(const ibl_output_set *b, bool several)
{
    const ibl_target *target = b->opts->of;
    const ibl_output *specular = &b->files[IBL_OUTPUT_SPECULAR];
    const ibl_output *irradiance = &b->files[IBL_OUTPUT_IRRADIANCE];
    const char *skybox = b->files[IBL_OUTPUT_SKYBOX].path;
    const ibl_target_files files = {
        .specular = specular->path ? ibl_path_name(specular->path) : "",
        .irradiance = irradiance->path ? ibl_path_name(irradiance->path) : "",
        .sh = b->sh_path ? ibl_path_name(b->sh_path) : "",
        .skybox = skybox ? ibl_path_name(skybox) : NULL,
        .lights = b->opts->input ? b->from->lights : NULL,
        .light_count = b->opts->input ? b->from->light_count : b->opts->lights};

    if (several)
        printf("%s: %s\n\n", target->name, target->engine);
    ibl_target_explain(target, &files, stdout);
    if (several)
        putchar('\n');
}

/* Sets a set's directories: --output or, of several, one in it; of maps that
 * were found in folders, the same below it. */
static bool set_directories(ibl_output_set *b, bool several)
{
    const ibl_opts *o = b->opts;
    const char *all = o->directory ? o->directory : ".";
    const char *below = o->below ? o->below : "";
    const int folders = (int)(ibl_path_name(below) - below);

    b->root = several ? ibl_path_join(all, o->of->name) : strdup(all);
    if (b->root)
        b->directory = folders
                           ? ibl_format("%s/%.*s", b->root, folders - 1, below)
                           : strdup(b->root);
    return b->directory;
}

/* Adds up what the sets need. */
static void add_sets(ibl_job *r)
{
    r->from.bake = r->opts->bake;
    r->from.chain_count = 0;
    for (int i = 0; i < r->count && r->sets; i++)
        ibl_bake_source_add(&r->from, &r->sets[i]);
}

bool ibl_job_begin(ibl_job *r)
{
    const ibl_opts *all = r->line->set;

    r->count = r->line->count;
    r->opts = r->from.opts = all;
    r->from.console = &r->console;
    r->from.run = r;
    r->sets = calloc((size_t)r->count + 1, sizeof *r->sets);
    for (int i = 0; i < r->count && r->sets; i++) {
        ibl_output_set *b = &r->sets[i];
        *b = (ibl_output_set){.opts = &all[i],
                              .console = &r->console,
                              .ctx = r->from.ctx,
                              .from = &r->from,
                              .tables = r->tables ? &r->tables[i] : NULL};
        if (!set_directories(b, r->count > 1))
            return false;
    }
    add_sets(r);
    return r->sets != NULL;
}

/* A set's part of what was baked. */
static void take_part(ibl_output_set *b)
{
    const ibl_bake_result *all = &b->from->made;

    b->made = *all;
    if (b->chain > 0) {
        b->made.specular = all->more[b->chain - 1];
        b->made.report = all->more_report[b->chain - 1];
    } else if (b->chain < 0) {
        b->made.specular = (ibl_cube){0};
    }
}

/* Adds the set of sheen behind the only one, b, if there is any. */
static bool add_sheen(ibl_job *r, const ibl_output_set *b)
{
    ibl_output_set *sheen = &r->sets[1];

    if (!ibl_scenes_sheen(r->from.scenes, b->opts, &r->sheen, b->choice))
        return true;
    *sheen = (ibl_output_set){
        .opts = &r->sheen, .console = &r->console, .from = &r->from};
    r->count = 2;
    return set_directories(sheen, false) ||
           ibl_console_fail(&r->console, "no memory for a set of sheen");
}

/* Chooses what --rendered-error leaves open in a set. */
static bool choose(ibl_job *r, ibl_output_set *b)
{
    ibl_materials materials = ibl_materials_all();
    ibl_opts *o = (ibl_opts *)b->opts;
    const ibl_scenes *scenes = r->from.scenes;
    bool ok = true;

    if (scenes)
        ibl_scenes_tell(scenes, b->choice);
    if (scenes && !ibl_scenes_materials(scenes, &materials))
        ibl_scenes_drop(scenes, o, b->choice);
    else
        ok = ibl_choose(&r->from, &materials, o, b->choice);
    if (ok && scenes)
        ok = add_sheen(r, b);
    if (scenes && !o->bake.skybox)
        ibl_choice_add(b->choice, true, "skybox", "none\tadd --skybox N %s",
                       scenes->survey.transmission > 0
                           ? "for what transmits light, which shows it"
                           : "to draw it behind");
    return ok;
}

static bool read_scenes(ibl_job *r)
{
    if (!r->opts->scenes.count)
        return true;
    ibl_console_progress(&r->console, "scene", 0);
    r->from.scenes = calloc(1, sizeof *r->from.scenes);
    return r->from.scenes &&
           ibl_scenes_read(r->from.ctx, &r->opts->scenes,
                           r->opts->common.read.strict, r->from.scenes);
}

/* Chooses what --rendered-error leaves open, and prints it. */
static bool decide(ibl_job *r)
{
    const int count = r->count;

    if (isnan(r->opts->rendered_error))
        return true;
    r->choices = calloc((size_t)count, sizeof *r->choices);
    bool ok = r->choices && read_scenes(r) && ibl_bake_source_read(&r->from);
    for (int i = 0; i < count && ok; i++) {
        r->sets[i].choice = &r->choices[i];
        ok = choose(r, &r->sets[i]);
        if (ok && count > 1)
            printf("%s%s\n", i ? "\n" : "", r->sets[i].opts->of->name);
        if (ok)
            ibl_choice_print(&r->choices[i], stdout);
    }
    add_sets(r);
    return ok;
}

static bool start(ibl_job *r)
{
    bool ok = !ibl_start_outputs(r->from.ctx, r->opts->sync, &r->outputs);

    for (int i = 0; i < r->count && ok; i++) {
        r->sets[i].ctx = r->from.ctx;
        r->sets[i].outputs = r->outputs;
        ok = !ibl_outputs_mkdir(r->outputs, r->sets[i].root) &&
             !ibl_outputs_mkdir(r->outputs, r->sets[i].directory);
    }
    return ok;
}

/* Writes all files, but does not yet give them their names. */
static bool write_sets(ibl_job *r)
{
    bool ok = true;

    for (int i = 0; i < r->count && ok; i++) {
        take_part(&r->sets[i]);
        ok = turn_harmonics(&r->sets[i]) && write_all(&r->sets[i]);
    }
    return ok &&
           (!r->opts->depfile || r->line->batch ||
            write_text(r->sets, r->opts->depfile,
                       ibl_depfile_text(r->sets, r->count), "the depfile"));
}

void ibl_job_log(const ibl_job *r)
{
    const char *const others[] = {r->opts->preview,
                                  r->line->batch ? NULL : r->opts->depfile};

    log_source(&r->from);
    for (int i = 0; i < r->count; i++)
        log_set(&r->sets[i]);
    for (int i = 0; i < 2; i++)
        if (others[i])
            ibl_console_info((ibl_console *)&r->console, "wrote %s", others[i]);
}

static void free_set(ibl_output_set *b)
{
    ibl_report_free(&b->judged);
    ibl_choice_free(b->choice);
    if (!is_taken(b, IBL_OUTPUT_LUT))
        ibl_lut_free(&b->lut);
    if (!is_taken(b, IBL_OUTPUT_LOBES))
        ibl_lobe_table_free(&b->lobes);
    for (int i = 0; i < IBL_OUTPUT_COUNT; i++)
        free(b->files[i].path);
    free(b->sh_path);
    for (int i = 0; i < b->face_count; i++)
        free(b->faces[i]);
    free(b->directory);
    free(b->root);
    free(b->sh);
}

void ibl_job_end(ibl_job *r)
{
    ibl_end_outputs(r->outputs);
    for (int i = 0; i < r->count && r->sets; i++)
        free_set(&r->sets[i]);
    free(r->sets);
    free(r->choices);
    ibl_scenes_free(r->from.scenes);
    ibl_bake_source_free(&r->from);
}

bool ibl_job_make(ibl_job *r)
{
    return decide(r) && (r->opts->dry_run ||
                         (start(r) && ibl_bake_plan(r->sets, r->count) &&
                          ibl_bake_source_make(&r->from) && write_sets(r)));
}

bool ibl_job_commit(ibl_job *r)
{
    return !r->outputs || ibl_console_commit(&r->console, r->outputs);
}

bool ibl_job_names(ibl_job *r)
{
    bool ok = true;

    for (int i = 0; i < r->count && ok; i++)
        ok = ibl_set_name_files(&r->sets[i]);
    return ok;
}

static int bake_one(const ibl_cmdline *line)
{
    ibl_job r = {.line = line, .from.print = stdout};

    ibl_console_init(&r.console, line->set->common.quiet,
                     line->set->common.verbose);
    ibl_signals_catch();
    const bool only_explains = line->set->explain && !line->set->input;
    bool ok = ibl_job_begin(&r) &&
              (only_explains
                   ? ibl_job_names(&r)
                   : !ibl_start(&line->set->common, &r.console, &r.from.ctx) &&
                         ibl_job_make(&r));
    ibl_console_finish(&r.console);
    for (int i = 0; i < r.count && ok && line->set->explain; i++)
        explain(&r.sets[i], r.count > 1);
    ok = ok && ibl_job_commit(&r);
    const int status = ibl_console_end(&r.console, ok);
    if (ok && line->set->common.verbose && !line->set->dry_run) {
        ibl_job_log(&r);
        ibl_console_print_times(&r.console);
    }
    ibl_job_end(&r);
    ibl_ctx_free(r.from.ctx);
    return status;
}

int ibl_bake_run(const void *settings)
{
    const ibl_cmdline *line = settings;

    if (line->set->targets & IBL_TARGET_LIST) {
        ibl_targets_print(stdout);
        return 0;
    }
    return line->batch ? ibl_batch_run(line) : bake_one(line);
}
