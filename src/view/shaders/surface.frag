// SPDX-License-Identifier: MIT
// Surfaces: spheres, or with MODEL triangles of a model, whose materials and
// layers are those of glTF 2.0, appendix B, KHR_materials_ior, _specular,
// _clearcoat, _emissive_strength and _unlit. They are lit by a set, by the
// functions of ibl/ibl.glsl, with PROBES by those of the room, or with INTEGRAL
// by the integral itself, over all that a surface faces: nothing shades itself.
#include "light.glsl"
#include "integral.glsl"
#include "room_light.glsl"

layout(location = 0) out vec4 colour;

// view_parts of view/settings.h; after the last, the number of the sphere or
// the material.
#ifndef PARTS
#define PARTS 0
#endif
const int ALL = 0, AMBIENT = 1, DIRECT = 2, DIFFUSE_LIGHT = 3, SPECULAR = 4,
    NUMBER = 5;

// Of the light that a surface reflects towards view: the specular part and, if
// it is wanted, irradiance / pi.
void lit(surface s, bool diffuse_part, uint number, out vec3 specular,
         out vec3 light)
{
    specular = light = vec3(0.0);
    int discs = reflection.z;
    if (PARTS != AMBIENT && PARTS != DIRECT) {
#ifdef INTEGRAL
        integrate(s, diffuse_part, number, specular, light);
        discs = sampling.w;
#elif defined(PROBES)
        light_by_probes(s, specular, light);
#else
        light = irradiance(s.normal);
        specular = specular_factor(s) *
                   ibl_specular(specular_map, lobe_of(s), turned(s.normal),
                                turned(s.view), light);
#endif
    }
    add_lights(s, discs, specular, light);
    specular *= float(PARTS != DIFFUSE_LIGHT);
    light *= float(PARTS != SPECULAR);
}

// What VIEW_PARTS_AMBIENT adds of a surface of this metallic.
vec3 ambient(surface s, vec3 albedo, float metallic)
{
    return PARTS == AMBIENT ? constant.rgb * (albedo + metallic * s.f0)
                            : vec3(0.0);
}

#ifndef MODEL
flat in vec4 ball; // centre, radius
flat in vec4 ball_f0; // F0, metallic
flat in vec4 ball_albedo; // diffuse colour, roughness

// The sphere under a pixel and the part of the pixel that it covers, 0..1. Rays
// that miss the sphere by less than a pixel hit its outline. The edge is as
// wide as places in the pixel are apart: their mean is the part of it that is
// covered. All vectors are relative to the centre, so no digits cancel.
surface sphere_at(vec2 pixel, out float coverage)
{
    vec3 d = ray_through(pixel);
    vec3 to = ball.xyz - eye.xyz;
    vec3 off = dot(to, d) * d - to; // the ray's nearest point to the centre
    float miss = length(off), r = ball.w;
    float pixel_step = length(vec2(dFdx(miss), dFdy(miss)));
    float half_chord = sqrt(max((r - miss) * (r + miss), 0.0));
    coverage = (r - miss) / max(pixel_step * turn.z, 1e-20);
    coverage = clamp(coverage + 0.5, 0.0, 1.0);
    if (dot(to, d) <= half_chord)
        coverage = 0.0; // sphere behind or around the eye
    vec3 n = normalize(off - half_chord * d);
    return surface_at(ball.xyz + r * n, n, -d, half_chord / r, ball_f0.rgb,
                      ball_albedo.a);
}

void main()
{
    float coverage;
    vec3 specular, light, albedo = ball_albedo.rgb;
    surface s = sphere_at(gl_FragCoord.xy, coverage);
    colour = vec4(0.0);
#ifdef INTEGRAL
    if (coverage <= 0.0)
        return;
#endif
    if (PARTS == NUMBER) {
        vec2 place = round(ball.xy + 0.5 * (vec2(grid.xy) - 1.0));
        colour = vec4(1.0 + place.x + place.y * float(grid.x), 0.0, 0.0,
                      coverage);
        return;
    }
    vec3 k = diffuse_factor(s, albedo);
    lit(s, any(notEqual(k, vec3(0.0))), 0u, specular, light);
    colour = vec4(specular + k * light + ambient(s, albedo, ball_f0.a),
                  coverage);
}
#else
// model_block of view/model.c: the same members in the same order.
layout(std140) uniform Material {
    vec4 base_colour;
    vec4 emissive; // RGB, number of the material
    vec4 surface_factors; // metallic, roughness, normal scale, occlusion
    vec4 specular_factors; // F0 of the dielectric, weight
    vec4 coat_factors; // clearcoat, roughness, normal scale, alpha cutoff
    vec4 rows[2 * 10]; // of texture transforms: u, v, 1, coordinates
};

uniform sampler2D base_map, rough_map, normal_map, occlusion_map, emissive_map,
    weight_map, f0_map, coat_map, coat_rough_map, coat_normal_map;

// Textures by their number among these, in the order of view/model.c; HAS has a
// bit for each that there is.
const int BASE = 0, ROUGH = 1, NORMAL = 2, OCCLUSION = 3, EMISSIVE = 4,
    WEIGHT = 5, F0 = 6, COAT_WEIGHT = 7, COAT_ROUGH = 8, COAT_NORMAL = 9;
#define has(i) ((HAS >> i & 1) != 0)
// Its texel, or white.
#define look(i, map) (has(i) ? texture(map, placed(i)) : vec4(1.0))

in vec3 at;
in vec3 at_normal;
in vec4 at_tangent;
in vec4 at_texcoord;
in vec4 at_texcoord2;
in vec4 at_colour;

vec2 placed(int texture)
{
    vec4 u = rows[2 * texture], v = rows[2 * texture + 1];
    vec4 sets = u.w < 2.0 ? at_texcoord : at_texcoord2;
    vec3 t = vec3(u.w == 1.0 || u.w == 3.0 ? sets.zw : sets.xy, 1.0);
    return vec2(dot(u.xyz, t), dot(v.xyz, t));
}

// The normal that a texel stands for, on the side that is seen. Without
// tangents they follow from derivatives: Schueler 2013, "Followup: Normal
// Mapping Without Precomputed Tangents". glTF's green points against v.
vec3 bumped(vec3 n, vec3 texel, vec2 place, float scale)
{
    vec3 m = (2.0 * texel - 1.0) * vec3(scale, scale, 1.0);
    m.xy *= gl_FrontFacing ? 1.0 : -1.0;
#ifdef TANGENTS
    vec3 t = normalize(at_tangent.xyz - dot(at_tangent.xyz, n) * n);
    vec3 b = cross(n, t) * at_tangent.w * (gl_FrontFacing ? 1.0 : -1.0);
#else
    vec3 x = cross(dFdy(at), n), y = cross(n, dFdx(at));
    vec2 across = dFdx(place), down = dFdy(place);
    vec3 t = x * across.x + y * down.x, b = -x * across.y - y * down.y;
    float size = inversesqrt(max(max(dot(t, t), dot(b, b)), 1e-30));
    t *= size;
    b *= size;
#endif
    return normalize(m.x * t + m.y * b + m.z * n);
}

// The normal is turned towards the eye where it faces away, which interpolation
// and normal maps do.
surface layer(vec3 n, vec3 f0, float roughness)
{
    vec3 view = normalize(eye.xyz - at);
    n = normalize(n + max(1e-3 - dot(n, view), 0.0) * view);
    return surface_at(at, n, view, clamp(dot(n, view), 0.0, 1.0), f0,
                      clamp(roughness, 0.0, 1.0));
}

void main()
{
    vec4 base = base_colour * at_colour * look(BASE, base_map);
#ifdef MASK
    if (base.a < coat_factors.w)
        discard;
#endif
#ifndef BLEND
    base.a = 1.0;
#endif
    colour = PARTS == NUMBER ? vec4(emissive.w) : base;
#if !defined(DEPTH) && !defined(UNLIT) && PARTS != 5
    vec3 smooth_normal = normalize(at_normal) *
                         (gl_FrontFacing ? 1.0 : -1.0);
    vec3 n = smooth_normal;
    if (has(NORMAL))
        n = bumped(n, look(NORMAL, normal_map).xyz, placed(NORMAL),
                   surface_factors.z);
    vec4 rough = look(ROUGH, rough_map);
    float metallic = clamp(surface_factors.x * rough.b, 0.0, 1.0);
    float weight = mix(specular_factors.w * look(WEIGHT, weight_map).a, 1.0,
                       metallic);
    vec3 dielectric = min(specular_factors.rgb * look(F0, f0_map).rgb, 1.0);
#ifdef GLOSS
    float roughness = 1.0 - (1.0 - surface_factors.y) * rough.a;
#else
    float roughness = surface_factors.y * rough.g;
#endif
    vec3 emitted = emissive.rgb * look(EMISSIVE, emissive_map).rgb;
#ifdef OVERRIDE
    base.rgb = metal.rgb;
    roughness = metal.a;
    dielectric = plastic.rgb;
    metallic = plastic.a;
    weight = 1.0;
    emitted = vec3(0.0);
#endif
    vec3 albedo = base.rgb * (1.0 - metallic);
    surface s = layer(n, mix(dielectric, base.rgb, metallic), roughness);
    vec3 k = mix(albedo, diffuse_factor(s, albedo), weight);
    vec3 specular, light;
    lit(s, true, 0u, specular, light);
    vec3 seen = weight * specular + k * light + ambient(s, albedo, metallic);
    float open = mix(1.0, look(OCCLUSION, occlusion_map).r, surface_factors.w);
    seen = seen * open + emitted * float(PARTS == ALL);
#ifdef COAT
    n = smooth_normal;
    if (has(COAT_NORMAL))
        n = bumped(n, look(COAT_NORMAL, coat_normal_map).xyz,
                   placed(COAT_NORMAL), coat_factors.z);
    s = layer(n, vec3(0.04),
              coat_factors.y * look(COAT_ROUGH, coat_rough_map).g);
    float coat = coat_factors.x * look(COAT_WEIGHT, coat_map).r;
    lit(s, false, 3u, specular, light);
    seen = mix(seen, seen * 0.96 * (1.0 - pow(1.0 - s.n_v, 5.0)), coat) +
           coat * open * specular;
#endif
#ifdef PROBES
    if (order.w != 0)
        seen = light;
#endif
    colour.rgb = seen;
#endif
}
#endif
