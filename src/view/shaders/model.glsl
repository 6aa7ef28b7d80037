// SPDX-License-Identifier: MIT
// The material of a model under a pixel, and its layers: glTF 2.0, appendix B,
// KHR_materials_ior, _specular, _clearcoat, _sheen, _emissive_strength and
// _unlit. Where light comes from is the part of model.frag and
// model_truth.frag.
//
// Of each texture view/model.c defines look_NAME, its texel or white, and, if
// there is one, has_NAME and place_NAME, its coordinates.
#include "ray.glsl"
#include "maps.glsl"
#include "widen.glsl"

// model_block of view/model.c: the same members in the same order.
layout(std140) uniform Material {
    vec4 base_colour;
    vec4 emissive; // RGB, number of the material
    vec4 surface_factors; // metallic, roughness, normal scale, occlusion
    vec4 specular_factors; // F0 of the dielectric, weight
    vec4 coat_factors; // clearcoat, roughness, normal scale, alpha cutoff
    vec4 sheen_factors; // colour, roughness
    vec4 rows[2 * TEXTURES]; // of texture transforms: u, v, 1, coordinates
};

uniform sampler2D base_map, rough_map, normal_map, occlusion_map, emissive_map,
    weight_map, f0_map, coat_map, coat_rough_map, coat_normal_map,
    sheen_map, sheen_rough_map;

in vec3 at;
in vec3 at_normal;
in vec4 at_tangent;
in vec4 at_texcoord;
in vec4 at_texcoord2;
in vec4 at_colour;

layout(location = 0) out vec4 colour;

// A layer: its own normal is the coat's alone.
struct layer {
    vec3 normal;
    float n_v;
    vec3 f0;
    float roughness;
};

// Radiance that a layer reflects towards view and, for its diffuse part,
// irradiance / pi: from the environment and from lights.
void lit(layer s, vec3 view, bool diffuse_part, uint number, out vec3 specular,
         out vec3 light);
#ifdef SHEEN
uniform sampler2D sheen_table; // albedo, level
// The same of sheen of colour 1.
vec3 lit_sheen(layer s, vec3 view, vec2 sheen);
#endif

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

// Turned towards the eye where it faces away, which interpolation and normal
// maps do.
vec3 facing(vec3 n, vec3 view)
{
    return normalize(n + max(1e-3 - dot(n, view), 0.0) * view);
}

layer layer_of(vec3 n, vec3 view, vec3 f0, float roughness)
{
    n = facing(n, view);
    return layer(n, clamp(dot(n, view), 0.0, 1.0), f0,
                 widened(clamp(roughness, 0.0, 1.0), n,
                         textureSize(specular_map, 0).x));
}

void main()
{
    vec4 base = base_colour * at_colour * look_base;
#ifdef MASK
    if (base.a < coat_factors.w)
        discard;
#endif
#ifdef DEPTH
    colour = vec4(0.0);
#else
#ifndef BLEND
    base.a = emissive.w;
#endif
#ifdef UNLIT
    colour = base;
#else
    vec3 view = normalize(eye.xyz - at);
    vec3 smooth_normal = normalize(at_normal) *
                         (gl_FrontFacing ? 1.0 : -1.0);
    vec3 n = smooth_normal;
#ifdef has_normal
    n = bumped(n, look_normal.xyz, place_normal, surface_factors.z);
#endif
    float metallic = clamp(surface_factors.x * look_rough.b, 0.0, 1.0);
    float weight = mix(specular_factors.w * look_weight.a, 1.0, metallic);
    vec3 dielectric = min(specular_factors.rgb * look_f0.rgb, 1.0);
    vec3 albedo = base.rgb * (1.0 - metallic);
#ifdef GLOSS
    float roughness = 1.0 - (1.0 - surface_factors.y) * look_rough.a;
#else
    float roughness = surface_factors.y * look_rough.g;
#endif
    layer s = layer_of(n, view, mix(dielectric, base.rgb, metallic), roughness);
    vec2 rg = ibl_brdf(lut_map, s.n_v, s.roughness);
    vec3 k = mix(albedo, diffuse_factor(s.f0, albedo, rg), weight);
    vec3 specular, light;
    lit(s, view, true, 0u, specular, light);
    vec3 seen = weight * specular + k * light;
#ifdef SHEEN
    vec3 sheen = sheen_factors.rgb * look_sheen.rgb;
    s.roughness = clamp(sheen_factors.w * look_sheen_rough.a, 0.0, 1.0);
    vec2 part = textureLod(sheen_table, vec2(s.n_v, s.roughness), 0.0).rg;
    float taken = max(sheen.r, max(sheen.g, sheen.b)) * part.r;
    seen = seen * max(1.0 - taken, 0.0) + sheen * lit_sheen(s, view, part);
#endif
    float open = mix(1.0, look_occlusion.r, surface_factors.w);
    seen = seen * open + emissive.rgb * look_emissive.rgb;
#ifdef COAT
    n = smooth_normal;
#ifdef has_coat_normal
    n = bumped(n, look_coat_normal.xyz, place_coat_normal, coat_factors.z);
#endif
    s = layer_of(n, view, vec3(0.04), coat_factors.y * look_coat_rough.g);
    float coat = coat_factors.x * look_coat.r;
    lit(s, view, false, 3u, specular, light);
    seen = mix(seen, seen * 0.96 * (1.0 - pow(1.0 - s.n_v, 5.0)), coat) +
           coat * open * specular;
#endif
    colour = vec4(seen, base.a);
#endif
#endif
}
