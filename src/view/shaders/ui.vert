// SPDX-License-Identifier: MIT
// A vertex of the user interface, in pixels from the upper left.
layout(location = 0) in vec2 position;
layout(location = 1) in vec2 texcoord;
layout(location = 2) in vec4 tint; // sRGB-encoded, alpha not multiplied in

uniform vec2 window; // pixels

out vec2 at;
out vec4 paint;

void main()
{
    at = texcoord;
    paint = tint;
    gl_Position = vec4((2.0 * position / window - 1.0) * vec2(1.0, -1.0), 0.0,
                       1.0);
}
