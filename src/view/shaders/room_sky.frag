// SPDX-License-Identifier: MIT
// The environment, where nothing is before it.
#include "room.glsl"
#include "ray.glsl"

uniform samplerCube sky_map;

in vec2 place;
layout(location = 0) out vec4 colour;

void main()
{
    vec3 rgb = textureLod(sky_map, turned(seen_at(place)), 0.0).rgb;
    colour = limit_centre.w != 0.0 ? vec4(0.0) : vec4(rgb, 1.0);
}
