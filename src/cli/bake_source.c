/* SPDX-License-Identifier: MIT */
/* Reads the environment and bakes all that the sets of files need of it. */
#include <math.h>
#include <string.h>

#include "cli/candidate.h"
#include "cli/job.h"
#include "cli/rendered.h"

enum {
    MOST_AUTO = 16, /* lights that --lights auto takes */
    DIRECTIONS = 256
};
static const double gain = 0.9; /* what lights leave of the error, at most */

/* What all sets need. Their chains of levels, all different: the first is in
 * the result, the others are its `more`. */
static ibl_bake_options join_sets(const ibl_job *r,
                                  ibl_specular_options chains[IBL_MAX_TARGETS])
{
    ibl_bake_options all = r->opts->bake;
    int count = 0;

    for (int i = 0; i < r->count; i++) {
        const ibl_bake_options *o = &r->sets[i].opts->bake;
        const ibl_specular_options *own = &o->specular_options;
        int c = 0;
        while (c < count && memcmp(&chains[c], own, sizeof *own) != 0)
            c++;
        if (o->specular && c == count)
            chains[count++] = *own;
        r->sets[i].chain = o->specular ? c : -1;
        all.skybox = o->skybox > all.skybox ? o->skybox : all.skybox;
        all.irradiance |= o->irradiance;
        if (o->sh_degree > all.sh_degree)
            all.sh_degree = o->sh_degree;
    }
    all.specular = count > 0;
    if (count)
        all.specular_options = chains[0];
    all.more = chains + 1;
    all.more_count = count > 1 ? count - 1 : 0;
    return all;
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
    const bool chooses =
        !isnan(o->rendered_error) || o->lights == IBL_LIGHTS_AUTO;
    ibl_specular_options chains[IBL_MAX_TARGETS];
    const ibl_bake_options all = join_sets(r, chains);
    double map = 0, files = 0;
    size_t bake = 0;

    if (ibl_bake_memory(r->ctx, width, height, &all, &bake))
        return 0;
    if (o->lights || o->verify || o->preview || chooses)
        map = pixels * (12 + 14 * (o->lights != 0) + 4 * chooses);
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
    const double mib = 1 << 20, most = (double)ibl_memory_most(&o->common);
    const double need =
        ibl_bake_bytes(r, ibl_source_memory(source), ibl_source_width(source),
                       ibl_source_height(source));
    const char *keeps = ibl_given_of(&o->given, keep_map);

    ibl_console_info(&r->console, "plans %.0f MiB of memory", need / mib);
    if (!(need > 0))
        return false;
    return most <= 0 || need <= most ||
           ibl_console_fail(&r->console,
                            "%s: takes %.0f MiB of memory, more than the %.0f "
                            "of --max-memory: ask for a smaller --size or "
                            "--skybox, or scale the map down%s%s",
                            o->input, ceil(need / mib), floor(most / mib),
                            keeps ? ", or leave out --" : "",
                            keeps ? keeps : "");
}

/* ---- the environment --------------------------------------------------- */

/* Opens the environment. A sidecar, which has coefficients, has the hash of
 * the source too. */
static bool open_source(ibl_job *r, const ibl_bake_options *all,
                        ibl_source **source)
{
    ibl_read_options read = r->opts->common.read;

    read.hash = all->sh_degree >= 0;
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
        take_lights(r, lights) && !ibl_candidate_bake(r->ctx, &r->rest, o, &c);
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

bool ibl_job_read(ibl_job *r)
{
    ibl_specular_options chains[IBL_MAX_TARGETS];
    const ibl_bake_options all = join_sets(r, chains);
    const int lights = r->opts->lights;
    ibl_source *source = NULL;
    const bool ok =
        open_source(r, &all, &source) && !ibl_source_image(source, &r->env);

    if (source)
        r->report = *ibl_source_report(source);
    ibl_source_close(source);
    r->width = r->env.width;
    r->height = r->env.height;
    if (!ok || !lights)
        return ok;
    /* The whole environment is only kept for what shows it. */
    if (!all.skybox && !r->opts->preview && lights > 0 &&
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
static bool bake_image(ibl_job *r, const ibl_bake_options *all)
{
    const ibl_environment env = {.image = &r->env}, rest = {.image = &r->rest};
    ibl_bake_options sky = *all, others = *all;
    ibl_bake_result made = {0};

    if (!r->opts->lights)
        return !ibl_bake_environment(r->ctx, &env, all, &r->made);
    sky.specular = sky.irradiance = sky.more_count = 0;
    sky.sh_degree = -1;
    others.skybox = 0;
    const bool ok =
        (!sky.skybox || !ibl_bake_environment(r->ctx, &env, &sky, &made)) &&
        !ibl_bake_environment(r->ctx, &rest, &others, &r->made);
    r->made.skybox = made.skybox;
    return ok;
}

static bool bake_source(ibl_job *r, const ibl_bake_options *all)
{
    ibl_source *source = NULL;
    bool ok = open_source(r, all, &source);

    if (ok) {
        const ibl_environment rows = ibl_source_environment(source);
        r->width = rows.width;
        r->height = rows.height;
        ok = !ibl_bake_environment(r->ctx, &rows, all, &r->made);
        r->report = *ibl_source_report(source);
    }
    ibl_source_close(source);
    return ok;
}

bool ibl_job_bake(ibl_job *r)
{
    const ibl_opts *o = r->opts;
    ibl_specular_options chains[IBL_MAX_TARGETS];
    const ibl_bake_options all = join_sets(r, chains);
    double window = o->sh_window;
    bool ok;

    if (!o->input)
        return true;
    if (r->width || o->lights || o->verify || o->preview) /* needs the map */
        ok = (r->width || ibl_job_read(r)) && bake_image(r, &all);
    else
        ok = bake_source(r, &all);
    if (!ok || !r->made.sh || window >= HUGE_VAL)
        return ok;
    if (!(window > 0))
        window = ibl_sh_widest_window(r->made.sh);
    ibl_sh_window(all.sh_degree, window, r->made.sh);
    ibl_console_info(&r->console, "harmonics in a window of %.4g", window);
    return true;
}
