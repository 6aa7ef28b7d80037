/* SPDX-License-Identifier: MIT */
#include "bake/spectral/plan.h"

#include <math.h>

#include "bake/spectral/kernel.h"
#include "core/context.h"
#include "core/pi.h"

/* Nanoseconds on one core, measured; only their ratios matter. */
static const double per_sample = 1.0;   /* of a texel */
static const double per_texel = 40;     /* of a spectral level */
static const double per_legendre = 0.2; /* a value P_lm on a pair of rings */
static const double per_pixel = 5; /* of the map, kept as samples need it */

/* How much more than a sampled level a spectral one may cost: its error is a
 * hundredth, at least, of what samples leave. */
static const double worth = 16;

static const int min_degree = 32;

/* The lights that are taken out leave less of the worst than this. */
static const double slack = 4;
/* What of a point light may be left out where more degrees are not worth it.
 * A thousand samples leave about as much of a whole map. */
static const double most_tail = 0.01;

/* The larger of a pixel's height and its width at the equator. */
static double pixel_angle(int width, int height)
{
    return fmax(IBL_PI / height, 2 * IBL_PI / width);
}

double ibl_spectral_shortfall(int width, int height, ibl_lobe lobe,
                              double alpha)
{
    /* Of include/ibl/reference.h. */
    const double points = lobe == IBL_LOBE_GGX     ? 4
                          : lobe == IBL_LOBE_PHONG ? 2
                                                   : 1;
    const double lack = 4 - 4 * alpha / (points * pixel_angle(width, height));
    if (lack > 0 && lobe != IBL_LOBE_GGX)
        return 1;
    return lack > 0 ? 0.01 * lack * lack : 0;
}

static double legendre_cost(double rings, double degree)
{
    return per_legendre * rings / 2 * degree * degree / 2;
}

struct request {
    ibl_ctx *ctx;
    int width, height;
    ibl_method method;
    ibl_lobe lobe;
    double tolerance;
    bool strict; /* it was asked for */
};

/* Whether pixels are points to a lobe. */
static bool are_points(const struct request *q, double alpha)
{
    const double allowed =
        q->strict ? q->tolerance / 2 : IBL_SPECTRAL_SHORTFALL;
    return ibl_spectral_shortfall(q->width, q->height, q->lobe, alpha) <=
           allowed;
}

/* The degree at which a point light that is not taken out, the worst of all,
 * is off by tail. 0: there is none. */
static ibl_status find_degree(const struct request *q, double alpha,
                              double tail, int *degree)
{
    const ibl_status status =
        ibl_kernel_band(q->ctx, q->lobe, alpha, fmin(tail, 1),
                        IBL_SPECTRAL_MAX_DEGREE + 1, degree);
    if (*degree > IBL_SPECTRAL_MAX_DEGREE)
        *degree = 0;
    else if (*degree < min_degree)
        *degree = min_degree;
    return status;
}

static bool is_worth_it(const struct request *q, const ibl_spectral_plan *plan,
                        int degree, double texels, double samples)
{
    const double analysis = legendre_cost(q->height, degree) -
                            legendre_cost(q->height, plan->degree);
    const double spectral = fmax(analysis, 0) +
                            legendre_cost(2 * degree, degree) +
                            per_texel * texels;
    const double map = plan->whole ? 0 : per_pixel * q->width * q->height;
    return spectral < worth * (per_sample * texels * samples + map);
}

/*
 * The degree to be there for a level, 0 if it is to be sampled; which of them
 * a tolerance needs turns out later. Where all are not worth it, more of a
 * point light may be left out, as long as samples would leave more still.
 */
static ibl_status level_degree(const struct request *q,
                               const ibl_spectral_plan *plan, double alpha,
                               double texels, double samples, int *degree)
{
    double tail = slack * IBL_SPECTRAL_TOLERANCE;
    ibl_status status = IBL_OK;

    *degree = 0;
    if (!are_points(q, alpha))
        return IBL_OK;
    do {
        status = find_degree(q, alpha, tail, degree);
        if (status ||
            (*degree && (q->method == IBL_METHOD_SPECTRAL ||
                         is_worth_it(q, plan, *degree, texels, samples))))
            return status;
        *degree = 0;
        tail *= 4;
    } while (tail <= most_tail && !q->strict);
    return status;
}

static ibl_status plan_level(const struct request *q,
                             const ibl_specular_options *o,
                             const ibl_specular_layout *layout, int l,
                             ibl_spectral_plan *plan)
{
    const double r = layout->roughness[l];
    const double n = ibl_cube_edge(layout->size, l);
    int degree;

    plan->level[l] = IBL_METHOD_SAMPLED;
    if (q->method == IBL_METHOD_SAMPLED ||
        (q->method == IBL_METHOD_AUTO && o->level_samples[l]))
        return IBL_OK;
    const ibl_status status =
        level_degree(q, plan, r * r, IBL_FACES * n * n, o->samples, &degree);
    if (!status && !degree && q->method == IBL_METHOD_SPECTRAL)
        ibl_info(q->ctx,
                 "specular level %d: roughness %.3g is too narrow for the "
                 "spectral method on a map of %dx%d: sampled",
                 l, r, q->width, q->height);
    if (status || !degree)
        return status;
    plan->level[l] = IBL_METHOD_SPECTRAL;
    plan->degree = degree > plan->degree ? degree : plan->degree;
    return IBL_OK;
}

static ibl_status plan_irradiance(const struct request *q,
                                  const ibl_irradiance_options *o,
                                  ibl_spectral_plan *plan)
{
    int degree = 0;
    plan->irradiance = IBL_METHOD_SAMPLED;
    if (o->step > 0 || q->method == IBL_METHOD_SAMPLED || !are_points(q, 1))
        return IBL_OK;
    const ibl_status status =
        find_degree(q, 1, slack * IBL_SPECTRAL_TOLERANCE, &degree);
    if (status || !degree)
        return status;
    plan->irradiance = IBL_METHOD_SPECTRAL;
    plan->degree = degree > plan->degree ? degree : plan->degree;
    return IBL_OK;
}

/* What follows from the choices. */
static void finish_plan(const ibl_bake_options *opts, ibl_spectral_plan *plan)
{
    if (opts->irradiance && plan->irradiance == IBL_METHOD_SAMPLED)
        plan->whole = true;
    plan->sh = plan->whole ? IBL_METHOD_SAMPLED : IBL_METHOD_SPECTRAL;
    if (opts->sh_degree > plan->degree && plan->sh == IBL_METHOD_SPECTRAL)
        plan->degree = opts->sh_degree;
}

ibl_status ibl_spectral_plan_make(ibl_ctx *ctx, int width, int height,
                                  const ibl_bake_options *opts,
                                  const ibl_specular_layout *layout,
                                  ibl_spectral_plan *plan)
{
    const ibl_specular_options *o = &opts->specular_options;
    struct request q = {.ctx = ctx,
                        .width = width,
                        .height = height,
                        .method = o->method,
                        .lobe = o->lobe,
                        .tolerance = o->tolerance > 0 ? o->tolerance
                                                      : IBL_SPECTRAL_TOLERANCE,
                        .strict = o->tolerance > 0};
    ibl_status status = IBL_OK;

    *plan = (ibl_spectral_plan){.degree = -1, .tolerance = q.tolerance};
    for (int l = 0; opts->specular && l < layout->levels && !status; l++) {
        if (layout->roughness[l] > 0)
            status = plan_level(&q, o, layout, l, plan);
        plan->whole |= plan->level[l] == IBL_METHOD_SAMPLED;
    }
    q.lobe = IBL_LOBE_GGX;
    if (!status && opts->irradiance)
        status = plan_irradiance(&q, &opts->irradiance_options, plan);
    finish_plan(opts, plan);
    return status;
}
