/* SPDX-License-Identifier: MIT */
/*
 * The driver of a bake. It reads the environment once and gives each batch of
 * rows to level 0, the sky, the spectral analysis and the near parts. It keeps
 * the whole map only if samples need it.
 */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bake/ladder.h"
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
    MOST_POWER = 256, /* degree of the power */
    GROUP = 2 * IBL_SPECTRAL_GROUP,
    BATCH_BYTES = 1 << 20, /* least size of a batch: about a core's cache */
    MOST_BYTES = 16 << 20  /* largest size of a batch, for many threads */
};

/* A bake in progress. */
typedef struct bake {
    ibl_ctx *ctx;
    const ibl_environment *env;
    ibl_bake_options opts; /* in range, with the bake's yaw */
    ibl_spectral_plan plan;
    ibl_specular_layout layout;
    ibl_image own;          /* the map, if it was read as a whole */
    const ibl_image *image; /* the whole map, or NULL */
    float *rows;            /* without image: two batches of rows, by turns */
    ibl_level0 *level0, *sky;
    ibl_spectral *spectral;
    ibl_near *near[IBL_MAX_LEVELS]; /* NULL: the level has no near part */
    ibl_bake_result *out;
} bake;

void ibl_bake_result_free(ibl_bake_result *r)
{
    if (!r)
        return;
    ibl_cube_free(&r->skybox);
    ibl_cube_free(&r->specular);
    ibl_cube_free(&r->irradiance);
    ibl_free(r->sh);
    ibl_free(r->power);
    *r = (ibl_bake_result){0};
}

static bool has_flat_sky(const bake *b)
{
    return b->opts.skybox && b->opts.skybox_projection != IBL_PROJECTION_CUBE;
}

static bool needs_flat_level0(const bake *b)
{
    return b->opts.specular && b->layout.roughness[0] <= 0 &&
           b->opts.specular_options.projection != IBL_PROJECTION_CUBE;
}

/* ---- before anything is read ------------------------------------------- */

/* Logs the layout if the range of roughness is only a part. */
static void log_layout(const bake *b)
{
    const ibl_specular_options *o = &b->opts.specular_options;
    if (o->roughness_min > 0 || o->roughness_max < 1)
        ibl_info(b->ctx,
                 "specular: roughness %g to %g alone, %d level%s from %d "
                 "texels; a whole chain has %d from %d",
                 o->roughness_min, o->roughness_max, b->layout.levels,
                 b->layout.levels == 1 ? "" : "s", b->layout.size,
                 ibl_default_levels(o->size), o->size);
}

static bool has_best(const bake *b)
{
    return b->opts.specular &&
           b->opts.specular_options.mapping == IBL_ROUGHNESS_BEST;
}

static ibl_status prepare_specular(bake *b)
{
    const ibl_specular_options *o = &b->opts.specular_options;
    /* Without a layout ibl_cube_alloc fails and reports why. */
    if (ibl_specular_layout_of(o, &b->layout))
        b->layout.size = o->size, b->layout.levels = o->levels;
    const ibl_status status =
        ibl_cube_alloc_as(b->ctx, o->projection, b->layout.size,
                          b->layout.levels, &b->out->specular);
    if (status)
        return status;
    b->out->report.layout = b->layout;
    for (int l = 0; l < b->layout.levels; l++)
        b->out->report.level[l].error = -1;
    log_layout(b);
    if (b->layout.roughness[0] > 0 || o->projection != IBL_PROJECTION_CUBE)
        return IBL_OK;
    if (!b->opts.level0)
        return ibl_level0_create(b->ctx, b->env->width, b->env->height,
                                 b->opts.yaw_deg, &b->out->specular,
                                 &b->level0);
    memcpy(b->out->specular.data, b->opts.level0->data,
           3 * sizeof(float) * ibl_cube_texels(b->layout.size, 1));
    return IBL_OK;
}

static ibl_status prepare_sky(bake *b)
{
    const ibl_projection projection = b->opts.skybox_projection;
    const int size = b->opts.skybox, even = size & -size; /* what halves it */
    const bool flat = projection != IBL_PROJECTION_CUBE;
    const ibl_status status = ibl_cube_alloc_as(
        b->ctx, projection, size, ibl_cube_most_levels(flat ? even : size),
        &b->out->skybox);
    if (status || flat)
        return status;
    return ibl_level0_create(b->ctx, b->env->width, b->env->height,
                             b->opts.yaw_deg, &b->out->skybox, &b->sky);
}

static ibl_status prepare_near(bake *b, int level)
{
    const ibl_near_map map = {b->env->width, b->env->height,
                              b->opts.yaw_deg / 180 * IBL_PI};
    const ibl_level_shape shape = ibl_map_shape(&b->out->specular, level);
    return ibl_near_create(b->ctx, &map, &b->plan.shape[level], &shape,
                           &b->near[level]);
}

static ibl_status prepare(bake *b)
{
    ibl_status status = IBL_OK;
    if (b->opts.specular)
        status = prepare_specular(b);
    if (!status && b->opts.skybox)
        status = prepare_sky(b);
    if (!status)
        status = ibl_spectral_plan_make(b->ctx, b->env->width, b->env->height,
                                        &b->opts, &b->layout, &b->plan);
    if (!status && b->plan.degree >= 0)
        status = ibl_spectral_create(b->ctx, b->env->width, b->env->height,
                                     b->opts.yaw_deg, b->plan.degree,
                                     b->plan.single, &b->spectral);
    for (int l = 0; l < b->layout.levels && !status; l++)
        if (b->plan.parts[l].near)
            status = prepare_near(b, l);
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
    if (!status && b->level0)
        status = ibl_level0_add(b->level0, rows, rgb);
    if (!status && b->sky)
        status = ibl_level0_add(b->sky, rows, rgb);
    if (!status && b->spectral)
        ibl_spectral_add(b->spectral, rows, rgb);
    for (int l = 0; l < IBL_MAX_LEVELS && !status; l++)
        if (b->near[l])
            ibl_near_add(b->near[l], rows, rgb);
    return status;
}

/* Rows in a batch: whole groups, one for each thread if MOST_BYTES allows it.
 * The results do not depend on this number. */
static int batch_rows(const bake *b)
{
    const int threads = ibl_ctx_threads(b->ctx);
    const size_t row = 3 * sizeof(float) * (size_t)b->env->width;
    const int fit = (int)(BATCH_BYTES / row) / GROUP;
    const int most = (int)(MOST_BYTES / row) / GROUP;
    int groups = threads;
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
    const ibl_cube *specular = &b->out->specular, *sky = &b->out->skybox;
    const ibl_cube first = {specular->size, 1, specular->data,
                            specular->projection};
    ibl_status status = IBL_OK;

    if (needs_flat_level0(b))
        status =
            ibl_flat_from_latlong(b->ctx, b->image, b->opts.yaw_deg, &first);
    if (!status && has_flat_sky(b))
        status = ibl_flat_from_latlong(b->ctx, b->image, b->opts.yaw_deg, sky);
    return status;
}

static ibl_status read_all(bake *b)
{
    ibl_status status = IBL_OK;
    b->image = b->env->image;
    if (!b->image && (b->plan.whole || needs_flat_level0(b) || has_flat_sky(b)))
        status = keep_whole(b);
    if (!status)
        status = feed(b);
    if (!status && b->level0)
        status = ibl_level0_finish(b->level0);
    if (!status && b->sky)
        status = ibl_level0_finish(b->sky);
    if (!status)
        status = make_flat(b);
    if (!status && (b->level0 || b->sky))
        ibl_progress(b->ctx, "level 0", 1);
    ibl_level0_free(b->level0);
    ibl_level0_free(b->sky);
    b->level0 = b->sky = NULL;
    if (!status && b->spectral)
        status = ibl_spectral_finish(b->spectral);
    ibl_free(b->rows);
    return status;
}

/* ---- outputs --------------------------------------------------------------
 */

static ibl_status sample_levels(bake *b)
{
    const ibl_specular_options *o = &b->opts.specular_options;
    ibl_specular_report *report = &b->out->report;
    bool any = false;
    for (int l = 0; l < b->layout.levels; l++) {
        const int own = o->level_samples[l];
        if (b->plan.level[l] != IBL_METHOD_SAMPLED)
            continue;
        report->level[l].samples = own ? own : o->samples;
        any = true;
    }
    return any ? ibl_sample_levels(b->ctx, b->image, o, &b->out->specular,
                                   report)
               : IBL_OK;
}

/* Makes a level from its near part only. */
static void near_level(const bake *b, int level)
{
    const ibl_level_shape shape = ibl_map_shape(&b->out->specular, level);
    const size_t count = ibl_level_texels(&shape);
    const double *sums = ibl_near_sums(b->near[level]);
    const float *base = ibl_near_base(b->near[level]);
    float *rgb = ibl_cube_face(&b->out->specular, level, 0);
    for (size_t i = 0; i < 3 * count; i++)
        rgb[i] = fmaxf((float)sums[i] + base[i % 3], 0);
}

static ibl_status spectral_level(bake *b, int level)
{
    const double tolerance = b->opts.specular_options.tolerance;
    const ibl_spectral_target target = {.shape = &b->plan.shape[level],
                                        .near = b->near[level],
                                        .tolerance = tolerance,
                                        .cube = &b->out->specular,
                                        .level = level};
    ibl_specular_level *made = &b->out->report.level[level];
    char stage[32];
    snprintf(stage, sizeof stage, "specular %d", level);
    if (b->near[level])
        made->reach = ibl_near_reach(b->near[level]);
    if (!b->plan.parts[level].spectral) {
        near_level(b, level);
        return IBL_OK;
    }
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

static ibl_status make_specular(bake *b)
{
    ibl_status status = sample_levels(b);
    for (int l = 0; l < b->layout.levels && !status; l++)
        if (b->plan.level[l] == IBL_METHOD_SPECTRAL)
            status = spectral_level(b, l);
    return status;
}

static ibl_status make_irradiance(bake *b)
{
    const ibl_irradiance_options *o = &b->opts.irradiance_options;
    const ibl_lobe_shape cosine = ibl_lobe_shape_of(IBL_LOBE_GGX, 1);
    double error;
    ibl_status status;

    ibl_progress(b->ctx, "irradiance", 0);
    status = ibl_cube_alloc_as(b->ctx, o->projection, o->size, 1,
                               &b->out->irradiance);
    if (status)
        return status;
    if (b->plan.irradiance == IBL_METHOD_SAMPLED)
        return ibl_irradiance_grid(b->ctx, b->image, o, &b->out->irradiance);
    const ibl_spectral_target target = {.shape = &cosine,
                                        .tolerance =
                                            b->opts.specular_options.tolerance,
                                        .cube = &b->out->irradiance};
    return ibl_spectral_bake(b->spectral, "irradiance", &target,
                             &b->out->irradiance_degree, &error);
}

static ibl_status make_sh(bake *b)
{
    const size_t edge = (size_t)b->opts.sh_degree + 1;
    b->out->sh = ibl_alloc_array(3 * edge * edge, sizeof *b->out->sh);
    if (!b->out->sh)
        return ibl_no_memory(b->ctx, "the spherical harmonics");
    ibl_progress(b->ctx, "sh", 0);
    const ibl_status status =
        ibl_spectral_sh(b->spectral, b->opts.sh_degree, b->out->sh);
    if (!status)
        ibl_progress(b->ctx, "sh", 1);
    return status;
}

static ibl_status make_power(bake *b)
{
    const int degree =
        b->plan.degree < MOST_POWER ? b->plan.degree : MOST_POWER;
    b->out->power = ibl_alloc_array((size_t)degree + 1, sizeof *b->out->power);
    if (!b->out->power)
        return ibl_no_memory(b->ctx, "the power of the spherical harmonics");
    b->out->power_degree = degree;
    return ibl_spectral_power(b->spectral, degree, b->out->power);
}

/* Fits the roughnesses of the levels, other than those whose near part is
 * already there, and plans them anew: they need no more degrees than before. */
static ibl_status fit_ladder(bake *b)
{
    const int degree = b->plan.degree;
    int kept = 1;
    while (kept < b->layout.levels && b->near[kept])
        kept++;
    ibl_status status = ibl_ladder_fit(b->ctx, b->out->power,
                                       b->out->power_degree, kept, &b->layout);
    if (!status)
        status = ibl_spectral_plan_make(b->ctx, b->env->width, b->env->height,
                                        &b->opts, &b->layout, &b->plan);
    assert(status || b->plan.degree <= degree);
    (void)degree;
    b->out->report.layout = b->layout;
    return status;
}

static ibl_status make_all(bake *b)
{
    ibl_status status = prepare(b);
    if (!status)
        status = read_all(b);
    if (!status && b->opts.skybox && !has_flat_sky(b))
        status = ibl_cube_build_mips(b->ctx, &b->out->skybox);
    if (!status && b->opts.power)
        status = make_power(b);
    if (!status && has_best(b))
        status = fit_ladder(b);
    if (!status && b->opts.specular)
        status = make_specular(b);
    if (!status && b->opts.irradiance)
        status = make_irradiance(b);
    if (!status && b->opts.sh_degree >= 0)
        status = make_sh(b);
    return status;
}

ibl_status ibl_bake_environment(ibl_ctx *ctx, const ibl_environment *env,
                                const ibl_bake_options *opts,
                                ibl_bake_result *result)
{
    if (!ctx || !env || !result)
        return ibl_missing(ctx, "ibl_bake_environment: env or result");
    ibl_bake_result out = {0};
    ibl_environment from = *env;
    bake b = {.ctx = ctx, .env = &from, .out = &out};

    if (from.image) {
        from.width = from.image->width;
        from.height = from.image->height;
    }
    b.opts = opts ? *opts : ibl_bake_options_default();
    b.opts.specular_options.yaw_deg = b.opts.yaw_deg;
    b.opts.irradiance_options.yaw_deg = b.opts.yaw_deg;
    b.opts.power |= has_best(&b);
    ibl_status status = ibl_check_bake(ctx, &from, &b.opts);
    if (!status)
        status = make_all(&b);
    ibl_spectral_free(b.spectral);
    for (int l = 0; l < IBL_MAX_LEVELS; l++)
        ibl_near_free(b.near[l]);
    ibl_level0_free(b.level0);
    ibl_level0_free(b.sky);
    ibl_image_free(&b.own);
    if (status)
        ibl_bake_result_free(&out);
    else
        *result = out;
    return status;
}
