// SPDX-License-Identifier: MIT
// Every function of ibl/ibl.glsl, for check_view_ibl and check-glsl.sh, which
// make HLSL of it as well.
// a: roughness, metallic, kind, radius of a light; n.w: F0. Of kinds 11 and 12,
// flat maps in place of brdf: lod, edge, kind.
vec4 seen_by(samplerCube specular, samplerCube irradiance, sampler2D brdf,
             sampler2DArray lobe, vec4 chain, vec4 a, vec4 n, vec4 v, vec4 l,
             vec4 sh[25])
{
    int kind = int(a.z);
    vec3 f0 = vec3(n.w, 0.5 * n.w, 1.0), albedo = vec3(0.8, 0.5, 0.0);
    vec3 direct = vec3(0.0, 0.0, 0.0), light = direct;
    vec4 low[9];

    for (int i = 0; i < 9; i++)
        low[i] = sh[i];
    ibl_add_light(n.xyz, v.xyz, f0, a.x, l.xyz, a.w, vec3(1.0, 2.0, 3.0),
                  direct, light);
    if (kind == 11)
        return vec4(ibl_octahedral(brdf, n.xyz, a.x, a.y), 1.0);
    if (kind == 12)
        return vec4(ibl_equirect(brdf, n.xyz, a.x, a.y), 1.0);
    if (kind == 6)
        return vec4(direct, light.b);
    if (kind == 7)
        return vec4(ibl_irradiance_sh(low, n.xyz), 1.0);
    if (kind == 8)
        return vec4(ibl_irradiance_sh4(sh, n.xyz), 1.0);
    float n_v = clamp(dot(n.xyz, v.xyz), 0.0, 1.0);
    vec2 rg = ibl_brdf(brdf, n_v, a.x);
    if (kind == 9)
        return vec4(ibl_lod(chain, a.x), ibl_metallic(f0, rg), rg);
    light = ibl_irradiance(irradiance, n.xyz);
    ibl_lobe q = ibl_lobe_split(a.x, chain);
    if (kind == 1)
        q = ibl_lobe_fit(n_v, a.x, a.y, chain);
    if (kind == 10)
        q = ibl_lobe_bent(n_v, a.x, chain);
    if (kind == 2)
        q = ibl_lobe_table(lobe, n_v, a.x, a.y, chain);
    if (kind == 3 || kind == 4 || kind == 5)
        q = ibl_lobe_taps(lobe, n_v, a.x, a.y, chain, kind - 1);
    vec3 seen = ibl_specular(specular, q, n.xyz, v.xyz, light);
    return vec4(ibl_shade(f0, albedo, rg, seen, light), seen.g);
}
