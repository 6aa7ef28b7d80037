// SPDX-License-Identifier: MIT
// The sun as light from one direction, with shadows: the uniform block of
// room_shadow.c.
#include "ibl.glsl"

layout(std140) uniform Sun {
    mat4 sun_clip;       // world to the depth map's clip space
    vec4 sun_direction;  // to the sun, in the world; w: 1 with shadows
    vec4 sun_irradiance; // w: 1 if there is a sun
    vec4 sun_right;      // a texel of the depth map, in the world; w: texels
    vec4 sun_up;         // the same; w: depth of a unit of the world
    vec4 sun_limit;      // luminance that is kept, cosine of the cone; 1 if the
                         // maps are without the sun, and its radius
};

uniform sampler2DShadow sun_depth;

// Height of a lookup above the surface, in units of the room: triangles of
// spheres are up to that far below the spheres.
const float SUN_ABOVE = 0.003;
// Minimum N.L for slopes: planes nearly along the light would rise too much.
const float SUN_LEAST = 0.01;

// Visible part of the sun: 3 x 3 texels weighted by a quadratic B-spline. Each
// is compared with the surface's plane there, so that no plane shades itself.
float sun_seen(vec3 point, vec3 normal, float n_l)
{
    if (sun_direction.w == 0.0)
        return 1.0;
    vec3 at = 0.5 + 0.5 * (sun_clip * vec4(point + SUN_ABOVE * normal,
                                           1.0)).xyz;
    vec2 slope = vec2(dot(normal, sun_right.xyz), dot(normal, sun_up.xyz)) *
                 (sun_up.w / max(n_l, SUN_LEAST));
    vec2 texel = floor(at.xy * sun_right.w);
    vec2 off = at.xy * sun_right.w - texel - 0.5; // from the texel's centre
    vec2 low = 0.5 * (0.5 - off) * (0.5 - off);
    vec2 high = 0.5 * (0.5 + off) * (0.5 + off);
    vec2 weight[3] = vec2[3](low, 1.0 - low - high, high);
    float seen = 0.0;
    for (int y = 0; y < 3; y++)
        for (int x = 0; x < 3; x++) {
            vec2 step = vec2(x - 1, y - 1);
            vec3 tap = vec3((texel + 0.5 + step) / sun_right.w,
                            at.z + dot(slope, step - off));
            seen += weight[x].x * weight[y].y *
                    textureLod(sun_depth, tap, 0.0);
        }
    return seen;
}

bool sun_in_maps()
{
    return sun_irradiance.w != 0.0 && sun_limit.z == 0.0;
}

// Radiance of the environment without the sun. direction: world, unit.
vec3 sun_cut(vec3 direction, vec3 radiance)
{
    if (!sun_in_maps() || dot(direction, sun_direction.xyz) < sun_limit.y)
        return radiance;
    float y = dot(radiance, vec3(0.2126, 0.7152, 0.0722));
    return y > sun_limit.x ? radiance * (sun_limit.x / y) : radiance;
}

// Irradiance / pi without the sun, from a map that contains it.
vec3 sun_cut_irradiance(vec3 normal, vec3 light)
{
    float n_l = max(dot(normal, sun_direction.xyz), 0.0);
    if (!sun_in_maps())
        return light;
    return max(light - sun_irradiance.rgb * (n_l / ibl_pi), 0.0);
}

// The integral of D(N.H) N.L over all L, with N = V.
float sun_lobe(float alpha)
{
    float a2 = alpha * alpha, b = 1.0 - a2;
    return b < 0.02 ? 1.0 + b * (2.0 / 3.0)
                    : 4.0 / (b * b) *
                          (b - 2.0 * a2 * log((1.0 + a2) / (2.0 * a2)));
}

// Radiance of a level of that roughness without the sun. Narrow lobes, which
// interpolated levels match less well, are only cut as the sky is.
vec3 sun_cut_specular(vec3 direction, float roughness, vec3 light)
{
    float alpha = roughness * roughness;
    float n_l = dot(direction, sun_direction.xyz);
    if (sun_in_maps() && n_l > 0.0 && alpha > 1e-3) {
        vec3 h = normalize(direction + sun_direction.xyz);
        light -= sun_irradiance.rgb *
                 (ibl_ggx_d(direction, h, alpha) * n_l / sun_lobe(alpha));
    }
    return sun_cut(direction, max(light, 0.0));
}
