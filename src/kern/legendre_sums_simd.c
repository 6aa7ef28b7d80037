/* SPDX-License-Identifier: MIT */
/* AT_ONCE vectors of points stay in registers for all l; each l has LANES sums,
 * which are added at the end. The recurrence is linear: started with the weight
 * it gives weighted P_l. */
#include <string.h>

#include "kern/lanes.h"
#include "kern/legendre_sums.h"

enum {
    LANES = 4,
    PARTS = LANES / VD, /* vectors of them */
    AT_ONCE = REGISTERS / 4
};
_Static_assert(IBL_LEGENDRE_SUMS_POINTS % (AT_ONCE * VD) == 0, "whole blocks");

/* Adds sixteen points, or fewer, to the lanes: four to each. */
static inline void add_lanes(const vd p[AT_ONCE], double *sums)
{
#pragma GCC unroll 2
    for (int h = 0; h < PARTS; h++) {
        vd sum = p[h] + p[h + PARTS];
        if (AT_ONCE == 4 * PARTS)
            sum += p[h + 2 * PARTS] + p[h + 3 * PARTS];
        vd_store(sums + h * VD, vd_load(sums + h * VD) + sum);
    }
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
    add_lanes(p, sums);
    for (int l = 0; l < degree; l++) {
        const vd part = vd_all(inverse[l]);
#pragma GCC unroll 8
        for (int n = 0; n < AT_ONCE; n++) {
            e[n] = vd_fma(minus, at[n] * p[n], e[n]);
            p[n] = vd_fma(e[n], part, p[n]);
        }
        add_lanes(p, sums + (size_t)(l + 1) * LANES);
        minus -= two;
    }
}

static void sums_of_points(const double *y, const double *w, int count,
                           const double *inverse, int degree, double *scratch,
                           double *k)
{
    memset(scratch, 0, ((size_t)degree + 1) * LANES * sizeof *scratch);
    for (int i = 0; i < count; i += AT_ONCE * VD)
        add_block(y + i, w + i, inverse, degree, scratch);
    for (int l = 0; l <= degree; l++) {
        const double *from = scratch + (size_t)l * LANES;
        double sum = 0;
        for (int i = 0; i < LANES; i++)
            sum += from[i];
        k[l] = sum;
    }
}

IBL_VECTOR_KERNEL(ibl_legendre_sums, sums_of_points)
