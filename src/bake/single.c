/* SPDX-License-Identifier: MIT */
/* The calls that bake one thing from an image in memory. */
#include <string.h>

#include "core/context.h"
#include "image/image.h"

/* Options with no output; the caller then adds one. */
static ibl_bake_options nothing(void)
{
    ibl_bake_options o = ibl_bake_options_default();
    o.specular = o.irradiance = 0;
    o.sh_degree = -1;
    return o;
}

/* out: the caller's pointer for the result; name: its name in messages. */
static ibl_status bake(ibl_ctx *ctx, const ibl_image *env,
                       const ibl_bake_options *opts, const void *out,
                       const char *name, ibl_bake_result *made)
{
    const ibl_environment from = {.image = env};
    const ibl_status status = ibl_check_image(ctx, env);
    if (status)
        return status;
    return out ? ibl_bake_environment(ctx, &from, opts, made)
               : ibl_missing(ctx, name);
}

ibl_status ibl_bake_specular(ibl_ctx *ctx, const ibl_image *env,
                             const ibl_specular_options *opts, ibl_cube *out,
                             ibl_specular_report *report)
{
    ibl_bake_options o = nothing();
    ibl_bake_result made;

    if (opts)
        o.specular_options = *opts;
    o.specular = 1;
    o.yaw_deg = o.specular_options.yaw_deg;
    const ibl_status status =
        bake(ctx, env, &o, out, "ibl_bake_specular: out", &made);
    if (status)
        return status;
    *out = made.specular;
    if (report)
        *report = made.report;
    made.specular = (ibl_cube){0};
    ibl_bake_result_free(&made);
    return IBL_OK;
}

ibl_status ibl_bake_irradiance(ibl_ctx *ctx, const ibl_image *env,
                               const ibl_irradiance_options *opts,
                               ibl_cube *out)
{
    ibl_bake_options o = nothing();
    ibl_bake_result made;

    if (opts)
        o.irradiance_options = *opts;
    o.irradiance = 1;
    o.yaw_deg = o.irradiance_options.yaw_deg;
    const ibl_status status =
        bake(ctx, env, &o, out, "ibl_bake_irradiance: out", &made);
    if (!status)
        *out = made.irradiance;
    return status;
}

ibl_status ibl_bake_sh(ibl_ctx *ctx, const ibl_image *env, int degree,
                       double yaw_deg, double *coeffs)
{
    const size_t edge = (size_t)degree + 1;
    ibl_bake_options o = nothing();
    ibl_bake_result made;

    if (degree < 0)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "spherical harmonics of degree %d: must be 0 to %d",
                        degree, IBL_MAX_SH_DEGREE);
    o.sh_degree = degree;
    o.yaw_deg = yaw_deg;
    const ibl_status status =
        bake(ctx, env, &o, coeffs, "ibl_bake_sh: coeffs", &made);
    if (status)
        return status;
    memcpy(coeffs, made.sh, 3 * edge * edge * sizeof *coeffs);
    ibl_bake_result_free(&made);
    return IBL_OK;
}
