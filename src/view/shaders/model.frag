// SPDX-License-Identifier: MIT
// A model as shaders of games draw it, by the functions of ibl/ibl.glsl.
#include "model.glsl"
#include "lights.glsl"
#include "lookup.glsl"

void lit(layer s, vec3 view, bool diffuse_part, uint number, out vec3 specular,
         out vec3 light)
{
    vec2 rg = ibl_brdf(lut_map, s.n_v, s.roughness);
    light = irradiance(s.normal);
    vec3 seen = ibl_specular(specular_map,
                             lobe_of(s.n_v, s.roughness, s.f0, rg),
                             turned(s.normal), turned(view), light);
    specular = (s.f0 * rg.x + rg.y) * seen;
    add_lights(at, s.normal, view, s.f0, s.roughness, reflection.z, specular,
               light);
}

#ifdef SHEEN
uniform samplerCube sheen_chain;

vec3 lit_sheen(layer s, vec3 view, vec2 sheen)
{
    // Half way to the normal is nearer to the integral than the mirrored
    // direction or the normal.
    vec3 r = turned(0.5 * (reflect(-view, s.normal) + s.normal));
    return sheen.r * textureLod(sheen_chain, r, sheen.g).rgb;
}
#endif
