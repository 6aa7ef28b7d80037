/* SPDX-License-Identifier: MIT */
#include "bake/options.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#include "brdf/lobe.h"
#include "core/context.h"
#include "core/pi.h"
#include "ibl/ibl.h"
#include "image/cube.h"

enum {
    MAX_SAMPLES = 1048576
};

/* ---- defaults ----------------------------------------------------------- */

ibl_specular_options ibl_specular_options_default(void)
{
    return (ibl_specular_options){.size = 256,
                                  .mapping = IBL_ROUGHNESS_FILAMENT,
                                  .roughness_max = 1,
                                  .tolerance = IBL_TOLERANCE_DEFAULT,
                                  .samples = 1024,
                                  .lod_bias = NAN,
                                  .pdf_mip = 1};
}

double ibl_lod_bias_of(const ibl_specular_options *opts)
{
    return isnan(opts->lod_bias)
               ? fmin(fmax(log2(opts->samples / 64.0) / 6, 0), 1)
               : opts->lod_bias;
}

ibl_irradiance_options ibl_irradiance_options_default(void)
{
    return (ibl_irradiance_options){.size = 32};
}

ibl_bake_options ibl_bake_options_default(void)
{
    return (ibl_bake_options){
        .specular = 1,
        .specular_options = ibl_specular_options_default(),
        .irradiance = 1,
        .irradiance_options = ibl_irradiance_options_default(),
        .sh_degree = 2};
}

/* ---- ranges ------------------------------------------------------------- */

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

static ibl_status check_specular(ibl_ctx *ctx, const ibl_specular_options *o)
{
    if (o->method != IBL_METHOD_SPECTRAL && o->method != IBL_METHOD_SAMPLED)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "method %d: must be spectral (%d) or sampled (%d)",
                        (int)o->method, IBL_METHOD_SPECTRAL,
                        IBL_METHOD_SAMPLED);
    if (o->method == IBL_METHOD_SAMPLED && o->projection != IBL_PROJECTION_CUBE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "sampled levels of an %s map: must be spectral",
                        ibl_projection_name(o->projection));
    if (o->samples < 1 || o->samples > MAX_SAMPLES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%d samples a texel: must be 1 to %d", o->samples,
                        MAX_SAMPLES);
    if (!(o->tolerance >= 1e-6 && o->tolerance <= 1))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a tolerance of %g: must be 1e-6 to 1", o->tolerance);
    if (o->lod_bias < -4 || o->lod_bias > 4)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a lod bias of %g: must be -4 to 4", o->lod_bias);
    const ibl_status status = ibl_lobe_check(ctx, o->lobe);
    return status ? status : ibl_check_roughness(ctx, o);
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
    if (!status && (o->more_count < 0 || o->more_count > IBL_MAX_MORE_CHAINS ||
                    (o->more_count && !o->more)))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%d more specular chains: must be 0 to %d, in a list",
                        o->more_count, IBL_MAX_MORE_CHAINS);
    if (!status && o->specular)
        status = check_specular(ctx, &o->specular_options);
    for (int i = 0; i < o->more_count && !status; i++)
        status = check_specular(ctx, &o->more[i]);
    if (!status && o->irradiance)
        status = check_irradiance(ctx, &o->irradiance_options);
    return status;
}

/* ---- sizes and roughnesses of the levels of the specular chain --------- */

const char *ibl_roughness_map_name(ibl_roughness_map map)
{
    return map == IBL_ROUGHNESS_LINEAR     ? "linear"
           : map == IBL_ROUGHNESS_FILAMENT ? "filament"
                                           : "babylon";
}

const char *ibl_specular_report_method(const ibl_specular_report *report)
{
    /* Level 0 may be the environment. */
    for (int l = 0; l < report->layout.levels; l++)
        if (report->level[l].samples > 0)
            return "sampled";
        else if (report->level[l].degree > 0)
            return "spectral";
    return "environment";
}

/* The quantity that grows in equal steps from level to level. */
static double x_of(ibl_roughness_map map, double r)
{
    return map == IBL_ROUGHNESS_LINEAR ? r : r * (2 - r);
}

static double roughness_of(ibl_roughness_map map, double x)
{
    return map == IBL_ROUGHNESS_LINEAR ? x : 1 - sqrt(1 - x);
}

/* Levels of Babylon.js for each halving of alpha: its lodGenerationScale. */
static const double babylon_scale = 0.8;

static double babylon_roughness(int level, double size)
{
    return level ? sqrt(fmin(exp2(level / babylon_scale) / size, 1)) : 0;
}

double ibl_level_roughness(ibl_roughness_map map, int level, int levels)
{
    if (map == IBL_ROUGHNESS_BABYLON)
        return babylon_roughness(level, exp2(levels - 1));
    return roughness_of(map, levels > 1 ? (double)level / (levels - 1) : 0);
}

int ibl_default_levels(int size)
{
    const int last = size < 8 ? 1 : 8;
    int levels = 1;
    while (size >> levels >= last)
        levels++;
    return levels;
}

/* ---- parts of the range ----------------------------------------------- */

/*
 * Texels along an edge that the lobe of roughness r needs, in a chain whose
 * level 0 has `size`.
 *
 * A prefiltered level is the environment convolved with its lobe, whose
 * spectrum falls like exp(-2 alpha l). Above the degree l = ln(1 / eps) / (2
 * alpha) less than eps is left. Texels pi / l apart hold the rest: l / 2 along
 * an edge of 90 degrees. A shader, however, only interpolates. The image of a
 * small light is the lobe (1 + (angle / 2 alpha)^2)^-2, with the curvature
 * -1 / alpha^2 at the peak in each direction. Between four texels h apart,
 * bilinear interpolation is too low by h^2 / (4 alpha^2). One percent of loss
 * allows h = alpha / 5, that is an edge of 5 pi / (2 alpha) and l = 5
 * pi / alpha. Then eps = exp(-10 pi) is negligible, and r = 1 needs 8 texels,
 * where ibl_default_levels() ends.
 *
 * The whole chain halves its edge at every level, whatever the lobe. Its edge
 * at the lod of r is the upper limit.
 */
static double edge_for(ibl_roughness_map map, int size, double r)
{
    const double lod = x_of(map, r) * (ibl_default_levels(size) - 1);
    const double chain = size * exp2(-lod);
    return r > 0 ? fmin(chain, 5 * IBL_PI / (2 * r * r)) : size;
}

static int default_levels(const ibl_specular_options *o, double edge)
{
    const double last = edge_for(o->mapping, o->size, o->roughness_max);
    int levels = 1;
    if (o->roughness_min <= 0 && o->roughness_max >= 1)
        return ibl_default_levels(o->size);
    if (o->roughness_min >= o->roughness_max)
        return 1;
    /* The nearest number of halvings keeps the roughnesses close together. If
     * it is rounded up, interpolation takes at most 2 % of a small light. */
    while (levels < IBL_MAX_LEVELS && edge * exp2(-levels) >= last * sqrt(0.5))
        levels++;
    return levels > 1 || edge < 2 ? levels : 2;
}

/* The smallest multiple of 2^(levels - 1) that is not below edge. */
static int round_up(double edge, int levels)
{
    const int step = 1 << (levels - 1);
    return (int)ceil((edge - 1e-6) / step) * step;
}

double ibl_lod_of_roughness(const ibl_specular_layout *l, double r)
{
    const double x = l->mapping == IBL_ROUGHNESS_BABYLON
                         ? 2 * log2(fmax(r, 1e-6))
                         : x_of(l->mapping, r);
    return fmin(fmax(x * l->lod_scale + l->lod_offset, 0), l->levels - 1);
}

static void layout_babylon(const ibl_specular_options *o,
                           ibl_specular_layout *layout)
{
    const int levels = o->levels ? o->levels : ibl_cube_most_levels(o->size);
    *layout =
        (ibl_specular_layout){.size = o->size,
                              .levels = levels,
                              .mapping = o->mapping,
                              .lod_scale = babylon_scale,
                              .lod_offset = babylon_scale * log2(o->size)};
    for (int l = 0; l < levels; l++)
        layout->roughness[l] = babylon_roughness(l, o->size);
}

ibl_status ibl_specular_layout_of(const ibl_specular_options *o,
                                  ibl_specular_layout *layout)
{
    if (!o || !layout || ibl_check_roughness(NULL, o) || o->size < 1 ||
        o->size > IBL_MAX_CUBE_SIZE || o->levels < 0 ||
        o->levels > ibl_cube_most_levels(o->size))
        return IBL_ERR_ARGUMENT;
    if (o->mapping == IBL_ROUGHNESS_BABYLON) {
        layout_babylon(o, layout);
        return IBL_OK;
    }
    const double edge = edge_for(o->mapping, o->size, o->roughness_min);
    const int levels = o->levels ? o->levels : default_levels(o, edge);
    const double low = x_of(o->mapping, o->roughness_min);
    const double range = x_of(o->mapping, o->roughness_max) - low;
    ibl_specular_layout l = {
        .size = o->size, .levels = levels, .mapping = o->mapping};
    if (o->roughness_min > 0 && round_up(edge, levels) < o->size)
        l.size = round_up(edge, levels);
    for (int i = 0; i < levels; i++) {
        const double t = levels > 1 ? (double)i / (levels - 1) : 0;
        l.roughness[i] = roughness_of(o->mapping, low + range * t);
    }
    if (levels > 1) {
        l.lod_scale = (levels - 1) / range;
        l.lod_offset = 0 - low * l.lod_scale; /* 0, not -0 */
    }
    *layout = l;
    return IBL_OK;
}
