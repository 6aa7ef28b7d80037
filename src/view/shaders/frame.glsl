// SPDX-License-Identifier: MIT
// Uniform block of view/frame.h: the same members in the same order.
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
    ivec4 shading;
    ivec4 choice;
    ivec4 reflection;
    vec4 inspect_at;
    vec4 display;
    ivec4 show;
    ivec4 sampling;
};
