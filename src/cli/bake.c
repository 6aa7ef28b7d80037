/* SPDX-License-Identifier: MIT */
/* The bake, from the command line to the files: all of them are written, or
 * none. */
#include <stdlib.h>
#include <string.h>

#include "cli/bake_record.h"
#include "cli/console.h"
#include "common/signals.h"

/* ---- read and bake ---------------------------------------------------- */

static ibl_status read_rows(void *cookie, int rows, float *rgb)
{
    return ibl_source_read(cookie, rows, rgb);
}

/* From a map in memory, for what looks at it again. */
static ibl_status bake_image(ibl_bake *b)
{
    const ibl_environment rows = {.image = &b->env};
    const ibl_status status = ibl_image_read(
        b->ctx, b->opts->input, &b->opts->common.read, &b->env, &b->report);

    b->width = b->env.width;
    b->height = b->env.height;
    return status
               ? status
               : ibl_bake_environment(b->ctx, &rows, &b->opts->bake, &b->made);
}

static ibl_status bake_source(ibl_bake *b)
{
    ibl_source *source = NULL;
    ibl_status status =
        ibl_source_open(b->ctx, b->opts->input, &b->opts->common.read, &source);

    if (status)
        return status;
    b->width = ibl_source_width(source);
    b->height = ibl_source_height(source);
    const ibl_environment rows = {.width = b->width,
                                  .height = b->height,
                                  .read = read_rows,
                                  .cookie = source};
    status = ibl_bake_environment(b->ctx, &rows, &b->opts->bake, &b->made);
    b->report = *ibl_source_report(source);
    ibl_source_close(source);
    return status;
}

static ibl_status bake_environment(ibl_bake *b)
{
    if (!b->opts->input)
        return IBL_OK;
    ibl_console_progress(b->console, "decode", 0);
    return b->opts->verify || b->opts->preview ? bake_image(b) : bake_source(b);
}

/* ---- write ------------------------------------------------------------ */

static void warn_of_overflow(const ibl_bake *b, const ibl_baked *file)
{
    ibl_overflow_level sum = {0};

    for (int l = 0; l < file->shape.levels; l++)
        ibl_overflow_add(&file->overflow.level[l], &sum);
    ibl_warn_of_overflow(b->console, file->path, file->shape.pixel,
                         b->opts->overflow, &sum);
}

/* Writes and frees a texture. */
static ibl_status write_texture(ibl_bake *b, ibl_output_kind kind,
                                ibl_texture *tex)
{
    ibl_baked *file = &b->files[kind];
    ibl_status status = ibl_texture_metadata(b, kind, tex);

    if (!status && b->opts->verify)
        status = ibl_bake_judge(b, kind, tex);
    ibl_console_progress(b->console, "write", 0);
    file->shape = *tex;
    file->shape.data = NULL;
    file->shape.keys = NULL;
    file->shape.key_count = 0;
    if (status)
        ibl_texture_free(tex);
    else
        status = ibl_outputs_take_texture(b->outputs, file->path, tex,
                                          b->opts->format, &file->bytes);
    if (!status)
        warn_of_overflow(b, file);
    return status;
}

static ibl_status write_cube(ibl_bake *b, ibl_output_kind kind,
                             const ibl_cube *cube)
{
    ibl_texture tex = {0};

    ibl_console_progress(b->console, "write", 0);
    const ibl_status status =
        ibl_texture_from_cube(b->ctx, cube, b->opts->pixel, b->opts->overflow,
                              &tex, &b->files[kind].overflow);
    return status ? status : write_texture(b, kind, &tex);
}

static ibl_status write_specular(ibl_bake *b)
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

/* The table is rg32f where the cubes are rgba32f, else rg16f. */
static ibl_status write_lut(ibl_bake *b)
{
    const ibl_pixel pixel =
        b->opts->pixel == IBL_PIXEL_RGBA32F ? IBL_PIXEL_RG32F : IBL_PIXEL_RG16F;
    ibl_texture tex = {0};

    ibl_console_progress(b->console, "lut", 0);
    ibl_status status = ibl_bake_lut(b->ctx, &b->opts->lut, &b->lut);
    if (!status)
        status =
            ibl_texture_from_lut(b->ctx, &b->lut, pixel, &tex,
                                 &b->files[IBL_OUTPUT_LUT].overflow.values);
    return status ? status : write_texture(b, IBL_OUTPUT_LUT, &tex);
}

/* Writes and frees bytes; NULL: there was no memory for them. */
static ibl_status write_bytes(ibl_bake *b, const char *path, void *bytes,
                              size_t size, const char *what)
{
    ibl_console_progress(b->console, "write", 0);
    if (!bytes)
        return ibl_refuse(b->console, IBL_ERR_MEMORY,
                          "no memory for %s: ask for less", what);
    const ibl_status status = ibl_outputs_add(b->outputs, path, bytes, size);
    free(bytes);
    return status;
}

static ibl_status write_text(ibl_bake *b, const char *path, char *text,
                             const char *what)
{
    return write_bytes(b, path, text, text ? strlen(text) : 0, what);
}

static ibl_status write_preview(ibl_bake *b)
{
    void *png = NULL;
    size_t size = 0;

    ibl_console_progress(b->console, "preview", 0);
    if (!ibl_preview_png(b, &png, &size))
        png = NULL;
    return write_bytes(b, b->opts->preview, png, size, "the preview");
}

static ibl_status write_all(ibl_bake *b)
{
    const ibl_baked *f = b->files;
    ibl_status status = IBL_OK;

    if (f[IBL_OUTPUT_SKYBOX].path)
        status = write_cube(b, IBL_OUTPUT_SKYBOX, &b->made.skybox);
    if (!status && f[IBL_OUTPUT_SPECULAR].path)
        status = write_specular(b);
    if (!status && f[IBL_OUTPUT_IRRADIANCE].path)
        status = write_cube(b, IBL_OUTPUT_IRRADIANCE, &b->made.irradiance);
    if (!status && f[IBL_OUTPUT_LUT].path)
        status = write_lut(b);
    if (!status && f[IBL_OUTPUT_JSON].path) {
        ibl_console_progress(b->console, "write", 0);
        status = write_text(b, f[IBL_OUTPUT_JSON].path, ibl_sidecar_text(b),
                            "the sidecar");
    }
    if (!status && b->opts->preview)
        status = write_preview(b);
    if (!status && b->opts->depfile)
        status =
            write_text(b, b->opts->depfile, ibl_depfile_text(b), "the depfile");
    return status;
}

/* ---- the whole -------------------------------------------------------- */

/* Logs the files that were read and written, for -v. */
static void log_summary(const ibl_bake *b)
{
    if (b->opts->input)
        ibl_console_info(b->console, "read %s: %s, %d x %d, peak %.6g",
                         b->opts->input, b->report.format, b->width, b->height,
                         (double)b->report.peak);
    for (int kind = 0; kind < IBL_OUTPUT_JSON; kind++) {
        const ibl_baked *file = &b->files[kind];
        if (file->path)
            ibl_console_info(
                b->console, "wrote %s: %s, %s, %d x %d, levels: %d", file->path,
                file->shape.faces == 6 ? "cube" : "2D",
                ibl_pixel_name(file->shape.pixel), file->shape.width,
                file->shape.height, file->shape.levels);
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
    ibl_judge_free(b->judge);
    ibl_image_free(&b->env);
    ibl_bake_result_free(&b->made);
    ibl_lut_free(&b->lut);
    for (int i = 0; i < IBL_OUTPUT_COUNT; i++)
        free(b->files[i].path);
    ibl_ctx_free(b->ctx);
}

static int run(const void *settings)
{
    const ibl_opts *opts = settings;
    ibl_console console;
    ibl_bake b = {.opts = opts, .console = &console};
    ibl_status status;

    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    ibl_signals_catch();
    status = ibl_start(&opts->common, &console, &b.ctx);
    if (!status)
        status = ibl_start_outputs(b.ctx, opts->sync, &b.outputs);
    if (!status)
        status = ibl_outputs_mkdir(b.outputs, opts->directory);
    if (!status)
        status = ibl_targets_plan(&b);
    if (!status)
        status = bake_environment(&b);
    if (!status)
        status = write_all(&b);
    if (!status && opts->verify)
        status = ibl_bake_judged(&b);
    if (!status) {
        ibl_console_progress(&console, "write", 1);
        status = ibl_outputs_wait(b.outputs);
    }
    if (!status)
        status = ibl_commit_outputs(b.outputs);
    ibl_console_finish(&console);
    if (status)
        ibl_console_fail(&console, "%s", ibl_status_text(status));
    else if (opts->common.verbose) {
        log_summary(&b);
        ibl_console_print_times(&console);
    }
    free_bake(&b);
    return status ? 1 : 0;
}

const ibl_command ibl_bake_command = {
    .usage = "[options] ENV -o DIR",
    .intro =
        "Bakes an equirectangular HDR environment (.hdr, .exr and others; - "
        "reads\n"
        "standard input) into the textures of image-based lighting:\n"
        "  DIR/NAME_specular.EXT    prefiltered cube, one roughness per "
        "level\n"
        "  DIR/NAME_irradiance.EXT  diffuse cube, E/pi\n"
        "  DIR/brdf_lut.EXT         scale and bias of F0 over N.V and "
        "roughness\n"
        "  DIR/NAME.json            spherical harmonics and what was done\n",
    .statuses = "0 done, 1 failed, 2 wrong usage",
    .sections = ibl_bake_sections,
    .settings_size = sizeof(ibl_opts),
    .defaults = ibl_bake_defaults,
    .take = ibl_bake_take,
    .validate = ibl_bake_validate,
    .run = run,
};
