// SPDX-License-Identifier: MIT
// For passes that fill a cube's face, most of them from an array of one cube.
// Row 0, first in memory, is the top row.
#include "cube.glsl"

uniform int face;
uniform float edge; // of the target

layout(location = 0) out vec4 colour;

// Place of the texel on its face, -1..1.
vec2 texel_place()
{
    return 2.0 * gl_FragCoord.xy / edge - 1.0;
}

// Not normalised.
vec3 texel_direction()
{
    return face_direction(face, texel_place());
}

// Tangents of the unit direction n; t points along the face's rows.
void texel_frame(vec3 n, out vec3 t, out vec3 b)
{
    vec3 right = face_direction(face, vec2(1.0, 0.0)) -
                 face_direction(face, vec2(0.0));
    t = normalize(right - dot(n, right) * n);
    b = cross(n, t);
}

// Rounds to the nearest half float, ties to even. OpenGL may truncate instead,
// which would make each level darker.
vec4 nearest(vec4 c)
{
    uvec4 b = floatBitsToUint(c);
    b = (b + 0xfffu + ((b >> 13u) & 1u)) & ~uvec4(0x1fffu);
    const float least = 1.0 / 16777216.0; // step of halves below 2^-14
    return mix(uintBitsToFloat(b), round(c / least) * least,
               lessThan(c, vec4(1.0 / 16384.0)));
}

const float LARGEST_HALF = 65504.0;

// A value to store as half floats: 0 for NaN and for values below 0.
vec4 kept(vec4 c)
{
    c = mix(c, vec4(0.0), isnan(c));
    return nearest(clamp(c, 0.0, LARGEST_HALF));
}
