/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "ibl/probes.h"

/* Takes out an entry of the mix. */
static void drop(ibl_probe_mix *mix, int at)
{
    mix->count--;
    for (int i = at; i < mix->count; i++) {
        mix->probe[i] = mix->probe[i + 1];
        mix->weight[i] = mix->weight[i + 1];
    }
}

/* Adds a share; the least goes where there are too many. Returns the one that
 * went, or 0. */
static double add(ibl_probe_mix *mix, int probe, double share)
{
    double gone = 0;

    if (mix->count == IBL_MAX_PROBES_AT) {
        int least = 0;

        for (int i = 1; i < mix->count; i++) {
            if (mix->weight[i] <= mix->weight[least])
                least = i;
        }
        if (!(share > mix->weight[least]))
            return share;
        gone = mix->weight[least];
        drop(mix, least);
    }
    mix->probe[mix->count] = probe;
    mix->weight[mix->count] = share;
    mix->count++;
    return gone;
}

void ibl_probes_blend(const ibl_probe *probes, int count, const int *order,
                      const double point[3], const double *alpha,
                      ibl_probe_mix *mix)
{
    double left = 1, fifth = 0, sum = 0;

    *mix = (ibl_probe_mix){0};
    for (int i = 0; i < count && left > 0; i++) {
        const int probe = order[i];
        double share = ibl_probe_influence(&probes[probe], point);

        if (alpha)
            share *= alpha[probe];
        share = fmin(share, left);
        if (!(share > 0))
            continue;
        left -= share;
        fifth = fmax(fifth, add(mix, probe, share));
    }
    for (int i = mix->count - 1; i >= 0; i--) {
        mix->weight[i] -= fifth;
        if (!(mix->weight[i] > 0))
            drop(mix, i);
    }
    for (int i = 0; i < mix->count; i++)
        sum += mix->weight[i];
    mix->rest = fmax(1 - sum, 0);
}
