// SPDX-License-Identifier: MIT
// The ray of a pixel and the rotation of the environment, like view_camera_ray
// and view_turn of view/sphere_grid.h.
#include "frame.glsl"
#include "ibl.glsl"

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

// Place of a direction of the environment in its map: row 0 is the zenith, the
// middle column +X.
vec2 place_in_map(vec3 d)
{
    return vec2(fract(atan(d.z, d.x) / (2.0 * ibl_pi) + 0.5 + diffuse.z),
                acos(clamp(d.y, -1.0, 1.0)) / ibl_pi);
}
