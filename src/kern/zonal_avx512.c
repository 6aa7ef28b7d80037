/* SPDX-License-Identifier: MIT */
#include "kern/zonal_lanes.h"

void ibl_zonal_sums_avx512(const double *y, const double *w, int count,
                           const double *inverse, int degree, double *scratch,
                           double *k)
{
    zonal_sums(y, w, count, inverse, degree, scratch, k);
}
