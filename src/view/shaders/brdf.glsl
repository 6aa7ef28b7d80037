// SPDX-License-Identifier: MIT
// GGX formulas; alpha is roughness squared. Vectors are unit, cosines in 0..1.
// Walter et al. 2007, "Microfacet Models for Refraction through Rough
// Surfaces"; Heitz 2014, "Understanding the Masking-Shadowing Function in
// Microfacet-Based BRDFs"; Karis 2013, "Real Shading in Unreal Engine 4";
// Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".

const float PI = 3.14159265358979;

// Distribution of normals, Walter eq. 33. The sine comes from the cross
// product: near the peak 1 - cos^2 would lose all digits.
float ggx_d(vec3 n, vec3 h, float alpha)
{
    vec3 s = cross(n, h);
    float c = alpha * dot(n, h);
    float k = alpha / (dot(s, s) + c * c);
    return k * k / PI;
}

// G / (4 N.L N.V), Smith's G, height-correlated: Heitz eq. 99.
float smith_v(float n_l, float n_v, float alpha)
{
    float a2 = alpha * alpha;
    float l = n_v * sqrt(n_l * n_l * (1.0 - a2) + a2);
    float v = n_l * sqrt(n_v * n_v * (1.0 - a2) + a2);
    return 0.5 / max(l + v, 1e-20);
}

// The same with Schlick's G, k = roughness^2 / 2: Karis, image-based light.
float schlick_v(float n_l, float n_v, float alpha)
{
    float k = 0.5 * alpha;
    float l = n_l * (1.0 - k) + k;
    float v = n_v * (1.0 - k) + k;
    return 0.25 / max(l * v, 1e-20);
}

float pow5(float x)
{
    float x2 = x * x;
    return x2 * x2 * x;
}

// Fresnel: Schlick eq. 15.
vec3 schlick_f(vec3 f0, float v_h)
{
    return f0 + (1.0 - f0) * pow5(1.0 - v_h);
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
    float s = sqrt(u.x), phi = 2.0 * PI * u.y;
    return vec3(s * cos(phi), s * sin(phi), sqrt(1.0 - u.x));
}

// Factor of irradiance / pi: the part that is not reflected specularly. fss:
// single-scattering reflection of white light; ess: the same for F0 = 1.
// multiple: compensates for lost multiple scattering, Fdez-Aguera 2019, "A
// Multiple-Scattering Microfacet Model for Real-Time Image Based Lighting",
// JCGT 8(1), listing 1.
vec3 diffuse_factor(vec3 f0, vec3 albedo, vec3 fss, float ess, bool multiple)
{
    vec3 fms = vec3(0.0);
    if (multiple) {
        float ems = max(1.0 - ess, 0.0);
        vec3 favg = f0 + (1.0 - f0) / 21.0;
        fms = ems * fss * favg / (1.0 - favg * ems);
    }
    return fms + albedo * (1.0 - fss - fms);
}
