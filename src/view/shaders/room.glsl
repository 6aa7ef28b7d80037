// SPDX-License-Identifier: MIT
// Uniform block of view/room.c: the same members in the same order.
#include "frame.glsl"
#include "paraboloid.glsl"

layout(std140) uniform Room {
    ivec4 order;
    ivec4 hiding;
    vec4 boxes[2 * 25];
    vec4 spheres[4];
    vec4 local_lod;
    vec4 dynamic_lod;
    vec4 scales;
};

// before: a clip distance, below 0 too far behind a paraboloid.
vec4 projected(vec3 point, out float before)
{
    vec4 p = clip * vec4(point, 1.0);
    before = 1.0;
    if (hiding.w == 0)
        return p;
    before = paraboloid_front(p) - PARABOLOID_BACK;
    return paraboloid_position(p);
}
