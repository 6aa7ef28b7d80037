/* SPDX-License-Identifier: MIT */
/* Writes the outputs of a set: turned into its axes, encoded, judged if
 * --verify asks for it, and handed to the job's files. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/job.h"
#include "common/names.h"
#include "common/path.h"
#include "json/text.h"

/* ---- axes ------------------------------------------------------------- */

static bool has_axes(const ibl_output_set *b)
{
    return b->opts->axes.mirror || b->opts->axes.up;
}

static bool turn_back(const ibl_output_set *b, ibl_cube *cube)
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

/* ---- --verify --------------------------------------------------------- */

static bool judge_lut(ibl_output_set *b, const ibl_texture *tex)
{
    ibl_lut lut = {0};
    const bool ok =
        !ibl_texture_to_lut(b->ctx, tex, &lut) &&
        ibl_report_lut(&b->judged, b->ctx, &lut, b->opts->lut.geometry);

    ibl_lut_free(&lut);
    return ok;
}

static bool judge_cube(ibl_output_set *b, ibl_output_kind kind,
                       const ibl_texture *tex)
{
    const ibl_opts *o = b->opts;
    ibl_cube cube = {0};

    const bool rest = o->lights && kind != IBL_OUTPUT_SKYBOX;
    ibl_judge **judge = &b->from->judge[rest];

    if (!*judge)
        *judge = ibl_judge_create(b->ctx, rest ? &b->from->rest : &b->from->env,
                                  o->bake.yaw_deg);
    bool ok = *judge && !ibl_texture_to_cube(b->ctx, tex, &cube) &&
              turn_back(b, &cube);
    const ibl_judged judged = {.content = kind,
                               .chain = cube,
                               .levels = tex->levels,
                               .lobe = o->bake.specular_options.lobe,
                               .roughness =
                                   kind == IBL_OUTPUT_SPECULAR
                                       ? b->made.report.layout.roughness
                                       : NULL};
    ok = ok && ibl_report_levels(&b->judged, *judge, &judged);
    ibl_cube_free(&cube);
    return ok;
}

static bool judge(ibl_output_set *b, ibl_output_kind kind,
                  const ibl_texture *tex)
{
    bool ok = true;

    ibl_console_progress(b->console, "verify", 0);
    b->judged.options = b->opts->judge;
    if (kind == IBL_OUTPUT_LUT)
        ok = judge_lut(b, tex);
    else if (kind != IBL_OUTPUT_LOBES) /* no texel of it has a truth */
        ok = judge_cube(b, kind, tex);
    ibl_console_progress(b->console, "write", 0);
    return ok;
}

static bool judged(const ibl_output_set *b)
{
    char why[160];

    ibl_console_finish(b->console);
    if (!b->opts->common.quiet)
        ibl_report_print(&b->judged, b->from->print);
    return ibl_report_passes(&b->judged, b->opts->max_error, NAN, why,
                             sizeof why) ||
           ibl_console_fail(b->console, "%s: nothing was written", why);
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
              (!b->opts->verify || judge(b, kind, tex));
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
         (!o->verify || judge(b, IBL_OUTPUT_SPECULAR, tex));
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

bool ibl_set_write_text(ibl_output_set *b, const char *path, char *text,
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
    if (ibl_set_takes(b, kind))
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

    return ibl_set_write_text(b, b->sh_path, ibl_sh_text(format, sh),
                              "the harmonics");
}

/* The sidecar is last: where it is new, so are the others. */
bool ibl_set_write(ibl_output_set *b)
{
    const ibl_opts *o = b->opts;
    bool ok = turn_harmonics(b);

    for (int kind = 0; kind < IBL_OUTPUT_JSON && ok; kind++)
        ok = !b->files[kind].path || write_output(b, (ibl_output_kind)kind);
    for (int kind = 0; kind < IBL_OUTPUT_JSON && ok; kind++) {
        ibl_output *file = &b->files[kind];
        if (file->path && !ibl_set_takes(b, (ibl_output_kind)kind))
            snprintf(file->hash, sizeof file->hash, "%s",
                     ibl_outputs_hash(b->outputs, file->path));
    }
    return ok && (!b->sh_path || write_harmonics(b)) &&
           (!o->preview || write_preview(b)) &&
           (!b->files[IBL_OUTPUT_JSON].path || write_sidecar(b)) &&
           (!o->verify || !b->from->print || judged(b));
}
