/* SPDX-License-Identifier: MIT */
/* Which roughness a level of the specular chain stands for. */
#include <math.h>

#include "ibl/ibl.h"

const char *ibl_roughness_map_name(ibl_roughness_map map)
{
    return map == IBL_ROUGHNESS_FILAMENT ? "filament" : "linear";
}

double ibl_level_roughness(ibl_roughness_map map, int level, int levels)
{
    const double t = levels > 1 ? (double)level / (levels - 1) : 0;
    return map == IBL_ROUGHNESS_FILAMENT ? 1 - sqrt(1 - t) : t;
}

int ibl_default_levels(int size)
{
    const int last = size < 8 ? 1 : 8;
    int levels = 1;
    while (size >> levels >= last)
        levels++;
    return levels;
}
