/* SPDX-License-Identifier: MIT */
/* The probes that light a point: by their volumes in order, or the nearest. */
#include <math.h>
#include <stdbool.h>

#include "core/pi.h"
#include "core/vector.h"
#include "ibl/probes.h"

/* ---- volumes ------------------------------------------------------------ */

const char *ibl_shape_name(ibl_shape shape)
{
    switch (shape) {
    case IBL_SHAPE_BOX:
        return "box";
    case IBL_SHAPE_SPHERE:
        return "sphere";
    }
    return "unknown";
}

double ibl_volume_size(const ibl_volume *volume)
{
    const double *h = volume->half;

    if (volume->shape == IBL_SHAPE_SPHERE)
        return 4 * IBL_PI / 3 * h[0] * h[0] * h[0];
    return 8 * h[0] * h[1] * h[2];
}

/* The depth of a point inside a volume; negative outside. Depths of two points
 * differ at most by their distance. */
static double depth_in(const ibl_volume *volume, const double point[3])
{
    const double *c = volume->centre, *h = volume->half;

    if (volume->shape == IBL_SHAPE_SPHERE)
        return h[0] - distance3(point, c);
    const double x = h[0] - fabs(point[0] - c[0]);
    const double y = h[1] - fabs(point[1] - c[1]);
    const double z = h[2] - fabs(point[2] - c[2]);

    return fmin(fmin(x, y), z);
}

double ibl_probe_influence(const ibl_probe *probe, const double point[3])
{
    const double depth = depth_in(&probe->influence, point);

    if (!(depth > 0))
        return 0;
    if (!(depth < probe->blend))
        return 1;
    const double t = depth / probe->blend;

    return t * t * (3 - 2 * t);
}

/* ---- order -------------------------------------------------------------- */

static bool before(const ibl_probe *a, const ibl_probe *b)
{
    if (a->priority != b->priority)
        return a->priority > b->priority;
    return ibl_volume_size(&a->influence) < ibl_volume_size(&b->influence);
}

void ibl_probes_order(const ibl_probe *probes, int count, int *order)
{
    for (int i = 0; i < count; i++) {
        int at = i;

        for (; at > 0 && before(&probes[i], &probes[order[at - 1]]); at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
}

/* ---- by volumes --------------------------------------------------------- */

/* Removes the least of n shares, the last of equals; returns it. */
static double drop_least(int *probe, double *share, int n)
{
    int least = 0;

    for (int i = 1; i < n; i++) {
        if (share[i] <= share[least])
            least = i;
    }
    const double gone = share[least];

    for (int i = least; i < n - 1; i++) {
        probe[i] = probe[i + 1];
        share[i] = share[i + 1];
    }
    return gone;
}

void ibl_probes_blend(const ibl_probe *probes, int count, const int *order,
                      const double point[3], const double *alpha,
                      ibl_probe_mix *mix)
{
    int probe[IBL_MAX_PROBES_AT + 1], n = 0;
    double share[IBL_MAX_PROBES_AT + 1], left = 1, next = 0, sum = 0;

    *mix = (ibl_probe_mix){0};
    for (int i = 0; i < count && left > 0; i++) {
        probe[n] = order[i];
        share[n] = ibl_probe_influence(&probes[order[i]], point);
        if (alpha)
            share[n] *= alpha[order[i]];
        share[n] = fmin(share[n], left);
        if (!(share[n] > 0))
            continue;
        left -= share[n++];
        if (n > IBL_MAX_PROBES_AT)
            next = fmax(next, drop_least(probe, share, n--));
    }
    for (int i = 0; i < n; i++)
        sum += share[i] - next;
    if (!(sum > 0)) { /* all are equal */
        sum += n * next;
        next = 0;
    }
    for (int i = 0; i < n; i++) {
        if (!(share[i] - next > 0))
            continue;
        mix->probe[mix->count] = probe[i];
        mix->weight[mix->count++] = (share[i] - next) / sum * (1 - left);
    }
    mix->rest = left;
}

/* ---- the nearest -------------------------------------------------------- */

/* Finds the n nearest probes, nearest first, equals by index. Returns their
 * number, n or less. */
static int find_near(const ibl_probe *probes, int count, const double point[3],
                     int n, int *index, double *distance)
{
    int found = 0;

    for (int i = 0; i < count; i++) {
        const double d = distance3(probes[i].position, point);
        if (found == n && !(d < distance[n - 1]))
            continue;
        int at = found < n ? found++ : n - 1;
        for (; at > 0 && d < distance[at - 1]; at--) {
            index[at] = index[at - 1];
            distance[at] = distance[at - 1];
        }
        index[at] = i;
        distance[at] = d;
    }
    return found;
}

/* (1/d - 1/R)^2 times least^2, which makes it finite at d = least = 0. */
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

int ibl_probes_nearest(const ibl_probe *probes, int count,
                       const double point[3])
{
    ibl_probe_mix mix;

    ibl_probes_near(probes, count, point, 1, &mix);
    return mix.count ? mix.probe[0] : -1;
}

/* ---- for shaders -------------------------------------------------------- */

static void pack3(const double v[3], double fourth, float texel[4])
{
    for (int i = 0; i < 3; i++)
        texel[i] = (float)v[i];
    texel[3] = (float)fourth;
}

static void pack_volume(const ibl_volume *volume, double with, float *texels)
{
    pack3(volume->centre, with, texels);
    pack3(volume->half, volume->shape == IBL_SHAPE_SPHERE, texels + 4);
}

void ibl_probes_pack(const ibl_probe *probes, int count, const int *order,
                     float *texels)
{
    for (int i = 0; i < count; i++, texels += IBL_PROBE_FLOATS) {
        const ibl_probe *probe = &probes[order[i]];

        pack_volume(&probe->influence, probe->blend, texels);
        pack_volume(&probe->proxy, probe->has_proxy != 0, texels + 8);
        pack3(probe->position, probe->layer, texels + 16);
    }
}
