// SPDX-License-Identifier: MIT
// Shows a map without interpolation, as linear RGB. Alpha is 0 outside the map.
#include "frame.glsl"
#include "layout.glsl"

uniform samplerCube specular_map;
uniform samplerCube irradiance_map;
uniform sampler2D lut_map;

out vec4 colour;

// view_mode of view/settings.h
const int IRRADIANCE_MAP = 2, TABLE = 3;

// Samplers take the nearest texel, so a bright neighbour, such as the sun, adds
// nothing.
vec4 cube() {
    bool irradiance = choice.x == IRRADIANCE_MAP;
    int level = irradiance ? 0 : clamp(choice.w, 0, int(lod.z));
    int n = irradiance ? textureSize(irradiance_map, 0).x
                       : textureSize(specular_map, level).x;
    texel t = flat_texel(choice.z, n);
    if (t.face < 0)
        return vec4(0.0);
    vec3 d = texel_direction(t, n);
    return vec4(irradiance ? textureLod(irradiance_map, d, 0.0).rgb
                           : textureLod(specular_map, d, float(level)).rgb,
                1.0);
}

// R and G, interpolated between texel centres.
vec2 table(vec2 p) {
    ivec2 last = textureSize(lut_map, 0) - 1;
    p = clamp(p - 0.5, vec2(0.0), vec2(last));
    ivec2 a = ivec2(p);
    ivec2 b = min(a + 1, last);
    vec2 f = p - vec2(a);
    return mix(mix(texelFetch(lut_map, a, 0).rg,
                   texelFetch(lut_map, ivec2(b.x, a.y), 0).rg, f.x),
               mix(texelFetch(lut_map, ivec2(a.x, b.y), 0).rg,
                   texelFetch(lut_map, b, 0).rg, f.x), f.y);
}

// Part of a pixel that the lines at 0.1, 0.2, .. 0.9 of R and G cover, from the
// distance to the nearest line along the slope. Without slope there is no line.
vec2 lines(vec2 p, float pixel) {
    vec2 h = vec2(0.5 * pixel, 0.0);
    vec2 dx = table(p + h.xy) - table(p - h.xy);
    vec2 dy = table(p + h.yx) - table(p - h.yx);
    vec2 slope = sqrt(dx * dx + dy * dy);
    vec2 v = table(p);
    vec2 nearest = clamp(round(10.0 * v), 1.0, 9.0) / 10.0;
    vec2 cover = clamp(1.0 - abs(v - nearest) / max(slope, 1e-6), 0.0, 1.0);
    return mix(cover, vec2(0.0), lessThan(slope, vec2(1e-6)));
}

// N.V to the right, roughness upwards. White lines for R, blue lines for G.
vec4 flat_table() {
    vec2 size = vec2(textureSize(lut_map, 0));
    vec2 p = flat_point(size);
    if (!within(p, size))
        return vec4(0.0);
    p.y = size.y - p.y;
    vec3 c = vec3(texelFetch(lut_map, min(ivec2(p), ivec2(size) - 1), 0).rg,
                  0.0);
    vec2 cover = lines(p, 1.0 / flat_scale(size));
    c = mix(c, vec3(0.0, 0.5, 1.0), cover.g);
    return vec4(mix(c, vec3(1.0), cover.r), 1.0);
}

void main() {
    colour = choice.x == TABLE ? flat_table() : cube();
}
