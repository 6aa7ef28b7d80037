// SPDX-License-Identifier: MIT
// Vertices of a model, with PROBES in the room. to_world is the same for all of
// a draw.
#include "frame.glsl"
#include "room.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;
layout(location = 3) in vec2 texcoord0;
layout(location = 4) in vec2 texcoord1;
layout(location = 5) in vec2 texcoord2;
layout(location = 6) in vec2 texcoord3;
layout(location = 7) in vec4 colour;
layout(location = 8) in mat4 to_world;

out vec3 at; // in the world
out vec3 at_normal;
out vec4 at_tangent; // with the sign of the bitangent
out vec4 at_texcoord; // the first two sets
out vec4 at_texcoord2; // the others
out vec4 at_colour;

invariant gl_Position;

void main()
{
    mat3 m = mat3(to_world);
    // The cofactors, which are the inverse transposed but for a factor.
    mat3 k = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    float side = dot(m[0], k[0]) < 0.0 ? -1.0 : 1.0;
    vec4 p = to_world * vec4(position, 1.0);
    at = p.xyz;
    at_normal = side * (k * normal);
    at_tangent = vec4(m * tangent.xyz, side * tangent.w);
    at_texcoord = vec4(texcoord0, texcoord1);
    at_texcoord2 = vec4(texcoord2, texcoord3);
    at_colour = colour;
#ifdef PROBES
    gl_Position = projected(at, gl_ClipDistance[0]);
#else
    gl_Position = clip * p;
#endif
}
