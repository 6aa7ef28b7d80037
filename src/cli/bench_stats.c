/* SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The value below which the part q of n sorted values lies, interpolated
 * between its two neighbours (R's type 7, the usual one). */
static double quantile(const double *sorted, int n, double q)
{
    const double at = q * (n - 1);
    const int i = (int)at;
    return i + 1 < n ? sorted[i] + (at - i) * (sorted[i + 1] - sorted[i])
                     : sorted[n - 1];
}

void ibl_bench_sum_up(ibl_bench_series *s, int n)
{
    double sorted[IBL_BENCH_ROUNDS];

    memcpy(sorted, s->rounds, (size_t)n * sizeof *sorted);
    qsort(sorted, (size_t)n, sizeof *sorted, by_value);
    s->low = quantile(sorted, n, 0.25);
    s->median = quantile(sorted, n, 0.5);
    s->high = quantile(sorted, n, 0.75);
}
