// SPDX-License-Identifier: MIT
flat in vec3 wire;

layout(location = 0) out vec4 colour;

void main()
{
    colour = vec4(wire, 1.0);
}
