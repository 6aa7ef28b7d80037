/* SPDX-License-Identifier: MIT */
/* Runs a job: begins its sets, chooses what is left open, plans the files,
 * bakes, writes. All files of all sets appear, or none. */
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

/* ---- its sets ------------------------------------------------------------ */

/* Adds a set. Its directory is --output or, of several, one in it; of maps that
 * were found in folders, the same below it. */
static void add_set(ibl_job *r, const ibl_opts *o)
{
    ibl_output_set *b = &r->sets[r->count];
    const char *all = o->directory ? o->directory : ".";
    const char *below = o->below ? o->below : "";
    const int folders = (int)(ibl_path_name(below) - below);

    *b = (ibl_output_set){.opts = o, .job = r};
    if (r->tables)
        b->tables = &r->tables[r->count];
    b->root = ibl_need(r->line->count > 1 ? ibl_path_join(all, o->of->name)
                                          : strdup(all));
    b->directory =
        ibl_need(folders ? ibl_format("%s/%.*s", b->root, folders - 1, below)
                         : strdup(b->root));
    ibl_set_name_files(b);
    r->count++;
}

void ibl_job_begin(ibl_job *r)
{
    r->opts = r->line->set;
    r->sets = ibl_need(calloc((size_t)r->line->count + 1, sizeof *r->sets));
    for (int i = 0; i < r->line->count; i++)
        add_set(r, &r->line->set[i]);
}

/* ---- what is left open --------------------------------------------------- */

/* Chooses what --rendered-error leaves open in a set. Behind an only one may
 * come one of sheen for a scene. */
static bool choose(ibl_job *r, ibl_output_set *b)
{
    ibl_materials materials = ibl_materials_all();
    ibl_opts *o = (ibl_opts *)b->opts;
    const ibl_scenes *scenes = r->scenes;

    b->choice = ibl_need(calloc(1, sizeof *b->choice));
    if (scenes)
        ibl_scenes_tell(scenes, b->choice);
    if (scenes && !ibl_scenes_materials(scenes, &materials))
        ibl_scenes_drop(scenes, o, b->choice);
    else if (!ibl_choose(r, &materials, o, b->choice))
        return false;
    ibl_set_name_files(b);
    if (scenes && ibl_scenes_sheen(scenes, o, &r->sheen, b->choice))
        add_set(r, &r->sheen);
    if (scenes && !o->bake.skybox)
        ibl_choice_add(b->choice, true, "skybox", "none\tadd --skybox N %s",
                       scenes->survey.transmission > 0
                           ? "for what transmits light, which shows it"
                           : "to draw it behind");
    return true;
}

/* Chooses what --rendered-error leaves open, and prints it. */
static bool decide(ibl_job *r)
{
    const int count = r->count;
    bool ok = true;

    if (isnan(r->opts->rendered_error))
        return true;
    if (r->opts->scenes.count) {
        ibl_console_progress(&r->console, "scene", 0);
        r->scenes = ibl_need(calloc(1, sizeof *r->scenes));
        ok = ibl_scenes_read(r->ctx, &r->opts->scenes,
                             r->opts->common.read.strict, r->scenes);
    }
    ok = ok && ibl_job_read(r);
    for (int i = 0; i < count && ok; i++) {
        ok = choose(r, &r->sets[i]);
        if (ok && count > 1)
            printf("%s%s\n", i ? "\n" : "", r->sets[i].opts->of->name);
        if (ok)
            ibl_choice_print(r->sets[i].choice, stdout);
    }
    return ok;
}

/* ---- from the environment to the files ----------------------------------- */

static bool make_directories(ibl_job *r)
{
    bool ok = !ibl_outputs_create(r->ctx, r->opts->sync, &r->outputs);

    for (int i = 0; i < r->count && ok; i++)
        ok = !ibl_outputs_mkdir(r->outputs, r->sets[i].root) &&
             !ibl_outputs_mkdir(r->outputs, r->sets[i].directory);
    return ok;
}

bool ibl_job_make(ibl_job *r)
{
    const ibl_opts *o = r->opts;
    bool ok = decide(r);

    if (!ok || o->dry_run)
        return ok;
    ok = make_directories(r) && ibl_job_plan(r) && ibl_job_bake(r);
    for (int i = 0; i < r->count && ok; i++)
        ok = ibl_set_write(&r->sets[i]);
    if (ok && o->depfile && !r->line->batch) {
        char *text = ibl_depfile_text(r);
        ok = text &&
             !ibl_outputs_add(r->outputs, o->depfile, text, strlen(text));
        free(text);
    }
    return ok;
}

bool ibl_job_commit(ibl_job *r)
{
    return !r->outputs || ibl_console_commit(&r->console, r->outputs);
}

void ibl_job_end(ibl_job *r)
{
    ibl_outputs_free(r->outputs);
    for (int i = 0; i < r->count; i++) {
        ibl_output_set *b = &r->sets[i];
        if (b->judged.json)
            json_decref(b->judged.json);
        if (b->choice)
            ibl_choice_free(b->choice);
        free(b->choice);
        if (!ibl_set_takes(b, IBL_OUTPUT_LUT))
            ibl_lut_free(&b->lut);
        if (!ibl_set_takes(b, IBL_OUTPUT_LOBES))
            ibl_lobe_table_free(&b->lobes);
        ibl_set_forget_names(b);
        free(b->directory);
        free(b->root);
        free(b->sh);
    }
    free(r->sets);
    if (r->scenes)
        ibl_scenes_free(r->scenes);
    for (int i = 0; i < 2; i++)
        if (r->judge[i])
            ibl_judge_free(r->judge[i]);
    ibl_image_free(&r->env);
    ibl_image_free(&r->rest);
    ibl_bake_result_free(&r->made);
}

/* ---- what is said of it -------------------------------------------------- */

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

static void log_file(ibl_console *c, const char *path)
{
    if (path)
        ibl_console_info(c, "wrote %s", path);
}

void ibl_job_log(ibl_job *r)
{
    ibl_console *c = &r->console;

    if (r->opts->input)
        ibl_console_info(c, "read %s: %s, %d x %d, peak %.6g", r->opts->input,
                         r->report.format, r->width, r->height,
                         (double)r->report.peak);
    for (int i = 0; i < r->light_count; i++) {
        const ibl_light *light = &r->lights[i];
        const double *to = light->direction, *e = light->irradiance;
        ibl_console_info(c,
                         "took a light: towards %.4f %.4f %.4f, radius %.3g "
                         "degrees, irradiance %.4g %.4g %.4g",
                         to[0], to[1], to[2], light->radius * 180 / M_PI, e[0],
                         e[1], e[2]);
    }
    for (int i = 0; i < r->count; i++) {
        const ibl_output_set *b = &r->sets[i];
        for (int kind = 0; kind < IBL_OUTPUT_JSON; kind++) {
            const ibl_output *file = &b->files[kind];
            const ibl_texture *shape = &file->shape;
            char errors[64 + 16 * IBL_MAX_LEVELS];
            list_errors(file, errors, sizeof errors);
            if (file->paths)
                ibl_console_info(
                    c, "wrote %s: %s, %s, %d x %d, levels: %d%s",
                    file->paths[0], shape->faces == 6 ? "cube" : "2D",
                    ibl_baked_pixel(b->opts, shape->pixel), shape->width,
                    shape->height, shape->levels, errors);
        }
        if (b->files[IBL_OUTPUT_JSON].paths)
            log_file(c, b->files[IBL_OUTPUT_JSON].paths[0]);
        log_file(c, b->sh_path);
    }
    log_file(c, r->opts->preview);
    log_file(c, r->line->batch ? NULL : r->opts->depfile);
}

static const char *name_of(const ibl_output_set *b, ibl_output_kind kind)
{
    char **paths = b->files[kind].paths;

    return paths ? ibl_path_name(paths[0]) : NULL;
}

/* Prints the program that loads a set's files. */
static void explain(const ibl_output_set *b, bool several)
{
    const ibl_target *target = b->opts->of;
    const char *specular = name_of(b, IBL_OUTPUT_SPECULAR);
    const char *irradiance = name_of(b, IBL_OUTPUT_IRRADIANCE);
    const ibl_job *r = b->job;
    const ibl_target_files files = {
        .specular = specular ? specular : "",
        .irradiance = irradiance ? irradiance : "",
        .sh = b->sh_path ? ibl_path_name(b->sh_path) : "",
        .skybox = name_of(b, IBL_OUTPUT_SKYBOX),
        .lights = b->opts->input ? r->lights : NULL,
        .light_count = b->opts->input ? r->light_count : b->opts->lights};

    if (several)
        printf("%s: %s\n\n", target->name, target->engine);
    ibl_target_explain(target, &files, stdout);
    if (several)
        putchar('\n');
}

/* ---- the command --------------------------------------------------------- */

static int bake_one(const ibl_cmdline *line)
{
    const ibl_opts *o = line->set;
    ibl_job r = {.line = line, .print = stdout};

    ibl_console_init(&r.console, o->common.quiet, o->common.verbose);
    ibl_signals_catch();
    ibl_job_begin(&r);
    bool ok = (o->explain && !o->input) || /* which bakes nothing */
              (!ibl_start(&o->common, &r.console, &r.ctx) && ibl_job_make(&r));
    ibl_console_finish(&r.console);
    for (int i = 0; i < r.count && ok && o->explain; i++)
        explain(&r.sets[i], r.count > 1);
    ok = ok && ibl_job_commit(&r);
    const int status = ibl_console_end(&r.console, ok);
    if (ok && o->common.verbose && !o->dry_run) {
        ibl_job_log(&r);
        ibl_console_print_times(&r.console);
    }
    ibl_job_end(&r);
    ibl_ctx_free(r.ctx);
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
