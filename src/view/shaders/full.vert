// SPDX-License-Identifier: MIT
// One triangle that covers the picture, behind everything: three vertices, no
// attributes.
out vec2 place; // in the picture, 0..1, from the lower left

void main()
{
    place = 2.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(2.0 * place - 1.0, 1.0, 1.0);
}
