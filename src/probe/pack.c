/* SPDX-License-Identifier: MIT */
#include "ibl/probes.h"

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
