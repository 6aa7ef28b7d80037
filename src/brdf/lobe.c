/* SPDX-License-Identifier: MIT */
#include "brdf/lobe.h"

#include <assert.h>

#include "core/context.h"

static const char *const names[] = {IBL_LOBE_NAMES};
static_assert(sizeof names / sizeof *names == IBL_LOBE_COUNT, "lobes' names");

const char *ibl_lobe_name(ibl_lobe lobe)
{
    return names[lobe >= 0 && lobe < IBL_LOBE_COUNT ? lobe : 0];
}

ibl_status ibl_lobe_check(ibl_ctx *ctx, ibl_lobe lobe)
{
    switch (lobe) {
    case IBL_LOBE_GGX:
    case IBL_LOBE_CHARLIE:
    case IBL_LOBE_PHONG:
        return IBL_OK;
    }
    return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                    "lobe %d: must be ggx (%d), charlie (%d) or phong (%d)",
                    (int)lobe, IBL_LOBE_GGX, IBL_LOBE_CHARLIE, IBL_LOBE_PHONG);
}

/*
 * The integral of D_ggx N.L over the sphere. With b = 1 - alpha^2 and
 * t = alpha^2 + b q it is
 *     4 pi int_0^1/2 alpha^2 / (pi t^2) (1 - 2 q) dq
 *         = 4 / b (1 - log(1 + x) / x),   x = b / (2 alpha^2),
 * and for small x, where that cancels, 2 / alpha^2 (1/2 - x/3 + x^2/4 - ...).
 */
static double ggx_integral(double alpha)
{
    const double a2 = alpha * alpha, b = (1 - alpha) * (1 + alpha);
    const double x = b / (2 * a2);
    double sum = 0, power = 1;
    if (x > 0.25)
        return 4 / b * (1 - log1p(x) / x);
    for (int k = 2; k < 30; k++) {
        sum += power / k;
        power *= -x;
    }
    return 2 / a2 * sum;
}

ibl_lobe_shape ibl_lobe_shape_of(ibl_lobe lobe, double alpha)
{
    ibl_lobe_shape s = {.lobe = lobe, .alpha = fmax(alpha, 1e-75), .end = 1};

    switch (lobe) {
    case IBL_LOBE_CHARLIE:
        s.kind = IBL_LOBE_RING;
        s.power = 1 / (2 * s.alpha);
        s.scale = (s.power + 1) * (s.power + 2) / (2 * IBL_PI);
        break;
    case IBL_LOBE_PHONG:
        s.kind = IBL_LOBE_COMPACT;
        s.power = (1 / s.alpha - 1) * (1 / s.alpha + 1) / 2;
        s.scale = (s.power + 2) / (2 * IBL_PI);
        s.end = s.power + 1;
        break;
    case IBL_LOBE_GGX:
        s.kind = IBL_LOBE_TAILED;
        s.scale = 1 / ggx_integral(s.alpha);
        break;
    }
    return s;
}
