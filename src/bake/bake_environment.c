/* SPDX-License-Identifier: MIT */
/*
 * The driver of a bake. It reads the environment once and gives each batch of
 * rows to level 0, the sky and the spectral analysis. It keeps the whole map
 * only if samples need it.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bake/options.h"
#include "bake/sampled.h"
#include "bake/spectral/engine.h"
#include "bake/spectral/plan.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"
#include "image/level0.h"

enum {
    GROUP = 2 * IBL_ROW_GROUP,
    BATCH_BYTES = 1 << 20, /* least size of a batch: about a core's cache */
    MOST_BYTES = 16 << 20  /* largest size of a batch, for many threads */
};

/* A specular chain in progress. */
typedef struct chain {
    const ibl_specular_options *opts; /* of the yaws, only the bake's counts */
    const ibl_cube *given;            /* its level 0, or NULL */
    int degree[IBL_MAX_LEVELS];       /* of spectral levels, the most */
    ibl_specular_layout layout;
    ibl_level0 *level0;
    ibl_cube *cube; /* the result's */
    ibl_specular_report *report;
} chain;

/* A bake in progress. */
typedef struct bake {
    ibl_ctx *ctx;
    const ibl_environment *env;
    const ibl_bake_options *opts; /* in range */
    ibl_spectral_plan plan;
    chain *chains;
    int chain_count;
    ibl_image own;          /* the map, if it was read as a whole */
    const ibl_image *image; /* the whole map, or NULL */
    float *rows;            /* without image: two batches of rows, by turns */
    ibl_level0 *sky;
    ibl_spectral *spectral;
    ibl_bake_result *out;
} bake;

void ibl_bake_result_free(ibl_bake_result *r)
{
    if (!r)
        return;
    ibl_cube_free(&r->skybox);
    ibl_cube_free(&r->specular);
    ibl_cube_free(&r->irradiance);
    for (int i = 0; i < r->more_count; i++)
        ibl_cube_free(&r->more[i]);
    ibl_free(r->more);
    ibl_free(r->more_report);
    ibl_free(r->sh);
    *r = (ibl_bake_result){0};
}

static bool has_flat_sky(const bake *b)
{
    return b->opts->skybox && b->opts->skybox_projection != IBL_PROJECTION_CUBE;
}

static bool needs_flat_level0(const chain *c)
{
    return c->layout.roughness[0] <= 0 &&
           c->opts->projection != IBL_PROJECTION_CUBE;
}

static bool is_spectral(const chain *c, int level)
{
    return c->opts->method == IBL_METHOD_SPECTRAL &&
           c->layout.roughness[level] > 0;
}

/* Whether two levels have the same texels. */
static bool are_same(const chain *a, int i, const chain *b, int j)
{
    const double r = a->layout.roughness[i], s = b->layout.roughness[j];

    if (ibl_cube_edge(a->layout.size, i) != ibl_cube_edge(b->layout.size, j) ||
        a->opts->projection != b->opts->projection || a->given || b->given)
        return false;
    if (r <= 0 || s <= 0)
        return r <= 0 && s <= 0;
    return is_spectral(a, i) && is_spectral(b, j) && r <= s && s <= r &&
           a->opts->lobe == b->opts->lobe &&
           a->opts->tolerance <= b->opts->tolerance &&
           b->opts->tolerance <= a->opts->tolerance;
}

/* The first chain that has a level of this one, at *level; NULL: none. */
static const chain *find_same(const bake *b, const chain *c, int *level)
{
    const int own = *level;

    for (const chain *from = b->chains; from < c; from++)
        for (int l = 0; l < from->layout.levels; l++)
            if (are_same(from, l, c, own)) {
                *level = l;
                return from;
            }
    return NULL;
}

static bool is_copied(const bake *b, const chain *c, int level)
{
    return find_same(b, c, &level);
}

/* ---- before anything is read ------------------------------------------- */

/* Logs the layout if the range of roughness is only a part. */
static void log_layout(const bake *b, const chain *c)
{
    const ibl_specular_options *o = c->opts;
    if (o->roughness_min > 0 || o->roughness_max < 1)
        ibl_info(b->ctx,
                 "specular: roughness %g to %g alone, %d level%s from %d "
                 "texels; a whole chain has %d from %d",
                 o->roughness_min, o->roughness_max, c->layout.levels,
                 c->layout.levels == 1 ? "" : "s", c->layout.size,
                 ibl_default_levels(o->size), o->size);
}

/* Lists the chains: that of the options, if any, and the others. */
static ibl_status list_chains(bake *b)
{
    const ibl_bake_options *o = b->opts;
    const int more = o->more_count, first = o->specular ? 1 : 0;
    const size_t count = (size_t)more;

    if (more) {
        b->out->more = ibl_alloc_zeroed(count, sizeof *b->out->more);
        b->out->more_report =
            ibl_alloc_zeroed(count, sizeof *b->out->more_report);
        b->out->more_count = b->out->more ? more : 0;
    }
    b->chains = ibl_alloc_zeroed(count + 1, sizeof *b->chains);
    if (!b->chains || (more && (!b->out->more || !b->out->more_report)))
        return ibl_no_memory(b->ctx, "the specular chains");
    if (first)
        b->chains[0] = (chain){.opts = &o->specular_options,
                               .given = o->level0,
                               .cube = &b->out->specular,
                               .report = &b->out->report};
    for (int i = 0; i < more; i++)
        b->chains[first + i] = (chain){.opts = &o->more[i],
                                       .cube = &b->out->more[i],
                                       .report = &b->out->more_report[i]};
    b->chain_count = first + more;
    return IBL_OK;
}

static ibl_status prepare_chain(const bake *b, chain *c)
{
    const ibl_specular_options *o = c->opts;
    /* Without a layout ibl_cube_alloc fails and reports why. */
    if (ibl_specular_layout_of(o, &c->layout))
        c->layout.size = o->size, c->layout.levels = o->levels;
    const ibl_status status = ibl_cube_alloc_as(
        b->ctx, o->projection, c->layout.size, c->layout.levels, c->cube);
    if (status)
        return status;
    c->report->layout = c->layout;
    for (int l = 0; l < c->layout.levels; l++)
        c->report->level[l].error = -1;
    log_layout(b, c);
    if (c->layout.roughness[0] > 0 || o->projection != IBL_PROJECTION_CUBE ||
        is_copied(b, c, 0))
        return IBL_OK;
    if (!c->given)
        return ibl_level0_create(b->ctx, b->env->width, b->env->height,
                                 b->opts->yaw_deg, c->cube, &c->level0);
    memcpy(c->cube->data, c->given->data,
           3 * sizeof(float) * ibl_cube_texels(c->layout.size, 1));
    return IBL_OK;
}

static ibl_status prepare_sky(bake *b)
{
    const ibl_projection projection = b->opts->skybox_projection;
    const int size = b->opts->skybox, even = size & -size; /* what halves it */
    const bool flat = projection != IBL_PROJECTION_CUBE;
    const ibl_status status = ibl_cube_alloc_as(
        b->ctx, projection, size, ibl_cube_most_levels(flat ? even : size),
        &b->out->skybox);
    if (status || flat)
        return status;
    return ibl_level0_create(b->ctx, b->env->width, b->env->height,
                             b->opts->yaw_deg, &b->out->skybox, &b->sky);
}

static ibl_status prepare(bake *b)
{
    ibl_status status = list_chains(b);
    for (int i = 0; i < b->chain_count && !status; i++)
        status = prepare_chain(b, &b->chains[i]);
    if (!status && b->opts->skybox)
        status = prepare_sky(b);
    if (!status)
        status = ibl_spectral_plan_make(b->ctx, b->opts, &b->plan);
    for (int i = 0; i < b->chain_count && !status; i++)
        status = ibl_spectral_plan_chain(b->ctx, b->chains[i].opts,
                                         &b->chains[i].layout,
                                         b->chains[i].degree, &b->plan);
    if (!status && b->plan.degree >= 0)
        status = ibl_spectral_create(b->ctx, b->env->width, b->env->height,
                                     b->opts->yaw_deg, b->plan.degree,
                                     b->plan.single, &b->spectral);
    return status;
}

/* ---- reading ----------------------------------------------------------- */

/* Reads the next rows; the first of them is `row`. */
static ibl_status read_rows(const bake *b, int row, int rows, float *rgb)
{
    const double height = b->env->height;
    ibl_progress(b->ctx, "decode", row / height);
    const ibl_status status = b->env->read(b->env->cookie, rows, rgb);
    if (!status)
        ibl_progress(b->ctx, "decode", (row + rows) / height);
    return status;
}

/* Starts the jobs for these rows after those of the previous call have ended.
 * rgb must stay valid until the next call returns. */
static ibl_status give_rows(bake *b, int rows, const float *rgb)
{
    ibl_status status = ibl_run_end(b->ctx);
    for (int i = 0; i < b->chain_count && !status; i++)
        if (b->chains[i].level0)
            status = ibl_level0_add(b->chains[i].level0, rows, rgb);
    if (!status && b->sky)
        status = ibl_level0_add(b->sky, rows, rgb);
    if (!status && b->spectral)
        ibl_spectral_add(b->spectral, rows, rgb);
    return status;
}

/* Rows in a batch: whole groups, one for each thread in two batches if
 * MOST_BYTES allows it. The results do not depend on this number. */
static int batch_rows(const bake *b)
{
    const int threads = ibl_ctx_threads(b->ctx);
    const size_t row = 3 * sizeof(float) * (size_t)b->env->width;
    const int fit = (int)(BATCH_BYTES / row) / GROUP;
    const int most = (int)(MOST_BYTES / row) / GROUP;
    int groups = (threads + 1) / 2;
    if (groups > most)
        groups = most > 1 ? most : 1;
    return GROUP * (fit > groups ? fit : groups);
}

static ibl_status keep_whole(bake *b)
{
    ibl_status status =
        ibl_image_alloc(b->ctx, b->env->width, b->env->height, &b->own);
    if (!status)
        status = read_rows(b, 0, b->env->height, b->own.data);
    if (!status)
        b->image = &b->own;
    return status;
}

static ibl_status feed(bake *b)
{
    const int height = b->env->height, batch = batch_rows(b);
    const size_t row = 3 * (size_t)b->env->width;
    ibl_status status = IBL_OK;

    if (!b->image) {
        const int most = 2 * batch < height ? 2 * batch : height;
        b->rows = ibl_alloc_array(row * (size_t)most, sizeof *b->rows);
        if (!b->rows)
            return ibl_no_memory(b->ctx, "rows of the environment");
    }
    for (int done = 0; done < height && !status; done += batch) {
        const int rows = batch < height - done ? batch : height - done;
        const int turn = done / batch % 2 * batch;
        float *rgb = b->rows ? b->rows + row * (size_t)turn : NULL;
        const float *from = rgb ? rgb : b->image->data + row * (size_t)done;
        if (rgb)
            status = read_rows(b, done, rows, rgb);
        if (!status)
            status = give_rows(b, rows, from);
    }
    const ibl_status ended = ibl_run_end(b->ctx);
    return status ? status : ended;
}

/* Fills flat levels of the environment itself. */
static ibl_status make_flat(const bake *b)
{
    const ibl_cube *sky = &b->out->skybox;
    ibl_status status = IBL_OK;

    for (int i = 0; i < b->chain_count && !status; i++) {
        ibl_cube first = *b->chains[i].cube;
        first.levels = 1;
        if (needs_flat_level0(&b->chains[i]) && !is_copied(b, &b->chains[i], 0))
            status = ibl_flat_from_latlong(b->ctx, b->image, b->opts->yaw_deg,
                                           &first);
    }
    if (!status && has_flat_sky(b))
        status = ibl_flat_from_latlong(b->ctx, b->image, b->opts->yaw_deg, sky);
    return status;
}

static bool needs_whole(const bake *b)
{
    bool whole = b->plan.whole || has_flat_sky(b);
    for (int i = 0; i < b->chain_count; i++)
        whole |= needs_flat_level0(&b->chains[i]);
    return whole;
}

/* Ends the cubes of the environment itself. */
static ibl_status finish_cubes(bake *b)
{
    bool any = b->sky != NULL;
    ibl_status status = IBL_OK;

    for (int i = 0; i < b->chain_count && !status; i++) {
        any |= b->chains[i].level0 != NULL;
        if (b->chains[i].level0)
            status = ibl_level0_finish(b->chains[i].level0);
    }
    if (!status && b->sky)
        status = ibl_level0_finish(b->sky);
    if (!status)
        status = make_flat(b);
    if (!status && any)
        ibl_progress(b->ctx, "level 0", 1);
    return status;
}

static void free_cubes(bake *b)
{
    for (int i = 0; i < b->chain_count; i++) {
        ibl_level0_free(b->chains[i].level0);
        b->chains[i].level0 = NULL;
    }
    ibl_level0_free(b->sky);
    b->sky = NULL;
}

static ibl_status read_all(bake *b)
{
    ibl_status status = IBL_OK;
    b->image = b->env->image;
    if (!b->image && needs_whole(b))
        status = keep_whole(b);
    if (!status)
        status = feed(b);
    if (!status)
        status = finish_cubes(b);
    free_cubes(b);
    ibl_free(b->rows);
    if (!status && b->spectral)
        status = ibl_spectral_finish(b->spectral);
    return status;
}

/* ---- outputs --------------------------------------------------------------
 */

static ibl_status spectral_level(const bake *b, const chain *c, int level)
{
    const double tolerance = c->opts->tolerance;
    const double r = c->layout.roughness[level];
    const ibl_lobe_shape shape = ibl_lobe_shape_of(c->opts->lobe, r * r);
    const ibl_spectral_target target = {.shape = &shape,
                                        .most = c->degree[level],
                                        .tolerance = tolerance,
                                        .cube = c->cube,
                                        .level = level};
    ibl_specular_level *made = &c->report->level[level];
    char stage[32];
    snprintf(stage, sizeof stage, "specular %d", level);
    const ibl_status status = ibl_spectral_bake(b->spectral, stage, &target,
                                                &made->degree, &made->error);
    if (!status && tolerance > IBL_TOLERANCE_DEFAULT && made->error > tolerance)
        ibl_warn(b->ctx,
                 "specular level %d: a tolerance of %g is not reached: degree "
                 "%d leaves an estimated error of %.2g: allow a larger one, or "
                 "ask for a smaller one to have more degrees",
                 level, tolerance, made->degree, made->error);
    return status;
}

/* Copies a level that an earlier chain has. False: none has it. */
static bool copy_level(const bake *b, const chain *c, int level)
{
    const ibl_level_shape shape = ibl_map_shape(c->cube, level);
    int l = level;
    const chain *from = find_same(b, c, &l);

    if (!from)
        return false;
    memcpy(ibl_cube_face(c->cube, level, 0), ibl_cube_face(from->cube, l, 0),
           ibl_level_texels(&shape) * 3 * sizeof(float));
    c->report->level[level] = from->report->level[l];
    return true;
}

static ibl_status make_chain(const bake *b, const chain *c)
{
    ibl_status status = IBL_OK;

    for (int l = 0; l < c->layout.levels && !status; l++)
        if (!copy_level(b, c, l) && is_spectral(c, l))
            status = spectral_level(b, c, l);
    if (status || c->opts->method == IBL_METHOD_SPECTRAL)
        return status;
    return ibl_sample_levels(b->ctx, b->image, b->opts->yaw_deg, c->opts,
                             c->cube, c->report);
}

static ibl_status make_irradiance(bake *b)
{
    ibl_irradiance_options o = b->opts->irradiance_options;
    const ibl_lobe_shape cosine = ibl_lobe_shape_of(IBL_LOBE_GGX, 1);
    double error;
    ibl_status status;

    o.yaw_deg = b->opts->yaw_deg;
    ibl_progress(b->ctx, "irradiance", 0);
    status =
        ibl_cube_alloc_as(b->ctx, o.projection, o.size, 1, &b->out->irradiance);
    if (status)
        return status;
    if (b->plan.irradiance == IBL_METHOD_SAMPLED)
        return ibl_irradiance_grid(b->ctx, b->image, &o, &b->out->irradiance);
    const ibl_spectral_target target = {.shape = &cosine,
                                        .most = b->plan.irradiance_degree,
                                        .tolerance =
                                            b->opts->specular_options.tolerance,
                                        .cube = &b->out->irradiance};
    return ibl_spectral_bake(b->spectral, "irradiance", &target,
                             &b->out->irradiance_degree, &error);
}

static ibl_status make_sh(bake *b)
{
    const size_t edge = (size_t)b->opts->sh_degree + 1;
    b->out->sh = ibl_alloc_array(3 * edge * edge, sizeof *b->out->sh);
    if (!b->out->sh)
        return ibl_no_memory(b->ctx, "the spherical harmonics");
    ibl_progress(b->ctx, "sh", 0);
    const ibl_status status =
        ibl_spectral_sh(b->spectral, b->opts->sh_degree, b->out->sh);
    if (!status)
        ibl_progress(b->ctx, "sh", 1);
    return status;
}

/* Shares of the time, as measured for a map of 8192 pixels and, sampled, of
 * 1024. */
static void begin_progress(const bake *b)
{
    const bool sampled = b->opts->specular_options.method == IBL_METHOD_SAMPLED;
    const ibl_share shares[IBL_SHARES] = {
        {"decode", b->env->image ? 0 : 0.4},
        {"level 0", b->chain_count || b->opts->skybox ? 0.2 : 0},
        {"analysis", 0.2},
        {"specular", b->chain_count ? sampled ? 9 : 0.15 : 0},
        {"irradiance", b->opts->irradiance ? 0.03 : 0},
        {"sh", b->opts->sh_degree >= 0 ? 0.02 : 0}};

    ibl_progress_begin(b->ctx, shares);
}

static ibl_status make_all(bake *b)
{
    ibl_status status = prepare(b);
    if (!status)
        begin_progress(b);
    if (!status)
        status = read_all(b);
    if (!status && b->opts->skybox && !has_flat_sky(b))
        status = ibl_cube_build_mips(b->ctx, &b->out->skybox);
    for (int i = 0; i < b->chain_count && !status; i++) {
        ibl_progress_numbered(b->ctx, b->chains[i].layout.levels - 1,
                              (double)i / b->chain_count,
                              (i + 1.0) / b->chain_count);
        if (!status)
            status = make_chain(b, &b->chains[i]);
    }
    if (!status && b->opts->irradiance)
        status = make_irradiance(b);
    if (!status && b->opts->sh_degree >= 0)
        status = make_sh(b);
    ibl_progress_end(b->ctx, !status);
    return status;
}

ibl_status ibl_bake_environment(ibl_ctx *ctx, const ibl_environment *env,
                                const ibl_bake_options *opts,
                                ibl_bake_result *result)
{
    if (!ctx || !env || !result)
        return ibl_missing(ctx, "ibl_bake_environment: env or result");
    const ibl_bake_options usual = ibl_bake_options_default();
    ibl_bake_result out = {0};
    ibl_environment from = *env;
    bake b = {
        .ctx = ctx, .env = &from, .opts = opts ? opts : &usual, .out = &out};

    if (from.image) {
        from.width = from.image->width;
        from.height = from.image->height;
    }
    ibl_status status = ibl_check_bake(ctx, &from, b.opts);
    if (!status)
        status = make_all(&b);
    ibl_spectral_free(b.spectral);
    free_cubes(&b);
    ibl_free(b.chains);
    ibl_image_free(&b.own);
    if (status)
        ibl_bake_result_free(&out);
    else
        *result = out;
    return status;
}
