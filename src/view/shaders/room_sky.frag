// SPDX-License-Identifier: MIT
// The environment, where no surface covers it.
#include "room.glsl"
#include "ray.glsl"
#include "sun.glsl"

uniform samplerCube sky_map;

in vec2 place;
layout(location = 0) out vec4 colour;

void main()
{
    vec3 d = normalize(seen_at(place));
    vec3 rgb = sun_cut(d, textureLod(sky_map, turned(d), 0.0).rgb);
    colour = vec4(rgb, 1.0);
}
