/* SPDX-License-Identifier: MIT */
#include "bake/specular.h"

#include <math.h>
#include <stdio.h>

#include "bake/filter.h"
#include "brdf/lobe.h"
#include "core/context.h"
#include "image/cube.h"

enum {
    MAX_SAMPLES = 1048576,
    LOOKUPS_PER_TEXEL = 128, /* measured */
    CHEAP_EDGE = 128         /* a cube of this is always worth making */
};

ibl_specular_options ibl_specular_options_default(void)
{
    return (ibl_specular_options){.size = 256,
                                  .roughness_max = 1,
                                  .tolerance = IBL_TOLERANCE_DEFAULT,
                                  .samples = 1024,
                                  .lod_bias = 1,
                                  .pdf_mip = 1};
}

static ibl_status check_samples(ibl_ctx *ctx, const char *what, int samples)
{
    if (samples < 1 || samples > MAX_SAMPLES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "%d samples%s: must be 1 to %d",
                        samples, what, MAX_SAMPLES);
    return IBL_OK;
}

ibl_status ibl_specular_check(ibl_ctx *ctx, const ibl_specular_options *o)
{
    if (o->method < IBL_METHOD_AUTO || o->method > IBL_METHOD_SAMPLED)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "method %d: must be auto (%d), spectral (%d) or "
                        "sampled (%d)",
                        (int)o->method, IBL_METHOD_AUTO, IBL_METHOD_SPECTRAL,
                        IBL_METHOD_SAMPLED);
    if (o->lobe < IBL_LOBE_GGX || o->lobe > IBL_LOBE_PHONG)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "lobe %d: must be ggx (%d), charlie (%d) or phong (%d)",
                        (int)o->lobe, IBL_LOBE_GGX, IBL_LOBE_CHARLIE,
                        IBL_LOBE_PHONG);
    if (o->mapping != IBL_ROUGHNESS_LINEAR &&
        o->mapping != IBL_ROUGHNESS_FILAMENT)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "roughness mapping %d: must be linear (%d) or "
                        "filament (%d)",
                        (int)o->mapping, IBL_ROUGHNESS_LINEAR,
                        IBL_ROUGHNESS_FILAMENT);
    if (!(o->roughness_min >= 0 && o->roughness_min <= o->roughness_max &&
          o->roughness_max <= 1))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a roughness range of %g to %g: must be 0 to 1, the "
                        "smaller first",
                        o->roughness_min, o->roughness_max);
    if (o->roughness_min >= o->roughness_max && o->levels > 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%d levels of the one roughness %g: must be 1",
                        o->levels, o->roughness_min);
    if (!(o->tolerance >= 1e-6 && o->tolerance <= 1))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a tolerance of %g: must be 1e-6 to 1", o->tolerance);
    if (!(o->lod_bias >= -4 && o->lod_bias <= 4))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a lod bias of %g: must be -4 to 4", o->lod_bias);
    if (!isfinite(o->yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a yaw of %g degrees: must be finite", o->yaw_deg);
    ibl_status status = check_samples(ctx, " a texel", o->samples);
    for (int l = 0; l < IBL_MAX_LEVELS && !status; l++) {
        char what[40];
        snprintf(what, sizeof what, " a texel at level %d", l);
        if (o->level_samples[l])
            status = check_samples(ctx, what, o->level_samples[l]);
    }
    return status;
}

/* ---- lookups ----------------------------------------------------------- */

static int lookup_limit(const ibl_image *env)
{
    const double wanted = fmax(env->width / 2.0, env->height);
    int edge = 1;
    while (edge < wanted && edge < IBL_GATHER_MAX_EDGE)
        edge *= 2;
    return edge;
}

static double lookup_cost(int edge)
{
    return (double)LOOKUPS_PER_TEXEL * IBL_FACES * edge * edge;
}

static bool has_level0(const ibl_specular_bake *b)
{
    const int size = b->layout.size;
    return b->layout.roughness[0] <= 0 && (size & (size - 1)) == 0 &&
           size <= IBL_GATHER_MAX_EDGE;
}

/*
 * Edge of the cube for lookups, a power of two. The finest sample should find
 * its texels a level below: a light in level 0 itself stands in the middle of
 * its texel (image/pyramid.h). Finer than half a pixel of the source is of no
 * use; and making a cube finer than the output, which a texel costs about as
 * much as LOOKUPS_PER_TEXEL samples, should not take longer than using it.
 */
static int lookup_edge(const ibl_specular_bake *b,
                       const ibl_specular_level *levels)
{
    const int size = b->layout.size;
    double wanted = 1, lookups = 0;
    for (int l = 0; l < b->layout.levels; l++) {
        /* lod_of() in samples.c at the lobe's peak, solved for the edge where
         * it is 1. */
        const double r = b->layout.roughness[l];
        if (!b->sampled[l])
            continue;
        const ibl_lobe_shape shape = ibl_lobe_shape_of(b->opts->lobe, r * r);
        const double edge =
            sqrt(levels[l].samples / 6.0 * 4 * IBL_PI * ibl_lobe_peak(&shape)) /
            exp2(b->opts->lod_bias - 1);
        const double n = ibl_cube_edge(size, l);
        wanted = fmax(wanted, edge);
        lookups += IBL_FACES * n * n * levels[l].samples;
    }
    wanted = fmin(wanted, lookup_limit(b->env));

    int edge = 1;
    while (edge < wanted)
        edge *= 2;
    while (edge > CHEAP_EDGE && edge > size && lookup_cost(edge) > lookups)
        edge /= 2;
    /* Level 0 of the output is there already, if it is of that kind. */
    if (has_level0(b) && size >= edge && size <= 4 * edge)
        return size;
    return edge;
}

static ibl_status lookup_make(const ibl_specular_bake *b, int edge,
                              ibl_pyramid *pyramid)
{
    const int levels = ibl_cube_most_levels(edge);
    if (edge == b->layout.size && b->layout.roughness[0] <= 0)
        return ibl_pyramid_create(b->ctx, &b->cube, levels, pyramid);

    ibl_cube cube = {0};
    ibl_status status = ibl_cube_alloc(b->ctx, edge, 1, &cube);
    if (!status)
        status = ibl_cube_from_latlong(b->ctx, b->env, b->opts->yaw_deg, &cube);
    if (!status)
        status = ibl_pyramid_create(b->ctx, &cube, levels, pyramid);
    ibl_cube_free(&cube);
    return status;
}

/* ---- levels ------------------------------------------------------------ */

/* Variance along an axis of a source pixel as a cube of this edge has it: a
 * constant patch or, where it is larger than the texels, a tent. */
static double footprint(const ibl_image *env, int edge)
{
    const double angle = 4 * IBL_PI / ((double)env->width * env->height);
    const bool tent = env->width < 4 * edge || env->height < 2 * edge;
    return angle / (tent ? 6 : 12);
}

static ibl_status make_samples(const ibl_specular_bake *b, int level, int count,
                               ibl_samples *samples)
{
    const double r = b->layout.roughness[level];
    const ibl_sampling sampling = {
        .shape = ibl_lobe_shape_of(b->opts->lobe, r * r),
        .count = count,
        .edge = b->pyramid.size,
        .levels = b->pyramid.levels,
        .lod_bias = b->opts->lod_bias,
        .pdf_mip = b->opts->pdf_mip,
        .footprint = footprint(b->env, b->pyramid.size),
    };
    return ibl_samples_specular(b->ctx, &sampling, samples);
}

static ibl_status bake_level(ibl_specular_bake *b, int level, int count)
{
    char stage[32];
    ibl_samples samples;
    ibl_status status = make_samples(b, level, count, &samples);
    if (status)
        return status;
    snprintf(stage, sizeof stage, "specular %d", level);
    status = ibl_filter_level(b->ctx, stage, &b->pyramid, &samples,
                              b->opts->jitter, &b->cube, level);
    ibl_samples_free(&samples);
    return status;
}

ibl_status ibl_specular_sample(ibl_specular_bake *b,
                               const ibl_specular_level *levels)
{
    const int count = b->layout.levels;
    ibl_status status = lookup_make(b, lookup_edge(b, levels), &b->pyramid);
    for (int l = 0; l < count && !status; l++)
        if (b->sampled[l])
            status = bake_level(b, l, levels[l].samples);
    return status;
}
