// SPDX-License-Identifier: MIT
// The wires of a volume: the edges of a box, or three circles. Each end of a
// line is a vertex.
#include "frame.glsl"

layout(location = 1) in vec4 centre; // w: lines of a circle, 0 for a box
layout(location = 2) in vec3 extent; // half sizes
layout(location = 3) in vec3 paint;

flat out vec3 wire;

// Wires are nearer to the eye by this part of their distance, more than the
// error of 24-bit depth, so that wires on a wall are visible.
const float NEARER = 1.0 / 256.0;
const float TURN = 6.28318530718;

void main()
{
    int line = gl_VertexID / 2, end = gl_VertexID % 2;
    bool circles = centre.w > 0.0;
    int axis = line / (circles ? int(centre.w) : 4);
    float angle = TURN * float(line + end) / centre.w;
    // Along the axis, and the two that follow it. An edge of a box runs along
    // one axis at one of four places.
    vec3 p = circles ? vec3(0.0, cos(angle), sin(angle))
                     : vec3(2 * ivec3(end, line & 1, (line >> 1) & 1) - 1);
    p = axis == 0 ? p : axis == 1 ? p.zxy : p.yzx;
    vec3 away = centre.xyz + extent * p - eye.xyz;
    wire = paint;
    gl_Position = clip * vec4(eye.xyz + (1.0 - NEARER) * away, 1.0);
}
