// SPDX-License-Identifier: MIT
// Passes of view/capture.c, each a program, that fill a cube's face; most of
// them read an array of one cube. Row 0, first in memory, is the top row.
#include "cube.glsl"
#include "room.glsl"

uniform vec4 target; // the face, its edge, two numbers of the pass

layout(location = 0) out vec4 colour;

// Not normalised.
vec3 texel_direction()
{
    return face_direction(int(target.x),
                          2.0 * gl_FragCoord.xy / target.y - 1.0);
}

// Tangents of the unit direction n; t points along the face's rows.
void texel_frame(vec3 n, out vec3 t, out vec3 b)
{
    vec3 right = face_direction(int(target.x), vec2(1.0, 0.0)) -
                 face_direction(int(target.x), vec2(0.0));
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

#if defined(FACE) || defined(PARABOLOID)
uniform sampler2D source;  // a face, or the paraboloid towards +Z
uniform sampler2D source1; // towards -Z
#else
uniform samplerCubeArray source; // the visible level is the one to read
#endif

#if defined(PARABOLOID)
vec4 lookup(sampler2D picture, vec3 d)
{
    return textureLod(picture, 0.5 + 0.5 * paraboloid_place(d), 0.0);
}

vec4 result()
{
    vec3 d = normalize(texel_direction());
    return d.z > 0.0 ? lookup(source, vec3(-d.x, d.y, d.z))
                     : lookup(source1, vec3(d.x, d.y, -d.z));
}
#elif defined(BLUR)
// The source blurred by a Gaussian of the same width everywhere on the sphere;
// target.zw: its variance along an axis is z - w * the texel's relative solid
// angle. Means of texels would make lights up to a third too bright or too
// dark: texels differ in solid angle by a factor of 5. Lookups are on rings,
// the nodes of Gauss-Laguerre quadrature in r^2 / (2 v) (Abramowitz and Stegun
// 1964, table 25.9), every second ring turned by half a step.
const vec2 RINGS[3] = vec2[](vec2(0.415775, 0.711093), vec2(2.294280, 0.278518),
                             vec2(6.289945, 0.010389));
const int POINTS = 12; // per ring

vec4 result()
{
    vec3 n = normalize(texel_direction());
    vec3 t, b, a = abs(n);
    texel_frame(n, t, b);
    float most = max(a.x, max(a.y, a.z));
    float v = target.z - target.w * most * most * most;
    vec4 sum = vec4(0.0);
    for (int r = 0; r < 3; r++) {
        float angle = sqrt(2.0 * v * RINGS[r].x), s = sin(angle);
        for (int i = 0; i < POINTS; i++) {
            float phi = 6.28318530718 * (float(i) + 0.5 * float(r)) /
                        float(POINTS);
            vec3 d = cos(angle) * n + s * (cos(phi) * t + sin(phi) * b);
            sum += RINGS[r].y / float(POINTS) *
                   textureLod(source, vec4(d, 0.0), 0.0);
        }
    }
    return sum;
}
#elif defined(LOBE)
// A filtered level: the weighted sum of target.w lookups of the row target.z
// around the texel's normal. Tangents follow the face's rows, so there is no
// jump within a face.
uniform sampler2D samples; // x, y, weight and level of a direction around +Z

vec4 result()
{
    vec3 n = normalize(texel_direction());
    vec3 t, b;
    texel_frame(n, t, b);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < int(target.w); i++) {
        vec4 s = texelFetch(samples, ivec2(i, int(target.z)), 0);
        float z = sqrt(max(1.0 - dot(s.xy, s.xy), 0.0));
        vec3 d = s.x * t + s.y * b + z * n;
        sum += s.z * textureLod(source, vec4(d, 0.0), s.w);
    }
    return vec4(sum.rgb, min(sum.a, 1.0)); // weights sum to 1 but for rounding
}
#else
vec4 result()
{
    return texelFetch(source, ivec2(gl_FragCoord.xy), 0);
}
#endif

void main()
{
    colour = kept(result());
}
