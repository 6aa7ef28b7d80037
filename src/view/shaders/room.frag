// SPDX-License-Identifier: MIT
// The split sum, or ibl_lobe_fit, with the light of probes.
// The environment gets the weight that they leave: ibl_probes_blend of
// ibl/probes.h with any number of probes. Probes are layers of cube arrays.
#extension GL_ARB_texture_cube_map_array : require
#include "room.glsl"
#include "maps.glsl"
#include "probes.glsl"
#include "lights.glsl"
#include "sun.glsl"

uniform samplerBuffer probe_buffer;
uniform usampler2D tile_masks;
uniform samplerCubeArray local_specular;
uniform samplerCubeArray local_irradiance;
uniform samplerCubeArray dynamic_specular;
uniform samplerCubeArray dynamic_irradiance;

in vec3 surface_position;
in vec3 surface_normal;
flat in vec4 surface_albedo;
flat in vec3 surface_f0;
flat in vec3 surface_emission;

layout(location = 0) out vec4 colour;

// rgb: the sum so far; a: the weight that is left, of 1.
void take(inout vec4 sum, vec4 seen, float influence)
{
    if (seen.a <= 0.0)
        return;
    float share = min(influence * min(seen.a, 1.0), sum.a);
    sum += vec4(share / seen.a * seen.rgb, -share);
}

// Influence of probe i at this point. Most probes need only this.
float influence_of(int i)
{
    vec4 first = texelFetch(probe_buffer, ibl_probe_texels * i);
    vec4 second = texelFetch(probe_buffer, ibl_probe_texels * i + 1);

    return ibl_volume_influence(ibl_volume_unpack(first, second), first.w,
                                surface_position);
}

// Roughness of levels, and the direction of the lobe's middle.
float looked_up;
vec3 towards;

vec3 lookup_of(ibl_probe probe)
{
    vec3 d;

    probe.has_proxy = probe.has_proxy && limit_half.w != 0.0;
    ibl_probe_parallax(probe, surface_position, towards, d);
    return d;
}

// lod and scale are those of the cubes.
void add_probe(int i, samplerCubeArray radiance_cubes,
               samplerCubeArray light_cubes, vec4 lod, float scale, vec3 normal,
               inout vec4 specular, inout vec4 light)
{
    float influence = influence_of(i);
    if (influence <= 0.0)
        return;
    ibl_probe probe = ibl_probe_fetch(probe_buffer, i);
    float layer = float(probe.layer);
    vec4 seen = textureLod(radiance_cubes,
                           vec4(lookup_of(probe), layer),
                           ibl_lod(lod, looked_up));
    vec4 diffuse = textureLod(light_cubes, vec4(normal, layer), 0.0);

    take(specular, seen, influence);
    take(light, vec4(scale * diffuse.rgb, diffuse.a), influence);
}

// Index of the only bit that is set, from the float's exponent.
int place_of(uint bit)
{
    return (floatBitsToInt(float(bit)) >> 23) - 127;
}

// Adds this tile's probes in order until no weight is left: two words of local
// ones before the dynamic one, that one, two words of local ones after it.
void add_probes(vec3 normal, inout vec4 specular, inout vec4 light)
{
    uvec2 mask = picture_size.z == 0
                     ? masks.xy
                     : ibl_tile_mask(tile_masks, gl_FragCoord.xy,
                                     picture_size.z);

    for (int part = 0; part < 5; part++) {
        int word = part > 2 ? part - 3 : part;
        if (part == 2) {
            if (scales.z != 0.0 && (specular.a > 0.0 || light.a > 0.0))
                add_probe(DYNAMIC, dynamic_specular, dynamic_irradiance,
                          dynamic_lod, scales.y, normal, specular, light);
            continue;
        }
        uint bits = mask[word] & (part < 2 ? masks[2 + word]
                                           : ~masks[2 + word]);
        while (bits != 0u && (specular.a > 0.0 || light.a > 0.0)) {
            int i = place_of(bits & (~bits + 1u));
            bits &= bits - 1u;
            add_probe(32 * word + i, local_specular, local_irradiance,
                      local_lod, scales.x, normal, specular, light);
        }
    }
}

bool beyond_limit()
{
    // The border counts as inside: it may be a wall.
    return limit_centre.w != 0.0 &&
           any(greaterThan(abs(surface_position - limit_centre.xyz),
                           limit_half.xyz * (1.0 + 1.0 / 1024.0)));
}

// Returns the sun's reflection; adds its irradiance / pi to light. Surfaces
// below the minimum roughness of lights already reflect a sun in the sky.
vec3 add_sun(vec3 normal, vec3 view, inout vec3 light)
{
    float n_l = dot(normal, sun_direction.xyz), r = surface_albedo.a;
    vec3 specular = vec3(0.0);
    if (sun_irradiance.w == 0.0 || n_l <= 0.0 || surface_f0 == vec3(0.0))
        return specular;
    vec3 e = sun_irradiance.rgb * sun_seen(surface_position, normal, n_l);
    bool in_maps = sun_in_maps();
    ibl_add_light(normal, view, surface_f0, in_maps ? max(r, LIGHT_ROUGHNESS)
                                                    : r,
                  sun_direction.xyz, sun_limit.w, e, specular, light);
    return in_maps && r < LIGHT_ROUGHNESS ? vec3(0.0) : specular;
}

void main()
{
    if (beyond_limit()) {
        colour = vec4(0.0);
        return;
    }
    vec3 normal = normalize(surface_normal);
    vec3 view = normalize(eye.xyz - surface_position);
    float n_v = clamp(dot(normal, view), 0.0, 1.0);

    vec2 rg = ibl_brdf(lut_map, n_v, surface_albedo.a);
    // Each cube has a chain of its own: the level of this one is the roughness.
    const vec4 chain = vec4(1.0, 0.0, 1.0, 0.0);
    ibl_lobe q = reflection.x == 0
                     ? ibl_lobe_split(surface_albedo.a, chain)
                     : ibl_lobe_fit(n_v, surface_albedo.a,
                                    ibl_metallic(surface_f0, rg), chain);
    looked_up = q.lod;
    towards = normalize(mix(reflect(-view, normal), normal, q.bend));
    vec4 specular = vec4(0.0, 0.0, 0.0, 1.0), light = specular;
    add_probes(normal, specular, light);
    if (specular.a > 0.0) {
        vec3 rest = textureLod(specular_map, turned(towards),
                               ibl_lod(lod, looked_up)).rgb;
        specular.rgb += specular.a * sun_cut_specular(towards, looked_up, rest);
    }
    if (light.a > 0.0)
        light.rgb += light.a * sun_cut_irradiance(normal, irradiance(normal));

    vec3 seen = mix(specular.rgb, light.rgb, q.diffuse);
    vec3 direct = add_sun(normal, view, light.rgb);

    // F0 is 0 for panels, which reflect nothing, even at grazing angles.
    if (surface_f0 == vec3(0.0))
        rg = vec2(0.0);
    colour = vec4(ibl_shade(surface_f0, surface_albedo.rgb, rg, seen,
                            light.rgb) + direct + surface_emission, 1.0);
}
