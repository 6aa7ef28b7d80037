/* SPDX-License-Identifier: MIT */
/* Reads the environment and bakes all that the sets of files need of it. */
#include <math.h>
#include <string.h>

#include "cli/bake_record.h"

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

void ibl_bake_source_add(ibl_bake_source *s, ibl_bake *set)
{
    const ibl_bake_options *o = &set->opts->bake;
    ibl_bake_options *all = &s->bake;

    set->chain = o->specular ? take_chain(s, &o->specular_options) : -1;
    all->skybox = o->skybox > all->skybox ? o->skybox : all->skybox;
    all->irradiance |= o->irradiance;
    if (o->sh_degree > all->sh_degree)
        all->sh_degree = o->sh_degree;
}

/* Moves the environment to the rest, or copies it for what shows all of it. */
static bool copy_environment(ibl_bake_source *s)
{
    const ibl_image *env = &s->env;

    if (!s->bake.skybox && !s->opts->preview &&
        isnan(s->opts->rendered_error)) {
        s->rest = *env;
        s->env = (ibl_image){0};
        return true;
    }
    if (ibl_image_alloc(s->ctx, env->width, env->height, &s->rest))
        return false;
    memcpy(s->rest.data, env->data,
           3 * sizeof *env->data * (size_t)env->width * (size_t)env->height);
    return true;
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

bool ibl_bake_source_read(ibl_bake_source *s)
{
    const ibl_read_options read = read_options(s);

    ibl_console_progress(s->console, "decode", 0);
    if (!read_image(s, &read))
        return false;
    s->width = s->env.width;
    s->height = s->env.height;
    return !s->opts->lights ||
           (copy_environment(s) &&
            !ibl_image_take_lights(s->ctx, &s->rest, s->bake.yaw_deg,
                                   s->opts->lights, s->lights,
                                   &s->light_count));
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

bool ibl_bake_source_make(ibl_bake_source *s)
{
    if (!s->opts->input)
        return true;
    s->bake.specular = s->chain_count > 0;
    if (s->chain_count)
        s->bake.specular_options = s->chains[0];
    s->bake.more = s->chains + 1;
    s->bake.more_count = s->chain_count > 1 ? s->chain_count - 1 : 0;
    ibl_console_progress(s->console, "decode", 0);
    return s->width || s->opts->lights || s->opts->verify || s->opts->preview
               ? bake_image(s)
               : bake_source(s);
}

void ibl_bake_source_free(ibl_bake_source *s)
{
    ibl_judge_free(s->judge[0]);
    ibl_judge_free(s->judge[1]);
    ibl_image_free(&s->env);
    ibl_image_free(&s->rest);
    ibl_bake_result_free(&s->made);
}
