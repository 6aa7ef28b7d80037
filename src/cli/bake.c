/* SPDX-License-Identifier: MIT */
/* Runs a job: begins its sets, chooses what is left open, plans the files,
 * reads the environment, bakes all that the sets need of it, writes. All files
 * of all sets appear, or none. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/batch.h"
#include "cli/candidate.h"
#include "cli/choose.h"
#include "cli/job.h"
#include "cli/rendered.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "json/text.h"

/* ---- what its sets need -------------------------------------------------- */

enum {
    MOST_AUTO = 16, /* lights that --lights auto takes */
    DIRECTIONS = 256
};
static const double gain = 0.9; /* what lights leave of the error, at most */

static void join_sets(ibl_job *r)
{
    ibl_bake_options *all = &r->need;
    int count = 0;

    *all = r->opts->bake;
    for (int i = 0; i < r->count; i++) {
        const ibl_bake_options *o = &r->sets[i].opts->bake;
        const ibl_specular_options *own = &o->specular_options;
        int c = 0;
        while (c < count && memcmp(&r->chains[c], own, sizeof *own) != 0)
            c++;
        if (o->specular && c == count)
            r->chains[count++] = *own;
        r->sets[i].chain = o->specular ? c : -1;
        all->skybox = o->skybox > all->skybox ? o->skybox : all->skybox;
        all->irradiance |= o->irradiance;
        if (o->sh_degree > all->sh_degree)
            all->sh_degree = o->sh_degree;
    }
    all->specular = count > 0;
    if (count)
        all->specular_options = r->chains[0];
    all->more = r->chains + 1;
    all->more_count = count > 1 ? count - 1 : 0;
}

/* ---- the memory that it takes ------------------------------------------ */

/* The stack and buffers of a thread. */
#define THREAD_BYTES (0.25 * (1 << 20))
/* What the C library keeps of freed blocks, and small ones. */
#define KEPT_SHARE 0.1

/* Options that need the whole map in memory. */
static const char keep_map[] =
    "lights sun verify scene preview max-error rendered-error";

/* What becomes a file, beside its texels in floats: these as RGBA while light
 * is spread, turned or decoded again, and the file itself. */
static double file_bytes(const ibl_opts *o, int size, int levels)
{
    const bool again = o->verify || o->axes.mirror || o->axes.up || o->picture;
    double texels = 0;

    for (int l = 0; l < levels; l++)
        texels += 8 * pow(ibl_cube_edge(size, l), 2); /* 6 of a cube */
    return texels * (12 + 12 * again +
                     (double)ibl_pixel_bytes(o->texels.pixel) *
                         (1 + (o->zstd > 0) + 2 * o->verify));
}

double ibl_bake_bytes(const ibl_job *r, size_t reader, int width, int height)
{
    const ibl_opts *o = r->opts;
    const double pixels = (double)width * (double)height;
    double map = 0, files = 0;
    size_t bake = 0;

    if (ibl_bake_memory(r->ctx, width, height, &r->need, &bake))
        return 0;
    if (o->lights || o->verify || o->preview || !isnan(o->rendered_error))
        map = pixels * (12 + 14 * (o->lights != 0));
    for (int i = 0; i < r->count; i++) {
        const ibl_bake_options *set = &r->sets[i].opts->bake;
        ibl_specular_layout l;
        if (set->specular &&
            !ibl_specular_layout_of(&set->specular_options, &l))
            files = fmax(files, file_bytes(r->sets[i].opts, l.size, l.levels));
        if (set->skybox)
            files = fmax(files, file_bytes(r->sets[i].opts, set->skybox, 16));
    }
    return IBL_PROGRAM_BYTES + THREAD_BYTES * ibl_ctx_threads(r->ctx) +
           (1 + KEPT_SHARE) * (map + (double)reader + (double)bake + files);
}

/* False, after a message, if that is more than --max-memory. */
static bool fits(ibl_job *r, const ibl_source *source)
{
    const ibl_opts *o = r->opts;
    const double need =
        ibl_bake_bytes(r, ibl_source_memory(source), ibl_source_width(source),
                       ibl_source_height(source));
    const char *keeps = ibl_given_of(&o->given, keep_map);
    char advice[128];

    snprintf(advice, sizeof advice,
             "ask for a smaller --size or --skybox, or scale the map down%s%s",
             keeps ? ", or leave out --" : "", keeps ? keeps : "");
    ibl_console_info(&r->console, "plans %.0f MiB of memory", need / (1 << 20));
    return need > 0 &&
           ibl_console_fits(&r->console, &o->common, o->input, need, advice);
}

/* ---- the environment --------------------------------------------------- */

/* Opens the environment. A sidecar, which has coefficients, has the hash of
 * the source too. */
static bool open_source(ibl_job *r, ibl_source **source)
{
    ibl_read_options read = r->opts->common.read;

    read.hash = r->need.sh_degree >= 0;
    ibl_console_progress(&r->console, "decode", 0);
    return !ibl_source_open(r->ctx, r->opts->input, &read, source) &&
           fits(r, *source);
}

/* Takes some lights out of the rest, which becomes that of the environment. */
static bool take_lights(ibl_job *r, int most)
{
    if (r->env.data)
        memcpy(r->rest.data, r->env.data,
               3 * sizeof *r->env.data * (size_t)r->env.width *
                   (size_t)r->env.height);
    r->light_count = 0;
    return !most ||
           !ibl_image_take_lights(r->ctx, &r->rest, r->opts->bake.yaw_deg, most,
                                  r->lights, &r->light_count);
}

/* Measures what is drawn with so many lights, unless their error is known. */
static bool measure(ibl_job *r, const ibl_opts *o, const ibl_truth *truth,
                    int lights, double *error)
{
    ibl_measured rows[2 * IBL_RENDERED_LIST];
    ibl_candidate c = {0};

    if (!isnan(error[lights]))
        return true;
    const bool ok =
        take_lights(r, lights) && ibl_candidate_bake(r->ctx, &r->rest, o, &c);
    if (ok) {
        ibl_drawn d = {.lights = r->lights, .light_count = r->light_count};
        ibl_candidate_draw(&d, &c);
        ibl_measure(truth, &d, rows);
        error[lights] =
            ibl_measured_mean(rows, truth->rows).value[IBL_FIGURE_NRMSE];
    }
    ibl_candidate_free(&c);
    return ok;
}

/*
 * Takes as few of the strongest lights as all the others together lower the
 * error of what is drawn by less than a tenth, and of these none at the end
 * that alone lowers it by less.
 */
static bool choose_lights(ibl_job *r)
{
    ibl_truth_options of = ibl_truth_options_default();
    ibl_truth truth = {0};
    ibl_opts o = *r->opts;
    double error[MOST_AUTO + 1];
    const bool quiet = r->console.quiet;

    r->console.quiet = true; /* if there are fewer */
    bool ok = take_lights(r, MOST_AUTO);
    r->console.quiet = quiet;
    if (!ok || !r->light_count)
        return ok;
    const int all = r->light_count;
    int least = 1, n = all;
    for (int k = 0; k <= all; k++)
        error[k] = NAN;
    o.only &= 1u << IBL_OUTPUT_SPECULAR | 1u << IBL_OUTPUT_LOBES;
    o.bake.irradiance = ibl_opts_want(&o, IBL_OUTPUT_LOBES);
    o.bake.irradiance_options = ibl_irradiance_options_default();
    o.bake.sh_degree = -1;
    of.directions = DIRECTIONS;
    of.geometry = o.lut.geometry;
    ok = ibl_truth_make(r->ctx, &r->env, r->opts->bake.yaw_deg, &of, &truth) &&
         measure(r, &o, &truth, 0, error) && measure(r, &o, &truth, all, error);
    if (ok && error[all] > gain * error[0])
        n = 0;
    while (ok && least < n) {
        const int k = (least + n) / 2;
        ok = measure(r, &o, &truth, k, error);
        if (error[all] > gain * error[k])
            n = k;
        else
            least = k + 1;
    }
    while (ok && n && (ok = measure(r, &o, &truth, n - 1, error)) &&
           error[n] > gain * error[n - 1])
        n--;
    ibl_truth_free(&truth);
    if (ok)
        ibl_console_info(&r->console,
                         "lights taken: %d; drawn off by %.2g %%, without any "
                         "%.2g %%",
                         n, 100 * error[n], 100 * error[0]);
    return ok && take_lights(r, n);
}

/* Reads the environment, and takes lights out of it. */
static bool read_map(ibl_job *r)
{
    const int lights = r->opts->lights;
    ibl_source *source = NULL;
    const bool ok =
        open_source(r, &source) && !ibl_source_image(source, &r->env);

    if (source)
        r->report = *ibl_source_report(source);
    ibl_source_close(source);
    r->width = r->env.width;
    r->height = r->env.height;
    if (!ok || !lights)
        return ok;
    /* The whole environment is only kept for what shows it. */
    if (!r->need.skybox && !r->opts->preview && lights > 0 &&
        isnan(r->opts->rendered_error)) {
        r->rest = r->env;
        r->env = (ibl_image){0};
    } else if (ibl_image_alloc(r->ctx, r->width, r->height, &r->rest)) {
        return false;
    }
    return lights == IBL_LIGHTS_AUTO ? choose_lights(r)
                                     : take_lights(r, lights);
}

/* Bakes the environment, or the skybox of it and all else of what lights leave
 * of it. */
static bool bake_image(ibl_job *r)
{
    const ibl_environment env = {.image = &r->env}, rest = {.image = &r->rest};
    ibl_bake_options sky = r->need, others = r->need;
    ibl_bake_result made = {0};

    if (!r->opts->lights)
        return !ibl_bake_environment(r->ctx, &env, &r->need, &r->made);
    sky.specular = sky.irradiance = sky.more_count = 0;
    sky.sh_degree = -1;
    others.skybox = 0;
    const bool ok =
        (!sky.skybox || !ibl_bake_environment(r->ctx, &env, &sky, &made)) &&
        !ibl_bake_environment(r->ctx, &rest, &others, &r->made);
    r->made.skybox = made.skybox;
    return ok;
}

/* Reads the environment, if there is one and it was not read, and bakes. */
static bool bake_sets(ibl_job *r)
{
    const ibl_opts *o = r->opts;
    double window = o->sh_window;
    ibl_source *source = NULL;
    bool ok;

    if (!o->input)
        return true;
    if (r->width || o->lights || o->verify || o->preview) { /* needs the map */
        ok = (r->width || read_map(r)) && bake_image(r);
    } else if ((ok = open_source(r, &source))) {
        const ibl_environment rows = ibl_source_environment(source);
        r->width = rows.width;
        r->height = rows.height;
        ok = !ibl_bake_environment(r->ctx, &rows, &r->need, &r->made);
        r->report = *ibl_source_report(source);
    }
    ibl_source_close(source);
    if (!ok || !r->made.sh || window >= HUGE_VAL)
        return ok;
    if (!(window > 0))
        window = ibl_sh_widest_window(r->made.sh);
    ibl_sh_window(r->need.sh_degree, window, r->made.sh);
    ibl_console_info(&r->console, "harmonics in a window of %.4g", window);
    return true;
}

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
    join_sets(r);
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
    if (scenes && !ibl_scenes_materials(scenes, &materials)) {
        b->choice->usual_bytes = b->choice->bytes = ibl_candidate_bytes(o);
        ibl_choice_add(b->choice, true, "outputs",
                       "as usual\tnothing reflects");
    } else if (!ibl_choose(r, &materials, o, b->choice)) {
        return false;
    }
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
    ok = ok && read_map(r);
    for (int i = 0; i < count && ok; i++) {
        ok = choose(r, &r->sets[i]);
        if (ok && count > 1)
            printf("%s%s\n", i ? "\n" : "", r->sets[i].opts->of->name);
        if (ok)
            ibl_choice_print(r->sets[i].choice, stdout);
    }
    join_sets(r);
    return ok;
}

/* ---- from the environment to the files ----------------------------------- */

bool ibl_job_make(ibl_job *r)
{
    const ibl_opts *o = r->opts;
    bool ok = decide(r);

    if (!ok || o->dry_run)
        return ok;
    ok = !ibl_outputs_create(r->ctx, o->sync, &r->outputs);
    for (int i = 0; i < r->count && ok; i++)
        ok = !ibl_outputs_mkdir(r->outputs, r->sets[i].root) &&
             !ibl_outputs_mkdir(r->outputs, r->sets[i].directory);
    ok = ok && ibl_job_plan(r) && bake_sets(r);
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
        json_decref(b->judged.json);
        if (b->choice)
            free(b->choice->table);
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

/* "FILE: cube, rgba16f, 256 x 256, levels: 2, off by the format 0.013 0.011 %",
 * the nRMSE of each level. */
static void log_texture(ibl_console *c, const ibl_output *file,
                        const ibl_opts *o)
{
    const ibl_texture *shape = &file->shape;
    char *text = NULL;
    double most = 0;

    ibl_append(&text, "%s: %s, %s, %d x %d, levels: %d", file->paths[0],
               shape->faces == 6 ? "cube" : "2D",
               ibl_baked_pixel(o, shape->pixel), shape->width, shape->height,
               shape->levels);
    for (int l = 0; l < shape->levels; l++)
        most = fmax(most, file->error[l].nrmse);
    for (int l = 0; l < shape->levels && most > 0; l++)
        ibl_append(&text, "%s %.2g", l ? "" : ", off by the format",
                   100 * file->error[l].nrmse);
    ibl_console_info(c, "wrote %s%s", text, most > 0 ? " %" : "");
    free(text);
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
        for (int kind = 0; kind < IBL_OUTPUT_JSON; kind++)
            if (b->files[kind].paths)
                log_texture(c, &b->files[kind], b->opts);
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

    return paths ? ibl_path_name(paths[0]) : "";
}

/* Prints the program that loads a set's files. */
static void explain(const ibl_output_set *b, bool several)
{
    const ibl_target *target = b->opts->of;
    const ibl_job *r = b->job;
    const ibl_target_files files = {
        .specular = name_of(b, IBL_OUTPUT_SPECULAR),
        .irradiance = name_of(b, IBL_OUTPUT_IRRADIANCE),
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
    ibl_job r = {.line = line};

    ibl_console_init(&r.console, o->common.quiet, o->common.verbose);
    ibl_job_begin(&r);
    bool ok = (o->explain && !o->input) || /* which bakes nothing */
              (!ibl_start(&o->common, &r.console, &r.ctx) && ibl_job_make(&r));
    ibl_console_finish(&r.console);
    for (int i = 0; i < r.count && ok && o->explain; i++)
        explain(&r.sets[i], r.count > 1);
    ok = ok && ibl_job_commit(&r);
    if (ok && o->common.verbose && !o->dry_run)
        ibl_job_log(&r);
    const int status = ibl_console_end(&r.console, ok);
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
