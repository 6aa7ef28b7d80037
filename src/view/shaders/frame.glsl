// SPDX-License-Identifier: MIT
// Uniform block of view/frame.h: the same members in the same order. The ray of
// a pixel and, like view_turn, the rotation of the environment.
#include "ibl.glsl"

layout(std140) uniform Frame {
    mat4 clip;
    vec4 eye;
    vec4 right, up, forward;
    vec4 viewport;
    vec4 turn;
    vec4 lod;
    vec4 diffuse;
    vec4 sh[25];
    vec4 disc_direction[64];
    vec4 disc_irradiance[64];
    vec4 light_position[4];
    vec4 light_intensity[4];
    vec4 background;
    vec4 constant;
    vec4 metal;
    vec4 plastic;
    vec4 ranges;
    ivec4 grid;
    mat4 ground_light;
    vec4 ground_sun;
    vec4 ground;
    ivec4 parts;
    ivec4 shading;
    ivec4 choice;
    ivec4 reflection;
    vec4 inspect_at;
    ivec4 looks;
    vec4 display;
    ivec4 show;
    ivec4 sampling;
};

// pixel: like gl_FragCoord, from the lower left.
vec3 ray_through(vec2 pixel)
{
    vec2 p = 2.0 * pixel * viewport.zw - 1.0;
    return normalize(forward.xyz + p.x * right.xyz + p.y * up.xyz);
}

// Converts a world direction to the environment's frame.
vec3 turned(vec3 world)
{
    return vec3(turn.x * world.x - turn.y * world.z, world.y,
                turn.y * world.x + turn.x * world.z);
}

// Place of a direction of the environment in its map: row 0 is the zenith, the
// middle column +X.
vec2 place_in_map(vec3 d)
{
    return vec2(fract(atan(d.z, d.x) / (2.0 * ibl_pi) + 0.5 + diffuse.z),
                acos(clamp(d.y, -1.0, 1.0)) / ibl_pi);
}

vec3 direction_in_map(vec2 place)
{
    float phi = 2.0 * ibl_pi * (place.x - 0.5 - diffuse.z);
    float theta = ibl_pi * place.y;
    return vec3(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi));
}
