/* SPDX-License-Identifier: MIT */
#include "bake/spectral/plan.h"

#include <math.h>

#include "bake/spectral/lobe_coefficients.h"
#include "core/pi.h"

static const int min_degree = 32;
static const int least_power = 128; /* the degree of ibl_bake_result's power */

/* Highest degree of a lobe without a near part: degrees_a_pixel over a pixel's
 * size in radians, within limits. A near part then reaches two or three pixels
 * or, with the least limit, more of a small map. That limit is above what
 * default levels of faces up to 512 need: degrees take a thirtieth of the time
 * of a near part there. */
static const double degrees_a_pixel = 8;
static const double least_limit = 768, most_limit = 2048;

/* Degree at which the far part ends, times 1 / sqrt(split). */
static const double far_end = 3.2;

/* split alpha^2 from which the near part is negligible. */
static const double no_near = 40;

/* Share of a point light that degrees may leave out, over the tolerance: maps
 * are smoother than points, and the brightest pixels are taken out. */
static const double slack = 4;
/* If the tolerance grows by a factor, this share grows by its square root: dark
 * texels must keep the tolerance, too. */
static double tail_of(double tolerance)
{
    const double factor = tolerance / IBL_TOLERANCE_DEFAULT;
    const double tail = slack * IBL_TOLERANCE_DEFAULT;
    return fmin(tail * (factor > 1 ? sqrt(factor) : factor), 1);
}

/* Share of a point light from which floats do. */
static const double single_tail = 0.2;

struct request {
    ibl_ctx *ctx;
    double limit; /* of the degree of a lobe without near part */
    double tail;
};

/* The degree that a lobe or its far part needs. */
static ibl_status find_degree(const struct request *q,
                              const ibl_lobe_shape *shape, int *degree)
{
    const int most = 2 * (int)most_limit;
    const ibl_status status =
        ibl_lobe_degree(q->ctx, shape, q->tail, most, degree);
    if (*degree < min_degree)
        *degree = min_degree;
    return status;
}

static ibl_status plan_lobe(const struct request *q, ibl_lobe_shape *shape,
                            ibl_spectral_parts *parts, int *degree)
{
    const double split = q->limit * q->limit / (far_end * far_end);
    const ibl_status status = find_degree(q, shape, degree);
    *parts = (ibl_spectral_parts){.spectral = true};
    if (status || *degree <= q->limit)
        return status;
    *degree = (int)q->limit;
    switch (shape->kind) {
    case IBL_LOBE_RING:
        /* A ring around the sphere averages the omitted degrees. */
        break;
    case IBL_LOBE_COMPACT:
        *parts = (ibl_spectral_parts){.near = true};
        *degree = -1;
        break;
    case IBL_LOBE_TAILED:
        /* A wide lobe has no near part: only its corner on the horizon exceeds
         * the limit. */
        parts->near = split * shape->alpha * shape->alpha < no_near;
        if (parts->near)
            shape->split = split;
        break;
    }
    return IBL_OK;
}

/* Adds the degree of a level. */
static ibl_status add_degree(const struct request *q,
                             const ibl_lobe_shape *shape, bool spectral,
                             int degree, ibl_spectral_plan *plan)
{
    int single = 0;
    ibl_status status = IBL_OK;

    plan->degree = degree > plan->degree ? degree : plan->degree;
    if (spectral && degree > min_degree && degree > plan->single)
        status = ibl_lobe_degree(q->ctx, shape, single_tail, degree, &single);
    plan->single = single > plan->single ? single : plan->single;
    return status;
}

static ibl_status plan_levels(const struct request *q,
                              const ibl_specular_options *o,
                              const ibl_specular_layout *layout,
                              ibl_chain_plan *chain, ibl_spectral_plan *plan)
{
    ibl_status status = IBL_OK;

    for (int l = 0; l < layout->levels && !status; l++) {
        const double r = layout->roughness[l];
        int degree;
        if (r <= 0)
            continue;
        chain->level[l] = IBL_METHOD_SAMPLED;
        if (o->method == IBL_METHOD_SAMPLED ||
            (o->method == IBL_METHOD_AUTO && o->level_samples[l])) {
            plan->whole = true;
            continue;
        }
        chain->level[l] = IBL_METHOD_SPECTRAL;
        chain->shape[l] = ibl_lobe_shape_of(o->lobe, r * r);
        status = plan_lobe(q, &chain->shape[l], &chain->parts[l], &degree);
        if (!status)
            status = add_degree(q, &chain->shape[l], chain->parts[l].spectral,
                                degree, plan);
    }
    return status;
}

static ibl_status plan_irradiance(const struct request *q,
                                  const ibl_irradiance_options *o,
                                  ibl_spectral_plan *plan)
{
    const ibl_lobe_shape cosine = ibl_lobe_shape_of(IBL_LOBE_GGX, 1);
    int degree = 0;
    if (o->step > 0) {
        plan->irradiance = IBL_METHOD_SAMPLED;
        plan->whole = true;
        return IBL_OK;
    }
    plan->irradiance = IBL_METHOD_SPECTRAL;
    const ibl_status status = find_degree(q, &cosine, &degree);
    plan->degree = degree > plan->degree ? degree : plan->degree;
    return status;
}

static struct request request_of(ibl_ctx *ctx, int width, int height,
                                 double tolerance)
{
    const double pixel = fmax(IBL_PI / height, 2 * IBL_PI / width);
    return (struct request){
        .ctx = ctx,
        .limit = fmin(fmax(degrees_a_pixel / pixel, least_limit), most_limit),
        .tail = tail_of(tolerance)};
}

ibl_status ibl_spectral_plan_make(ibl_ctx *ctx, int width, int height,
                                  const ibl_bake_options *opts,
                                  ibl_spectral_plan *plan)
{
    const struct request q =
        request_of(ctx, width, height, opts->specular_options.tolerance);
    ibl_status status = IBL_OK;

    *plan = (ibl_spectral_plan){.degree = -1};
    if (opts->irradiance)
        status = plan_irradiance(&q, &opts->irradiance_options, plan);
    if (opts->sh_degree > plan->degree)
        plan->degree = opts->sh_degree;
    plan->single = opts->sh_degree + 1;
    if (opts->power && plan->degree < least_power)
        plan->degree = least_power;
    return status;
}

ibl_status ibl_spectral_plan_chain(ibl_ctx *ctx, int width, int height,
                                   const ibl_specular_options *opts,
                                   const ibl_specular_layout *layout,
                                   ibl_chain_plan *chain,
                                   ibl_spectral_plan *plan)
{
    const struct request q = request_of(ctx, width, height, opts->tolerance);

    *chain = (ibl_chain_plan){0};
    return plan_levels(&q, opts, layout, chain, plan);
}
