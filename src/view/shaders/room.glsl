// SPDX-License-Identifier: MIT
// Uniform block of room_render.c, and the projection of points.
#include "frame.glsl"
#include "paraboloid.glsl"

// The dynamic probe's index; local ones have those from 0 on.
const int DYNAMIC = 64;

layout(std140) uniform Room {
    mat4 picture;       // x, y and depth in the picture to the direction
    vec4 paraboloid;    // x: 1 of a paraboloid
    vec4 limit_centre;  // w: 1 if there is a limit
    vec4 limit_half;    // w: 1 for parallax
    ivec4 picture_size; // and edge of tiles, 0: no masks; locals
    uvec4 masks;        // xy: all locals; zw: those before the dynamic one
    vec4 local_lod;     // as lod of frame.glsl
    vec4 dynamic_lod;
    vec4 scales;        // irradiance of locals, of the dynamic one; 1 with it
};

// before: below 0 of what is too far behind a paraboloid.
vec4 projected(vec3 point, out float before)
{
    vec4 p = clip * vec4(point, 1.0);
    before = 1.0;
    if (paraboloid.x == 0.0)
        return p;
    before = paraboloid_front(p) - PARABOLOID_BACK;
    return paraboloid_position(p);
}

// The inverse: the direction seen at a place, -1..1; of any length.
vec3 seen_at(vec2 p)
{
    vec2 q = p / PARABOLOID_FILL;
    vec3 bent = vec3(2.0 * q, 1.0 - dot(q, q));
    return mat3(picture) * (paraboloid.x == 0.0 ? vec3(p, 1.0) : bent);
}
