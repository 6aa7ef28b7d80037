/* SPDX-License-Identifier: MIT */
#include "bake/options.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "brdf/lobe.h"
#include "core/context.h"
#include "image/cube.h"

enum {
    MAX_SAMPLES = 1048576
};

/* ---- defaults ----------------------------------------------------------- */

static const ibl_specular_options specular = {.struct_size = sizeof specular,
                                              .size = 256,
                                              .mapping = IBL_ROUGHNESS_FILAMENT,
                                              .roughness_max = 1,
                                              .tolerance =
                                                  IBL_TOLERANCE_DEFAULT,
                                              .samples = 1024,
                                              .lod_bias = NAN,
                                              .pdf_mip = 1};

double ibl_lod_bias_of(const ibl_specular_options *opts, int samples)
{
    return isnan(opts->lod_bias) ? fmin(fmax(log2(samples / 64.0) / 6, 0), 1)
                                 : opts->lod_bias;
}

void ibl_specular_options_init(ibl_specular_options *opts, size_t struct_size)
{
    ibl_give_options(opts, struct_size, &specular, sizeof specular);
}

static const ibl_irradiance_options irradiance = {
    .struct_size = sizeof irradiance, .size = 32};

void ibl_irradiance_options_init(ibl_irradiance_options *opts,
                                 size_t struct_size)
{
    ibl_give_options(opts, struct_size, &irradiance, sizeof irradiance);
}

static const ibl_bake_options bake = {
    .struct_size = sizeof bake, .specular = 1, .irradiance = 1, .sh_degree = 2};

/* Where options of a bake have those that are nested and what follows each. */
enum {
    SPECULAR = offsetof(ibl_bake_options, specular_options),
    MIDDLE = SPECULAR + sizeof(ibl_specular_options),
    IRRADIANCE = offsetof(ibl_bake_options, irradiance_options),
    LAST = IRRADIANCE + sizeof(ibl_irradiance_options)
};

void ibl_bake_options_init(ibl_bake_options *opts, size_t struct_size,
                           size_t specular_size, size_t irradiance_size)
{
    const char *from = (const char *)&bake;
    char *to = (char *)opts;
    char *middle = to + SPECULAR + specular_size;
    char *second = middle + (IRRADIANCE - MIDDLE);
    char *last = second + irradiance_size;

    memcpy(to, from, SPECULAR);
    memcpy(to, &struct_size, sizeof struct_size);
    ibl_give_options(to + SPECULAR, specular_size, &specular, sizeof specular);
    memcpy(middle, from + MIDDLE, IRRADIANCE - MIDDLE);
    ibl_give_options(second, irradiance_size, &irradiance, sizeof irradiance);
    ibl_give_members(last, struct_size - (size_t)(last - to), from + LAST,
                     sizeof bake - LAST);
}

/* The chains of a list whose options have the size that the first one says. */
static ibl_status take_more(ibl_ctx *ctx, ibl_taken_options *own)
{
    const char *from = (const char *)own->bake.more;
    size_t size;

    if (own->bake.more_count < 0 ||
        own->bake.more_count > IBL_MAX_MORE_CHAINS ||
        (own->bake.more_count && !from))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%d more specular chains: must be 0 to %d, in a list",
                        own->bake.more_count, IBL_MAX_MORE_CHAINS);
    own->bake.more = own->more;
    if (!own->bake.more_count)
        return IBL_OK;
    ibl_status status = ibl_options_size(ctx, from, &size);
    for (int i = 0; i < own->bake.more_count && !status; i++) {
        own->more[i] = specular;
        status = ibl_take_options(ctx, from + size * (size_t)i, &own->more[i],
                                  sizeof own->more[i]);
    }
    return status;
}

ibl_status ibl_bake_take_options(ibl_ctx *ctx, const ibl_bake_options *opts,
                                 ibl_taken_options *own)
{
    const char *from = (const char *)opts;
    char *to = (char *)&own->bake;
    size_t size, first, second;

    own->bake = bake;
    own->bake.specular_options = specular;
    own->bake.irradiance_options = irradiance;
    if (!opts)
        return take_more(ctx, own);
    ibl_status status = ibl_options_size(ctx, from, &size);
    if (!status)
        status = ibl_options_size(ctx, from + SPECULAR, &first);
    if (status)
        return status;
    const char *middle = from + SPECULAR + first;
    const char *nested = middle + (IRRADIANCE - MIDDLE);
    status = ibl_options_size(ctx, nested, &second);
    if (status)
        return status;
    const char *last = nested + second;
    if ((size_t)(last - from) > size)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "options of %zu bytes that have others of %zu and %zu",
                        size, first, second);
    status =
        ibl_take_options(ctx, from + SPECULAR, to + SPECULAR, sizeof specular);
    if (!status)
        status =
            ibl_take_options(ctx, nested, to + IRRADIANCE, sizeof irradiance);
    if (!status)
        status = ibl_take_members(ctx, last, size - (size_t)(last - from),
                                  to + LAST, sizeof bake - LAST);
    if (status)
        return status;
    memcpy(to, from, SPECULAR);
    own->bake.struct_size = sizeof bake;
    memcpy(to + MIDDLE, middle, IRRADIANCE - MIDDLE);
    return take_more(ctx, own);
}

/* ---- ranges ------------------------------------------------------------- */

static ibl_status check_samples(ibl_ctx *ctx, const char *what, int samples)
{
    if (samples < 1 || samples > MAX_SAMPLES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "%d samples%s: must be 1 to %d",
                        samples, what, MAX_SAMPLES);
    return IBL_OK;
}

ibl_status ibl_check_roughness(ibl_ctx *ctx, const ibl_specular_options *o)
{
    if (o->mapping < IBL_ROUGHNESS_LINEAR || o->mapping > IBL_ROUGHNESS_BABYLON)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "roughness mapping %d: must be linear (%d), filament "
                        "(%d) or babylon (%d)",
                        (int)o->mapping, IBL_ROUGHNESS_LINEAR,
                        IBL_ROUGHNESS_FILAMENT, IBL_ROUGHNESS_BABYLON);
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
    if (o->mapping == IBL_ROUGHNESS_BABYLON &&
        (o->roughness_min > 0 || o->roughness_max < 1))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "the %s mapping for a roughness range of %g to %g: "
                        "must be 0 to 1",
                        ibl_roughness_map_name(o->mapping), o->roughness_min,
                        o->roughness_max);
    return IBL_OK;
}

/* Sampled levels are cubes. */
static ibl_status check_flat(ibl_ctx *ctx, const ibl_specular_options *o)
{
    bool sampled = o->method == IBL_METHOD_SAMPLED;

    for (int l = 0; l < IBL_MAX_LEVELS; l++)
        sampled |= o->method == IBL_METHOD_AUTO && o->level_samples[l];
    if (o->projection != IBL_PROJECTION_CUBE && sampled)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "sampled levels of an %s map: must be spectral",
                        ibl_projection_name(o->projection));
    return IBL_OK;
}

static ibl_status check_specular(ibl_ctx *ctx, const ibl_specular_options *o)
{
    if (o->method < IBL_METHOD_AUTO || o->method > IBL_METHOD_SAMPLED)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "method %d: must be auto (%d), spectral (%d) or "
                        "sampled (%d)",
                        (int)o->method, IBL_METHOD_AUTO, IBL_METHOD_SPECTRAL,
                        IBL_METHOD_SAMPLED);
    if (!(o->tolerance >= 1e-6 && o->tolerance <= 1))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a tolerance of %g: must be 1e-6 to 1", o->tolerance);
    if (o->lod_bias < -4 || o->lod_bias > 4)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a lod bias of %g: must be -4 to 4", o->lod_bias);
    ibl_status status = ibl_lobe_check(ctx, o->lobe);
    if (!status)
        status = ibl_check_roughness(ctx, o);
    if (!status)
        status = check_flat(ctx, o);
    if (!status)
        status = check_samples(ctx, " a texel", o->samples);
    for (int l = 0; l < IBL_MAX_LEVELS && !status; l++) {
        char what[40];
        snprintf(what, sizeof what, " a texel at level %d", l);
        if (o->level_samples[l])
            status = check_samples(ctx, what, o->level_samples[l]);
    }
    return status;
}

static ibl_status check_irradiance(ibl_ctx *ctx,
                                   const ibl_irradiance_options *opts)
{
    if (opts->size < 1 || opts->size > IBL_MAX_CUBE_SIZE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "irradiance faces of size %d: must be 1 to %d",
                        opts->size, IBL_MAX_CUBE_SIZE);
    if (opts->projection != IBL_PROJECTION_CUBE && opts->step != 0)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an irradiance step of %g for an %s map: must be 0",
                        opts->step, ibl_projection_name(opts->projection));
    if (!(opts->step >= 0.0 && opts->step <= 0.5))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an irradiance step of %g: must be 0 to 0.5 radians",
                        opts->step);
    return IBL_OK;
}

ibl_status ibl_check_bake(ibl_ctx *ctx, const ibl_environment *env,
                          const ibl_bake_options *o)
{
    ibl_status status = IBL_OK;

    if (env->image ? !env->image->data : !env->read)
        return ibl_missing(ctx, "an environment's read or image's data");
    if (env->width < 1 || env->width > IBL_MAX_EDGE || env->height < 1 ||
        env->height > IBL_MAX_EDGE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a map of %dx%d pixels: must be 1x1 to %dx%d",
                        env->width, env->height, IBL_MAX_EDGE, IBL_MAX_EDGE);
    if (o->skybox < 0 || o->skybox > IBL_MAX_CUBE_SIZE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a skybox of size %d: must be 1 to %d, or 0 for none",
                        o->skybox, IBL_MAX_CUBE_SIZE);
    if (!isfinite(o->yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a yaw of %g degrees: must be finite", o->yaw_deg);
    if (o->sh_degree < -1 || o->sh_degree > IBL_MAX_SH_DEGREE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "spherical harmonics of degree %d: must be 0 to %d, "
                        "or -1 for none",
                        o->sh_degree, IBL_MAX_SH_DEGREE);
    if (o->specular && o->level0 && o->level0->size != o->specular_options.size)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a level 0 of size %d for a specular cube of %d: must "
                        "have its size",
                        o->level0->size, o->specular_options.size);
    if (o->specular && o->level0 &&
        o->specular_options.projection != IBL_PROJECTION_CUBE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a level 0 for an %s map: must be for a cube",
                        ibl_projection_name(o->specular_options.projection));
    if (o->specular && o->level0)
        status = ibl_check_cube(ctx, o->level0);
    if (!status && o->specular)
        status = check_specular(ctx, &o->specular_options);
    for (int i = 0; i < o->more_count && !status; i++)
        status = check_specular(ctx, &o->more[i]);
    if (!status && o->irradiance)
        status = check_irradiance(ctx, &o->irradiance_options);
    return status;
}
