/* SPDX-License-Identifier: MIT */
#include "bake/irradiance.h"

#include <math.h>

#include "core/context.h"
#include "image/image.h"

ibl_irradiance_options ibl_irradiance_options_default(void)
{
    return (ibl_irradiance_options){.size = 32};
}

ibl_status ibl_irradiance_check(ibl_ctx *ctx,
                                const ibl_irradiance_options *opts)
{
    if (opts->size < 1 || opts->size > IBL_MAX_CUBE_SIZE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "irradiance faces of size %d: must be 1 to %d",
                        opts->size, IBL_MAX_CUBE_SIZE);
    if (!(opts->step >= 0.0 && opts->step <= 0.5))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an irradiance step of %g: must be 0 to 0.5 radians",
                        opts->step);
    if (!isfinite(opts->yaw_deg))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "the yaw must be finite");
    return IBL_OK;
}

ibl_status ibl_bake_irradiance(ibl_ctx *ctx, const ibl_image *env,
                               const ibl_irradiance_options *opts,
                               ibl_cube *out)
{
    const ibl_environment from = {.image = env};
    ibl_bake_options all = ibl_bake_options_default();
    ibl_bake_result made;

    if (opts)
        all.irradiance_options = *opts;
    all.yaw_deg = all.irradiance_options.yaw_deg;
    all.specular = 0;
    all.sh_degree = -1;
    ibl_status status = ibl_check_image(ctx, env);
    if (!status && !out)
        status = ibl_missing(ctx, "ibl_bake_irradiance: out");
    if (!status)
        status = ibl_bake_environment(ctx, &from, &all, &made);
    if (!status)
        *out = made.irradiance;
    return status;
}
