/* SPDX-License-Identifier: MIT */
#include "cli/verify.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/heatmap.h"
#include "cli/json_text.h"
#include "cli/judge_report.h"
#include "cli/signals.h"
#include "cli/session.h"
#include "cli/verify_files.h"

typedef struct verify {
    const ibl_verify_opts *opts;
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_outputs *outputs;
    ibl_image env;
    ibl_verify_files files;
    ibl_judge *judge;
    ibl_report report;
} verify;

static ibl_status judge_file(const ibl_verify_files *files,
                             ibl_verify_kind kind, ibl_judge *judge,
                             ibl_console *console, ibl_report *report)
{
    static const ibl_role roles[] = {IBL_ROLE_ENVIRONMENT, IBL_ROLE_SPECULAR,
                                     IBL_ROLE_IRRADIANCE};
    const ibl_verify_file *f = &files->cubes[kind];
    const int base = f->levels ? f->level[0].size : 0;
    ibl_status status = IBL_OK;

    for (int l = 0; l < f->levels && !status; l++) {
        const ibl_judge_level level = {
            .role = roles[kind],
            .lobe = f->lobe,
            .roughness = f->roughness[l],
            .scale = f->scale,
            .size = f->level[l].size,
            .base = base > f->level[l].size ? base : f->level[l].size,
            .texels = f->level[l].data,
            .pixel = f->pixel,
            .mended = f->mended[l]};
        char stage[32];
        snprintf(stage, sizeof stage, "%s %d", ibl_verify_content(kind), l);
        ibl_console_progress(console, stage, 0);
        status =
            ibl_report_add(report, judge, ibl_verify_content(kind), l, &level);
    }
    return status;
}

ibl_status ibl_verify_judge(const ibl_verify_files *files, ibl_judge *judge,
                            ibl_console *console, ibl_report *report)
{
    ibl_status status = IBL_OK;

    for (int kind = 0; kind < IBL_VERIFY_LUT && !status; kind++)
        status =
            judge_file(files, (ibl_verify_kind)kind, judge, console, report);
    return status;
}

static ibl_status judge_cubes(verify *v)
{
    ibl_judge_options options = v->opts->judge;
    ibl_status status;

    if (v->opts->heatmap)
        options.grid = IBL_HEATMAP_GRID;
    ibl_console_progress(v->console, "decode", 0);
    status = ibl_image_read(v->ctx, v->opts->input, &v->opts->common.read,
                            &v->env, NULL);
    if (!status)
        status = ibl_judge_create(v->ctx, &v->env, v->files.yaw_deg, &options,
                                  &v->judge);
    return status
               ? status
               : ibl_verify_judge(&v->files, v->judge, v->console, &v->report);
}

static ibl_status judge_all(verify *v)
{
    ibl_status status = IBL_OK;

    v->report.options = v->opts->judge;
    if (v->files.cubes[IBL_VERIFY_SKYBOX].path ||
        v->files.cubes[IBL_VERIFY_SPECULAR].path ||
        v->files.cubes[IBL_VERIFY_IRRADIANCE].path)
        status = judge_cubes(v);
    if (!status && v->files.lut_path) {
        ibl_console_progress(v->console, "lut", 0);
        status =
            ibl_judge_lut(v->ctx, &v->files.lut, v->files.lut_pixel,
                          v->files.geometry, &v->opts->judge, &v->report.lut);
        v->report.has_lut = !status;
    }
    return status;
}

/* ---- results --------------------------------------------------------- */

static void put(json_t *object, const char *key, json_t *value, bool *failed)
{
    *failed |= json_object_set_new(object, key, value) != 0;
}

/* The report with what it is about before it; NULL: no memory. */
static char *json_report(const verify *v, bool passed)
{
    const ibl_verify_opts *o = v->opts;
    json_t *root = json_object(), *files = json_object();
    bool failed = false;
    char *text = NULL;

    if (o->input)
        put(root, "environment", ibl_json_string(o->input), &failed);
    put(root, "yaw_deg", json_real(v->files.yaw_deg), &failed);
    for (int kind = 0; kind < IBL_VERIFY_COUNT; kind++) {
        const char *path = kind == IBL_VERIFY_LUT ? v->files.lut_path
                                                  : v->files.cubes[kind].path;
        if (path)
            put(files, ibl_verify_content((ibl_verify_kind)kind),
                ibl_json_string(path), &failed);
    }
    put(root, "files", files, &failed);
    if (!isnan(o->max_error)) {
        put(root, "max_error", json_real(o->max_error), &failed);
        put(root, "passed", json_boolean(passed), &failed);
    }
    json_t *report = ibl_report_json(&v->report);
    failed |= !report || json_object_update(root, report) != 0;
    json_decref(report);
    if (!failed)
        text = ibl_json_text(root);
    json_decref(root);
    return text;
}

static ibl_status put_json(verify *v, bool passed)
{
    const char *path = v->opts->json;
    char *text = json_report(v, passed);
    ibl_status status = text ? IBL_OK : IBL_ERR_MEMORY;

    if (!status && !strcmp(path, "-"))
        fputs(text, stdout);
    else if (!status)
        status = ibl_outputs_add(v->outputs, path, text, strlen(text));
    free(text);
    return status;
}

static ibl_status put_heatmap(verify *v)
{
    void *png = NULL;
    size_t size;

    ibl_console_progress(v->console, "heatmap", 0);
    if (!ibl_heatmap_png(&v->report, &png, &size))
        return IBL_ERR_MEMORY;
    const ibl_status status =
        ibl_outputs_add(v->outputs, v->opts->heatmap, png, size);
    free(png);
    return status;
}

static ibl_status put_results(verify *v, bool passed)
{
    ibl_status status = IBL_OK;

    if (v->opts->json)
        status = put_json(v, passed);
    if (!status && v->opts->heatmap)
        status = put_heatmap(v);
    if (status)
        return status;
    ibl_console_finish(v->console);
    if (!v->opts->common.quiet &&
        !(v->opts->json && !strcmp(v->opts->json, "-")))
        ibl_report_print(&v->report, stdout);
    return ibl_commit_outputs(v->outputs);
}

static void free_verify(verify *v)
{
    ibl_end_outputs(v->outputs);
    ibl_report_free(&v->report);
    ibl_judge_free(v->judge);
    ibl_verify_files_free(&v->files);
    ibl_image_free(&v->env);
    ibl_ctx_free(v->ctx);
}

int ibl_verify_run(const void *settings)
{
    const ibl_verify_opts *opts = settings;
    ibl_console console;
    verify v = {.opts = opts, .console = &console};
    char why[160] = "";
    bool passed = true;
    ibl_status status;

    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    ibl_signals_catch();
    status = ibl_start(&opts->common, &console, &v.ctx);
    if (!status)
        status = ibl_start_outputs(v.ctx, 0, &v.outputs);
    if (!status)
        status = ibl_verify_files_read(opts, v.ctx, &console, &v.files);
    if (!status)
        status = judge_all(&v);
    if (!status) {
        passed = isnan(opts->max_error) ||
                 ibl_report_passes(&v.report, opts->max_error, why, sizeof why);
        status = put_results(&v, passed);
    }
    ibl_console_finish(&console);
    if (status)
        ibl_console_fail(&console, "%s", ibl_status_text(status));
    else if (!passed)
        ibl_console_fail(&console, "%s", why);
    else if (opts->common.verbose)
        ibl_console_print_times(&console);
    free_verify(&v);
    return status || !passed ? 1 : 0;
}
