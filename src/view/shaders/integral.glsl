// SPDX-License-Identifier: MIT
// The integral of BRDF, environment and N.L: the mean of sampling.y samples of
// one sequence, from sampling.x on. A sample is a visible normal for the
// specular part and a cosine direction for the diffuse part. If the environment
// has lights, a direction to one of them is added for both parts. The balance
// heuristic weights them: Veach and Guibas 1995, "Optimally Combining Sampling
// Techniques for Monte Carlo Rendering", eq. 12.
//
// Sample points and directions: Roberts 2018, "The Unreasonable Effectiveness
// of Quasirandom Sequences"; Cranley and Patterson 1976, "Randomization of
// Number Theoretic Methods for Multiple Integration"; Jarzynski and Olano 2020,
// "Hash Functions for GPU Rendering", JCGT 9(3); Heitz 2018, "Sampling the GGX
// Distribution of Visible Normals", JCGT 7(4); Dupuy and Benyoub 2023,
// "Sampling Visible GGX Normals with Spherical Caps".
#include "light.glsl"

#ifdef INTEGRAL
uniform sampler2D aim_tokens; // see view/truth.h
uniform sampler2D aim_chance;

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

// Density of a unit direction in a cell of that chance: a row of the map is as
// long as its sine.
float density(float chance, vec3 d)
{
    ivec2 cells = textureSize(aim_chance, 0);
    return chance * float(cells.x * cells.y) /
           (2.0 * ibl_pi * ibl_pi * max(length(d.xz), 1e-6));
}

// Density of aim_at at a unit direction, 0 without a table.
float aimed(vec3 d)
{
    return sampling.z == 0
               ? 0.0
               : density(textureLod(aim_chance, place_in_map(d), 0.0).r, d);
}

// By view_environment of view/baked_set.h: the map, constant over each pixel,
// or a cube.
vec3 light_from(vec3 d)
{
    if (diffuse.w != 1.0)
        return diffuse.w == 0.0 ? textureLod(specular_map, d, 0.0).rgb
                                : textureLod(sky_map, d, 0.0).rgb;
    ivec2 size = textureSize(backdrop_map, 0);
    ivec2 at = ivec2(place_in_map(d) * vec2(size));
    return texelFetch(backdrop_map, min(at, size - 1), 0).rgb;
}

// A random direction in a cell that is random by the light above the mean, its
// density and its light: beside a border, lookups may find the other cell.
vec3 aim_at(uvec3 fraction, out float other, out vec3 from)
{
    ivec2 size = textureSize(aim_tokens, 0), cells = textureSize(aim_chance, 0);
    int token = int(fraction.x >> 14u);
    int cell = int(texelFetch(aim_tokens,
                              ivec2(token % size.x, token / size.x), 0).r);
    ivec2 at = ivec2(cell % cells.x, cell / cells.x);
    vec3 d = direction_in_map((vec2(at) + unit(fraction.yz)) / vec2(cells));
    other = density(texelFetch(aim_chance, at, 0).r, d);
    from = diffuse.w == 1.0 && cells == textureSize(backdrop_map, 0)
               ? texelFetch(backdrop_map, at, 0).rgb
               : light_from(d);
    return d;
}

// Below this alpha a lobe is a mirror in float precision.
const float MIRROR = 1e-6;

// ibl_smith_v with Schlick's G, k = roughness^2 / 2: Karis 2013, image-based
// light.
float schlick_v(float n_l, float n_v, float alpha)
{
    float k = 0.5 * alpha;
    float l = n_l * (1.0 - k) + k;
    float v = n_v * (1.0 - k) + k;
    return 0.25 / max(l * v, 1e-20);
}

// A frame with z axis n, continuous except at n.z = 0: Duff et al. 2017,
// "Building an Orthonormal Basis, Revisited", listing 3.
mat3 frame_of(vec3 n)
{
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
                vec3(b, s + n.y * n.y * a, -n.y), n);
}

// Direction around +Z with density N.L / pi; u is uniform in 0..1 squared.
vec3 cosine_direction(vec2 u)
{
    float s = sqrt(u.x), phi = 2.0 * ibl_pi * u.y;
    return vec3(s * cos(phi), s * sin(phi), sqrt(1.0 - u.x));
}

// Shared by all samples of a pixel, in the frame of the normal, +Z.
struct patch_of {
    vec3 view, f0;
    float alpha;
    float spread;      // N.V + sqrt(alpha^2 + (1 - alpha^2) N.V^2)
    mat3 to_environment;
};

// BRDF times N.L over the density p = D / (2 spread) of visible normals: F V
// N.L 2 spread (Heitz 2018 eq. 19). Times the balance heuristic p / (p +
// other). The same for both kinds of samples.
vec3 specular_weight(patch_of s, vec3 h, vec3 l, float other)
{
    float v_h = clamp(dot(s.view, h), 0.0, 1.0);
    float g = int(diffuse.y) == 1 ? schlick_v(l.z, s.view.z, s.alpha)
                            : ibl_smith_v(l.z, s.view.z, s.alpha);
    float share = 1.0;
    if (other > 0.0) {
        float k = s.alpha / (dot(h.xy, h.xy) + s.alpha * s.alpha * h.z * h.z);
        float p = k * k / (2.0 * ibl_pi * s.spread);
        share = p / (p + other);
    }
    return ibl_schlick_f(s.f0, v_h) * (g * l.z * 2.0 * s.spread * share);
}

patch_of patch_at(surface at)
{
    mat3 frame = frame_of(at.normal);
    patch_of s;
    s.f0 = at.f0;
    s.alpha = at.roughness * at.roughness;
    s.view = vec3((at.view * frame).xy, max(at.n_v, 1e-6));
    s.spread = s.view.z + sqrt(s.alpha * s.alpha +
                               (1.0 - s.alpha * s.alpha) * s.view.z * s.view.z);
    s.to_environment =
        mat3(turned(frame[0]), turned(frame[1]), turned(frame[2]));
    return s;
}

// The specular part and irradiance / pi, if it is wanted. sequence: another
// number gives other samples.
void integrate(surface at, bool diffuse_part, uint sequence, out vec3 specular,
               out vec3 light)
{
    patch_of s = patch_at(at);
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uvec3 a = hash_of(uvec3(pixel, sequence)),
          b = hash_of(uvec3(pixel, sequence + 1u)),
          c = hash_of(uvec3(pixel, sequence + 2u));
    specular = vec3(0.0);
    light = vec3(0.0);
    for (int i = sampling.x; i < sampling.x + sampling.y; i++) {
        vec3 h = visible_normal(s.view, s.alpha, unit(point2(uint(i), a.xy)));
        vec3 l = reflect(-s.view, h), d = s.to_environment * l;
        if (l.z > 0.0)
            specular += light_from(d) *
                        specular_weight(s, h, l,
                                        s.alpha < MIRROR ? 0.0 : aimed(d));
        if (diffuse_part) {
            l = cosine_direction(unit(point2(uint(i), b.xy)));
            d = s.to_environment * l;
            light += light_from(d) * (l.z / (l.z + ibl_pi * aimed(d)));
        }
        if (sampling.z == 0)
            continue;
        float other;
        vec3 from;
        d = aim_at(point3(uint(i), c), other, from);
        l = d * s.to_environment;
        if (l.z <= 0.0)
            continue;
        light += from * (l.z / (l.z + ibl_pi * other));
        if (s.alpha >= MIRROR)
            specular += from * specular_weight(s, normalize(s.view + l), l,
                                               other);
    }
    specular /= float(sampling.y);
    light /= float(sampling.y);
}
#endif
