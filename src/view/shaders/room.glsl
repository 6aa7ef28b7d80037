// SPDX-License-Identifier: MIT
// Uniform block of view/room.c: the same members in the same order. And where
// points of the world are in the picture.
#include "frame.glsl"
#include "paraboloid.glsl"

const int PROBES = 4;

layout(std140) uniform Room {
    mat4 picture;       // x, y and depth in the picture to the direction
    vec4 range;         // 1 of a paraboloid, probes
    vec4 limit_centre;  // w: 1 if there is a limit
    vec4 limit_half;    // w: 1 for parallax
    vec4 probe_position[PROBES]; // w: width of the blend
    vec4 influence_centre[PROBES];
    vec4 influence_half[PROBES];
    vec4 proxy_centre[PROBES];
    vec4 proxy_half[PROBES];
    vec4 probe_lod[PROBES]; // scale, offset, last level
};

// before: below 0 of what is too far behind a paraboloid.
vec4 projected(vec3 point, out float before)
{
    vec4 p = clip * vec4(point, 1.0);
    before = 1.0;
    if (range.x == 0.0)
        return p;
    before = paraboloid_front(p) - PARABOLOID_BACK;
    return paraboloid_position(p);
}

// The other way: the direction that is seen at a place, -1..1; of
// any length.
vec3 seen_at(vec2 p)
{
    vec2 q = p / PARABOLOID_FILL;
    return mat3(picture) *
           (range.x == 0.0 ? vec3(p, 1.0) : vec3(2.0 * q, 1.0 - dot(q, q)));
}
