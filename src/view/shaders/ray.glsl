// SPDX-License-Identifier: MIT
// The ray of a pixel and the rotation of the environment, like view_camera_ray
// and view_turn of view/sphere_grid.h.
#include "frame.glsl"

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

vec3 turned_back(vec3 environment)
{
    return vec3(turn.x * environment.x + turn.y * environment.z, environment.y,
                turn.x * environment.z - turn.y * environment.x);
}
