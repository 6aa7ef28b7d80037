/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "core/vector.h"
#include "ibl/probes.h"

int ibl_probes_nearest(const ibl_probe *probes, int count,
                       const double point[3])
{
    double least = 0;
    int nearest = -1;

    for (int i = 0; i < count; i++) {
        const double d = distance3(probes[i].position, point);

        if (nearest < 0 || d < least) {
            nearest = i;
            least = d;
        }
    }
    return nearest;
}

/* The n nearest, nearest first, of equals the first; returns how many. */
static int find_near(const ibl_probe *probes, int count, const double point[3],
                     int n, int *index, double *distance)
{
    int found = 0;

    for (int i = 0; i < count; i++) {
        const double d = distance3(probes[i].position, point);
        int at = found < n ? found++ : n;

        for (; at > 0 && d < distance[at - 1]; at--) {
            if (at < n) {
                index[at] = index[at - 1];
                distance[at] = distance[at - 1];
            }
        }
        if (at < n) {
            index[at] = i;
            distance[at] = d;
        }
    }
    return found;
}

/* (1/d - 1/R)^2, times the square of the least d, which is finite there. */
static double weigh(double d, double least, double reach)
{
    if (!(d > 0))
        return 1;
    const double w = (1 - d / reach) * (least / d);

    return w * w;
}

void ibl_probes_near(const ibl_probe *probes, int count, const double point[3],
                     int k, ibl_probe_mix *mix)
{
    int index[IBL_MAX_PROBES_AT + 1];
    double distance[IBL_MAX_PROBES_AT + 1], sum = 0;

    *mix = (ibl_probe_mix){.rest = 1};
    k = k < 1 ? 1 : k > IBL_MAX_PROBES_AT ? IBL_MAX_PROBES_AT : k;
    const int found = find_near(probes, count, point, k + 1, index, distance);
    const double reach = found > k ? distance[k] : HUGE_VAL;

    if (found == 0)
        return;
    mix->rest = 0;
    mix->count = found < k ? found : k;
    for (int i = 0; i < mix->count; i++) {
        mix->probe[i] = index[i];
        mix->weight[i] = weigh(distance[i], distance[0], reach);
        sum += mix->weight[i];
    }
    for (int i = 0; i < mix->count; i++)
        mix->weight[i] = sum > 0 ? mix->weight[i] / sum : 1.0 / mix->count;
}
