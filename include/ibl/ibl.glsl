// SPDX-License-Identifier: MIT
// Image-based light in shaders, from what iblbake writes: the diffuse and the
// specular part, with multiple scattering, and lights that were taken out of
// the environment.
// GLSL 3.30 or later, ES 3.00 or later, after #version and precisions; it
// includes nothing, and its names begin with ibl_. ibl.hlsl is the same file
// in HLSL.
//
//     uniform samplerCube specular;   // NAME_specular
//     uniform samplerCube irradiance; // NAME_irradiance
//     uniform sampler2D brdf;         // brdf_lut
//     uniform sampler2DArray lobe;    // lobe_lut
//     uniform vec4 chain;             // see ibl_lod
//     ...
//     float n_v = clamp(dot(n, v), 0.0, 1.0);
//     vec2 rg = ibl_brdf(brdf, n_v, roughness);
//     vec3 light = ibl_irradiance(irradiance, n);
//     ibl_lobe q = ibl_lobe_table(lobe, n_v, roughness, metallic,
//                                 chain);
//     vec3 seen = ibl_specular(specular, q, n, v, light);
//     vec3 direct = vec3(0.0, 0.0, 0.0);
//     for (...) // lights of the sidecar, if --lights took any: only now
//         ibl_add_light(n, v, f0, roughness, direction, radius, irradiance,
//                       direct, light);
//     colour = ibl_shade(f0, albedo, rg, seen, light) + direct;
//
// Add lights after ibl_specular, which mixes light into seen: before it they
// would be reflected twice, with an error of 21 % in place of 1.8 %.
//
// n is the normal and v the direction to the eye, l to a light: unit vectors in
// the environment's frame. roughness is perceptual, 0..1. f0 is the reflection
// at normal incidence: .04, or a metal's colour; albedo the diffuse colour, 0
// for metals. All cubes are filtered linearly, the specular one between levels,
// too; tables are filtered linearly and clamped to their edges.
//
// The true lobe of a rough surface is neither centred on the mirrored direction
// nor round. There are five ways to look it up, from cheap to exact; README.md
// has their errors. From the third on they mix in the irradiance, which diffuse
// light fetches anyway. With their fetches of the levels and of the table:
//     ibl_lobe_split     1      the split sum: N = V = R
//     ibl_lobe_bent      1      bent towards the normal, by two lines
//     ibl_lobe_fit       1      by a formula
//     ibl_lobe_table     1 + 2  by the table lobe_lut
//     ibl_lobe_taps      2 + 4, 3 + 4 or 4 + 2, by the table
// Of a local probe correct the direction of each tap for parallax.
//
// Of flat maps (--layout) the functions ibl_octahedral and ibl_equirect stand
// in for textureLod(specular, direction, lod) and, with lod 0, for irradiance
// and skybox. They take a sampler2D, filtered linearly, between levels too, and
// coordinates clamped or repeated: near seams the functions find the texels
// that meet there themselves. edge: texels along a column of level 0.
//     vec3 r = mix(reflect(-v, n), n, q.bend);
//     vec3 seen = max(mix(ibl_octahedral(specular, r, q.lod, edge), light,
//                         q.diffuse), 0.0);

const float ibl_pi = 3.14159265358979;

// ---- the BRDF ---------------------------------------------------------------

// Distribution of normals; alpha is roughness squared: Walter et al. 2007,
// "Microfacet Models for Refraction through Rough Surfaces", eq. 33. The sine
// comes from the cross product: near the peak 1 - cos^2 would lose all digits.
float ibl_ggx_d(vec3 n, vec3 h, float alpha)
{
    vec3 s = cross(n, h);
    float c = alpha * dot(n, h);
    float k = alpha / (dot(s, s) + c * c);
    return k * k / ibl_pi;
}

// G / (4 N.L N.V), Smith's G, height-correlated: Heitz 2014, "Understanding the
// Masking-Shadowing Function in Microfacet-Based BRDFs", eq. 99.
float ibl_smith_v(float n_l, float n_v, float alpha)
{
    float a2 = alpha * alpha;
    float l = n_v * sqrt(n_l * n_l * (1.0 - a2) + a2);
    float v = n_l * sqrt(n_v * n_v * (1.0 - a2) + a2);
    return 0.5 / max(l + v, 1e-20);
}

// Fresnel: Schlick 1994, "An Inexpensive BRDF Model for Physically-based
// Rendering", eq. 15.
vec3 ibl_schlick_f(vec3 f0, float v_h)
{
    float x = 1.0 - v_h, x2 = x * x;
    return f0 + (1.0 - f0) * (x2 * x2 * x);
}

// R and G of the table brdf_lut: reflection of white light is f0 * R + G. Karis
// 2013, "Real Shading in Unreal Engine 4".
vec2 ibl_brdf(sampler2D brdf, float n_v, float roughness)
{
    return textureLod(brdf, vec2(n_v, roughness), 0.0).rg;
}

// ---- diffuse ----------------------------------------------------------------

// Irradiance / pi. Multiply by 1 / pi if the sidecar says the scale E.
vec3 ibl_irradiance(samplerCube irradiance, vec3 n)
{
    return textureLod(irradiance, n, 0.0).rgb;
}

// Sum over harmonics of degree 2, with the real basis of the sidecar: Sloan
// 2013, "Efficient Spherical Harmonic Evaluation", appendix A2, without
// alternating signs.
vec3 ibl_sh_sum(vec4 sh[9], vec3 n)
{
    float x = n.x, y = n.y, z = n.z;
    vec3 e = 0.28209479177387814 * sh[0].rgb;
    e += 0.4886025119029199 * (y * sh[1] + z * sh[2] + x * sh[3]).rgb;
    e += 1.0925484305920792 *
         (x * y * sh[4] + y * z * sh[5] + x * z * sh[7]).rgb;
    e += 0.31539156525252005 * (3.0 * z * z - 1.0) * sh[6].rgb;
    e += 0.5462742152960396 * (x * x - y * y) * sh[8].rgb;
    return e;
}

// Irradiance / pi from harmonics of degree 2: sh[i].rgb are the sidecar's
// "radiance" times 1 for i = 0, 2/3 for 1..3, 1/4 for 4..8.
vec3 ibl_irradiance_sh(vec4 sh[9], vec3 n)
{
    return max(ibl_sh_sum(sh, n), 0.0);
}

// The same of degree 4: times -1/24 for 16..24. Irradiance has no degree 3,
// 9..15: Ramamoorthi and Hanrahan 2001, eq. 9.
vec3 ibl_irradiance_sh4(vec4 sh[25], vec3 n)
{
    float x = n.x, y = n.y, z = n.z;
    float x2 = x * x, y2 = y * y, z2 = z * z;
    vec4 low[9];
    for (int i = 0; i < 9; i++)
        low[i] = sh[i];
    vec3 e = ibl_sh_sum(low, n);
    e += 2.5033429417967046 * x * y * (x2 - y2) * sh[16].rgb;
    e += 1.7701307697799304 * z *
         (y * (3.0 * x2 - y2) * sh[17] + x * (x2 - 3.0 * y2) * sh[23]).rgb;
    e += 0.9461746957575601 * (7.0 * z2 - 1.0) *
         (x * y * sh[18] + 0.5 * (x2 - y2) * sh[22]).rgb;
    e += 0.6690465435572892 * z * (7.0 * z2 - 3.0) *
         (y * sh[19] + x * sh[21]).rgb;
    e += 0.10578554691520431 * (z2 * (35.0 * z2 - 30.0) + 3.0) * sh[20].rgb;
    e += 0.6258357354491761 *
         (x2 * (x2 - 3.0 * y2) - y2 * (3.0 * x2 - y2)) * sh[24].rgb;
    return max(e, 0.0);
}

// ---- specular ---------------------------------------------------------------

// Level of a roughness. chain: lod_scale and lod_offset of the sidecar, the
// number of levels - 1, and the mapping: 0 linear, 1 filament, 2 babylon.
float ibl_lod(vec4 chain, float roughness)
{
    float x = chain.w == 1.0   ? roughness * (2.0 - roughness)
              : chain.w == 2.0 ? 2.0 * log2(max(roughness, 1e-6))
                               : roughness;
    return clamp(x * chain.x + chain.y, 0.0, chain.z);
}

// How the lobe of one N.V and roughness is looked up.
struct ibl_lobe {
    float bend;          // from the mirrored direction, 0, to the normal, 1
    float lod;           // level
    float diffuse;       // weight of irradiance / pi; more than 1 makes a lobe
                         // broader than that of irradiance, less some of the
                         // level's
    float half_distance; // taps are from bend - this to bend + this
    int taps;
};

// The split sum: Karis 2013.
ibl_lobe ibl_lobe_split(float roughness, vec4 chain)
{
    ibl_lobe q;
    q.bend = 0.0;
    q.lod = ibl_lod(chain, roughness);
    q.diffuse = 0.0;
    q.half_distance = 0.0;
    q.taps = 1;
    return q;
}

// What the functions below take as metallic, for surfaces that are given by F0:
// the share of the reflection that is as for F0 = 1, the rest being as for .04.
float ibl_metallic(vec3 f0, vec2 rg)
{
    float f = (f0.r + f0.g + f0.b) / 3.0;
    return clamp((f - 0.04) / 0.96 * (rg.x + rg.y) /
                     max(f * rg.x + rg.y, 1e-20), 0.0, 1.0);
}

// Bent towards the normal: fitted to lobes of F0 = 1.
ibl_lobe ibl_lobe_bent(float n_v, float roughness, vec4 chain)
{
    float r = roughness;
    ibl_lobe q = ibl_lobe_split(min(r * (0.75 + 0.28 * n_v + 0.27 * r * r),
                                    1.0), chain);
    q.bend = pow(r, 2.1 + 1.8 * n_v);
    return q;
}

// Mixed with the irradiance, too: fitted to lobes of F0 = .04 and F0 = 1.
ibl_lobe ibl_lobe_fit(float n_v, float roughness, float metallic, vec4 chain)
{
    float r = roughness;
    vec4 k = mix(vec4(0.55, 0.54, 0.49, 0.58), vec4(0.64, 0.44, 0.87, 0.43),
                 metallic);
    float narrow = min(3.0 * r, 1.0) * (k.x + k.y * n_v - 1.0);
    ibl_lobe q = ibl_lobe_split(min(r + r * narrow, 1.0), chain);
    q.bend = mix(3.1, 5.2, metallic) * pow(r, 3.5) * (1.0 - r) * (1.0 - n_v);
    q.diffuse = min((k.z + k.w * n_v) *
                        pow(max((r - 0.15) / 0.85, 0.0),
                            mix(2.6, 1.0 + 2.5 * n_v, metallic)), 1.0);
    return q;
}

// Of the two layers of the table that are of one tap, or of four: F0 = 1,
// F0 = .04. A table of one F0 has one of each. The outer texels are of 0 and 1.
vec4 ibl_lobe_fetch(sampler2DArray lobe, float n_v, float roughness,
                    float metallic, float four)
{
    vec3 size = vec3(textureSize(lobe, 0));
    vec2 at = (vec2(n_v, roughness) * (size.xy - 1.0) + 0.5) / size.xy;
    float metal = 0.5 * size.z * four, other = metal + 0.5 * size.z - 1.0;
    return mix(textureLod(lobe, vec3(at, other), 0.0),
               textureLod(lobe, vec3(at, metal), 0.0), metallic);
}

// One to four taps along the plane of n and v, in which lobes are longest. The
// table is for the chain that it was written with.
ibl_lobe ibl_lobe_taps(sampler2DArray lobe, float n_v, float roughness,
                       float metallic, vec4 chain, int taps)
{
    vec4 t = vec4(0.0, 0.0, 0.0, 0.0);
    if (taps < 4)
        t = ibl_lobe_fetch(lobe, n_v, roughness, metallic, 0.0);
    if (taps > 1)
        t = mix(t, ibl_lobe_fetch(lobe, n_v, roughness, metallic, 1.0),
                sqrt(float(taps - 1) / 3.0));
    ibl_lobe q;
    q.bend = t.r;
    q.lod = t.g * chain.z;
    q.diffuse = t.b;
    q.half_distance = t.a;
    q.taps = taps;
    return q;
}

ibl_lobe ibl_lobe_table(sampler2DArray lobe, float n_v, float roughness,
                        float metallic, vec4 chain)
{
    return ibl_lobe_taps(lobe, n_v, roughness, metallic, chain, 1);
}

// What the surface sees, to be reflected by ibl_shade. irradiance: /pi, at n.
vec3 ibl_specular(samplerCube specular, ibl_lobe q, vec3 n, vec3 v,
                  vec3 irradiance)
{
    vec3 r = reflect(-v, n), seen = vec3(0.0, 0.0, 0.0);
    float gap = 2.0 * q.half_distance / max(float(q.taps - 1), 1.0);
    for (int i = 0; i < q.taps; i++) {
        vec3 d = mix(r, n, q.bend - q.half_distance + float(i) * gap);
        seen += textureLod(specular, d, q.lod).rgb;
    }
    return max(mix(seen / float(q.taps), irradiance, q.diffuse), 0.0);
}

// ---- flat maps --------------------------------------------------------------

// Where a direction of any length is in an octahedral map, 0..1: Cigolle et al.
// 2014, "A Survey of Efficient Representations for Independent Unit Vectors",
// listing 1, with +Y in the middle, +X to the right and +Z below.
vec2 ibl_octahedral_uv(vec3 d)
{
    vec2 p = d.xz / (abs(d.x) + abs(d.y) + abs(d.z));
    vec2 folded = vec2((1.0 - abs(p.y)) * (p.x < 0.0 ? -1.0 : 1.0),
                       (1.0 - abs(p.x)) * (p.y < 0.0 ? -1.0 : 1.0));
    return 0.5 + 0.5 * (d.y < 0.0 ? folded : p);
}

// Where it is in an equirectangular map, whose first row is at +Y and whose
// middle column is at +X.
vec2 ibl_equirect_uv(vec3 d)
{
    float across = length(d.xz);
    float u = across > 0.0 ? 0.5 * atan(d.z, d.x) / ibl_pi : 0.0;
    return vec2(0.5 + u, atan(across, d.y) / ibl_pi);
}

// Texel `at` of a level: octahedral if it is square, else equirectangular.
// Beyond an edge, -1 or n, it is the one that meets there: each edge of an
// octahedral level is folded in its middle; columns of the other one go on
// around, and rows beyond a pole.
vec3 ibl_flat_texel(sampler2D map, vec2 at, vec2 size, float level)
{
    vec2 near = clamp(at, vec2(0.0, 0.0), size - 1.0);
    vec2 far = size - 1.0 - near;
    vec2 to = vec2(near.y == at.y ? near.x : far.x,
                   near.x == at.x ? near.y : far.y);
    if (size.x > size.y) {
        float x = at.x + (near.y == at.y ? 0.0 : size.y);
        to = vec2(x - size.x * floor((x + 0.5) / size.x), near.y);
    }
    return textureLod(map, (to + 0.5) / size, level).rgb;
}

// Height of a level.
float ibl_flat_height(float edge, float level)
{
    return max(floor(edge * exp2(-level) + 0.5), 1.0);
}

vec3 ibl_flat_level(sampler2D map, vec2 uv, float wide, float edge,
                    float level)
{
    vec2 size = vec2(wide, 1.0) * ibl_flat_height(edge, level);
    vec2 low = floor(uv * size - 0.5), p = uv * size - 0.5 - low;
    vec2 high = low + 1.0;
    vec3 above = mix(ibl_flat_texel(map, low, size, level),
                     ibl_flat_texel(map, vec2(high.x, low.y), size, level),
                     p.x);
    vec3 below = mix(ibl_flat_texel(map, vec2(low.x, high.y), size, level),
                     ibl_flat_texel(map, high, size, level), p.x);
    return mix(above, below, p.y);
}

// One trilinear fetch, and eight within half a texel of the map's edges, where
// the hardware cannot filter. wide: of the map, in its heights.
vec3 ibl_flat(sampler2D map, vec2 uv, float wide, float lod, float edge)
{
    vec2 size = vec2(wide, 1.0) * ibl_flat_height(edge, ceil(lod));
    vec2 off = abs(uv - 0.5) + 0.5 / size;
    if (max(off.x, off.y) <= 0.5)
        return textureLod(map, uv, lod).rgb;
    return mix(ibl_flat_level(map, uv, wide, edge, floor(lod)),
               ibl_flat_level(map, uv, wide, edge, ceil(lod)), fract(lod));
}

// Radiance of an octahedral map in a direction of any length. lod: 0 to the
// last level.
vec3 ibl_octahedral(sampler2D map, vec3 d, float lod, float edge)
{
    return ibl_flat(map, ibl_octahedral_uv(d), 1.0, lod, edge);
}

// The same of an equirectangular map.
vec3 ibl_equirect(sampler2D map, vec3 d, float lod, float edge)
{
    return ibl_flat(map, ibl_equirect_uv(d), 2.0, lod, edge);
}

// ---- the surface ------------------------------------------------------------

// Factor of irradiance / pi: what is not reflected specularly, and what is
// scattered more than once between facets: Fdez-Aguera 2019, "A
// Multiple-Scattering Microfacet Model for Real-Time Image Based Lighting",
// JCGT 8(1), listing 1. rg: of ibl_brdf.
vec3 ibl_diffuse_factor(vec3 f0, vec3 albedo, vec2 rg)
{
    vec3 once = f0 * rg.x + rg.y;
    float lost = max(1.0 - rg.x - rg.y, 0.0);
    vec3 mean = f0 + (1.0 - f0) / 21.0;
    vec3 more = lost * once * mean / (1.0 - mean * lost);
    return more + albedo * (1.0 - once - more);
}

// Radiance towards the eye. seen: of ibl_specular; irradiance: /pi.
vec3 ibl_shade(vec3 f0, vec3 albedo, vec2 rg, vec3 seen, vec3 irradiance)
{
    return (f0 * rg.x + rg.y) * seen +
           ibl_diffuse_factor(f0, albedo, rg) * irradiance;
}

// ---- lights -----------------------------------------------------------------

// GGX's slopes are spread as the form factor of a plane seen from a height of
// alpha above it. A disc light is an ellipse of slopes, so the lobe's share in
// it is the form factor of an ellipse: with the cone to it as a quadratic form
// of eigenvalues e1, e2 > 0 > e3, |e3| / sqrt((e1 - e3) (e2 - e3)) along the
// cone's axis (Heitz and Hill 2017, "Linear-Light Shading with Linearly
// Transformed Cosines"), times the cosine of that axis.

// The root 1..most of x^3 = m x^2 + n x + k: -1 / e3.
float ibl_disc_root(float m, float n, float k, float most)
{
    float s = sqrt(max(m * m + 3.0 * n, 1e-12)) / 3.0, u = m / s;
    float c = u * u * u / 27.0 + u * (n / s / s) / 6.0 + k / s / s / s / 2.0;
    float x = m / 3.0 + 2.0 * s * cos(acos(clamp(c, -1.0, 1.0)) / 3.0);
    x = clamp(x, 1.0, most);
    for (int i = 0; i < 2; i++)
        x -= ((x - m) * x - n - k / x) / (3.0 * x - 2.0 * m - n / x);
    return clamp(x, 1.0, most);
}

// Mean of ibl_ggx_d over a disc whose middle has N.L = n_l. a is the square of
// the ellipse's shorter half axis in slopes, over alpha^2.
float ibl_disc_d(vec3 n, vec3 h, float n_l, float n_v, float v_h, float alpha,
                 float a)
{
    vec3 s = cross(n, h);
    float c = max(dot(n, h), 0.05), scale = c * c * alpha * alpha;
    float t = dot(s, s) / scale, b = a / (v_h * v_h), k = a * b;
    float along = 0.25 * (n_l - n_v) * (n_l - n_v) /
                  (max(1.0 - v_h * v_h, 1e-6) * scale);
    float m = 1.0 + t - a - b, x = min(along, t);
    float o = a + b + b * x + a * (t - x) - k;
    float nu = ibl_disc_root(m, o, k, 1.0 + t);
    return sqrt((nu + a) / nu * ((nu + b) / nu)) /
           ((nu * nu + o + 2.0 * k / nu) * ibl_pi * scale * c * c);
}

// N.L of a disc that is above the horizon in part.
float ibl_disc_shown(float n_l, float radius)
{
    float edge = sin(radius);
    return abs(n_l) < edge ? (n_l + edge) * (n_l + edge) / (4.0 * edge)
                           : max(n_l, 0.0);
}

// Adds a disc light of angular radius in rad, whose middle is in direction l:
// its reflection to direct, irradiance / pi to light, which ibl_specular must
// have had before. e: irradiance of a surface that faces it. The rest of the
// BRDF is taken between the disc's middle and the mirrored direction, as far as
// the lobe is narrower than the disc.
void ibl_add_light(vec3 n, vec3 v, vec3 f0, float roughness, vec3 l,
                   float radius, vec3 e, inout vec3 direct, inout vec3 light)
{
    float n_v = max(dot(n, v), 1e-4), alpha = max(roughness * roughness, 1e-4);
    if (!(dot(n, l) > -sin(radius)))
        return; // below the surface
    light += e * (ibl_disc_shown(dot(n, l), radius) / ibl_pi);
    vec3 h = (v + l) / max(length(v + l), 1e-6);
    vec3 to_mirror = reflect(-v, n) - l;
    float n_h = max(dot(n, h), 0.05), v_h = max(dot(v, h), 1e-3);
    float a = 0.25 * radius * radius / (n_h * n_h * n_h * alpha * alpha);
    float share = a / (1.0 + a);
    vec3 to = normalize(l + share * to_mirror *
                        min(1.0, radius / max(length(to_mirror), 1e-6)));
    float n_l = ibl_disc_shown(dot(n, to), radius * (1.0 - share));
    vec3 half_to = (v + to) / max(length(v + to), 1e-6);
    float n_h_to = max(dot(n, half_to), 0.05);
    float v_h_to = max(dot(v, half_to), 1e-3);
    direct += e * n_l * ibl_disc_d(n, h, dot(n, l), n_v, v_h, alpha, a) *
              (v_h_to * n_h / (n_h_to * v_h)) *
              ibl_smith_v(n_l, n_v, alpha) *
              ibl_schlick_f(f0, min(v_h_to, 1.0));
}
