/* SPDX-License-Identifier: MIT */
/*
 * The cyclic exchange of axes x' = z, y' = x, z' = y is a quarter turn about
 * y' between two quarter turns about the poles. With D[m][n] Wigner's
 * d^l_mn(pi / 2) and complex harmonics,
 *     Y_lm(x, y, z) = (-i)^m sum over n of D[n][m] Y_ln(x', y', z').
 * D[n][-m] = (-1)^(l+n) D[n][m] and D[n][m] = (-1)^(m-n) D[m][n] bring this
 * to n, m >= 0 and to real harmonics without the Condon-Shortley phase: with
 * C and S the functions with cos and sin, g_0 = 1, g_n = sqrt(2),
 *     m even   C_m = +-g_m sum D[m][n] g_n C'_n    l + n even
 *              S_m = +-g_m sum D[m][n] g_n S'_n    l + n odd
 *     m odd    C_m = +-g_m sum D[m][n] g_n S'_n    l + n even
 *              S_m = -+g_m sum D[m][n] g_n C'_n    l + n odd
 * with the upper sign for m = 0, 1 and the lower for m = 2, 3, and so on.
 * Coefficients go as their functions do.
 *
 * Rows of D come from the top, D[l][n] = (-1)^(l-n) 2^-l sqrt((2l)! /
 * ((l+n)! (l-n)!)), downwards by the elements of Jx,
 *     2n D[m] = c+(m) D[m+1] + c-(m) D[m-1],
 * the direction in which D grows where it is not oscillating (Risbo 1996;
 * Trapani and Navaza 2006).
 */
#include "bake/sh_rotate.h"

#include <math.h>
#include <string.h>

/* Orders n in pairs: an even and an odd one. */
static size_t padded(int l)
{
    return ((size_t)l + 2) / 2 * 2;
}

size_t ibl_sh_rotate_work(int l)
{
    return 9 * padded(l);
}

static void top_row(int l, double *row)
{
    double d = ldexp(1.0, -l);

    for (int n = l; n >= 0; n--) {
        row[n] = (l - n) % 2 ? -d : d;
        d *= sqrt((double)(l + n) / (l - n + 1));
    }
}

/* The row below m: next may be the row above m, which it replaces. */
static void next_row(int l, int m, const double *row, const double *above,
                     double *next)
{
    const double scale = 1.0 / sqrt((double)(l + m) * (l - m + 1));
    const double up = scale * sqrt((double)(l - m) * (l + m + 1));

    for (int n = 0; n <= l; n++)
        next[n] = 2.0 * scale * n * row[n] - up * above[n];
}

/* sum[0] over even n, sum[1] over odd n. */
static void dot(const double *row, const double *g, size_t count, double sum[2])
{
    double even = 0.0, odd = 0.0;

    for (size_t n = 0; n < count; n += 2) {
        even += row[n] * g[n];
        odd += row[n + 1] * g[n + 1];
    }
    sum[0] = even;
    sum[1] = odd;
}

/*
 * The inputs of channel k: for even m C' where l + n is even and S' where it
 * is odd, for odd m the other way round.
 */
static void split(int l, int k, const double *ring, double *for_even,
                  double *for_odd)
{
    for (int n = 0; n <= l; n++) {
        const double g = n ? sqrt(2.0) : 1.0;
        const double c = g * ring[6 * n + k], s = g * ring[6 * n + 3 + k];
        for_even[n] = (l + n) % 2 ? s : c;
        for_odd[n] = (l + n) % 2 ? c : s;
    }
}

static void order(int l, int m, const double *row, const double *inputs,
                  double *out)
{
    const size_t count = padded(l);
    const double g = (m ? sqrt(2.0) : 1.0) * (m % 4 >= 2 ? -1.0 : 1.0);

    for (int k = 0; k < 3; k++) {
        double sum[2];
        dot(row, inputs + (size_t)(2 * k + m % 2) * count, count, sum);
        const double even = sum[l % 2], odd = sum[1 - l % 2];
        out[3 * (l + m) + k] = g * even;
        if (m)
            out[3 * (l - m) + k] = m % 2 ? -g * odd : g * odd;
    }
}

void ibl_sh_rotate(int l, const double *ring, double *out, double *work)
{
    const size_t count = padded(l);
    double *row = work, *other = work + count, *inputs = work + 2 * count;

    memset(work, 0, ibl_sh_rotate_work(l) * sizeof *work);
    for (int k = 0; k < 3; k++)
        split(l, k, ring, inputs + 2 * (size_t)k * count,
              inputs + (2 * (size_t)k + 1) * count);
    top_row(l, row);
    for (int m = l; m >= 0; m--) {
        order(l, m, row, inputs, out);
        if (m) {
            double *above = other;
            next_row(l, m, row, above, above);
            other = row;
            row = above;
        }
    }
}
