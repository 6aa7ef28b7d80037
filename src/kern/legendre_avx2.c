/* SPDX-License-Identifier: MIT */
#include "kern/legendre_lanes.h"

void ibl_legendre_analyse_avx2(const ibl_legendre_order *o, const float *f,
                               size_t stride, double *a)
{
    analyse(o, f, stride, a);
}

void ibl_legendre_synthesise_avx2(const ibl_legendre_order *o, const double *a,
                                  const double *factor, float *g, size_t stride)
{
    synthesise(o, a, factor, g, stride);
}
