// SPDX-License-Identifier: MIT
// Lights from one direction: Cook-Torrance with GGX, Smith and Schlick. Point
// lights fall with the square of the distance.
#include "ibl.glsl"
#include "frame.glsl"

// Minimum roughness for lights, which a mirror would not show: Filament's
// MIN_PERCEPTUAL_ROUGHNESS.
const float LIGHT_ROUGHNESS = 0.045;

// Adds all point lights at p: their reflection to specular, irradiance / pi to
// diffuse.
void add_lights(vec3 p, vec3 n, vec3 v, vec3 f0, float roughness,
                inout vec3 specular, inout vec3 diffuse)
{
    for (int i = 0; i < shading.y; i++) {
        vec3 to = light_position[i].xyz - p;
        ibl_add_light(n, v, f0, max(roughness, LIGHT_ROUGHNESS), normalize(to),
                      0.0, light_intensity[i].rgb * (1.0 / dot(to, to)),
                      specular, diffuse);
    }
}
