/* SPDX-License-Identifier: MIT */
/*
 * Spherical harmonics in other axes. A mirror changes signs; that of x and z is
 * quarter turns about x and z and a mirror of z. The turn by 90
 * degrees about x, which puts z up, is a matrix for each degree l,
 *     c'_m = sum over n of s d^l_|m||n| c_n,
 * with Wigner's d^l_mn = d^l_mn(90 degrees). It swaps what is even in y with
 * what is even in z. So the terms of a pair of orders are a cosine or a sine by
 * the parity of l plus the other order, and the factor s has the sign i^(m - n)
 * and the size 2, or sqrt(2) for each order that is 0.
 *
 * For two orders m and n, a the larger one, b the other,
 *     d^a_mn = 2^-a sqrt((2a)! / ((a + b)! (a - b)!)),
 *     l f(l + 1) d^(l+1) = -(2 l + 1) m n d^l - (l + 1) f(l) d^(l-1),
 *     f(l) = sqrt((l^2 - m^2) (l^2 - n^2))
 * (Varshalovich et al. 1988, 4.8.2), which grows where it starts small: it is
 * stable. No term is below 2^-IBL_MAX_SH_DEGREE, a normal number.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/axes.h"

/* Coefficients by order, so that a pair of orders is read in one line: for each
 * m = 0..degree the degrees l = m..degree, R, G, B of the cosine and of the
 * sine. */
typedef struct turning {
    int degree;
    int back;
    const double *root; /* sqrt(l^2 - m^2) at [m (degree + 1) + l] */
    double *from, *to;  /* to is zeroed */
} turning;

static size_t index_of(int l, int m)
{
    return 3 * (size_t)(l * (l + 1) + m);
}

static void change_signs(int degree, ibl_mirror across, double *c)
{
    for (int l = 0; l <= degree; l++)
        for (int m = -l; m <= l; m++) {
            const bool odd = across == IBL_MIRROR_Z ? (l + m) % 2 != 0
                                                    : (m % 2 != 0) != (m < 0);
            for (size_t k = 0; k < 3 && odd; k++)
                c[index_of(l, m) + k] *= -1;
        }
}

static double *at_order(const turning *t, double *orders, int m, int l)
{
    return orders + 6 * ((size_t)m * (size_t)(t->degree + 1) + (size_t)l);
}

/* Adds what order n of each degree l gives order m; start is the d of the
 * first one. */
static void add_order(const turning *t, int m, int n, double start)
{
    const double *fm = t->root + (size_t)m * (size_t)(t->degree + 1);
    const double *fn = t->root + (size_t)n * (size_t)(t->degree + 1);
    const double size = (m ? sqrt(2) : 1) * (n ? sqrt(2) : 1);
    const double sign = (m > n ? m - n : n - m) & 2 ? -size : size;
    double d = start, before = 0;

    for (int l = m > n ? m : n; l <= t->degree; l++) {
        const int sine = (l + n) % 2, from_sine = (l + m) % 2;
        const bool minus = t->back ? from_sine && !sine : sine && !from_sine;
        const double factor = minus ? -sign * d : sign * d;
        double *to = at_order(t, t->to, m, l) + 3 * sine;
        const double *from = at_order(t, t->from, n, l) + 3 * from_sine;
        for (int k = 0; k < 3; k++)
            to[k] += factor * from[k];
        if (l == t->degree)
            break;
        const double next =
            -(2.0 * l + 1) * m * n * d - (l + 1.0) * fm[l] * fn[l] * before;
        before = d;
        d = l ? next / (l * fm[l + 1] * fn[l + 1]) : 0;
    }
}

static void order_job(void *arg, int m, int worker)
{
    const turning *t = arg;
    double start = ldexp(1, -m);
    (void)worker;

    for (int n = m; n >= 0; n--) {
        add_order(t, m, n, start);
        start *= sqrt((double)(m + n) / (m - n + 1));
    }
    start = ldexp(1, -m);
    for (int n = m + 1; n <= t->degree; n++) {
        start *= 0.5 * sqrt(2.0 * n * (2 * n - 1) / (n + m) / (n - m));
        add_order(t, m, n, start);
    }
}

/* Copies coefficients to their orders, or back. The sines of order 0 are 0. */
static void sort(const turning *t, double *orders, bool back, double *coeffs)
{
    for (int l = 0; l <= t->degree; l++)
        for (int m = -l; m <= l; m++) {
            double *a = at_order(t, orders, abs(m), l) + (m < 0 ? 3 : 0);
            double *b = coeffs + index_of(l, m);
            memcpy(back ? b : a, back ? a : b, 3 * sizeof *a);
        }
}

static ibl_status turn_up(ibl_ctx *ctx, int degree, int back, double *coeffs)
{
    const size_t edge = (size_t)degree + 1, square = edge * edge;
    double *root = ibl_alloc_zeroed(13 * square, sizeof *root);
    turning t = {degree, back, root, root + square, root + 7 * square};

    if (!root)
        return ibl_no_memory(ctx, "the spherical harmonics in other axes");
    for (int m = 0; m <= degree; m++)
        for (int l = m; l <= degree; l++)
            root[(size_t)m * edge + (size_t)l] =
                sqrt((double)(l - m) * (l + m));
    sort(&t, t.from, false, coeffs);
    const ibl_status status = ibl_run(ctx, NULL, degree + 1, order_job, &t);
    if (!status)
        sort(&t, t.to, true, coeffs);
    ibl_free(root);
    return status;
}

/* Turns by 90 degrees from x to y, or back. */
static void turn_about_z(int degree, int back, double *coeffs)
{
    for (int l = 1; l <= degree; l++)
        for (int m = 1; m <= l; m++)
            for (size_t k = 0; k < 3; k++) {
                double *cosine = coeffs + index_of(l, m) + k;
                double *sine = coeffs + index_of(l, -m) + k;
                const double c = *cosine, s = *sine;
                const double sign = (m % 4 == 1) != back ? 1 : -1;
                *cosine = m % 2 ? -sign * s : m % 4 ? -c : c;
                *sine = m % 2 ? sign * c : m % 4 ? -s : s;
            }
}

/* Its own inverse. */
static ibl_status mirror(ibl_ctx *ctx, int degree, ibl_mirror across,
                         double *coeffs)
{
    if (across == IBL_MIRROR_XZ) {
        turn_about_z(degree, 1, coeffs);
        const ibl_status status = turn_up(ctx, degree, 0, coeffs);
        if (status)
            return status;
        turn_about_z(degree, 0, coeffs);
        across = IBL_MIRROR_Z;
    }
    if (across)
        change_signs(degree, across, coeffs);
    return IBL_OK;
}

ibl_status ibl_sh_turn_axes(ibl_ctx *ctx, int degree, ibl_axes axes, int back,
                            double *coeffs)
{
    if (!ctx || !coeffs)
        return ibl_missing(ctx, "ibl_sh_turn_axes: coeffs");
    ibl_status status = ibl_check_axes(ctx, axes);
    if (!status && (degree < 0 || degree > IBL_MAX_SH_DEGREE))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "spherical harmonics of degree %d: must be 0 to %d",
                        degree, IBL_MAX_SH_DEGREE);
    if (!status && !back)
        status = mirror(ctx, degree, axes.mirror, coeffs);
    if (!status && axes.up == IBL_UP_Z)
        status = turn_up(ctx, degree, back, coeffs);
    if (!status && back)
        status = mirror(ctx, degree, axes.mirror, coeffs);
    return status;
}
