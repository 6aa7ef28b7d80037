// SPDX-License-Identifier: MIT
// What is behind everything. Each kind has a program of its own, which defines
// BACKDROP: software draws all branches of a pixel.
#include "light.glsl"
#include "room.glsl"

layout(location = 0) out vec4 colour;

vec3 of_level(vec3 d)
{
    float r = background.y;
    vec3 rgb = textureLod(specular_map, d, background.x < 0.0
                                               ? ibl_lod(lod, r)
                                               : background.x).rgb;
    vec3 rest = vec3(0.0);
    for (int i = 0; i < reflection.z; i++)
        ibl_add_light(d, d, vec3(1.0), r, disc_direction[i].xyz,
                      disc_direction[i].w, disc_irradiance[i].rgb, rgb, rest);
    return rgb;
}

#ifdef GROUND
uniform sampler2D light_depth, below_depth; // of view/renderer.c

// Share of the main light that reaches a point: percentage-closer soft shadows
// (Fernando 2005). The mean distance of what is before the light's disc, as
// seen from there, and the disc's radius say how soft the shadow is.
float reached(vec3 p)
{
    const int TAPS = 32;
    vec3 at = 0.5 * (ground_light * vec4(p, 1.0)).xyz + 0.5;
    float wide = ground.z * at.z, near = 0.0, count = 0.0, lit = 0.0;
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < TAPS; i++) {
            // Vogel 1979: a spiral of equal areas.
            float r = sqrt((float(i) + 0.5) / float(TAPS)), a = 2.4 * float(i);
            float depth = textureLod(light_depth, at.xy + wide * r *
                                                      vec2(cos(a), sin(a)),
                                     0.0).r;
            float before = float(depth < min(at.z, 1.0));
            if (pass == 0) {
                near += before * depth;
                count += before;
            } else
                lit += (1.0 - before) / float(TAPS);
        }
        if (count == 0.0)
            return 1.0;
        wide = max(ground.z * (at.z - near / count), 0.001);
    }
    return lit;
}

// Height of the model above a point of the ground, or far more.
float height_above(vec2 p)
{
    float depth = textureLod(below_depth, 0.5 / GROUND * p + 0.5, 0.0).r;
    return depth < 1.0 ? max(GROUND * (2.0 * depth - 1.0) - ground.x, 1e-4)
                       : 1e4;
}

// Share of an even sky's light that reaches a point: each patch that is seen
// from below, at height h and distance r, hides its form factor h^2 / (pi (r^2
// + h^2)^2) dA of what the others leave. Rings grow with r, so dA is as r^2;
// inside there is a disc. Below a ball it is within 0.17.
float open_to_sky(vec2 p)
{
    const int RINGS = 12, SPOKES = 8;
    const float GROWTH = 1.5;
    float hidden = 0.0, r = 0.02, inner = r * r / GROWTH;
    for (int ring = 0; ring < RINGS; ring++) {
        for (int i = 0; i < SPOKES; i++) {
            float a = 2.0 * ibl_pi * (float(i) + 0.5 * float(ring)) /
                      float(SPOKES);
            float h = height_above(p + r * vec2(cos(a), sin(a)));
            float k = h / (r * r + h * h);
            hidden += k * k * r * r;
        }
        r *= GROWTH;
    }
    float h = height_above(p), left = h * h / (inner + h * h);
    return left * exp(-hidden * 2.0 * log(GROWTH) / float(SPOKES));
}

// Blends the ground over what is behind it.
vec4 over_ground(vec3 d, vec4 behind)
{
    vec3 up = vec3(0.0, 1.0, 0.0);
    float along = (ground.x - eye.y) / d.y;
    vec3 p = eye.xyz + along * d;
    float shown = 1.0 - smoothstep(0.5, 1.0, length(p.xz) / ground.y);
    if (d.y >= 0.0 || along <= 0.0 || shown <= 0.0)
        return behind;
    vec3 rest, specular;
    rest = parts.x == 1   ? constant.rgb
           : parts.x == 2 ? vec3(0.0)
                          : irradiance(up);
    add_lights(surface_at(p, up, -d, 1.0, vec3(0.0), 1.0), reflection.z,
               specular, rest);
    rest = max(rest - ground_sun.rgb, 0.0) * open_to_sky(p.xz);
    if (ground.w != 0.0)
        rest += ground_sun.rgb * reached(p);
    const float ALBEDO = 0.5;
    return mix(behind, vec4(parts.x == 4 ? vec3(0.0) : ALBEDO * rest, 1.0),
               shown);
}
#endif

// view_backdrop of view/frame.h
const int COLOUR = 0, CUBE = 1, MAP = 2;

void main()
{
#ifdef PROBES
    vec3 ray = room_ray(gl_FragCoord.xy), d = turned(ray);
#else
    vec3 ray = ray_through(gl_FragCoord.xy), d = turned(ray);
#endif
    colour = BACKDROP == COLOUR ? background
           : vec4(BACKDROP == CUBE  ? backdrop_cube(d)
                  : BACKDROP == MAP ? backdrop_of_map(d)
                                    : of_level(d), 1.0);
#ifdef GROUND
    colour = over_ground(ray, colour);
#endif
}
