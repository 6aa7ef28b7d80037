/* SPDX-License-Identifier: MIT */
#include "image/axes.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"
#include "kern/brdf_quadrature.h"

/* Its own inverse. */
static void mirror(ibl_mirror across, double d[3])
{
    const double x = d[0], z = d[2];

    d[0] = across == IBL_MIRROR_XZ ? z : across == IBL_MIRROR_X ? -x : x;
    d[2] = across == IBL_MIRROR_XZ ? x : across == IBL_MIRROR_Z ? -z : z;
}

const char *ibl_mirror_name(ibl_mirror mirror)
{
    static const char *const names[] = {[IBL_MIRROR_NONE] = "none",
                                        [IBL_MIRROR_X] = "x",
                                        [IBL_MIRROR_Z] = "z",
                                        [IBL_MIRROR_XZ] = "xz"};

    return (unsigned)mirror <= IBL_MIRROR_XZ ? names[mirror] : "unknown";
}

const char *ibl_up_name(ibl_up up)
{
    return up == IBL_UP_Y ? "y" : up == IBL_UP_Z ? "z" : "unknown";
}

void ibl_axes_turn(ibl_axes axes, int back, const double from[3], double to[3])
{
    double d[3] = {from[0], from[1], from[2]};

    if (!back)
        mirror(axes.mirror, d);
    if (axes.up == IBL_UP_Z) {
        const double y = d[1];
        d[1] = back ? d[2] : -d[2];
        d[2] = back ? -y : y;
    }
    if (back)
        mirror(axes.mirror, d);
    memcpy(to, d, sizeof d);
}

ibl_status ibl_check_axes(ibl_ctx *ctx, ibl_axes axes)
{
    if (axes.mirror < IBL_MIRROR_NONE || axes.mirror > IBL_MIRROR_XZ)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "mirror %d: must be none (%d), x (%d), z (%d) or xz "
                        "(%d)",
                        (int)axes.mirror, IBL_MIRROR_NONE, IBL_MIRROR_X,
                        IBL_MIRROR_Z, IBL_MIRROR_XZ);
    if (axes.up < IBL_UP_Y || axes.up > IBL_UP_Z)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "up %d: must be y (%d) or z (%d)", (int)axes.up,
                        IBL_UP_Y, IBL_UP_Z);
    return IBL_OK;
}

/* ---- cubes -------------------------------------------------------------- */

typedef struct turning {
    int n, words, back;
    ibl_axes axes;
    const char *from;
    char *to;
} turning;

/* The texel of `from` with the direction of texel (x, y) of a face of `to`. */
static size_t texel_from(const turning *t, int face, int x, int y)
{
    const ibl_face_axes *axes = &ibl_face[face];
    const int u = 2 * x + 1 - t->n, v = 2 * y + 1 - t->n;
    double d[3], from[3];

    for (int k = 0; k < 3; k++)
        d[k] = t->n * axes->forward[k] + u * axes->right[k] + v * axes->down[k];
    ibl_axes_turn(t->axes, !t->back, d, from);
    return ibl_cube_texel_at(t->n,
                             (int[]){(int)from[0], (int)from[1], (int)from[2]});
}

/* A row of a face comes from a row or a column. */
static void row_job(void *arg, int row, int worker)
{
    const turning *t = arg;
    const int n = t->n, face = row / n, y = row % n;
    const ptrdiff_t bytes = 4 * (ptrdiff_t)t->words;
    const size_t first = texel_from(t, face, 0, y);
    const ptrdiff_t step =
        (ptrdiff_t)texel_from(t, face, n > 1, y) - (ptrdiff_t)first;
    const char *from = t->from + (ptrdiff_t)first * bytes;
    char *to = t->to + (ptrdiff_t)row * n * bytes;
    (void)worker;

    for (int x = 0; x < n; x++, from += step * bytes)
        for (int w = 0; w < t->words; w++, to += 4)
            memcpy(to, from + 4 * (ptrdiff_t)w, 4);
}

ibl_status ibl_level_turn_axes(ibl_ctx *ctx, ibl_level_shape s, int words,
                               ibl_axes axes, int back, const void *from,
                               void *to)
{
    turning t = {s.width, words, back, axes, from, to};
    const ptrdiff_t bytes = 4 * (ptrdiff_t)words;

    if (s.projection == IBL_PROJECTION_CUBE)
        return ibl_run(ctx, NULL, IBL_FACES * t.n, row_job, &t);
    /* Mirrors put centres of texels onto centres in every projection. */
    for (int i = 0; i < s.width * s.height; i++) {
        double d[3];
        int at[3];
        ibl_level_direction(&s, 0, i % s.width, i / s.width, d);
        ibl_axes_turn(axes, !back, d, d);
        ibl_level_texel(&s, d, at);
        memcpy(t.to + i * bytes,
               t.from + ((ptrdiff_t)at[2] * s.width + at[1]) * bytes,
               (size_t)bytes);
    }
    return IBL_OK;
}

ibl_status ibl_cube_turn_axes(ibl_ctx *ctx, const ibl_cube *from, ibl_axes axes,
                              int back, ibl_cube *out)
{
    ibl_cube to = {0};
    ibl_status status = ibl_check_map(ctx, from);
    const bool flat = !status && from->projection != IBL_PROJECTION_CUBE;
    if (!status && !out)
        status = ibl_missing(ctx, "ibl_cube_turn_axes: out");
    if (!status)
        status = ibl_check_axes(ctx, axes);
    if (!status && flat && axes.up != IBL_UP_Y)
        status = ibl_fail(ctx, IBL_ERR_ARGUMENT,
                          "an %s map with +Z up: must be a cube",
                          ibl_projection_name(from->projection));
    if (!status)
        status = ibl_cube_alloc_as(ctx, from->projection, from->size,
                                   from->levels, &to);
    for (int l = 0; !status && l < from->levels; l++)
        status = ibl_level_turn_axes(ctx, ibl_map_shape(from, l), 3, axes, back,
                                     ibl_cube_face(from, l, 0),
                                     ibl_cube_face(&to, l, 0));
    if (status)
        ibl_cube_free(&to);
    else
        *out = to;
    return status;
}

/* ---- harmonics --------------------------------------------------------- */

/* Spherical harmonics in other axes: evaluated at points there and projected
 * again. Gauss-Legendre in z and equal steps around it are exact for products
 * of two harmonics. */

/* By a recurrence in l. */
void ibl_sh_at(int degree, const double d[3], double *y)
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
    ibl_sh_at(degree, other, y);
    ibl_sh_at(degree, d, y + count);
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
