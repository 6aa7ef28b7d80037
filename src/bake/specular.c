/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>

#include "bake/filter.h"
#include "bake/samples.h"
#include "brdf/ggx.h"
#include "core/context.h"
#include "ibl/ibl.h"
#include "image/pyramid.h"

enum {
    MAX_SAMPLES = 1048576,
    CHEAP_EDGE = 128,       /* a cube of this is always worth making */
    LOOKUPS_PER_TEXEL = 128 /* measured */
};

ibl_specular_options ibl_specular_options_default(void)
{
    return (ibl_specular_options){
        .size = 256, .samples = 1024, .lod_bias = 1, .pdf_mip = 1};
}

static ibl_status check_samples(ibl_ctx *ctx, const char *what, int samples)
{
    if (samples < 1 || samples > MAX_SAMPLES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "%d samples%s: must be 1 to %d",
                        samples, what, MAX_SAMPLES);
    return IBL_OK;
}

static ibl_status check(ibl_ctx *ctx, const ibl_specular_options *o)
{
    if (o->mapping != IBL_ROUGHNESS_LINEAR &&
        o->mapping != IBL_ROUGHNESS_FILAMENT)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "roughness mapping %d: must be linear (%d) or "
                        "filament (%d)",
                        (int)o->mapping, IBL_ROUGHNESS_LINEAR,
                        IBL_ROUGHNESS_FILAMENT);
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

static int samples_of(const ibl_specular_options *o, int level)
{
    return o->level_samples[level] ? o->level_samples[level] : o->samples;
}

static double alpha_of(const ibl_specular_options *o, int level, int levels)
{
    const double r = ibl_level_roughness(o->mapping, level, levels);
    return r * r;
}

/*
 * Edge of the cube for lookups, a power of two. The finest sample should find
 * its texels a level below: a light in level 0 itself stands in the middle of
 * its texel (image/pyramid.h). Finer than half a pixel of the source is of no
 * use; and making a cube finer than the output, which a texel costs about as
 * much as LOOKUPS_PER_TEXEL samples, should not take longer than using it.
 */
static int lookup_edge(const ibl_image *env, const ibl_specular_options *o,
                       int levels)
{
    double wanted = 1, lookups = 0;
    for (int l = 1; l < levels; l++) {
        /* lod_of() in samples.c at the lobe's peak, D = 1 / (pi alpha^2),
         * solved for the edge where it is 1. */
        const double edge = sqrt(samples_of(o, l) / 6.0) /
                            (alpha_of(o, l, levels) * exp2(o->lod_bias - 1));
        const double n = ibl_cube_edge(o->size, l);
        wanted = fmax(wanted, edge);
        lookups += IBL_FACES * n * n * samples_of(o, l);
    }
    wanted = fmin(wanted, fmax(env->width / 2.0, env->height));

    int edge = 1;
    while (edge < wanted && edge < IBL_GATHER_MAX_EDGE)
        edge *= 2;
    while (edge > CHEAP_EDGE && edge > o->size &&
           (double)LOOKUPS_PER_TEXEL * IBL_FACES * edge * edge > lookups)
        edge /= 2;
    /* Level 0 of the output is there already, if it is of that kind. */
    const bool halves = (o->size & (o->size - 1)) == 0;
    if (halves && o->size >= edge && o->size <= 4 * edge &&
        o->size <= IBL_GATHER_MAX_EDGE)
        return o->size;
    return edge;
}

/* Variance along an axis of a source pixel as a cube of this edge has it: a
 * constant patch or, where it is larger than the texels, a tent. */
static double footprint(const ibl_image *env, int edge)
{
    const double angle = 4 * IBL_PI / ((double)env->width * env->height);
    const bool tent = env->width < 4 * edge || env->height < 2 * edge;
    return angle / (tent ? 6 : 12);
}

/* level0: the output, whose level 0 is done. */
static ibl_status make_pyramid(ibl_ctx *ctx, const ibl_image *env,
                               double yaw_deg, const ibl_cube *level0, int edge,
                               ibl_pyramid *pyramid)
{
    int levels = 1;
    while (edge >> levels)
        levels++;
    if (edge == level0->size)
        return ibl_pyramid_create(ctx, level0, levels, pyramid);

    ibl_cube cube = {0};
    ibl_status status = ibl_cube_alloc(ctx, edge, 1, &cube);
    if (!status)
        status = ibl_cube_from_latlong(ctx, env, yaw_deg, &cube);
    if (!status)
        status = ibl_pyramid_create(ctx, &cube, levels, pyramid);
    ibl_cube_free(&cube);
    return status;
}

static ibl_status bake_level(ibl_ctx *ctx, const ibl_image *env,
                             const ibl_specular_options *o,
                             const ibl_pyramid *pyramid, ibl_cube *out,
                             int level)
{
    const ibl_lobe lobe = {
        .alpha = alpha_of(o, level, out->levels),
        .count = samples_of(o, level),
        .edge = pyramid->size,
        .levels = pyramid->levels,
        .lod_bias = o->lod_bias,
        .pdf_mip = o->pdf_mip,
        .footprint = footprint(env, pyramid->size),
    };
    char stage[32];
    ibl_samples samples;
    ibl_status status = ibl_samples_specular(ctx, &lobe, &samples);
    if (status)
        return status;
    snprintf(stage, sizeof stage, "specular %d", level);
    status =
        ibl_filter_level(ctx, stage, pyramid, &samples, o->jitter, out, level);
    ibl_samples_free(&samples);
    return status;
}

ibl_status ibl_bake_specular(ibl_ctx *ctx, const ibl_image *env,
                             const ibl_specular_options *opts, ibl_cube *out)
{
    const ibl_specular_options defaults = ibl_specular_options_default();
    ibl_pyramid pyramid = {0};
    ibl_cube cube = {0};
    ibl_status status;

    if (!opts)
        opts = &defaults;
    status = check(ctx, opts);
    if (status)
        return status;
    const int levels =
        opts->levels ? opts->levels : ibl_default_levels(opts->size);
    status = ibl_cube_alloc(ctx, opts->size, levels, &cube);
    if (status)
        return status;
    status = ibl_cube_from_latlong(ctx, env, opts->yaw_deg, &cube);
    if (!status && levels > 1)
        status = make_pyramid(ctx, env, opts->yaw_deg, &cube,
                              lookup_edge(env, opts, levels), &pyramid);
    for (int l = 1; l < levels && !status; l++)
        status = bake_level(ctx, env, opts, &pyramid, &cube, l);
    ibl_pyramid_free(&pyramid);
    if (status)
        ibl_cube_free(&cube);
    else
        *out = cube;
    return status;
}
