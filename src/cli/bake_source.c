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

/* The index of the chain with these options, added if it is new. */
static int take_chain(ibl_bake_source *s, const ibl_specular_options *o)
{
    int i = 0;

    while (i < s->chain_count && memcmp(&s->chains[i], o, sizeof *o) != 0)
        i++;
    if (i == s->chain_count)
        s->chains[s->chain_count++] = *o;
    return i;
}

void ibl_bake_source_add(ibl_bake_source *s, ibl_output_set *set)
{
    const ibl_bake_options *o = &set->opts->bake;
    ibl_bake_options *all = &s->bake;

    set->chain = o->specular ? take_chain(s, &o->specular_options) : -1;
    all->skybox = o->skybox > all->skybox ? o->skybox : all->skybox;
    all->irradiance |= o->irradiance;
    if (o->sh_degree > all->sh_degree)
        all->sh_degree = o->sh_degree;
}

/* Moves the environment to the rest, or makes room for it beside what shows all
 * of it. */
static bool make_rest(ibl_bake_source *s)
{
    const ibl_image *env = &s->env;

    if (!s->bake.skybox && !s->opts->preview && s->opts->lights > 0 &&
        isnan(s->opts->rendered_error)) {
        s->rest = *env;
        s->env = (ibl_image){0};
        return true;
    }
    return !ibl_image_alloc(s->ctx, env->width, env->height, &s->rest);
}

static bool bake_skybox(ibl_bake_source *s, ibl_cube *skybox)
{
    const ibl_environment all = {.image = &s->env};
    ibl_bake_options alone = ibl_bake_options_default();
    ibl_bake_result made = {0};

    if (!s->bake.skybox)
        return true;
    alone.skybox = s->bake.skybox;
    alone.skybox_projection = s->bake.skybox_projection;
    alone.specular = alone.irradiance = 0;
    alone.sh_degree = -1;
    alone.yaw_deg = s->bake.yaw_deg;
    const bool ok = !ibl_bake_environment(s->ctx, &all, &alone, &made);
    *skybox = made.skybox;
    return ok;
}

/* The skybox of the environment, all else of what lights leave of it. */
static bool bake_without_lights(ibl_bake_source *s)
{
    const ibl_environment rest = {.image = &s->rest};
    ibl_bake_options others = s->bake;
    ibl_cube skybox = {0};

    others.skybox = 0;
    const bool ok = bake_skybox(s, &skybox) &&
                    !ibl_bake_environment(s->ctx, &rest, &others, &s->made);
    s->made.skybox = skybox;
    return ok;
}

/* A sidecar, which has coefficients, has the hash of the source too. */
static ibl_read_options read_options(const ibl_bake_source *s)
{
    ibl_read_options read = s->opts->common.read;

    read.hash = s->bake.sh_degree >= 0;
    return read;
}

static bool fits(const ibl_bake_source *s, const ibl_source *source)
{
    return ibl_bake_fits(s->run, ibl_source_memory(source),
                         ibl_source_width(source), ibl_source_height(source));
}

static bool read_image(ibl_bake_source *s, const ibl_read_options *read)
{
    ibl_source *source = NULL;

    if (ibl_source_open(s->ctx, s->opts->input, read, &source))
        return false;
    const bool ok = fits(s, source) && !ibl_source_image(source, &s->env);
    s->report = *ibl_source_report(source);
    ibl_source_close(source);
    return ok;
}

/* Takes some lights out of the rest, which becomes that of the environment. */
static bool take_lights(ibl_bake_source *s, int most)
{
    if (s->env.data)
        memcpy(s->rest.data, s->env.data,
               3 * sizeof *s->env.data * (size_t)s->env.width *
                   (size_t)s->env.height);
    s->light_count = 0;
    return !most || !ibl_image_take_lights(s->ctx, &s->rest, s->bake.yaw_deg,
                                           most, s->lights, &s->light_count);
}

/* Measures what is drawn with so many lights, unless their error is known. */
static bool measure(ibl_bake_source *s, const ibl_opts *o,
                    const ibl_truth *truth, int lights, double *error)
{
    ibl_measured rows[2 * IBL_RENDERED_LIST];
    ibl_candidate c = {0};

    if (!isnan(error[lights]))
        return true;
    const bool ok =
        take_lights(s, lights) && !ibl_candidate_bake(s->ctx, &s->rest, o, &c);
    if (ok) {
        ibl_drawn d = {.lights = s->lights, .light_count = s->light_count};
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
static bool choose_lights(ibl_bake_source *s)
{
    ibl_truth_options of = ibl_truth_options_default();
    ibl_truth truth = {0};
    ibl_opts o = *s->opts;
    double error[MOST_AUTO + 1];
    const bool quiet = s->console->quiet;

    s->console->quiet = true; /* if there are fewer */
    bool ok = take_lights(s, MOST_AUTO);
    s->console->quiet = quiet;
    if (!ok || !s->light_count)
        return ok;
    const int all = s->light_count;
    int least = 1, n = all;
    for (int k = 0; k <= all; k++)
        error[k] = NAN;
    o.only &= 1u << IBL_OUTPUT_SPECULAR | 1u << IBL_OUTPUT_LOBES;
    o.bake.irradiance = ibl_opts_want(&o, IBL_OUTPUT_LOBES);
    o.bake.irradiance_options = ibl_irradiance_options_default();
    o.bake.sh_degree = -1;
    of.directions = DIRECTIONS;
    of.geometry = o.lut.geometry;
    ok = ibl_truth_make(s->ctx, &s->env, s->bake.yaw_deg, &of, &truth) &&
         measure(s, &o, &truth, 0, error) && measure(s, &o, &truth, all, error);
    if (ok && error[all] > gain * error[0])
        n = 0;
    while (ok && least < n) {
        const int k = (least + n) / 2;
        ok = measure(s, &o, &truth, k, error);
        if (error[all] > gain * error[k])
            n = k;
        else
            least = k + 1;
    }
    while (ok && n && (ok = measure(s, &o, &truth, n - 1, error)) &&
           error[n] > gain * error[n - 1])
        n--;
    ibl_truth_free(&truth);
    if (ok)
        ibl_console_info(s->console,
                         "lights taken: %d; drawn off by %.2g %%, without any "
                         "%.2g %%",
                         n, 100 * error[n], 100 * error[0]);
    return ok && take_lights(s, n);
}

bool ibl_bake_source_read(ibl_bake_source *s)
{
    const ibl_read_options read = read_options(s);

    ibl_console_progress(s->console, "decode", 0);
    if (!read_image(s, &read))
        return false;
    s->width = s->env.width;
    s->height = s->env.height;
    if (!s->opts->lights)
        return true;
    return make_rest(s) && (s->opts->lights == IBL_LIGHTS_AUTO
                                ? choose_lights(s)
                                : take_lights(s, s->opts->lights));
}

/* Keeps the map in memory, for lights, --verify, --preview and the choice. */
static bool bake_image(ibl_bake_source *s)
{
    const ibl_environment rows = {.image = &s->env};

    if (!s->width && !ibl_bake_source_read(s))
        return false;
    if (s->opts->lights)
        return bake_without_lights(s);
    return !ibl_bake_environment(s->ctx, &rows, &s->bake, &s->made);
}

static bool bake_source(ibl_bake_source *s)
{
    const ibl_read_options read = read_options(s);
    ibl_source *source = NULL;

    if (ibl_source_open(s->ctx, s->opts->input, &read, &source))
        return false;
    const ibl_environment rows = ibl_source_environment(source);
    s->width = rows.width;
    s->height = rows.height;
    const bool ok = fits(s, source) &&
                    !ibl_bake_environment(s->ctx, &rows, &s->bake, &s->made);
    s->report = *ibl_source_report(source);
    ibl_source_close(source);
    return ok;
}

/* As --sh-window says. */
static void window_harmonics(ibl_bake_source *s)
{
    const int degree = s->bake.sh_degree;
    double window = s->opts->sh_window;

    if (!s->made.sh || window >= HUGE_VAL)
        return;
    if (!(window > 0))
        window = ibl_sh_widest_window(s->made.sh);
    ibl_sh_window(degree, window, s->made.sh);
    ibl_console_info(s->console, "harmonics in a window of %.4g", window);
}

bool ibl_bake_source_make(ibl_bake_source *s)
{
    bool ok;

    if (!s->opts->input)
        return true;
    s->bake.specular = s->chain_count > 0;
    if (s->chain_count)
        s->bake.specular_options = s->chains[0];
    s->bake.more = s->chains + 1;
    s->bake.more_count = s->chain_count > 1 ? s->chain_count - 1 : 0;
    ibl_console_progress(s->console, "decode", 0);
    ok = s->width || s->opts->lights || s->opts->verify || s->opts->preview
             ? bake_image(s)
             : bake_source(s);
    if (ok)
        window_harmonics(s);
    return ok;
}

void ibl_bake_source_free(ibl_bake_source *s)
{
    ibl_judge_free(s->judge[0]);
    ibl_judge_free(s->judge[1]);
    ibl_image_free(&s->env);
    ibl_image_free(&s->rest);
    ibl_bake_result_free(&s->made);
}
