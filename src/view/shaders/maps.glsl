// SPDX-License-Identifier: MIT
// Lookups in baked maps. Directions are in world space.
#include "ray.glsl"

uniform samplerCube specular_map;
uniform samplerCube irradiance_map;
uniform sampler2D lut_map;

// Level of a roughness: x scale + offset with x = r or, with Filament's
// mapping, r (2 - r): ibl_specular_layout of ibl/ibl.h. lod as in the frame.
float lod_of(vec4 lod, float r)
{
    float x = int(lod.w) == 1 ? r * (2.0 - r) : r;
    return clamp(x * lod.x + lod.y, 0.0, lod.z);
}

vec3 specular_light(float roughness, vec3 direction)
{
    return textureLod(specular_map, turned(direction),
                      lod_of(lod, roughness)).rgb;
}

// Sum of sh[] with the real basis of ibl_bake_sh, to degree 4: Sloan 2013,
// "Efficient Spherical Harmonic Evaluation", appendix A2, without alternating
// signs. Irradiance has no degree 3: Ramamoorthi and Hanrahan 2001, eq. 9.
vec3 irradiance_sh(vec3 d)
{
    float x = d.x, y = d.y, z = d.z;
    float x2 = x * x, y2 = y * y, z2 = z * z;
    vec3 e = 0.28209479177387814 * sh[0].rgb;
    e += 0.4886025119029199 * (y * sh[1] + z * sh[2] + x * sh[3]).rgb;
    e += 1.0925484305920792 *
         (x * y * sh[4] + y * z * sh[5] + x * z * sh[7]).rgb;
    e += 0.31539156525252005 * (3.0 * z2 - 1.0) * sh[6].rgb;
    e += 0.5462742152960396 * (x2 - y2) * sh[8].rgb;
    e += 2.5033429417967046 * x * y * (x2 - y2) * sh[16].rgb;
    e += 1.7701307697799304 * z *
         (y * (3.0 * x2 - y2) * sh[17] + x * (x2 - 3.0 * y2) * sh[23]).rgb;
    e += 0.9461746957575601 * (7.0 * z2 - 1.0) *
         (x * y * sh[18] + 0.5 * (x2 - y2) * sh[22]).rgb;
    e += 0.6690465435572892 * z * (7.0 * z2 - 3.0) *
         (y * sh[19] + x * sh[21]).rgb;
    e += 0.10578554691520431 * (z2 * (35.0 * z2 - 30.0) + 3.0) * sh[20].rgb;
    e += 0.6258357354491761 *
         (x2 * (x2 - 3.0 * y2) - y2 * (3.0 * x2 - y2)) * sh[24].rgb;
    return max(e, 0.0);
}

// Irradiance / pi from level 0: a map may have smaller levels.
vec3 irradiance(vec3 n)
{
    vec3 d = turned(n);
    return choice.y == 1 ? irradiance_sh(d)
                         : diffuse.x * textureLod(irradiance_map, d, 0.0).rgb;
}

// R and G of the split sum. Texel (i, j) is at N.V = (i + .5) / n and roughness
vec2 table(float n_v, float roughness)
{
    return textureLod(lut_map, vec2(n_v, roughness), 0.0).rg;
}
