/* SPDX-License-Identifier: MIT */
/* Runs a bake. Writes all files of all sets or none. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bake_record.h"
#include "common/signals.h"

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
    tex->filament = b->opts->filament;
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
    if (ok && b->sh_path)
        ok = write_text(b, b->sh_path, ibl_sh_text(o->sh_format, b->made.sh),
                        "the harmonics");
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
                         b->opts->input, b->from->report.format, b->from->width,
                         b->from->height, (double)b->from->report.peak);
    for (int i = 0; i < b->from->light_count; i++)
        log_light(b, &b->from->lights[i]);
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
    const char *const others[] = {b->files[IBL_OUTPUT_JSON].path, b->sh_path,
                                  b->opts->preview, b->opts->depfile};
    for (int i = 0; i < 4; i++)
        if (others[i])
            ibl_console_info(b->console, "wrote %s", others[i]);
}

static void free_set(ibl_bake *b)
{
    ibl_report_free(&b->judged);
    ibl_lut_free(&b->lut);
    ibl_lobe_table_free(&b->lobes);
    for (int i = 0; i < IBL_OUTPUT_COUNT; i++)
        free(b->files[i].path);
    free(b->sh_path);
}

/* Plans, bakes and writes all, but does not yet rename the files. */
static bool make_set(ibl_bake *b)
{
    const ibl_opts *o = b->opts;

    if (ibl_outputs_mkdir(b->outputs, o->directory) || !ibl_bake_plan(b) ||
        !ibl_bake_source_make(b->from))
        return false;
    b->made = b->from->made;
    return write_all(b) && (!o->verify || ibl_bake_judged(b));
}

int ibl_bake_run(const void *settings)
{
    const ibl_opts *opts = settings;
    ibl_console console;
    ibl_bake_source from = {
        .opts = opts, .console = &console, .bake = opts->bake};
    ibl_bake b = {.opts = opts, .console = &console, .from = &from};

    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    ibl_signals_catch();
    const bool ok = !ibl_start(&opts->common, &console, &from.ctx) &&
                    !ibl_start_outputs(from.ctx, opts->sync, &b.outputs) &&
                    (b.ctx = from.ctx) && make_set(&b) &&
                    ibl_console_commit(&console, b.outputs);
    const int status = ibl_console_end(&console, ok);
    if (ok && opts->common.verbose) {
        log_summary(&b);
        ibl_console_print_times(&console);
    }
    ibl_end_outputs(b.outputs);
    free_set(&b);
    ibl_bake_source_free(&from);
    ibl_ctx_free(from.ctx);
    return status;
}
