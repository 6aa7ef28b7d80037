/* SPDX-License-Identifier: MIT */
#include "brdf/lobe.h"

const char *ibl_lobe_name(ibl_lobe lobe)
{
    static const char *const names[] = {"ggx", "charlie", "phong"};
    return names[lobe >= IBL_LOBE_GGX && lobe <= IBL_LOBE_PHONG ? lobe : 0];
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
    ibl_lobe_shape s = {lobe, fmax(alpha, 1e-75), 0, 0, 0};
    switch (lobe) {
    case IBL_LOBE_CHARLIE:
        s.power = 1 / (2 * s.alpha);
        s.scale = (s.power + 1) * (s.power + 2) / (2 * IBL_PI);
        break;
    case IBL_LOBE_PHONG:
        s.power = (1 / s.alpha - 1) * (1 / s.alpha + 1) / 2;
        s.scale = (s.power + 2) / (2 * IBL_PI);
        break;
    case IBL_LOBE_GGX:
        s.scale = 1 / ggx_integral(s.alpha);
        break;
    }
    return s;
}
