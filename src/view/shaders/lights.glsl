// SPDX-License-Identifier: MIT
// Lights from one direction: Cook-Torrance with GGX, Smith and Schlick. Point
// lights fall with the square of the distance.
#include "brdf.glsl"
#include "frame.glsl"

// Minimum roughness for lights, which a mirror would not show: Filament's
// MIN_PERCEPTUAL_ROUGHNESS.
const float LIGHT_ROUGHNESS = 0.045;

// Adds a light from l (unit) with irradiance e on a plane facing it: its
// reflection to specular, irradiance / pi to diffuse.
void add_light(vec3 n, vec3 v, vec3 l, vec3 e, vec3 f0, float roughness,
               inout vec3 specular, inout vec3 diffuse)
{
    float r = max(roughness, LIGHT_ROUGHNESS);
    float n_v = max(dot(n, v), 0.0), n_l = dot(n, l);
    if (!(n_l > 0.0))
        return; // below the surface, or NaN if the light is at p
    vec3 h = normalize(v + l);
    e *= n_l;
    specular += e * ggx_d(n, h, r * r) * smith_v(n_l, n_v, r * r) *
                schlick_f(f0, clamp(dot(v, h), 0.0, 1.0));
    diffuse += e / PI;
}

// The same for all point lights, at p.
void add_lights(vec3 p, vec3 n, vec3 v, vec3 f0, float roughness,
                inout vec3 specular, inout vec3 diffuse)
{
    for (int i = 0; i < shading.y; i++) {
        vec3 to = light_position[i].xyz - p;
        add_light(n, v, normalize(to),
                  light_intensity[i].rgb * (1.0 / dot(to, to)), f0, roughness,
                  specular, diffuse);
    }
}
