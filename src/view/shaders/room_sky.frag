// SPDX-License-Identifier: MIT
// The environment, where no surface covers it.
#include "room.glsl"
#include "backdrop.glsl"

layout(location = 0) out vec4 colour;

void main()
{
    vec2 place = 2.0 * gl_FragCoord.xy / vec2(picture_size.xy) - 1.0;
    vec3 d = normalize(seen_at(place));
    // 2: MAP of sky.frag
    vec3 rgb = shading.z == 2 ? backdrop_of_map(turned(d))
                              : textureLod(sky_map, turned(d), 0.0).rgb;
    colour = vec4(rgb, 1.0);
}
