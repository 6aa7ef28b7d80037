// SPDX-License-Identifier: MIT
// The environment, where no surface of the room covers it.
#include "room.glsl"
#include "light.glsl"

layout(location = 0) out vec4 colour;

void main()
{
    vec2 q = (2.0 * gl_FragCoord.xy * viewport.zw - 1.0) / PARABOLOID_FILL;
    vec3 d = ray_through(gl_FragCoord.xy);
    if (hiding.w != 0) // the inverse of paraboloid_place
        d = normalize(2.0 * q.x * right.xyz + 2.0 * q.y * up.xyz +
                      (1.0 - dot(q, q)) * forward.xyz);
    // 2: MAP of sky.frag
    vec3 rgb = shading.z == 2 ? backdrop_of_map(turned(d))
                              : textureLod(sky_map, turned(d), 0.0).rgb;
    colour = vec4(rgb, 1.0);
}
