/* SPDX-License-Identifier: MIT */
/* AT_ONCE vectors of points stay in registers for all l; each l has a vector of
 * sums, whose lanes are added at the end. The recurrence is linear: started
 * with the weight it gives weighted P_l. */
#include "kern/lanes.h"
#include "kern/legendre_sums.h"

enum {
    AT_ONCE = VF == 4 ? REGISTERS / 4 : 4
};
enum {
    OF_VALUES = IBL_LEGENDRE_VALUES_POINTS / VD /* vectors at once */
};
_Static_assert(IBL_LEGENDRE_SUMS_POINTS % (AT_ONCE * VD) == 0, "whole blocks");

static inline vd total(const vd p[AT_ONCE])
{
    vd sum = (p[0] + p[1]) + (p[2] + p[3]);

#pragma GCC unroll 4
    for (int n = 4; n < AT_ONCE; n += 4)
        sum += (p[n] + p[n + 1]) + (p[n + 2] + p[n + 3]);
    return sum;
}

static inline void add_block(const double *y, const double *w,
                             const double *inverse, int degree, double *sums)
{
    vd at[AT_ONCE], p[AT_ONCE], e[AT_ONCE], minus = vd_all(-1);
    const vd two = vd_all(2);

#pragma GCC unroll 8
    for (int n = 0; n < AT_ONCE; n++) {
        at[n] = vd_load(y + n * VD);
        p[n] = vd_load(w + n * VD);
        e[n] = vd_all(0);
    }
    vd_store(sums, vd_load(sums) + total(p));
    for (int l = 0; l < degree; l++) {
        const vd part = vd_all(inverse[l]);
        double *to = sums + (size_t)(l + 1) * VD;
#pragma GCC unroll 8
        for (int n = 0; n < AT_ONCE; n++) {
            e[n] = vd_fma(minus, at[n] * p[n], e[n]);
            p[n] = vd_fma(e[n], part, p[n]);
        }
        vd_store(to, vd_load(to) + total(p));
        minus -= two;
    }
}

static void sums_of_points(const double *y, const double *w, int count,
                           const double *inverse, int degree, double *scratch,
                           double *k)
{
    for (int l = 0; l <= degree; l++)
        vd_store(scratch + (size_t)l * VD, vd_all(0));
    for (int i = 0; i < count; i += AT_ONCE * VD)
        add_block(y + i, w + i, inverse, degree, scratch);
    for (int l = 0; l <= degree; l++) {
        const double *from = scratch + (size_t)l * VD;
        double sum = 0;
        for (int i = 0; i < VD; i++)
            sum += from[i];
        k[l] = sum;
    }
}

/* Q_l-1 becomes Q_l+1. */
static inline void next_values(double factor, const vd x[OF_VALUES],
                               const vd now[OF_VALUES], vd last[OF_VALUES])
{
    const vd f = vd_all(factor);
#pragma GCC unroll 8
    for (int n = 0; n < OF_VALUES; n++)
        last[n] = vd_fma(f * x[n], now[n], last[n]);
}

static inline void swap_values(vd a[OF_VALUES], vd b[OF_VALUES])
{
#pragma GCC unroll 8
    for (int n = 0; n < OF_VALUES; n++) {
        const vd v = a[n];
        a[n] = b[n];
        b[n] = v;
    }
}

static void values_at(const double *x, const double *start, int count,
                      const double *factor, int m, const int *degree,
                      int degrees, size_t stride, double *values)
{
    for (int i = 0; i < count; i += IBL_LEGENDRE_VALUES_POINTS) {
        vd at[OF_VALUES], now[OF_VALUES], last[OF_VALUES];
        double *to = values + i;
        int l = m;

#pragma GCC unroll 8
        for (int n = 0; n < OF_VALUES; n++) {
            at[n] = vd_load(x + i + n * VD);
            now[n] = vd_load(start + i + n * VD);
            last[n] = vd_all(0);
        }
        for (int d = 0; d < degrees; d++, to += stride) {
            for (; l + 1 < degree[d]; l += 2) {
                next_values(factor[l], at, now, last);
                next_values(factor[l + 1], at, last, now);
            }
            for (; l < degree[d]; l++) {
                next_values(factor[l], at, now, last);
                swap_values(now, last);
            }
#pragma GCC unroll 8
            for (int n = 0; n < OF_VALUES; n++)
                vd_store(to + n * VD, now[n]);
        }
    }
}

IBL_VECTOR_KERNEL(ibl_legendre_sums, sums_of_points, values_at)
