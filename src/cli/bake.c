/* SPDX-License-Identifier: MIT */
#include "cli/bake.h"

#include <stdlib.h>
#include <string.h>

#include "cli/bake_verify.h"
#include "cli/beyond.h"
#include "cli/depfile.h"
#include "cli/keys.h"
#include "cli/preview.h"
#include "cli/sidecar.h"
#include "cli/signals.h"
#include "cli/start.h"
#include "cli/targets.h"

bool ibl_bake_is_part(const ibl_bake *b)
{
    return b->opts->specular.roughness_min > 0 ||
           b->opts->specular.roughness_max < 1;
}

bool ibl_bake_is_sampled(const ibl_bake *b)
{
    bool sampled = false;
    for (int l = 0; l < b->made.report.layout.levels; l++)
        sampled |= b->made.report.level[l].samples > 0;
    return sampled;
}

const char *ibl_bake_specular_method(const ibl_bake *b)
{
    bool spectral = false;
    for (int l = 0; l < b->made.report.layout.levels; l++)
        spectral |= b->made.report.level[l].degree > 0 ||
                    b->made.report.level[l].reach > 0;
    if (ibl_bake_is_sampled(b))
        return spectral ? "mixed" : "sampled";
    return spectral ? "spectral" : "environment";
}

const char *ibl_bake_irradiance_method(const ibl_bake *b)
{
    return b->made.irradiance_degree ? "spectral" : "hemisphere grid";
}

const char *ibl_bake_lut_method(const ibl_bake *b)
{
    return b->opts->lut.samples ? "hammersley" : "quadrature";
}

static ibl_status no_memory(ibl_bake *b, const char *what)
{
    ibl_console_fail(b->console, "no memory for %s: ask for less", what);
    return IBL_ERR_MEMORY;
}

/* ---- outputs --------------------------------------------------------- */

/* Hands a file to the set. */
static ibl_status put(ibl_bake *b, const char *path, const void *bytes,
                      size_t size)
{
    ibl_console_progress(b->console, "write", 0);
    return ibl_outputs_add(b->outputs, path, bytes, size);
}

/* Judges the file that a texture is written as. */
static ibl_status judge_texture(ibl_bake *b, ibl_output_kind kind,
                                const ibl_texture *tex)
{
    void *bytes = NULL;
    size_t size;
    ibl_status status = ibl_texture_encode(
        b->ctx, tex, (ibl_container)b->opts->format, &bytes, &size);

    if (!status)
        status = ibl_bake_judge(b, kind, bytes, size);
    ibl_bytes_free(bytes);
    return status;
}

/* Writes and frees a texture. */
static ibl_status put_texture(ibl_bake *b, ibl_output_kind kind,
                              ibl_texture *tex)
{
    ibl_baked *file = &b->files[kind];
    ibl_overflow_level beyond = {0};
    ibl_status status = ibl_keys_set(b, kind, tex);

    if (!status && b->opts->verify)
        status = judge_texture(b, kind, tex);
    ibl_console_progress(b->console, "write", 0);
    file->shape = *tex;
    file->shape.data = NULL;
    file->shape.keys = NULL;
    file->shape.key_count = 0;
    if (status)
        ibl_texture_free(tex);
    else
        status = ibl_outputs_take_texture(b->outputs, file->path, tex,
                                          (ibl_container)b->opts->format,
                                          &file->bytes);
    for (int l = 0; l < file->shape.levels; l++)
        ibl_beyond_add(&file->beyond[l], &beyond);
    if (!status)
        ibl_beyond_warn(b->console, file->path, file->shape.pixel,
                        (ibl_overflow)b->opts->overflow, &beyond);
    return status;
}

static ibl_status put_cube(ibl_bake *b, ibl_output_kind kind,
                           const ibl_cube *cube)
{
    ibl_baked *file = &b->files[kind];
    ibl_overflow_report report = {0};
    ibl_texture tex = {0};

    ibl_console_progress(b->console, "write", 0);
    const ibl_status status =
        ibl_texture_from_cube(b->ctx, cube, (ibl_pixel)b->opts->pixel,
                              (ibl_overflow)b->opts->overflow, &tex, &report);
    file->saturated = report.values;
    memcpy(file->beyond, report.level, sizeof file->beyond);
    return status ? status : put_texture(b, kind, &tex);
}

static ibl_status make_skybox(ibl_bake *b)
{
    return put_cube(b, IBL_OUTPUT_SKYBOX, &b->made.skybox);
}

static ibl_status make_specular(ibl_bake *b)
{
    ibl_warn_of_small_faces(b->console, &b->made.report.layout);
    if (b->opts->sampling[0] &&
        !strcmp(ibl_bake_specular_method(b), "spectral"))
        ibl_console_warn(b->console,
                         "%s: without effect, since no level is sampled: add "
                         "--method sampled or leave it out",
                         b->opts->sampling);
    return put_cube(b, IBL_OUTPUT_SPECULAR, &b->made.specular);
}

static ibl_status make_irradiance(ibl_bake *b)
{
    return put_cube(b, IBL_OUTPUT_IRRADIANCE, &b->made.irradiance);
}

static ibl_status make_lut(ibl_bake *b)
{
    ibl_texture tex = {0};

    ibl_console_progress(b->console, "lut", 0);
    ibl_status status = ibl_bake_lut(b->ctx, &b->opts->lut, &b->lut);
    if (!status)
        status =
            ibl_texture_from_lut(b->ctx, &b->lut, ibl_opts_lut_pixel(b->opts),
                                 &tex, &b->files[IBL_OUTPUT_LUT].saturated);
    return status ? status : put_texture(b, IBL_OUTPUT_LUT, &tex);
}

static ibl_status make_json(ibl_bake *b)
{
    ibl_console_progress(b->console, "write", 0);
    char *text = ibl_sidecar_text(b);
    if (!text)
        return no_memory(b, "the sidecar");
    const ibl_status status =
        put(b, b->files[IBL_OUTPUT_JSON].path, text, strlen(text));
    free(text);
    return status;
}

static ibl_status make_preview(ibl_bake *b)
{
    void *png = NULL;
    size_t size;

    ibl_console_progress(b->console, "preview", 0);
    if (!ibl_preview_png(b, &png, &size))
        return no_memory(b, "the preview");
    const ibl_status status = put(b, b->opts->preview, png, size);
    free(png);
    return status;
}

static ibl_status make_depfile(ibl_bake *b)
{
    char *text = ibl_depfile_text(b);

    if (!text)
        return no_memory(b, "the depfile");
    const ibl_status status = put(b, b->opts->depfile, text, strlen(text));
    free(text);
    return status;
}

/* ---- environment ------------------------------------------------------ */

static ibl_status read_rows(void *cookie, int rows, float *rgb)
{
    return ibl_source_read(cookie, rows, rgb);
}

static ibl_status bake_rows(ibl_bake *b, const ibl_environment *rows)
{
    const ibl_bake_options options = {
        .skybox = b->files[IBL_OUTPUT_SKYBOX].path ? b->opts->skybox : 0,
        .specular = b->files[IBL_OUTPUT_SPECULAR].path != NULL,
        .specular_options = b->opts->specular,
        .irradiance = b->files[IBL_OUTPUT_IRRADIANCE].path != NULL,
        .irradiance_options = b->opts->irradiance,
        .sh_degree = b->files[IBL_OUTPUT_JSON].path ? b->opts->sh_degree : -1,
        .yaw_deg = b->opts->yaw_deg};

    b->width = rows->image ? rows->image->width : rows->width;
    b->height = rows->image ? rows->image->height : rows->height;
    return ibl_bake_environment(b->ctx, rows, &options, &b->made);
}

/* The map is read whole for what looks at it again, else row by row. */
static ibl_status make_environment(ibl_bake *b)
{
    const ibl_read_options *read = &b->opts->common.read;
    ibl_source *source = NULL;
    ibl_status status;

    ibl_console_progress(b->console, "decode", 0);
    if (b->opts->verify || b->opts->preview) {
        status =
            ibl_image_read(b->ctx, b->opts->input, read, &b->env, &b->report);
        const ibl_environment rows = {.image = &b->env};
        return status ? status : bake_rows(b, &rows);
    }
    status = ibl_source_open(b->ctx, b->opts->input, read, &source);
    if (status)
        return status;
    const ibl_environment rows = {.width = ibl_source_width(source),
                                  .height = ibl_source_height(source),
                                  .read = read_rows,
                                  .cookie = source};
    status = bake_rows(b, &rows);
    b->report = *ibl_source_report(source);
    ibl_source_close(source);
    return status;
}

static ibl_status make_all(ibl_bake *b)
{
    static ibl_status (*const makers[IBL_OUTPUT_COUNT])(ibl_bake *) = {
        make_skybox, make_specular, make_irradiance, make_lut, make_json};
    ibl_status status = IBL_OK;

    if (b->opts->input)
        status = make_environment(b);
    for (int kind = 0; kind < IBL_OUTPUT_COUNT && !status; kind++)
        if (b->files[kind].path)
            status = makers[kind](b);
    if (!status && b->opts->preview)
        status = make_preview(b);
    if (!status && b->opts->depfile)
        status = make_depfile(b);
    return status;
}

/* What was read and written, for -v. */
static void tell(const ibl_bake *b)
{
    if (b->opts->input)
        ibl_console_info(b->console, "read %s: %s, %d x %d, peak %.6g",
                         b->opts->input, b->report.format, b->width, b->height,
                         (double)b->report.peak);
    for (int kind = 0; kind < IBL_OUTPUT_COUNT; kind++) {
        const ibl_baked *file = &b->files[kind];
        if (!file->path)
            continue;
        if (kind == IBL_OUTPUT_JSON)
            ibl_console_info(b->console, "wrote %s", file->path);
        else
            ibl_console_info(
                b->console, "wrote %s: %s, %s, %d x %d, levels: %d", file->path,
                file->shape.faces == 6 ? "cube" : "2D",
                ibl_pixel_name(file->shape.pixel), file->shape.width,
                file->shape.height, file->shape.levels);
    }
    if (b->opts->preview)
        ibl_console_info(b->console, "wrote %s", b->opts->preview);
    if (b->opts->depfile)
        ibl_console_info(b->console, "wrote %s", b->opts->depfile);
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

int ibl_bake_run(const ibl_opts *opts)
{
    ibl_console console;
    ibl_bake b = {.opts = opts, .console = &console};
    ibl_status status;

    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    ibl_signals_catch();
    status = ibl_targets_name(&b);
    if (!status)
        status = ibl_start(&opts->common, &console, &b.ctx);
    if (!status)
        status = ibl_start_outputs(b.ctx, opts->sync, &b.outputs);
    if (!status)
        status = ibl_outputs_mkdir(b.outputs, opts->directory);
    if (!status)
        status = ibl_targets_check(&b);
    if (!status)
        status = make_all(&b);
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
        tell(&b);
        ibl_console_print_times(&console);
    }
    free_bake(&b);
    return status ? 1 : 0;
}
