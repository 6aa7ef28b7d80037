// SPDX-License-Identifier: MIT
// Lookups in baked maps. Directions are in world space.
#include "ray.glsl"
#include "ibl.glsl"

uniform samplerCube specular_map;
uniform samplerCube irradiance_map;
uniform sampler2D lut_map;

// Programs for one kind of diffuse light define it: software renderers run both
// branches.
#ifndef DIFFUSE
#define DIFFUSE choice.y
#endif

// Irradiance / pi from level 0: a map may have smaller levels.
vec3 irradiance(vec3 n)
{
    vec3 d = turned(n);
    return DIFFUSE == 1 ? ibl_irradiance_sh4(sh, d)
                         : diffuse.x * ibl_irradiance(irradiance_map, d);
}

// Factor of irradiance / pi, with multiple scattering or without.
vec3 diffuse_factor(vec3 f0, vec3 albedo, vec2 rg)
{
    return shading.x != 0 ? ibl_diffuse_factor(f0, albedo, rg)
                          : albedo * (1.0 - f0 * rg.x - rg.y);
}
