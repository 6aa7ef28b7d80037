// SPDX-License-Identifier: MIT
// How reflections are looked up: view_reflection of view/settings.h.
#include "frame.glsl"
#include "ibl.glsl"

uniform sampler2DArray lobe_map;

// Programs for one reflection define it.
#ifndef REFLECTION
#define REFLECTION reflection.x
#endif

const int BENT = 1, FIT = 2, TABLE = 3, TWO_TAPS = 4, FOUR_TAPS = 5;

ibl_lobe lobe_of(float n_v, float roughness, vec3 f0, vec2 rg)
{
    if (REFLECTION == BENT)
        return ibl_lobe_bent(n_v, roughness, lod);
    if (REFLECTION == FIT)
        return ibl_lobe_fit(n_v, roughness, ibl_metallic(f0, rg), lod);
    if (REFLECTION >= TABLE)
        return ibl_lobe_taps(lobe_map, n_v, roughness, ibl_metallic(f0, rg),
                             lod, REFLECTION == FOUR_TAPS ? 4
                                  : REFLECTION == TWO_TAPS ? 2 : 1);
    return ibl_lobe_split(roughness, lod);
}
