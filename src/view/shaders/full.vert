// SPDX-License-Identifier: MIT
// One triangle that covers the picture, behind everything: three vertices, no
// attributes.
out vec2 place; // in the picture, 0..1, from the lower left

void main()
{
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    place = 2.0 * corner;
    gl_Position = vec4(4.0 * corner - 1.0, 1.0, 1.0);
}
