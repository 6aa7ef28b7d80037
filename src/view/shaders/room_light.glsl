// SPDX-License-Identifier: MIT
// Light of the room's probes, which are layers of cube arrays. The environment
// gets the weight that they leave: ibl_probes_blend of ibl/probes.h with any
// number of probes; or the nearest local ones count by their distance.
#include "room.glsl"
#include "light.glsl"
#include "probes.glsl"

#ifdef PROBES
uniform samplerBuffer probe_buffer;
uniform samplerCubeArray local_specular;
uniform samplerCubeArray local_irradiance;
uniform samplerCubeArray dynamic_specular;
uniform samplerCubeArray dynamic_irradiance;

// Light of probes so far. rgb: the sum; a: the weight that is left, of 1.
struct probe_light {
    vec3 towards; // the middle of the lobe
    float level;  // its roughness in cubes
    vec4 specular, light;
    vec2 largest; // the probe with the largest share of light, and that
};

// order.w
const int WEIGHTS = 1, LARGEST = 2;

// Adds what a probe sees.
void take(inout vec4 sum, vec4 seen, float influence)
{
    float share = min(influence * min(seen.a, 1.0), sum.a);
    if (share > 0.0)
        sum += vec4(share / seen.a * seen.rgb, -share);
}

// In the order of the locals, then the dynamic one.
int number_of(int i)
{
    return i == order.x ? order.y - 1 : i > order.x ? i - 1 : i;
}

// White of the dynamic probe.
vec3 hue_of(int i)
{
    vec3 turns = fract(0.618033988749895 * float(number_of(i)) +
                       vec3(0.0, 2.0, 1.0) / 3.0);
    return i == order.x ? vec3(1.0)
                        : clamp(abs(6.0 * turns - 3.0) - 1.0, 0.0, 1.0);
}

void add_probe(surface s, int i, float influence, inout probe_light b)
{
    ibl_probe probe = ibl_probe_fetch(probe_buffer, i);
    vec4 normal = vec4(s.normal, probe.layer), lookup, seen, light;
    lookup.w = normal.w;
    ibl_probe_parallax(probe, s.position, b.towards, lookup.xyz);
    if (i != order.x) {
        seen = textureLod(local_specular, lookup, ibl_lod(local_lod, b.level));
        light = textureLod(local_irradiance, normal, 0.0);
        light.rgb *= scales.x;
    } else {
        seen = textureLod(dynamic_specular, lookup,
                          ibl_lod(dynamic_lod, b.level));
        light = textureLod(dynamic_irradiance, normal, 0.0);
        light.rgb *= scales.y;
    }
    if (order.w == WEIGHTS)
        light.rgb = light.a * hue_of(i);
    take(b.specular, seen, influence);
    float left = b.light.a;
    take(b.light, light, influence);
    if (left - b.light.a > b.largest.y)
        b.largest = vec2(number_of(i), left - b.light.a);
}

// Of a local probe.
float distance_to(int i, vec3 point)
{
    vec3 from = texelFetch(probe_buffer, ibl_probe_texels * i + 4).xyz;
    return i == order.x ? 1e30 : max(distance(from, point), 1e-6);
}

// Of the nearest local probes: how far they are, and the sum of the inverse
// distances.
vec2 nearest_reach(vec3 point)
{
    vec2 r = vec2(0.0);

    for (int n = 0; n < order.z; n++) {
        float next = 1e30;
        for (int i = 0; i < order.y; i++) {
            float away = distance_to(i, point);
            next = away > r.x ? min(next, away) : next;
        }
        r.x = 1.000001 * next;
    }
    for (int i = 0; i < order.y && order.z > 0; i++) {
        float away = distance_to(i, point);
        r.y += away <= r.x ? 1.0 / away : 0.0;
    }
    return r;
}

// The weight of a probe before its alpha.
// scale: of the nearest, the weight that is left to them.
float weight_of(int i, vec3 point, vec2 nearest, float scale)
{
    if (i != order.x && order.z > 0) {
        float away = distance_to(i, point);
        return away <= nearest.x ? scale / away / nearest.y : 0.0;
    }
    vec4 first = texelFetch(probe_buffer, ibl_probe_texels * i);
    vec4 second = texelFetch(probe_buffer, ibl_probe_texels * i + 1);
    return ibl_volume_influence(ibl_volume_unpack(first, second), first.w,
                                point);
}

// Adds probes in order until no weight is left.
void add_probes(surface s, inout probe_light b)
{
    vec2 nearest = nearest_reach(s.position);
    float scale = 1.0;

    for (int n = 0; b.specular.a > 0.0 || b.light.a > 0.0; n++) {
        float weight = 0.0;
        // Software runs all of a loop's body for each probe: this one is short.
        for (; n < order.y; n++) {
            weight = weight_of(n, s.position, nearest, scale);
            if (weight > 0.0)
                break;
        }
        if (weight <= 0.0)
            break;
        add_probe(s, n, weight, b);
        if (n == order.x)
            scale = b.light.a;
    }
}

void light_by_probes(surface s, out vec3 specular, out vec3 light)
{
    // Each cube has a chain of its own: the level of this one is the roughness.
    const vec4 chain = vec4(1.0, 0.0, 1.0, 0.0);
    const vec4 none = vec4(0.0, 0.0, 0.0, 1.0);
    ibl_lobe q = REFLECTION == FIT
                     ? ibl_lobe_fit(s.n_v, s.roughness,
                                    ibl_metallic(s.f0, s.rg), chain)
                     : ibl_lobe_split(s.roughness, chain);
    probe_light b = probe_light(
        normalize(mix(reflect(-s.view, s.normal), s.normal, q.bend)), q.lod,
        none, none, vec2(-1.0, 0.0));
    add_probes(s, b);
    vec4 seen = b.specular;
    light = b.light.rgb;
    if (seen.a > 0.0)
        seen.rgb += seen.a * textureLod(specular_map, turned(b.towards),
                                        ibl_lod(lod, q.lod)).rgb;
    if (b.light.a > 0.0)
        light += b.light.a *
                 (order.w == WEIGHTS ? vec3(0.2) : irradiance(s.normal));
    if (order.w == LARGEST)
        light = b.light.a < b.largest.y ? vec3(b.largest, 0.0)
                                        : vec3(-1.0, b.light.a, 0.0);
    specular = specular_factor(s) * mix(seen.rgb, light, q.diffuse);
}
#endif
