/* SPDX-License-Identifier: MIT */
/* Writes the outputs of a set: turned into its axes, encoded, described, judged
 * if --verify asks for it, and handed to the job's files. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/job.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "ibl/sidecar.h"
#include "json/json_text.h"

/* ---- axes ------------------------------------------------------------- */

static bool has_axes(const ibl_output_set *b)
{
    return b->opts->axes.mirror || b->opts->axes.up;
}

/* Gives the set harmonics of its own in the axes of its outputs. Those that
 * others want are not its. */
static bool turn_harmonics(ibl_output_set *b)
{
    const int degree = b->opts->bake.sh_degree;
    const size_t edge = (size_t)degree + 1;
    const size_t bytes = 3 * edge * edge * sizeof *b->sh;

    if (degree < 0)
        b->made.sh = NULL;
    if (!has_axes(b) || !b->made.sh)
        return true;
    b->sh = memcpy(ibl_need(malloc(bytes)), b->made.sh, bytes);
    b->made.sh = b->sh;
    return !ibl_sh_turn_axes(b->job->ctx, degree, b->opts->axes, 0, b->sh);
}

/* ---- what is said of the outputs ---------------------------------------- */

/* What keys and the sidecar say of the bake. */
static ibl_sidecar_options facts_of(const ibl_output_set *b)
{
    const ibl_opts *o = b->opts;

    return (ibl_sidecar_options){.source = o->input,
                                 .width = b->job->width,
                                 .height = b->job->height,
                                 .read = &o->common.read,
                                 .report = &b->job->report,
                                 .specular = &o->bake.specular_options,
                                 .irradiance = &o->bake.irradiance_options,
                                 .lut = &o->lut,
                                 .lobe_table = &b->lobe_table,
                                 .yaw_deg = o->bake.yaw_deg,
                                 .axes = o->axes,
                                 .sh_degree = o->bake.sh_degree,
                                 .made = &b->made,
                                 .lights = b->job->lights,
                                 .light_count =
                                     o->lights ? b->job->light_count : -1,
                                 .revision = IBL_REVISION,
                                 .target = o->of ? o->of->name : NULL};
}

/* Sets the keys of a texture: see FILES in the manual page. */
static bool set_keys(const ibl_output_set *b, ibl_output_kind kind,
                     ibl_texture *tex)
{
    const ibl_opts *o = b->opts;
    const ibl_sidecar_options facts = facts_of(b);
    const ibl_sidecar_output output = {.content = (ibl_content)kind,
                                       .texels = &o->texels};
    char writer[32];

    snprintf(writer, sizeof writer, "--zstd %d", o->zstd);
    bool ok = (!o->zstd || !ibl_texture_set(b->job->ctx, tex,
                                            "KTXwriterScParams", writer)) &&
              !ibl_texture_describe(b->job->ctx, tex, &facts, &output);
    /* Filament takes its harmonics from the KTX file of the levels. */
    if (ok && kind == IBL_OUTPUT_SPECULAR && o->format == IBL_CONTAINER_KTX &&
        o->bake.sh_degree >= 2) {
        char *text = ibl_need(ibl_sh_text(IBL_SH_NONE, b->made.sh));
        ok = !ibl_texture_set(b->job->ctx, tex, "sh", text);
        free(text);
    }
    return ok;
}

/* ---- the sidecar ------------------------------------------------------ */

/* What only the program knows; NULL: nothing. */
static char *more(const ibl_output_set *b)
{
    json_t *j = json_object();

    if (b->choice)
        json_object_set_new(j, "choice", ibl_choice_json(b->choice));
    if (b->job->scenes)
        json_object_set_new(j, "scene", ibl_scenes_json(b->job->scenes));
    if (b->opts->verify)
        json_object_set(j, "verify", b->judged.json);
    char *text = json_object_size(j) ? ibl_need(ibl_json_text(j)) : NULL;
    json_decref(j);
    return text;
}

const char *ibl_baked_pixel(const ibl_opts *o, ibl_pixel pixel)
{
    const char *own = o->engine    ? ibl_engine_pixel(o->engine)
                      : o->picture ? ibl_picture_pixel(o->picture)
                                   : NULL;

    return own ? own : ibl_pixel_name(pixel);
}

/* The name of an output's file from the sidecar's folder. */
static char *name_file(const ibl_output_set *b, ibl_output_kind kind)
{
    const char *below = b->opts->below ? b->opts->below : "";
    char *name = NULL;

    for (; *below && ibl_set_is_shared(b->opts, kind); below++)
        if (*below == '/')
            ibl_append(&name, "../");
    ibl_append(&name, "%s", ibl_path_name(b->files[kind].paths[0]));
    return name;
}

/* The text of NAME.json: see FILES in the manual page. It has neither threads
 * nor times, so equal bakes give equal bytes. The caller must free it with
 * ibl_bytes_free; NULL after a message. */
static char *sidecar(const ibl_output_set *b)
{
    const ibl_opts *o = b->opts;
    ibl_sidecar_options facts = facts_of(b);
    ibl_texture shapes[IBL_OUTPUT_JSON];
    char *names[IBL_OUTPUT_JSON], *text = NULL, *own = more(b);
    ibl_sidecar_output outputs[IBL_OUTPUT_JSON];
    ibl_key_value options[IBL_MOST_GIVEN];
    int n = 0;

    for (int kind = 0; kind < IBL_OUTPUT_JSON; kind++) {
        const ibl_output *file = &b->files[kind];
        if (!file->paths)
            continue;
        names[n] = name_file(b, (ibl_output_kind)kind);
        shapes[n] = file->shape;
        shapes[n].zstd = o->zstd;
        outputs[n] = (ibl_sidecar_output){
            .content = (ibl_content)kind,
            .file = names[n],
            .container = ibl_format_names[o->file],
            .texture = &shapes[n],
            .pixel = ibl_baked_pixel(o, file->shape.pixel),
            .bytes = file->bytes,
            .hash = file->hash,
            .projection = o->bake.skybox_projection,
            .texels = &o->texels,
            .overflow = &file->overflow,
            .error = o->picture == IBL_PICTURE_PNG ? NULL : file->error,
            .more = (const char *const *)file->paths + 1,
            .more_count = file->count - 1,
        };
        n++;
    }
    facts.outputs = outputs;
    facts.output_count = n;
    facts.options = options;
    for (int i = 0; i < o->given.count; i++) {
        const ibl_option *option = o->given.list[i].option;
        if (!option->aside)
            options[facts.option_count++] = (ibl_key_value){
                (char *)option->name, (char *)o->given.list[i].value};
    }
    facts.more = own;
    ibl_sidecar_text(b->job->ctx, &facts, &text);
    while (n--)
        free(names[n]);
    free(own);
    return text;
}

/* ---- --verify --------------------------------------------------------- */

static bool judge_cube(ibl_output_set *b, ibl_output_kind kind,
                       const ibl_texture *tex)
{
    const ibl_opts *o = b->opts;
    ibl_cube cube = {0}, turned = {0};
    const bool rest = o->lights && kind != IBL_OUTPUT_SKYBOX;
    ibl_judge **judge = &b->job->judge[rest];

    if (!*judge)
        *judge = ibl_judge_create(
            b->job->ctx, rest ? &b->job->rest : &b->job->env, o->bake.yaw_deg);
    bool ok = *judge && !ibl_texture_to_cube(b->job->ctx, tex, &cube) &&
              (!has_axes(b) ||
               !ibl_cube_turn_axes(b->job->ctx, &cube, o->axes, 1, &turned));
    const ibl_judged judged = {.content = kind,
                               .chain = has_axes(b) ? turned : cube,
                               .levels = tex->levels,
                               .lobe = o->bake.specular_options.lobe,
                               .roughness =
                                   kind == IBL_OUTPUT_SPECULAR
                                       ? b->made.report.layout.roughness
                                       : NULL};
    ok = ok && ibl_report_levels(&b->judged, *judge, &judged);
    ibl_cube_free(&turned);
    ibl_cube_free(&cube);
    return ok;
}

static bool judge(ibl_output_set *b, ibl_output_kind kind,
                  const ibl_texture *tex)
{
    ibl_lut lut = {0};
    bool ok = true;

    ibl_console_progress(&b->job->console, "verify", 0);
    b->judged.options = b->opts->judge;
    if (kind == IBL_OUTPUT_LUT)
        ok = !ibl_texture_to_lut(b->job->ctx, tex, &lut) &&
             ibl_report_lut(&b->judged, b->job->ctx, &lut,
                            b->opts->lut.geometry);
    else if (kind != IBL_OUTPUT_LOBES) /* no texel of it has a truth */
        ok = judge_cube(b, kind, tex);
    ibl_lut_free(&lut);
    ibl_console_progress(&b->job->console, "write", 0);
    return ok;
}

/* ---- write ------------------------------------------------------------ */

void ibl_output_warn(const ibl_output *file, ibl_console *console,
                     const ibl_texel_options *texels, const char *packed,
                     bool fixed)
{
    ibl_overflow_level sum = {0};
    double dark = 0;

    for (int l = 0; l < file->shape.levels; l++) {
        ibl_overflow_add(&file->overflow.level[l], &sum);
        dark = fmax(dark, file->error[l].lost);
    }
    ibl_warn_of_underflow(console, file->paths[0],
                          packed ? packed : ibl_pixel_name(texels->pixel),
                          dark);
    /* What was asked for is no reason to warn. */
    if (packed || sum.lost > 0 || !(texels->largest > 0) ||
        texels->largest > (double)ibl_pixel_max(texels->pixel))
        ibl_warn_of_overflow(console, file->paths[0], texels, packed, fixed,
                             &sum);
}

bool ibl_output_pictures(ibl_output *file, ibl_ctx *ctx, ibl_outputs *to,
                         const ibl_texture *tex, ibl_picture_options options)
{
    bool ok = true;

    options.halves = ibl_pixel_max(tex->pixel) < 1e5F;
    options.about = tex;
    for (int i = 0; i < file->count && ok; i++) {
        ibl_blob blob = {0};
        ok = !ibl_picture_of_texture(ctx, file->paths[i], tex, &options, i,
                                     &blob) &&
             !ibl_outputs_add(to, file->paths[i], blob.bytes, blob.size);
        file->bytes += blob.size;
        ibl_blob_free(&blob);
    }
    return ok;
}

/* Makes an engine's own files of the levels in tex, which then has what they
 * say of them. */
static bool encode(ibl_output_set *b, ibl_texture *tex, ibl_blob *files)
{
    const ibl_opts *o = b->opts;
    ibl_engine_set set = {tex, &b->made.irradiance, b->made.sh, o->name};
    ibl_cube turned = {0};
    bool ok = !has_axes(b) || !b->made.irradiance.data ||
              !ibl_cube_turn_axes(b->job->ctx, &b->made.irradiance, o->axes, 0,
                                  &turned);

    if (turned.data)
        set.irradiance = &turned;
    ok = ok &&
         !ibl_engine_encode(b->job->ctx, o->engine, &set, files, files + 1);
    ibl_cube_free(&turned);
    return ok;
}

/* Writes and frees a texture: of a map, which it is compared with, or of a
 * table. */
static bool write_texture(ibl_output_set *b, ibl_output_kind kind,
                          ibl_texture *tex, const ibl_cube *map)
{
    const ibl_opts *o = b->opts;
    const char *packed = o->engine ? ibl_engine_pixel(o->engine) : NULL;
    const ibl_picture_options picture = {
        .kind = o->picture,
        .tone = map ? o->tone : IBL_TONE_RAW,
        .cross = map && o->layout == IBL_LAYOUT_CROSS,
        .equirect = map && o->layout == IBL_PROJECTION_EQUIRECT};
    ibl_output *file = &b->files[kind];
    ibl_outputs *to = b->job->outputs;
    ibl_blob *blobs = NULL;

    file->shape = *tex;
    file->shape.data = NULL;
    file->shape.keys = NULL;
    file->shape.key_count = 0;
    bool ok = set_keys(b, kind, tex);
    if (o->engine) {
        blobs = ibl_need(calloc((size_t)file->count, sizeof *blobs));
        ok = ok && encode(b, tex, blobs);
    }
    ok = ok &&
         (!map || !ibl_texture_errors(b->job->ctx, tex, map, file->error)) &&
         (!o->verify || judge(b, kind, tex));
    tex->filament = o->of && o->of->filament;
    tex->zstd = o->zstd; /* loses nothing, so --verify can do without */
    for (int i = 0; i < file->count && blobs; i++) {
        ok = ok && !ibl_outputs_add(to, file->paths[i], blobs[i].bytes,
                                    blobs[i].size);
        file->bytes += blobs[i].size;
        ibl_blob_free(&blobs[i]);
    }
    if (ok && o->picture)
        ok = ibl_output_pictures(file, b->job->ctx, to, tex, picture);
    else if (ok && !blobs)
        ok = !ibl_outputs_take_texture(to, file->paths[0], tex, o->format,
                                       &file->bytes);
    free(blobs);
    ibl_texture_free(tex);
    if (ok)
        ibl_output_warn(file, &b->job->console, &o->texels, packed,
                        packed || o->of);
    return ok;
}

static bool write_cube(ibl_output_set *b, ibl_output_kind kind,
                       const ibl_cube *cube)
{
    ibl_texture tex = {0};
    ibl_cube turned = {0}, largest = *cube;

    ibl_console_progress(&b->job->console, "write", 0);
    largest.levels = 1;
    if (b->opts->picture && kind == IBL_OUTPUT_SKYBOX)
        cube = &largest;
    if (has_axes(b) &&
        ibl_cube_turn_axes(b->job->ctx, cube, b->opts->axes, 0, &turned))
        return false;
    if (has_axes(b))
        cube = &turned;
    bool ok = !ibl_texture_from_cube(b->job->ctx, cube, &b->opts->texels, &tex,
                                     &b->files[kind].overflow);
    if (ok && b->opts->picture)
        ibl_picture_round(b->opts->picture, &tex);
    ok = ok && write_texture(b, kind, &tex, cube);
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

    ibl_sh_least(b->job->made.sh, least);
    for (size_t i = 0; i < 3 * ibl_cube_texels(cube->size, 1); i++)
        exact[i % 3] = fmin(exact[i % 3], (double)texel[i]);
    for (int c = 1; c < 3; c++)
        if (least[c] * exact[worst] < least[worst] * exact[c])
            worst = c;
    if (least[worst] < exact[worst] / 2)
        ibl_console_warn(
            &b->job->console,
            "%s: the engine lights matte surfaces by nine harmonics, which "
            "have %.3g of %s where the map has %.3g or more: a dark or "
            "coloured spot away from the sun: take it out with --sun, or "
            "dampen "
            "them with --sh-window auto",
            ibl_path_name(b->sh_path ? b->sh_path
                                     : b->files[IBL_OUTPUT_SPECULAR].paths[0]),
            least[worst], (const char *[]){"red", "green", "blue"}[worst],
            exact[worst]);
}

static bool write_specular(ibl_output_set *b)
{
    const ibl_opts *o = b->opts;
    const char *file = b->files[IBL_OUTPUT_SPECULAR].paths[0];

    /* Engines know their last level. */
    if (!o->of && !o->engine)
        ibl_warn_of_small_faces(&b->job->console, &b->made.report.layout);
    if ((o->engine || (o->of && o->picture)) &&
        ibl_is_given(&o->given, "skybox"))
        ibl_console_warn(&b->job->console,
                         "--skybox: not in %s, whose level 0 is the "
                         "background: for a file of its own take --only "
                         "skybox without --target",
                         ibl_path_name(file));
    if (o->of && o->of->harmonics)
        warn_of_harmonics(b);
    return write_cube(b, IBL_OUTPUT_SPECULAR, &b->made.specular);
}

/* Takes a table that another job has made. */
static void take_table(ibl_output_set *b, ibl_output_kind kind)
{
    const ibl_output_set *from = b->tables;
    ibl_output *file = &b->files[kind];
    const ibl_output own = *file;

    *file = from->files[kind];
    file->paths = own.paths;
    file->count = own.count;
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
    }
}

static bool write_output(ibl_output_set *b, ibl_output_kind kind)
{
    ibl_ctx *ctx = b->job->ctx;
    ibl_texture tex = {0};

    switch (kind) {
    case IBL_OUTPUT_SPECULAR:
        return write_specular(b);
    case IBL_OUTPUT_LUT:
        ibl_console_progress(&b->job->console, "lut", 0);
        return !ibl_bake_lut(ctx, &b->opts->lut, &b->lut) &&
               !ibl_texture_from_lut(
                   ctx, &b->lut,
                   ibl_lut_pixel(b->opts->texels.pixel, b->lut.kind), &tex,
                   &b->files[kind].overflow.values) &&
               write_texture(b, kind, &tex, NULL);
    case IBL_OUTPUT_LOBES:
        ibl_console_progress(&b->job->console, "lobe table", 0);
        return !ibl_bake_lobe_table(ctx, &b->lobe_table, &b->lobes) &&
               !ibl_texture_from_lobe_table(ctx, &b->lobes, &tex) &&
               write_texture(b, kind, &tex, NULL);
    default:
        return write_cube(b, kind,
                          kind == IBL_OUTPUT_SKYBOX ? &b->made.skybox
                                                    : &b->made.irradiance);
    }
}

static bool write_bytes(ibl_output_set *b, const char *path, const void *bytes,
                        size_t size)
{
    ibl_console_progress(&b->job->console, "write", 0);
    return bytes && !ibl_outputs_add(b->job->outputs, path, bytes, size);
}

/* The sidecar is last: where it is new, so are the others. */
bool ibl_set_write(ibl_output_set *b)
{
    const ibl_opts *o = b->opts;
    const ibl_output *json = &b->files[IBL_OUTPUT_JSON];
    const ibl_bake_result *all = &b->job->made;
    char why[160];

    b->made = *all; /* but of the levels, the set's chain */
    if (b->chain > 0) {
        b->made.specular = all->more[b->chain - 1];
        b->made.report = all->more_report[b->chain - 1];
    } else if (b->chain < 0) {
        b->made.specular = (ibl_cube){0};
    }
    b->lobe_table =
        (ibl_lobe_table_options){.size = o->lobe_table_size, .f0 = o->lobe_f0};
    bool ok =
        turn_harmonics(b) && !ibl_specular_layout_of(&o->bake.specular_options,
                                                     &b->lobe_table.layout);
    for (int k = 0; k < IBL_OUTPUT_JSON && ok; k++) {
        const ibl_output_kind kind = (ibl_output_kind)k;
        if (b->files[kind].paths && ibl_set_takes(b, kind))
            take_table(b, kind);
        else if (b->files[kind].paths)
            ok = write_output(b, kind);
    }
    for (int k = 0; k < IBL_OUTPUT_JSON && ok; k++) {
        ibl_output *file = &b->files[k];
        if (file->paths && !ibl_set_takes(b, (ibl_output_kind)k))
            snprintf(file->hash, sizeof file->hash, "%s",
                     ibl_outputs_hash(b->job->outputs, file->paths[0]));
    }
    if (ok && b->sh_path) {
        /* three.js negates x when it looks up cubes, not in harmonics. */
        const double *sh =
            o->sh_format == IBL_SH_THREE ? b->job->made.sh : b->made.sh;
        char *text = ibl_need(ibl_sh_text(o->sh_format, sh));
        ok = write_bytes(b, b->sh_path, text, strlen(text));
        free(text);
    }
    if (ok && o->preview) {
        ibl_console_progress(&b->job->console, "preview", 0);
        const ibl_blob png = ibl_preview_png(b);
        ok = write_bytes(b, o->preview, png.bytes, png.size);
        free(png.bytes);
    }
    if (ok && json->paths) {
        char *text = sidecar(b);
        ok = write_bytes(b, json->paths[0], text, text ? strlen(text) : 0);
        ibl_bytes_free(text);
    }
    if (!ok || !o->verify || (b->job->maps && !o->input))
        return ok; /* what maps share is told of with each of them */
    ibl_console_finish(&b->job->console);
    if (!o->common.quiet) {
        char *text = ibl_report_text(&b->judged);
        if (b->job->verdicts)
            ibl_append(b->job->verdicts, "%s", text);
        else
            fputs(text, stdout);
        fflush(stdout); /* before later messages in a log */
        free(text);
    }
    return ibl_report_passes(&b->judged, o->max_error, NAN, why, sizeof why) ||
           ibl_console_fail(&b->job->console, "%s: nothing was written", why);
}
