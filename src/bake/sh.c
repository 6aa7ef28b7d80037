/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/image.h"

ibl_status ibl_bake_sh(ibl_ctx *ctx, const ibl_image *env, int degree,
                       double yaw_deg, double *coeffs)
{
    const ibl_environment from = {.image = env};
    ibl_bake_options all = ibl_bake_options_default();
    ibl_bake_result made;

    ibl_status status = ibl_check_image(ctx, env);
    if (status)
        return status;
    if (!coeffs)
        return ibl_missing(ctx, "ibl_bake_sh: coeffs");
    if (degree < 0)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "spherical harmonics of degree %d: must be 0 to %d",
                        degree, IBL_MAX_SH_DEGREE);
    all.specular = all.irradiance = 0;
    all.sh_degree = degree;
    all.yaw_deg = yaw_deg;
    status = ibl_bake_environment(ctx, &from, &all, &made);
    if (!status)
        memcpy(coeffs, made.sh,
               3 * (size_t)(degree + 1) * (size_t)(degree + 1) *
                   sizeof *coeffs);
    if (!status)
        ibl_bake_result_free(&made);
    return status;
}

/* Ramamoorthi and Hanrahan 2001, eq. 8: 0 for odd l > 1, for even l
 *     2 (-1)^(l/2 - 1) / ((l + 2) (l - 1)) * l! / (2^l (l/2)!^2). */
double ibl_sh_cosine(int l)
{
    double central = 1.0;

    if (l == 1)
        return 2.0 / 3.0;
    if (l < 0 || l % 2)
        return 0.0;
    for (int k = 1; k <= l / 2; k++)
        central *= (2.0 * k - 1.0) / (2.0 * k);
    const double value = 2.0 * central / ((l + 2.0) * (l - 1.0));
    return l / 2 % 2 ? value : -value;
}
