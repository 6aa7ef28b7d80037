// SPDX-License-Identifier: MIT
// Uniform block of room_render.c, and the projection of points.
#include "frame.glsl"
#include "paraboloid.glsl"

const int BOXES = 25;

layout(std140) uniform Room {
    mat4 picture;       // x, y, depth in the picture to direction
    vec4 paraboloid;    // x: 1 for a paraboloid
    vec4 flags;         // x: 1 with parallax; number of boxes that hide probes,
                        // of boxes and of spheres that hide lights
    vec4 boxes[2 * BOXES]; // low, high; w of low: thickness
    vec4 spheres[4];    // centre, radius
    ivec4 picture_size; // xy: size; z: tile edge, 0: no masks; w: locals, the
                        // dynamic probe comes after them
    ivec4 order;        // x: locals before the dynamic one; y: rows of tiles
    vec4 local_lod;     // as lod of frame.glsl
    vec4 dynamic_lod;
    vec4 scales;        // x, y: irradiance of locals, dynamic one; z: 1 with it
};

// before: a clip distance, below 0 too far behind a paraboloid.
vec4 projected(vec3 point, out float before)
{
    vec4 p = clip * vec4(point, 1.0);
    before = 1.0;
    if (paraboloid.x == 0.0)
        return p;
    before = paraboloid_front(p) - PARABOLOID_BACK;
    return paraboloid_position(p);
}

// Inverse: direction at a place in -1..1; not normalised.
vec3 seen_at(vec2 p)
{
    vec2 q = p / PARABOLOID_FILL;
    vec3 bent = vec3(2.0 * q, 1.0 - dot(q, q));
    return mat3(picture) * (paraboloid.x == 0.0 ? vec3(p, 1.0) : bent);
}
