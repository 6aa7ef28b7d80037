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

#endif
