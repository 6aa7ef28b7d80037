// SPDX-License-Identifier: MIT
// Uniform block of view/room.c: the same members in the same order. And where
// points of the world are in the picture.
#include "frame.glsl"

const int PROBES = 4;

layout(std140) uniform Room {
    mat4 picture;       // x, y and depth in the picture to the direction
    vec4 range;         // near, far, 1 of a paraboloid, probes
    vec4 limit_centre;  // w: 1 if there is a limit
    vec4 limit_half;    // w: 1 for parallax
    vec4 probe_position[PROBES]; // w: width of the blend
    vec4 influence_centre[PROBES];
    vec4 influence_half[PROBES];
    vec4 proxy_centre[PROBES];
    vec4 proxy_half[PROBES];
    vec4 probe_lod[PROBES]; // scale, offset, last level
};

// Cosines: what reaches further behind a paraboloid is cut off, some way after
// its picture's edge; and what triangles that are cut are drawn by.
const float BEHIND = -0.2, FAR_BEHIND = -0.6;

vec4 projected(vec3 point, out float before)
{
    vec4 p = clip * vec4(point, 1.0);
    before = 1.0;
    if (range.z == 0.0)
        return p;
    float away = length(p.xyz);
    vec3 d = p.xyz / max(away, 1e-20);
    float depth = (away - range.x) / (range.y - range.x);
    before = d.z - BEHIND;
    return vec4(d.xy / (1.0 + max(d.z, FAR_BEHIND)), 2.0 * depth - 1.0, 1.0);
}

// The other way: the direction that is seen at a place, -1..1.
vec3 seen_at(vec2 p)
{
    float square = dot(p, p);
    vec3 d = range.z == 0.0 ? vec3(p, 1.0)
                            : vec3(2.0 * p, 1.0 - square) / (1.0 + square);
    return mat3(picture) * d;
}
