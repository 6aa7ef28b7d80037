// SPDX-License-Identifier: MIT
// One triangle behind everything.
out vec2 place;

void main()
{
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    place = 4.0 * corner - 1.0;
    gl_Position = vec4(place, 1.0, 1.0);
}
