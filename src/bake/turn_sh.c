/* SPDX-License-Identifier: MIT */
/* Spherical harmonics in other axes: evaluated at points there and projected
 * again. Gauss-Legendre in z and equal steps around it are exact for products
 * of two harmonics. */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/axes.h"
#include "kern/brdf_quadrature.h"

/* All Y_lm of ibl_bake_sh in a direction, by a recurrence in l. */
static void harmonics_at(int degree, const double d[3], double *y)
{
    double start = sqrt(0.25 / IBL_PI), re = 1, im = 0; /* (x + i y)^m */
    for (int m = 0; m <= degree; m++) {
        double p = start * (m ? sqrt(2) : 1), before = 0, down = 0;
        for (int l = m; l <= degree; l++) {
            const double up = sqrt((2.0 * l + 1) * (2 * l + 3) /
                                   ((l + 1.0 - m) * (l + 1 + m)));
            const double next = up * (d[2] * p - down * before);
            y[l * (l + 1) - m] = p * im;
            y[l * (l + 1) + m] = p * re;
            before = p;
            p = next;
            down = 1 / up;
        }
        const double was = re;
        re = was * d[0] - im * d[1];
        im = was * d[1] + im * d[0];
        start *= sqrt((2.0 * m + 3) / (2 * m + 2));
    }
}

/* Adds to the coefficients what a point has of others: y has room for two. */
static void add_point(int degree, ibl_axes axes, int back, const double d[3],
                      double share, const double *from, double *y, double *to)
{
    const int count = (degree + 1) * (degree + 1);
    double other[3], value[3] = {0};
    ibl_axes_turn(axes, !back, d, other);
    harmonics_at(degree, other, y);
    harmonics_at(degree, d, y + count);
    for (int i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            value[c] += from[3 * i + c] * y[i];
    for (int i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            to[3 * i + c] += share * value[c] * y[count + i];
}

ibl_status ibl_sh_turn_axes(ibl_ctx *ctx, int degree, ibl_axes axes, int back,
                            double *coeffs)
{
    if (!ctx || !coeffs)
        return ibl_missing(ctx, "ibl_sh_turn_axes: coeffs");
    const ibl_status status = ibl_check_axes(ctx, axes);
    if (status)
        return status;
    if (degree < 0 || degree > IBL_MAX_SH_DEGREE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "spherical harmonics of degree %d: must be 0 to %d",
                        degree, IBL_MAX_SH_DEGREE);
    if (!axes.mirror && axes.up == IBL_UP_Y)
        return IBL_OK;
    const int n = degree + 1;
    double at[IBL_MAX_SH_DEGREE + 1], weight[IBL_MAX_SH_DEGREE + 1];
    double *from = ibl_alloc_array(5 * (size_t)(n * n), sizeof *from);
    if (!from)
        return ibl_no_memory(ctx, "the spherical harmonics in other axes");
    memcpy(from, coeffs, 3 * (size_t)(n * n) * sizeof *from);
    memset(coeffs, 0, 3 * (size_t)(n * n) * sizeof *from);
    ibl_gauss_points(n, at, weight);
    for (int i = 0; i < n * 2 * n; i++) {
        const double z = 2 * at[i / (2 * n)] - 1, s = sqrt(1 - z * z);
        const double phi = IBL_PI * (i % (2 * n)) / n;
        add_point(degree, axes, back, (double[]){s * cos(phi), s * sin(phi), z},
                  2 * IBL_PI / n * weight[i / (2 * n)], from, from + 3 * n * n,
                  coeffs);
    }
    ibl_free(from);
    return IBL_OK;
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
