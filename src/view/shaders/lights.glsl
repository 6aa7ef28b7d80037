// SPDX-License-Identifier: MIT
// Lights that are no part of the maps: the set's discs, and point lights, which
// fall with the square of the distance.
#include "ibl.glsl"
#include "ray.glsl"

// Minimum roughness for lights without a size, which a mirror would not show:
// Filament's MIN_PERCEPTUAL_ROUGHNESS.
const float LIGHT_ROUGHNESS = 0.045;

// Adds point lights at p and the first discs: their reflection to specular,
// irradiance / pi to diffuse.
void add_lights(vec3 p, vec3 n, vec3 v, vec3 f0, float roughness, int discs,
                inout vec3 specular, inout vec3 diffuse)
{
    for (int i = 0; i < shading.y; i++) {
        vec3 to = light_position[i].xyz - p;
        ibl_add_light(n, v, f0, max(roughness, LIGHT_ROUGHNESS), normalize(to),
                      0.0, light_intensity[i].rgb * (1.0 / dot(to, to)),
                      specular, diffuse);
    }
    vec3 n_turned = turned(n), v_turned = turned(v);
    for (int i = 0; i < discs; i++)
        ibl_add_light(n_turned, v_turned, f0, roughness, disc_direction[i].xyz,
                      disc_direction[i].w, disc_irradiance[i].rgb, specular,
                      diffuse);
}
