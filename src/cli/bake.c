/* SPDX-License-Identifier: MIT */
/* Runs a bake: reads, bakes and writes. Writes all files or none. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bake_record.h"
#include "cli/console.h"
#include "common/signals.h"

/* ---- read and bake ---------------------------------------------------- */

/* Moves the environment to the rest, or copies it for what shows all of it. */
static bool copy_environment(ibl_bake *b)
{
    const ibl_image *env = &b->env;

    if (!b->opts->bake.skybox && !b->opts->preview) {
        b->rest = *env;
        b->env = (ibl_image){0};
        return true;
    }
    if (ibl_image_alloc(b->ctx, env->width, env->height, &b->rest))
        return false;
    memcpy(b->rest.data, env->data,
           3 * sizeof *env->data * (size_t)env->width * (size_t)env->height);
    return true;
}

static bool bake_skybox(ibl_bake *b, ibl_cube *skybox)
{
    const ibl_environment all = {.image = &b->env};
    ibl_bake_options alone = ibl_bake_options_default();
    ibl_bake_result made = {0};

    if (!b->opts->bake.skybox)
        return true;
    alone.skybox = b->opts->bake.skybox;
    alone.specular = alone.irradiance = 0;
    alone.sh_degree = -1;
    alone.yaw_deg = b->opts->bake.yaw_deg;
    const bool ok = !ibl_bake_environment(b->ctx, &all, &alone, &made);
    *skybox = made.skybox;
    return ok;
}

/* The skybox of the environment, all else of what lights leave of it. */
static bool bake_without_lights(ibl_bake *b)
{
    const ibl_environment rest = {.image = &b->rest};
    ibl_bake_options others = b->opts->bake;
    ibl_cube skybox = {0};

    others.skybox = 0;
    const bool ok =
        bake_skybox(b, &skybox) && copy_environment(b) &&
        !ibl_image_take_lights(b->ctx, &b->rest, others.yaw_deg,
                               b->opts->lights, b->lights, &b->light_count) &&
        !ibl_bake_environment(b->ctx, &rest, &others, &b->made);
    b->made.skybox = skybox;
    return ok;
}

/* Keeps the map in memory, for lights, --verify and --preview. */
static bool bake_image(ibl_bake *b)
{
    const ibl_environment rows = {.image = &b->env};

    if (ibl_image_read(b->ctx, b->opts->input, &b->opts->common.read, &b->env,
                       &b->report))
        return false;
    b->width = b->env.width;
    b->height = b->env.height;
    if (b->opts->lights)
        return bake_without_lights(b);
    return !ibl_bake_environment(b->ctx, &rows, &b->opts->bake, &b->made);
}

static bool bake_source(ibl_bake *b)
{
    ibl_source *source = NULL;

    if (ibl_source_open(b->ctx, b->opts->input, &b->opts->common.read, &source))
        return false;
    const ibl_environment rows = ibl_source_environment(source);
    b->width = rows.width;
    b->height = rows.height;
    const bool ok =
        !ibl_bake_environment(b->ctx, &rows, &b->opts->bake, &b->made);
    b->report = *ibl_source_report(source);
    ibl_source_close(source);
    return ok;
}

static bool bake_environment(ibl_bake *b)
{
    if (!b->opts->input)
        return true;
    ibl_console_progress(b->console, "decode", 0);
    return b->opts->lights || b->opts->verify || b->opts->preview
               ? bake_image(b)
               : bake_source(b);
}

/* ---- write ------------------------------------------------------------ */

static void warn_of_overflow(const ibl_bake *b, const ibl_baked *file)
{
    ibl_overflow_level sum = {0};

    for (int l = 0; l < file->shape.levels; l++)
        ibl_overflow_add(&file->overflow.level[l], &sum);
    ibl_warn_of_overflow(b->console, file->path, file->shape.pixel,
                         b->opts->texels.overflow, &sum);
}

/* Writes and frees a texture. */
static bool write_texture(ibl_bake *b, ibl_output_kind kind, ibl_texture *tex)
{
    ibl_baked *file = &b->files[kind];

    file->shape = *tex;
    file->shape.data = NULL;
    file->shape.keys = NULL;
    file->shape.key_count = 0;
    bool ok = ibl_texture_metadata(b, kind, tex) &&
              (!b->opts->verify || ibl_bake_judge(b, kind, tex));
    tex->zstd = b->opts->zstd; /* loses nothing, so --verify can do without */
    ok = ok && !ibl_outputs_take_texture(b->outputs, file->path, tex,
                                         b->opts->format, &file->bytes);
    ibl_texture_free(tex);
    if (ok)
        warn_of_overflow(b, file);
    return ok;
}

static bool write_cube(ibl_bake *b, ibl_output_kind kind, const ibl_cube *cube)
{
    ibl_baked *file = &b->files[kind];
    ibl_texture tex = {0};

    ibl_console_progress(b->console, "write", 0);
    const bool ok = !ibl_texture_from_cube(b->ctx, cube, &b->opts->texels, &tex,
                                           &file->overflow) &&
                    !ibl_texture_errors(b->ctx, &tex, cube, file->error) &&
                    write_texture(b, kind, &tex);
    ibl_texture_free(&tex);
    return ok;
}

static bool write_specular(ibl_bake *b)
{
    char given[IBL_SAMPLING_BYTES];

    ibl_warn_of_small_faces(b->console, &b->made.report.layout);
    ibl_sampling_given(b->opts, given);
    if (*given && !strcmp(ibl_bake_specular_method(b), "spectral"))
        ibl_console_warn(b->console,
                         "%s: without effect, since no level is sampled: add "
                         "--method sampled or leave it out",
                         given);
    return write_cube(b, IBL_OUTPUT_SPECULAR, &b->made.specular);
}

static bool write_lut(ibl_bake *b)
{
    ibl_texture tex = {0};

    ibl_console_progress(b->console, "lut", 0);
    return !ibl_bake_lut(b->ctx, &b->opts->lut, &b->lut) &&
           !ibl_texture_from_lut(b->ctx, &b->lut,
                                 ibl_lut_pixel(b->opts->texels.pixel), &tex,
                                 &b->files[IBL_OUTPUT_LUT].overflow.values) &&
           write_texture(b, IBL_OUTPUT_LUT, &tex);
}

static bool write_lobes(ibl_bake *b)
{
    ibl_lobe_table_options o = ibl_lobe_table_options_default();
    ibl_texture tex = {0};

    o.size = b->opts->lobe_table_size;
    if (b->opts->lobe_table == IBL_LOBES_FITTED) {
        o.power = b->made.power;
        o.power_degree = b->made.power_degree;
    }
    o.layout = b->made.report.layout;
    if (!b->opts->bake.specular &&
        ibl_specular_layout_of(&b->opts->bake.specular_options, &o.layout))
        return false;
    b->lobe_layout = o.layout;
    ibl_console_progress(b->console, "lobe table", 0);
    const bool ok = !ibl_bake_lobe_table(b->ctx, &o, &b->lobes) &&
                    !ibl_texture_from_lobe_table(b->ctx, &b->lobes, &tex);
    return ok && write_texture(b, IBL_OUTPUT_LOBES, &tex);
}

/* Writes and frees bytes. If bytes is NULL, reports that memory ran out. */
static bool write_bytes(ibl_bake *b, const char *path, void *bytes, size_t size,
                        const char *what)
{
    ibl_console_progress(b->console, "write", 0);
    if (!bytes)
        return ibl_console_fail(b->console, "no memory for %s: ask for less",
                                what);
    const bool ok = !ibl_outputs_add(b->outputs, path, bytes, size);
    free(bytes);
    return ok;
}

static bool write_text(ibl_bake *b, const char *path, char *text,
                       const char *what)
{
    return write_bytes(b, path, text, text ? strlen(text) : 0, what);
}

static bool write_preview(ibl_bake *b)
{
    void *png = NULL;
    size_t size = 0;

    ibl_console_progress(b->console, "preview", 0);
    if (!ibl_preview_png(b, &png, &size))
        png = NULL;
    return write_bytes(b, b->opts->preview, png, size, "the preview");
}

static bool write_output(ibl_bake *b, ibl_output_kind kind)
{
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
        ibl_console_progress(b->console, "write", 0);
        return write_text(b, b->files[kind].path, ibl_sidecar_text(b),
                          "the sidecar");
    case IBL_OUTPUT_COUNT:
        break;
    }
    return false;
}

static bool write_all(ibl_bake *b)
{
    const ibl_opts *o = b->opts;
    bool ok = true;

    for (int kind = 0; kind < IBL_OUTPUT_COUNT && ok; kind++)
        ok = !b->files[kind].path || write_output(b, (ibl_output_kind)kind);
    return ok && (!o->preview || write_preview(b)) &&
           (!o->depfile ||
            write_text(b, o->depfile, ibl_depfile_text(b), "the depfile"));
}

/* ---- the command ------------------------------------------------------ */

static void log_light(const ibl_bake *b, const ibl_light *light)
{
    const double *to = light->direction, *e = light->irradiance;

    ibl_console_info(b->console,
                     "took a light: towards %.4f %.4f %.4f, radius %.3g "
                     "degrees, irradiance %.4g %.4g %.4g",
                     to[0], to[1], to[2], light->radius * 180 / M_PI, e[0],
                     e[1], e[2]);
}

/* ", off by 2.6 1.3 0.9 %": the nRMSE of each level of a cube by its pixel
 * format; "": none is off. */
static void list_errors(const ibl_baked *file, char *list, size_t size)
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

/* Logs the files that were read and written, for -v. */
static void log_summary(const ibl_bake *b)
{
    if (b->opts->input)
        ibl_console_info(b->console, "read %s: %s, %d x %d, peak %.6g",
                         b->opts->input, b->report.format, b->width, b->height,
                         (double)b->report.peak);
    for (int i = 0; i < b->light_count; i++)
        log_light(b, &b->lights[i]);
    for (int kind = 0; kind < IBL_OUTPUT_JSON; kind++) {
        const ibl_baked *file = &b->files[kind];
        char errors[64 + 16 * IBL_MAX_LEVELS];
        list_errors(file, errors, sizeof errors);
        if (file->path)
            ibl_console_info(
                b->console, "wrote %s: %s, %s, %d x %d, levels: %d%s",
                file->path, file->shape.faces == 6 ? "cube" : "2D",
                ibl_pixel_name(file->shape.pixel), file->shape.width,
                file->shape.height, file->shape.levels, errors);
    }
    const char *const others[] = {b->files[IBL_OUTPUT_JSON].path,
                                  b->opts->preview, b->opts->depfile};
    for (int i = 0; i < 3; i++)
        if (others[i])
            ibl_console_info(b->console, "wrote %s", others[i]);
}

static void free_bake(ibl_bake *b)
{
    ibl_end_outputs(b->outputs);
    ibl_report_free(&b->judged);
    ibl_judge_free(b->judge[0]);
    ibl_judge_free(b->judge[1]);
    ibl_image_free(&b->env);
    ibl_image_free(&b->rest);
    ibl_bake_result_free(&b->made);
    ibl_lut_free(&b->lut);
    ibl_lobe_table_free(&b->lobes);
    for (int i = 0; i < IBL_OUTPUT_COUNT; i++)
        free(b->files[i].path);
    ibl_ctx_free(b->ctx);
}

int ibl_bake_run(const void *settings)
{
    const ibl_opts *opts = settings;
    ibl_console console;
    ibl_bake b = {.opts = opts, .console = &console};

    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    ibl_signals_catch();
    const bool ok = !ibl_start(&opts->common, &console, &b.ctx) &&
                    !ibl_start_outputs(b.ctx, opts->sync, &b.outputs) &&
                    !ibl_outputs_mkdir(b.outputs, opts->directory) &&
                    ibl_targets_plan(&b) && bake_environment(&b) &&
                    write_all(&b) && (!opts->verify || ibl_bake_judged(&b)) &&
                    ibl_console_commit(&console, b.outputs);
    const int status = ibl_console_end(&console, ok);
    if (ok && opts->common.verbose) {
        log_summary(&b);
        ibl_console_print_times(&console);
    }
    free_bake(&b);
    return status;
}
