/* SPDX-License-Identifier: MIT */
/* The probes that light a point, by their volumes in order. */
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
