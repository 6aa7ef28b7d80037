// SPDX-License-Identifier: MIT
// What stands still, as the sun sees it.
#include "sun.glsl"

layout(location = 0) in vec3 position;

void main()
{
    gl_Position = sun_clip * vec4(position, 1.0);
}
