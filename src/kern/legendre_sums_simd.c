/* SPDX-License-Identifier: MIT */
/* Four vectors of points stay in registers for all l; each l has a vector of
 * sums, whose lanes are added at the end. The recurrence is linear: started
 * with the weight it gives weighted P_l. */
#define IBL_LANES_16
#include "kern/lanes.h"
#include "kern/legendre_sums.h"

static inline void add_block(const double *y, const double *w,
                             const double *inverse, int degree, double *sums)
{
    const vd y0 = vd_load(y), y1 = vd_load(y + VD);
    const vd y2 = vd_load(y + 2 * VD), y3 = vd_load(y + 3 * VD);
    vd p0 = vd_load(w), p1 = vd_load(w + VD);
    vd p2 = vd_load(w + 2 * VD), p3 = vd_load(w + 3 * VD);
    vd e0 = vd_all(0), e1 = e0, e2 = e0, e3 = e0;
    vd minus = vd_all(-1);
    const vd two = vd_all(2);

    vd_store(sums, vd_load(sums) + ((p0 + p1) + (p2 + p3)));
    for (int l = 0; l < degree; l++) {
        const vd part = vd_all(inverse[l]);
        double *to = sums + (size_t)(l + 1) * VD;
        e0 = vd_fma(minus, y0 * p0, e0);
        e1 = vd_fma(minus, y1 * p1, e1);
        e2 = vd_fma(minus, y2 * p2, e2);
        e3 = vd_fma(minus, y3 * p3, e3);
        p0 = vd_fma(e0, part, p0);
        p1 = vd_fma(e1, part, p1);
        p2 = vd_fma(e2, part, p2);
        p3 = vd_fma(e3, part, p3);
        vd_store(to, vd_load(to) + ((p0 + p1) + (p2 + p3)));
        minus -= two;
    }
}

static void sums_of_points(const double *y, const double *w, int count,
                           const double *inverse, int degree, double *scratch,
                           double *k)
{
    for (int l = 0; l <= degree; l++)
        vd_store(scratch + (size_t)l * VD, vd_all(0));
    for (int i = 0; i < count; i += 4 * VD)
        add_block(y + i, w + i, inverse, degree, scratch);
    for (int l = 0; l <= degree; l++) {
        const double *from = scratch + (size_t)l * VD;
        double sum = 0;
        for (int i = 0; i < VD; i++)
            sum += from[i];
        k[l] = sum;
    }
}

IBL_VECTOR_KERNEL(ibl_legendre_sums, sums_of_points)
