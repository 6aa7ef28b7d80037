/* SPDX-License-Identifier: MIT */
#include "bake/spectral/plan.h"

#include <math.h>

#include "bake/spectral/lobe_coefficients.h"
#include "core/pi.h"

static const int min_degree = 32;
static const int least_degree = 128; /* of an analysis for levels */

/* Highest degree of a level: a power of two less 1, for the columns of its
 * grid. GGX needs it from roughness 0.032 down. The corner of a wide lobe on
 * the horizon, a ring around the sphere, averages what lower degrees omit, so
 * it does not count. */
static const double most_degree = 4095, most_of_corner = 768;
static const double corner_from = 20; /* / alpha */

/* If the tolerance grows by a factor, this share grows by its square root: dark
 * texels must keep the tolerance, too. */
static double tail_of(double tolerance)
{
    const double factor = tolerance / IBL_TOLERANCE_DEFAULT;
    const double tail = ibl_error_parts.tail * IBL_TOLERANCE_DEFAULT;
    return fmin(tail * (factor > 1 ? sqrt(factor) : factor), 1);
}

/* Share of a point light from which floats do. */
static const double single_tail = 0.2;

/* Adds the degree that a lobe needs, at *degree. */
static ibl_status add_lobe(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                           double tolerance, ibl_spectral_plan *plan,
                           int *degree)
{
    const double narrow = fmin(corner_from / shape->alpha, most_degree);
    const double ring =
        tolerance < IBL_TOLERANCE_DEFAULT ? 2 * most_of_corner : most_of_corner;
    const double most =
        shape->kind == IBL_LOBE_RING ? ring : fmax(narrow, most_of_corner);
    int single = 0;
    ibl_status status =
        ibl_lobe_degree(ctx, shape, tail_of(tolerance), (int)most, degree);

    if (*degree < min_degree)
        *degree = min_degree;
    if (!status && *degree > min_degree && *degree > plan->single)
        status = ibl_lobe_degree(ctx, shape, single_tail, *degree, &single);
    plan->degree = *degree > plan->degree ? *degree : plan->degree;
    plan->single = single > plan->single ? single : plan->single;
    return status;
}

ibl_status ibl_spectral_plan_make(ibl_ctx *ctx, const ibl_bake_options *opts,
                                  ibl_spectral_plan *plan)
{
    const ibl_lobe_shape cosine = ibl_lobe_shape_of(IBL_LOBE_GGX, 1);
    ibl_status status = IBL_OK;

    *plan =
        (ibl_spectral_plan){.degree = -1, .irradiance = IBL_METHOD_SPECTRAL};
    if (opts->irradiance && opts->irradiance_options.step > 0) {
        plan->irradiance = IBL_METHOD_SAMPLED;
        plan->whole = true;
    } else if (opts->irradiance) {
        status = add_lobe(ctx, &cosine, opts->specular_options.tolerance, plan,
                          &plan->irradiance_degree);
    }
    if (opts->sh_degree > plan->degree)
        plan->degree = opts->sh_degree;
    plan->single = opts->sh_degree + 1;
    if (opts->specular && plan->degree < least_degree)
        plan->degree = least_degree;
    return status;
}

ibl_status ibl_spectral_plan_chain(ibl_ctx *ctx,
                                   const ibl_specular_options *opts,
                                   const ibl_specular_layout *layout,
                                   ibl_chain_plan *chain,
                                   ibl_spectral_plan *plan)
{
    ibl_status status = IBL_OK;

    for (int l = 0; l < layout->levels && !status; l++) {
        const double r = layout->roughness[l];
        const ibl_lobe_shape shape = ibl_lobe_shape_of(opts->lobe, r * r);
        chain->level[l] = r > 0 ? IBL_METHOD_SPECTRAL : IBL_METHOD_AUTO;
        if (r <= 0)
            continue;
        if (opts->method == IBL_METHOD_SAMPLED ||
            (opts->method == IBL_METHOD_AUTO && opts->level_samples[l])) {
            chain->level[l] = IBL_METHOD_SAMPLED;
            plan->whole = true;
        } else {
            status =
                add_lobe(ctx, &shape, opts->tolerance, plan, &chain->degree[l]);
        }
    }
    return status;
}
