// SPDX-License-Identifier: MIT
// Wires, already in clip space.
layout(location = 0) in vec4 position;
layout(location = 1) in vec3 colour_in;

flat out vec3 wire;

void main()
{
    wire = colour_in;
    gl_Position = position;
}
