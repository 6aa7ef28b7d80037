// SPDX-License-Identifier: MIT
// The split sum as sphere.frag has it, with light of the probes that hold here;
// of the environment what they leave: ibl_probes_blend of ibl/probes.h.
#include "room.glsl"
#include "ibl.glsl"
#include "brdf.glsl"
#include "probes.glsl"
#include "lights.glsl"
#include "sun.glsl"

uniform samplerCube probe_specular[PROBES];
uniform samplerCube probe_irradiance[PROBES];

in vec3 surface_position;
in vec3 surface_normal;
flat in vec4 surface_albedo;
flat in vec3 surface_f0;
flat in vec3 surface_emission;

layout(location = 0) out vec4 colour;

ibl_probe probe_at(int i)
{
    ibl_volume influence =
        ibl_volume(false, influence_centre[i].xyz, influence_half[i].xyz);
    ibl_volume proxy =
        ibl_volume(false, proxy_centre[i].xyz, proxy_half[i].xyz);
    bool has_proxy = limit_half.w != 0.0 && proxy_half[i].x > 0.0;
    return ibl_probe(probe_position[i].xyz, influence, probe_position[i].w,
                     has_proxy, proxy, i);
}

// rgb: the sum so far; a: what is left of 1.
void take(inout vec4 sum, vec4 seen, float influence)
{
    if (seen.a <= 0.0)
        return;
    float share = min(influence * min(seen.a, 1.0), sum.a);
    sum += vec4(share / seen.a * seen.rgb, -share);
}

// Samplers cannot be chosen by an index that varies.
void add_probe(int i, samplerCube specular_cube, samplerCube irradiance_cube,
               vec3 normal, vec3 reflected, inout vec4 specular,
               inout vec4 light)
{
    vec3 d;
    ibl_probe p = probe_at(i);
    float influence = ibl_probe_influence(p, surface_position);
    if (influence <= 0.0)
        return;
    ibl_probe_parallax(p, surface_position, reflected, d);
    float lod = clamp(surface_albedo.a * probe_lod[i].x + probe_lod[i].y, 0.0,
                      probe_lod[i].z);
    take(specular, textureLod(specular_cube, d, lod), influence);
    take(light, textureLod(irradiance_cube, normal, 0.0), influence);
}

bool beyond_limit()
{
    // What is on the border is inside: it may be a wall.
    return limit_centre.w != 0.0 &&
           any(greaterThan(abs(surface_position - limit_centre.xyz),
                           limit_half.xyz * (1.0 + 1.0 / 1024.0)));
}

// What the sun gives: the reflection of it, and irradiance / pi. What is
// smoother than a light's least roughness would show it as sharp as the sky
// does, and does show it in the sky, as much of it as is left there: it has no
// reflection besides.
vec3 add_sun(vec3 normal, vec3 view, inout vec3 light)
{
    float n_l = dot(normal, sun_direction.xyz);
    vec3 specular = vec3(0.0);
    if (sun_irradiance.w == 0.0 || n_l <= 0.0 || surface_f0 == vec3(0.0))
        return specular;
    vec3 e = sun_irradiance.rgb * sun_seen(surface_position, normal, n_l);
    add_light(normal, view, sun_direction.xyz, e, surface_f0, surface_albedo.a,
              specular, light);
    return surface_albedo.a < LIGHT_ROUGHNESS ? vec3(0.0) : specular;
}

void main()
{
    if (beyond_limit()) {
        colour = vec4(0.0);
        return;
    }
    vec3 normal = normalize(surface_normal);
    vec3 view = normalize(eye.xyz - surface_position);
    vec3 reflected = reflect(-view, normal);
    float n_v = clamp(dot(normal, view), 0.0, 1.0);

    vec4 specular = vec4(0.0, 0.0, 0.0, 1.0), light = specular;
    int probes = int(range.y);
    if (probes > 0)
        add_probe(0, probe_specular[0], probe_irradiance[0], normal, reflected,
                  specular, light);
    if (probes > 1)
        add_probe(1, probe_specular[1], probe_irradiance[1], normal, reflected,
                  specular, light);
    if (probes > 2)
        add_probe(2, probe_specular[2], probe_irradiance[2], normal, reflected,
                  specular, light);
    if (probes > 3)
        add_probe(3, probe_specular[3], probe_irradiance[3], normal, reflected,
                  specular, light);
    if (specular.a > 0.0)
        specular.rgb += specular.a * specular_light(surface_albedo.a,
                                                    reflected);
    if (light.a > 0.0)
        light.rgb += light.a * irradiance(normal);

    vec3 direct = add_sun(normal, view, light.rgb);

    vec2 rg = table(n_v, surface_albedo.a);
    // Nothing at all is reflected at grazing angles where F0 is 0: panels.
    if (surface_f0 == vec3(0.0))
        rg = vec2(0.0);
    vec3 fss = surface_f0 * rg.x + rg.y;
    vec3 k = diffuse_factor(surface_f0, surface_albedo.rgb, fss, rg.x + rg.y,
                            choice.z != 0);
    colour = vec4(fss * specular.rgb + direct + k * light.rgb +
                  surface_emission, 1.0);
}
