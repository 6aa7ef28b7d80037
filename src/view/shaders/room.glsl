// SPDX-License-Identifier: MIT
// Uniform block of view/room.c: the same members in the same order. A picture
// may be a paraboloid, which maps a half space of directions to a disc:
// Heidrich and Seidel 1998, "View-independent Environment Maps", section 3.
// Edges between vertices stay straight, so triangles must be small.
#include "frame.glsl"

layout(std140) uniform Room {
    ivec4 order;
    vec4 local_lod;
    vec4 dynamic_lod;
    vec4 scales;
};

// Radius of the half space's disc. The picture is larger, so that lookups on
// the rim find both halves.
const float PARABOLOID_FILL = 0.9375;
// Minimum cosine to the axis that is drawn: less than at the picture's edge,
// -0.064, since lookups on the rim touch the corners.
const float PARABOLOID_BACK = -0.3;

// Place of a unit direction, -1..1.
vec2 paraboloid_place(vec3 d)
{
    return PARABOLOID_FILL * d.xy / max(1.0 + d.z, 1e-3);
}

// before: a clip distance, below 0 too far behind a paraboloid. For these clip
// gives distances in units of far, and near / far; depth is by distance.
vec4 projected(vec3 point, out float before)
{
    vec4 p = clip * vec4(point, 1.0);
    before = 1.0;
    if (scales.z == 0.0)
        return p;
    float l = max(length(p.xyz), 1e-20);
    before = p.z / l - PARABOLOID_BACK;
    return vec4(paraboloid_place(p.xyz / l),
                2.0 * (l - p.w) / (1.0 - p.w) - 1.0, 1.0);
}

// As ray_through, in any picture of the room.
vec3 room_ray(vec2 pixel)
{
    if (scales.z == 0.0)
        return ray_through(pixel);
    vec2 q = (2.0 * pixel * viewport.zw - 1.0) / PARABOLOID_FILL;
    return normalize(2.0 * q.x * right.xyz + 2.0 * q.y * up.xyz +
                     (1.0 - dot(q, q)) * forward.xyz);
}
