/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The value below which the part q of n sorted values lies, between two of
 * them by how near it is to each (R's type 7, the usual one). */
static double quantile(const double *sorted, int n, double q)
{
    const double at = q * (n - 1);
    const int i = (int)at;
    return i + 1 < n ? sorted[i] + (at - i) * (sorted[i + 1] - sorted[i])
                     : sorted[n - 1];
}

ibl_bench_stat ibl_bench_stat_of(const double *values, int n)
{
    double sorted[IBL_BENCH_ROUNDS];

    memcpy(sorted, values, (size_t)n * sizeof *sorted);
    qsort(sorted, (size_t)n, sizeof *sorted, by_value);
    return (ibl_bench_stat){quantile(sorted, n, 0.5), quantile(sorted, n, 0.25),
                            quantile(sorted, n, 0.75)};
}

/* Index of a stage among names, or -1. */
static int find_name(char names[][32], int count, const char *name)
{
    for (int i = 0; i < count; i++)
        if (!strcmp(names[i], name))
            return i;
    return -1;
}

int ibl_bench_stages(const ibl_bench *b, char names[][32], int most)
{
    int count = 0;

    for (int i = 0; i < b->point_count; i++)
        for (int k = 0, next = 0; k < b->points[i].stage_count; k++) {
            const char *name = b->points[i].stages[k].name;
            const int at = find_name(names, count, name);
            if (at < 0 && count == most)
                continue;
            if (at < 0) {
                memmove(names[next + 1], names[next],
                        (size_t)(count - next) * sizeof *names);
                snprintf(names[next], sizeof *names, "%s", name);
                count++;
            }
            next = (at < 0 ? next : at) + 1;
        }
    return count;
}

double ibl_bench_stage_seconds(const ibl_bench_point *p, const char *name)
{
    for (int i = 0; i < p->stage_count; i++)
        if (!strcmp(p->stages[i].name, name))
            return p->stages[i].stat.median;
    return NAN;
}
