/* SPDX-License-Identifier: MIT */
#ifndef IBL_CORE_VECTOR_H
#define IBL_CORE_VECTOR_H

#include <math.h>
#include <stdbool.h>

static inline double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross3(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void subtract3(const double a[3], const double b[3], double c[3])
{
    for (int i = 0; i < 3; i++)
        c[i] = a[i] - b[i];
}

static inline double distance3(const double a[3], const double b[3])
{
    double d[3];

    subtract3(a, b, d);
    return sqrt(dot3(d, d));
}

/* Normalises v of any length except 0: then false, and v is unchanged. */
static inline bool unit3(double v[3])
{
    const double most = fmax(fmax(fabs(v[0]), fabs(v[1])), fabs(v[2]));

    if (!(most > 0))
        return false;
    if (most < 0x1p-500 || most > 0x1p500) { /* squares would overflow */
        const int exponent = ilogb(most);
        for (int i = 0; i < 3; i++)
            v[i] = ldexp(v[i], -exponent);
    }
    const double length = sqrt(dot3(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return true;
}

#endif
