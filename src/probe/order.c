/* SPDX-License-Identifier: MIT */
#include <stdbool.h>

#include "ibl/probes.h"

/* Whether probe a comes after probe b. */
static bool after(const ibl_probe *probes, int a, int b)
{
    if (probes[a].priority != probes[b].priority)
        return probes[a].priority < probes[b].priority;
    const double size_a = ibl_volume_size(&probes[a].influence);
    const double size_b = ibl_volume_size(&probes[b].influence);

    if (size_a != size_b)
        return size_a > size_b;
    return a > b;
}

/* Restores the heap of the first count below i: a parent is after its
 * children. */
static void sift(const ibl_probe *probes, int *order, int i, int count)
{
    for (int child; (child = 2 * i + 1) < count; i = child) {
        const int parent = order[i];

        if (child + 1 < count && after(probes, order[child + 1], order[child]))
            child++;
        if (!after(probes, order[child], parent))
            return;
        order[i] = order[child];
        order[child] = parent;
    }
}

/* A heap needs no memory; no two are equal, so that it need not be stable. */
void ibl_probes_order(const ibl_probe *probes, int count, int *order)
{
    for (int i = 0; i < count; i++)
        order[i] = i;
    for (int i = count / 2 - 1; i >= 0; i--)
        sift(probes, order, i, count);
    for (int last = count - 1; last > 0; last--) {
        const int top = order[0];

        order[0] = order[last];
        order[last] = top;
        sift(probes, order, 0, last);
    }
}
