// SPDX-License-Identifier: MIT
// One triangle that covers the picture, behind everything: three vertices, no
// attributes.
void main()
{
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(4.0 * corner - 1.0, 1.0, 1.0);
}
