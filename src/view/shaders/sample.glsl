// SPDX-License-Identifier: MIT
// Sample points and directions. Roberts 2018, "The Unreasonable Effectiveness
// of Quasirandom Sequences"; Cranley and Patterson 1976, "Randomization of
// Number Theoretic Methods for Multiple Integration"; Jarzynski and Olano 2020,
// "Hash Functions for GPU Rendering", JCGT 9(3); Heitz 2018, "Sampling the GGX
// Distribution of Visible Normals", JCGT 7(4); Dupuy and Benyoub 2023,
// "Sampling Visible GGX Normals with Spherical Caps".
#include "cube.glsl"
#include "frame.glsl"
#include "ibl.glsl"

uniform sampler2D aim_tokens; // see view/aim.h
uniform sampler2DArray aim_chance; // a layer per face

// Three random numbers of a pixel, independent of those of other pixels.
uvec3 hash_of(uvec3 x)
{
    x = x * 1664525u + 1013904223u;
    x.x += x.y * x.z;
    x.y += x.z * x.x;
    x.z += x.x * x.y;
    x ^= x >> 16u;
    x.x += x.y * x.z;
    x.y += x.z * x.x;
    x.z += x.x * x.y;
    return x;
}

// Point i of the sequences R2 and R3, as fractions of 2^32, offset by shift.
// Integers wrap without rounding.
uvec2 point2(uint i, uvec2 shift)
{
    return shift + i * uvec2(3242174889u, 2447445413u);
}

uvec3 point3(uint i, uvec3 shift)
{
    return shift + i * uvec3(3518319154u, 2882110344u, 2360945575u);
}

// Middle of the interval of 2^-23 that holds a fraction: never 0, never 1.
vec2 unit(uvec2 fraction)
{
    return (vec2(fraction >> 9u) + 0.5) / 8388608.0;
}

// Visible normal for v, v.z > 0, of a surface around +Z, density D G1 V.H / N.V
// (Heitz eq. 3), by a spherical cap: Dupuy and Benyoub, listing 1. The sum for
// h.z is arranged to keep its digits at the horizon.
vec3 visible_normal(vec3 v, float alpha, vec2 u)
{
    vec3 w = normalize(vec3(alpha * v.xy, v.z));
    float phi = 2.0 * ibl_pi * u.x;
    float h_z = (1.0 - u.y) * (1.0 + w.z);
    float c = h_z - w.z;
    float s = sqrt(max((1.0 - c) * (1.0 + c), 0.0));
    vec2 h = s * vec2(cos(phi), sin(phi)) + w.xy;
    return normalize(vec3(alpha * h, h_z));
}

// Density of aim_at at the unit direction d with place at: dO = dA m^3, m the
// largest component.
float aim_density(vec3 at, vec3 d)
{
    vec3 a = abs(d);
    float m = max(a.x, max(a.y, a.z));
    float chance = textureLod(aim_chance, vec3(0.5 * at.xy + 0.5, at.z), 0.0).r;
    return chance * float(sampling.z * sampling.z) * 0.25 / (m * m * m);
}

// A random place by the light above the mean: a random cell, and a tent of +-1
// cell around its middle.
vec3 aim_at(uvec3 fraction)
{
    ivec2 size = textureSize(aim_tokens, 0);
    int token = int(fraction.x >> 14u);
    int cell = int(texelFetch(aim_tokens,
                              ivec2(token % size.x, token / size.x), 0).r);
    vec2 u = 2.0 * unit(fraction.yz) - 1.0;
    vec2 tent = sign(u) * (1.0 - sqrt(1.0 - abs(u)));
    int edge = sampling.z;
    vec2 p = vec2(cell % edge, cell / edge % edge) + 0.5 + tent;
    p = abs(p); // reflects at the edges
    p = float(edge) - abs(float(edge) - p);
    return vec3(2.0 * p / float(edge) - 1.0, cell / (edge * edge));
}
