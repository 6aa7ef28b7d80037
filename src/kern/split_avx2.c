/* SPDX-License-Identifier: MIT */
#include "kern/split_lanes.h"

void ibl_split_sums_avx2(const ibl_split_rule *rule, ibl_geometry geometry,
                         double alpha, const double *n_dot_v, int count,
                         float *sum)
{
    split_sums(rule, geometry, alpha, n_dot_v, count, sum);
}

void ibl_split_mix_avx2(const float *table, size_t stride, const float *pair,
                        int terms, int count, float *out)
{
    split_mix(table, stride, pair, terms, count, out);
}
