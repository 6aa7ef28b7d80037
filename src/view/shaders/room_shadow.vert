// SPDX-License-Identifier: MIT
// A box or a sphere, as in room.vert, from the sun.
#include "sun.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 centre_radius;

void main()
{
    gl_Position = sun_clip * vec4(centre_radius.xyz +
                                  centre_radius.w * position, 1.0);
}
