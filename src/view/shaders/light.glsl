// SPDX-License-Identifier: MIT
// What lights a surface: a set's maps, and lights that are no part of them; and
// the environment behind everything: a cube, or the map that was baked.
// Directions are in world space.
#include "frame.glsl"
#include "ibl.glsl"

uniform samplerCube specular_map;
uniform samplerCube irradiance_map;
uniform sampler2D lut_map;
uniform sampler2DArray lobe_map;
uniform samplerCube sky_map;
uniform sampler2D backdrop_map;

// Programs for one kind of light define it: software renderers run all
// branches.
#ifndef DIFFUSE
#define DIFFUSE choice.y
#endif
#ifndef REFLECTION
#define REFLECTION reflection.x
#endif

// view_diffuse and view_reflection of view/settings.h: LOBES and what follows
// have 1 to 4 taps.
const int HARMONICS = 1, LAST = 2;
const int FIT = 1, LOBES = 2;

// Minimum roughness for lights without a size, which a mirror would not show:
// Filament's MIN_PERCEPTUAL_ROUGHNESS.
const float LIGHT_ROUGHNESS = 0.045;

struct surface {
    vec3 position, normal, view; // view: towards the eye
    float n_v;
    vec3 f0;
    float roughness;
    vec2 rg; // of ibl_brdf
};

surface surface_at(vec3 position, vec3 normal, vec3 view, float n_v, vec3 f0,
                   float roughness)
{
    return surface(position, normal, view, n_v, f0, roughness,
                   ibl_brdf(lut_map, n_v, roughness));
}

// Factors of the specular light that is seen, and of irradiance / pi with
// multiple scattering or without. ROUGH_FRESNEL: as tutorials have them, by
// Lagarde 2011, "Adopting a physically based shading model".
#ifdef ROUGH_FRESNEL
vec3 fresnel(surface s)
{
    return s.f0 + (max(vec3(1.0 - s.roughness), s.f0) - s.f0) *
                  pow(1.0 - s.n_v, 5.0);
}
#else
#define fresnel(s) s.f0
#endif

vec3 specular_factor(surface s)
{
    return fresnel(s) * s.rg.x + s.rg.y;
}

vec3 diffuse_factor(surface s, vec3 albedo)
{
#ifdef ROUGH_FRESNEL
    return albedo * (1.0 - fresnel(s));
#endif
    return shading.x != 0 ? ibl_diffuse_factor(s.f0, albedo, s.rg)
                          : albedo * (1.0 - specular_factor(s));
}

// Irradiance / pi from level 0: a map may have smaller levels.
vec3 irradiance(vec3 n)
{
    vec3 d = turned(n);
    return DIFFUSE == HARMONICS ? ibl_irradiance_sh4(sh, d)
         : DIFFUSE == LAST      ? textureLod(specular_map, d, lod.z).rgb
                                : diffuse.x * ibl_irradiance(irradiance_map, d);
}

ibl_lobe lobe_of(surface s)
{
    if (REFLECTION == FIT)
        return ibl_lobe_fit(s.n_v, s.roughness, ibl_metallic(s.f0, s.rg), lod);
    if (REFLECTION >= LOBES)
        return ibl_lobe_taps(lobe_map, s.n_v, s.roughness,
                             ibl_metallic(s.f0, s.rg), lod,
                             1 + REFLECTION - LOBES);
    return ibl_lobe_split(s.roughness, lod);
}

// Adds point lights and the first discs of the set: their reflection to
// specular, irradiance / pi to light. Point lights fall with the square of the
// distance.
void add_lights(surface s, int discs, inout vec3 specular, inout vec3 light)
{
    for (int i = 0; i < shading.y; i++) {
        vec3 to = light_position[i].xyz - s.position;
        ibl_add_light(s.normal, s.view, s.f0, max(s.roughness, LIGHT_ROUGHNESS),
                      normalize(to), 0.0,
                      light_intensity[i].rgb * (1.0 / dot(to, to)), specular,
                      light);
    }
    vec3 n = turned(s.normal), v = turned(s.view);
    for (int i = 0; i < discs; i++)
        ibl_add_light(n, v, s.f0, s.roughness, disc_direction[i].xyz,
                      disc_direction[i].w, disc_irradiance[i].rgb, specular,
                      light);
}

// d: unit, in the environment's frame.
vec3 backdrop_cube(vec3 d)
{
    // Further levels of a specular chain are other roughnesses, not smaller
    // pictures.
    vec3 rgb = shading.w != 0 ? texture(sky_map, d).rgb
                              : textureLod(sky_map, d, 0.0).rgb;
    for (int i = 0; i < reflection.w; i++) {
        float radius = disc_direction[i].w, s = sin(0.5 * radius);
        if (distance(d, disc_direction[i].xyz) < 2.0 * s)
            rgb += disc_irradiance[i].rgb / (4.0 * ibl_pi * s * s);
    }
    return rgb;
}

// By a cubic B-spline of 4 x 4 texels, whose steps are not seen where they are
// larger than pixels; two weights of a row are one linear lookup.
vec3 backdrop_of_map(vec3 d)
{
    vec2 size = vec2(textureSize(backdrop_map, 0));
    vec2 p = place_in_map(d) * size - 0.5, f = fract(p), g = 1.0 - f;
    vec2 low = g * g * g / 6.0, high = f * f * f / 6.0;
    vec2 left = low + 0.5 * f * f * (f - 2.0) + 2.0 / 3.0;
    vec2 right = 1.0 - left;
    vec2 a = (floor(p) + 0.5 - low / left) / size;
    vec2 b = (floor(p) + 1.5 + high / right) / size;
    return mix(mix(textureLod(backdrop_map, b, 0.0).rgb,
                   textureLod(backdrop_map, vec2(a.x, b.y), 0.0).rgb, left.x),
               mix(textureLod(backdrop_map, vec2(b.x, a.y), 0.0).rgb,
                   textureLod(backdrop_map, a, 0.0).rgb, left.x), left.y);
}
