/* SPDX-License-Identifier: MIT */
#ifndef VIEW_VECTOR_H
#define VIEW_VECTOR_H

#include <math.h>

static inline double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross3(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; k++)
        c[k] =
            a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* a is not 0. */
static inline void normalise3(double a[3])
{
    const double length = sqrt(dot3(a, a));

    for (int k = 0; k < 3; k++)
        a[k] /= length;
}

/* ---- spherical harmonics (baked_set.c) --------------------------------- */

/* Highest degree of irradiance that is drawn. */
#define VIEW_SH_DEGREE 4
#define VIEW_SH_COUNT ((VIEW_SH_DEGREE + 1) * (VIEW_SH_DEGREE + 1))

/* Sums harmonics in a unit direction, for one to four channels. Order and basis
 * are those of ibl_bake_sh: count (l + 1)^2 means degree l. */
void view_harmonics_sum(const double *coefficients, int count, int channels,
                        const double d[3], double *sum);

#endif
