/* SPDX-License-Identifier: MIT */
/* Runs a job: begins its sets, chooses what is left open, plans the files,
 * bakes the source, writes. All files of all sets appear, or none. */
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

bool ibl_job_names(ibl_job *r)
{
    bool ok = true;

    for (int i = 0; i < r->count && ok; i++)
        ok = ibl_set_name_files(&r->sets[i]);
    return ok;
}

/* ---- what is left open --------------------------------------------------- */

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
    bool ok = r->choices && (!r->opts->scenes.count || read_scenes(r)) &&
              ibl_bake_source_read(&r->from);
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

/* ---- its files ----------------------------------------------------------- */

static bool start(ibl_job *r)
{
    bool ok = !ibl_outputs_create(r->from.ctx, r->opts->sync, &r->outputs);

    for (int i = 0; i < r->count && ok; i++) {
        r->sets[i].ctx = r->from.ctx;
        r->sets[i].outputs = r->outputs;
        ok = !ibl_outputs_mkdir(r->outputs, r->sets[i].root) &&
             !ibl_outputs_mkdir(r->outputs, r->sets[i].directory);
    }
    return ok;
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

/* Writes all files, but does not yet give them their names. */
static bool write_sets(ibl_job *r)
{
    bool ok = true;

    for (int i = 0; i < r->count && ok; i++) {
        take_part(&r->sets[i]);
        ok = ibl_set_write(&r->sets[i]);
    }
    return ok && (!r->opts->depfile || r->line->batch ||
                  ibl_set_write_text(r->sets, r->opts->depfile,
                                     ibl_depfile_text(r->sets, r->count),
                                     "the depfile"));
}

/* ---- from the environment to the files ----------------------------------- */

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

static void free_set(ibl_output_set *b)
{
    json_decref(b->judged.json);
    ibl_choice_free(b->choice);
    if (!ibl_set_takes(b, IBL_OUTPUT_LUT))
        ibl_lut_free(&b->lut);
    if (!ibl_set_takes(b, IBL_OUTPUT_LOBES))
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
    ibl_outputs_free(r->outputs);
    for (int i = 0; i < r->count && r->sets; i++)
        free_set(&r->sets[i]);
    free(r->sets);
    free(r->choices);
    ibl_scenes_free(r->from.scenes);
    ibl_bake_source_free(&r->from);
}

/* ---- what is said of it -------------------------------------------------- */

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

/* ---- the command --------------------------------------------------------- */

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
