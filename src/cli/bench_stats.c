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

/* The stage's name without a level number: "specular 3" -> "specular". */
static void group_of(const char *stage, char *group, size_t size)
{
    snprintf(group, size, "%s", stage);
    if (!strncmp(group, "specular ", 9))
        group[8] = '\0';
}

int ibl_bench_groups(const ibl_bench *b, char groups[][32], int most)
{
    int count = 0;

    for (int i = 0; i < b->point_count; i++)
        for (int k = 0; k < b->points[i].stage_count; k++) {
            char name[32];
            int g = 0;
            group_of(b->points[i].stages[k].name, name, sizeof name);
            while (g < count && strcmp(groups[g], name) != 0)
                g++;
            if (g == count && count < most)
                memcpy(groups[count++], name, sizeof name);
        }
    return count;
}

double ibl_bench_group_seconds(const ibl_bench_point *p, const char *group)
{
    double sum = 0;
    bool any = false;

    for (int i = 0; i < p->stage_count; i++) {
        char name[32];
        group_of(p->stages[i].name, name, sizeof name);
        if (!strcmp(name, group)) {
            sum += p->stages[i].stat.median;
            any = true;
        }
    }
    return any ? sum : NAN;
}
