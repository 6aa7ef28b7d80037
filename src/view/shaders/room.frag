// SPDX-License-Identifier: MIT
// The split sum, or ibl_lobe_fit, with the light of probes.
// The environment gets the weight that they leave: ibl_probes_blend of
// ibl/probes.h with any number of probes. Probes are layers of cube arrays.
#include "room.glsl"
#include "maps.glsl"
#include "probes.glsl"
#include "widen.glsl"

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

// Light of probes. rgb: the sum so far; a: the weight that is left, of 1; open:
// what would be left if no wall hid a probe.
struct blend {
    vec4 sum;
    float open;
};

// Adds what a probe sees. visible scales its influence. again: it takes of what
// hidden probes have lost.
void take(inout blend b, vec4 seen, float influence, float visible, bool again)
{
    if (seen.a <= 0.0)
        return;
    float all = influence * min(seen.a, 1.0);
    float share = min(all * visible, b.sum.a - (again ? b.open : 0.0));
    b.open -= again ? 0.0 : min(all, b.open);
    b.sum += vec4(share / seen.a * seen.rgb, -share);
}

// Gives what hidden probes have lost to the others.
void settle(inout blend b)
{
    if (b.sum.a > b.open && b.sum.a < 1.0)
        b.sum = vec4((1.0 - b.open) / (1.0 - b.sum.a) * b.sum.rgb, b.open);
}

// How far the way from a point leads through box i; below 0: it does not. No
// component of way is 0.
float through(int i, vec3 from, vec3 way)
{
    vec3 a = (boxes[2 * i].xyz - from) / way;
    vec3 b = (boxes[2 * i + 1].xyz - from) / way;
    vec3 low = min(a, b), high = max(a, b);
    float enter = max(max(low.x, low.y), max(low.z, 0.0));
    float leave = min(min(high.x, high.y), min(high.z, 1.0));
    return (leave - enter) * length(way);
}

// The part of the way to a point that is free: 1, falling to 0 as the way
// through a wall gets as long as the wall is thick.
float visible_from(vec3 point)
{
    const float least = 1.0 / 1024.0; // keeps the only probe, if it is hidden
    vec3 way = point - surface_position;
    float free = 1.0;

    way += vec3(equal(way, vec3(0.0))) * 1e-6;
    for (int i = 0; i < int(flags.y); i++)
        free *= 1.0 - smoothstep(0.0, boxes[2 * i].w,
                                 through(i, surface_position, way));
    return max(free, least);
}

// The part of a light in direction l (unit) that is seen. Edges of shadows are
// as wide as about a pixel.
float lit_from(vec3 normal, vec3 l)
{
    const float beyond = 100.0, edge = 0.005;
    // Triangles of spheres are up to 0.001 below them.
    vec3 from = surface_position + 0.003 * normal, way = beyond * l;
    float free = 1.0;

    way += vec3(equal(way, vec3(0.0))) * 1e-6;
    for (int i = 0; i < int(flags.z); i++)
        free *= 1.0 - smoothstep(0.0, 2.0 * edge, through(i, from, way));
    for (int i = 0; i < int(flags.w); i++) {
        vec3 to = spheres[i].xyz - from;
        float along = dot(to, l), r = spheres[i].w;
        float miss = sqrt(max(dot(to, to) - along * along, 0.0));
        if (along > 0.0)
            free *= smoothstep(r - edge, r + edge, miss);
    }
    return free;
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

    probe.has_proxy = probe.has_proxy && flags.x != 0.0;
    ibl_probe_parallax(probe, surface_position, towards, d);
    return d;
}

// lod and scale are those of the cubes.
void add_probe(int i, float influence, samplerCubeArray radiance_cubes,
               samplerCubeArray light_cubes, vec4 lod, float scale, vec3 normal,
               bool again, inout blend specular, inout blend light)
{
    if (influence <= 0.0)
        return;
    ibl_probe probe = ibl_probe_fetch(probe_buffer, i);
    float layer = float(probe.layer), visible = visible_from(probe.position);
    vec4 seen = textureLod(radiance_cubes,
                           vec4(lookup_of(probe), layer),
                           ibl_lod(lod, looked_up));
    vec4 diffuse = textureLod(light_cubes, vec4(normal, layer), 0.0);

    take(specular, seen, influence, visible, again);
    take(light, vec4(scale * diffuse.rgb, diffuse.a), influence, visible,
         again);
}

// Index of the only bit that is set, from the float's exponent.
int place_of(uint bit)
{
    return (floatBitsToInt(float(bit)) >> 23) - 127;
}

// Bits of this tile's local probes from 32 * word on.
uint tile_word(int word)
{
    ivec2 at = ivec2(gl_FragCoord.xy) / max(picture_size.z, 1);

    if (picture_size.z == 0)
        return ~0u;
    at.y += word / 2 * order.y;
    return texelFetch(tile_masks, at, 0)[word % 2];
}

// The first count bits, 0..32 or beyond.
uint first_bits(int count)
{
    return count <= 0 ? 0u : count >= 32 ? ~0u : (1u << uint(count)) - 1u;
}

bool has_weight(blend specular, blend light)
{
    return specular.sum.a > 0.0 || light.sum.a > 0.0;
}

// Adds this tile's probes in order until no weight is left: locals before the
// dynamic one, that one, locals after it, and again that one for what is
// hidden.
void add_probes(vec3 normal, inout blend specular, inout blend light)
{
    int first = 0, dynamic = picture_size.w;

    for (int part = 0; part < 2; part++) {
        int end = part == 0 ? order.x : picture_size.w;
        for (int word = first / 32; 32 * word < end; word++) {
            uint bits = tile_word(word) & first_bits(end - 32 * word) &
                        ~first_bits(first - 32 * word);
            while (bits != 0u && has_weight(specular, light)) {
                int i = 32 * word + place_of(bits & (~bits + 1u));
                bits &= bits - 1u;
                add_probe(i, influence_of(i), local_specular, local_irradiance,
                          local_lod, scales.x, normal, false, specular, light);
            }
        }
        first = end;
        bool hidden = specular.sum.a > specular.open ||
                      light.sum.a > light.open;
        if (scales.z != 0.0 && (part == 0 ? has_weight(specular, light)
                                          : hidden))
            add_probe(dynamic, part == 0 ? influence_of(dynamic) : 1.0,
                      dynamic_specular, dynamic_irradiance, dynamic_lod,
                      scales.y, normal, part == 1, specular, light);
    }
    settle(specular);
    settle(light);
}

// Returns the reflection of the lights; adds their irradiance / pi to light.
vec3 add_discs(vec3 normal, vec3 view, float r, inout vec3 light)
{
    vec3 specular = vec3(0.0);
    for (int i = 0; i < reflection.z && surface_f0 != vec3(0.0); i++) {
        vec3 l = turned_back(disc_direction[i].xyz);
        if (dot(normal, l) > 0.0)
            ibl_add_light(normal, view, surface_f0, r, l, disc_direction[i].w,
                          lit_from(normal, l) * disc_irradiance[i].rgb,
                          specular, light);
    }
    return specular;
}

void main()
{
    vec3 normal = normalize(surface_normal);
    float roughness = widened(surface_albedo.a, normal,
                              textureSize(specular_map, 0).x);
    vec3 view = normalize(eye.xyz - surface_position);
    float n_v = clamp(dot(normal, view), 0.0, 1.0);

    vec2 rg = ibl_brdf(lut_map, n_v, roughness);
    // Each cube has a chain of its own: the level of this one is the roughness.
    const vec4 chain = vec4(1.0, 0.0, 1.0, 0.0);
    ibl_lobe q = reflection.x == 0
                     ? ibl_lobe_split(roughness, chain)
                     : ibl_lobe_fit(n_v, roughness,
                                    ibl_metallic(surface_f0, rg), chain);
    looked_up = q.lod;
    towards = normalize(mix(reflect(-view, normal), normal, q.bend));
    blend from_probes = blend(vec4(0.0, 0.0, 0.0, 1.0), 1.0);
    blend light_from_probes = from_probes;
    add_probes(normal, from_probes, light_from_probes);
    vec4 specular = from_probes.sum, light = light_from_probes.sum;
    if (specular.a > 0.0)
        specular.rgb += specular.a * textureLod(specular_map, turned(towards),
                                                ibl_lod(lod, looked_up)).rgb;
    if (light.a > 0.0)
        light.rgb += light.a * irradiance(normal);

    vec3 seen = mix(specular.rgb, light.rgb, q.diffuse);
    vec3 direct = add_discs(normal, view, roughness, light.rgb);

    // F0 is 0 for panels, which reflect nothing, even at grazing angles.
    if (surface_f0 == vec3(0.0))
        rg = vec2(0.0);
    colour = vec4(ibl_shade(surface_f0, surface_albedo.rgb, rg, seen,
                            light.rgb) + direct + surface_emission, 1.0);
}
