// SPDX-License-Identifier: MIT
// The integral of BRDF, environment and N.L: the mean of sampling.y samples of
// one sequence, from sampling.x on. A sample is a visible normal for the
// specular part and a cosine direction for the diffuse part. If the environment
// has lights, a direction to one of them is added for both parts. The balance
// heuristic weights them: Veach and Guibas 1995, "Optimally Combining Sampling
// Techniques for Monte Carlo Rendering", eq. 12.
#include "ibl.glsl"
#include "ray.glsl"
#include "sample.glsl"

uniform samplerCube environment_map;
uniform sampler2D backdrop_map;

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

// The map, constant over each pixel, if it is at hand; else a cube.
vec3 light_from(vec3 d)
{
    if (display.w == 0.0)
        return textureLod(environment_map, d, 0.0).rgb;
    ivec2 size = textureSize(backdrop_map, 0);
    ivec2 at = ivec2(place_in_map(d) * vec2(size));
    return texelFetch(backdrop_map, min(at, size - 1), 0).rgb;
}

float aimed(vec3 d)
{
    return sampling.z == 0 ? 0.0 : aim_density(face_place(d), d);
}

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

vec3 by_visible_normal(patch_of s, uvec2 fraction)
{
    vec3 h = visible_normal(s.view, s.alpha, unit(fraction));
    vec3 l = reflect(-s.view, h);
    if (l.z <= 0.0)
        return vec3(0.0);
    vec3 d = s.to_environment * l;
    float other = s.alpha < MIRROR ? 0.0 : aimed(d);
    return light_from(d) * specular_weight(s, h, l, other);
}

// Irradiance / pi.
vec3 by_cosine(patch_of s, uvec2 fraction)
{
    vec3 l = cosine_direction(unit(fraction));
    vec3 d = s.to_environment * l;
    float p = l.z / ibl_pi;
    return light_from(d) * (p / (p + aimed(d)));
}

// Samples a direction to a light and adds it to both parts.
void by_aim(patch_of s, uvec3 fraction, inout vec3 specular,
            inout vec3 irradiance)
{
    vec3 at = aim_at(fraction);
    vec3 d = normalize(face_direction(int(at.z), at.xy));
    vec3 l = d * s.to_environment;
    if (l.z <= 0.0)
        return;
    vec3 light = light_from(d);
    float other = aim_density(at, d), p = l.z / ibl_pi;
    irradiance += light * (p / (p + other));
    if (s.alpha >= MIRROR)
        specular += light * specular_weight(s, normalize(s.view + l), l, other);
}

patch_of patch_at(vec3 normal, vec3 view, float n_v, vec3 f0, float roughness)
{
    mat3 frame = frame_of(normal);
    patch_of s;
    s.f0 = f0;
    s.alpha = roughness * roughness;
    s.view = vec3((view * frame).xy, max(n_v, 1e-6));
    s.spread = s.view.z + sqrt(s.alpha * s.alpha +
                               (1.0 - s.alpha * s.alpha) * s.view.z * s.view.z);
    s.to_environment =
        mat3(turned(frame[0]), turned(frame[1]), turned(frame[2]));
    return s;
}

// The specular part and irradiance / pi, if it is wanted. sequence: another
// number gives other samples.
void integrate(vec3 normal, vec3 view, float n_v, vec3 f0, float roughness,
               bool diffuse_part, uint sequence, out vec3 specular,
               out vec3 light)
{
    patch_of s = patch_at(normal, view, n_v, f0, roughness);
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uvec3 a = hash_of(uvec3(pixel, sequence)),
          b = hash_of(uvec3(pixel, sequence + 1u)),
          c = hash_of(uvec3(pixel, sequence + 2u));
    specular = vec3(0.0);
    light = vec3(0.0);
    for (int i = sampling.x; i < sampling.x + sampling.y; i++) {
        specular += by_visible_normal(s, point2(uint(i), a.xy));
        if (diffuse_part)
            light += by_cosine(s, point2(uint(i), b.xy));
        if (sampling.z != 0)
            by_aim(s, point3(uint(i), c), specular, light);
    }
    specular /= float(sampling.y);
    light /= float(sampling.y);
}

#ifdef SHEEN
// Charlie's distribution (Estevez and Kulla 2017) with Ashikhmin's visibility,
// of colour 1, times N.L and the light, over the density of both samplings.
vec3 sheen_from(patch_of s, vec3 l, vec3 d)
{
    vec3 h = normalize(s.view + l);
    float v = 4.0 * (l.z + s.view.z - l.z * s.view.z), k = 1.0 / s.alpha;
    float lobe = (2.0 + k) * pow(length(h.xy), k) / (2.0 * ibl_pi);
    return light_from(d) * (lobe / v * l.z / (l.z / ibl_pi + aimed(d)));
}

vec3 integrate_sheen(vec3 normal, vec3 view, float n_v, float roughness,
                     uint sequence)
{
    patch_of s = patch_at(normal, view, n_v, vec3(0.0), max(roughness, 0.03));
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uvec3 a = hash_of(uvec3(pixel, sequence)),
          b = hash_of(uvec3(pixel, sequence + 1u));
    vec3 sum = vec3(0.0);
    for (int i = sampling.x; i < sampling.x + sampling.y; i++) {
        vec3 l = cosine_direction(unit(point2(uint(i), a.xy)));
        sum += sheen_from(s, l, s.to_environment * l);
        if (sampling.z == 0)
            continue;
        vec3 at = aim_at(point3(uint(i), b));
        vec3 d = normalize(face_direction(int(at.z), at.xy));
        l = d * s.to_environment;
        if (l.z > 0.0)
            sum += sheen_from(s, l, d);
    }
    return sum / float(sampling.y);
}
#endif
