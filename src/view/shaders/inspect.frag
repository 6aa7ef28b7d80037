// SPDX-License-Identifier: MIT
// Shows a map as linear RGB. Alpha is 1, outside the map 0.
#include "frame.glsl"
#include "ibl.glsl"
#include "layout.glsl"
#include "tone.glsl"

uniform samplerCube specular_map;
uniform samplerCube irradiance_map;
uniform sampler2D lut_map;
uniform sampler2D backdrop_map;

out vec4 colour;

// view_mode, view_diffuse and view_channel of view/settings.h
const int IRRADIANCE_MAP = 2, TABLE = 3, SOURCE_MAP = 6;
const int SH = 1, LAST = 2;
const int ALPHA = 4, LUMINANCE = 5;
const int HARMONICS_EDGE = 32; // VIEW_HARMONICS_EDGE of view/inspect.h
const vec4 OUTSIDE = vec4(0.0, 0.0, 0.0, -1.0);

// Without filtering, samplers take the nearest texel, so a bright neighbour,
// such as the sun, adds nothing.
vec4 cube() {
    bool irradiance = choice.x == IRRADIANCE_MAP;
    bool last = irradiance && choice.y == LAST;
    bool harmonics = irradiance && choice.y == SH;
    int level = last ? int(lod.z) : clamp(choice.w, 0, int(lod.z));
    int n = harmonics            ? HARMONICS_EDGE
          : irradiance && !last ? textureSize(irradiance_map, 0).x
                                : textureSize(specular_map, level).x;
    texel t = flat_texel(choice.z, n);
    if (t.face < 0)
        return OUTSIDE;
    vec3 d = texel_direction(t, n);
    if (harmonics)
        return vec4(ibl_irradiance_sh4(sh, normalize(d)), 1.0);
    return irradiance && !last ? textureLod(irradiance_map, d, 0.0)
                               : textureLod(specular_map, d, float(level));
}

// The environment at its own resolution.
vec4 source_map() {
    vec2 size = vec2(textureSize(backdrop_map, 0));
    vec2 p = flat_point(size);
    if (!within(p, size))
        return OUTSIDE;
    return looks.y != 0 ? texture(backdrop_map, p / size)
                        : texelFetch(backdrop_map, ivec2(p), 0);
}

// One channel as grey.
vec4 channel(vec4 c) {
    float grey = looks.x == LUMINANCE ? luminance(c.rgb)
                 : looks.x == ALPHA   ? c.a
                                      : c[max(looks.x - 1, 0)];
    return vec4(looks.x == 0 ? c.rgb : vec3(grey), 1.0);
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
        return OUTSIDE;
    p.y = size.y - p.y;
    vec3 c = vec3(texelFetch(lut_map, min(ivec2(p), ivec2(size) - 1), 0).rg,
                  0.0);
    vec2 cover = lines(p, 1.0 / flat_scale(size));
    c = mix(c, vec3(0.0, 0.5, 1.0), cover.g);
    return vec4(mix(c, vec3(1.0), cover.r), 1.0);
}

void main() {
    vec4 c = choice.x == TABLE        ? flat_table()
             : choice.x == SOURCE_MAP ? source_map()
                                      : cube();
    colour = c.a < 0.0 ? vec4(0.0) : channel(c);
}
