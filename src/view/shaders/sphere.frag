// SPDX-License-Identifier: MIT
// The split sum: Karis 2013, "Real Shading in Unreal Engine 4".
#include "sphere.glsl"
#include "maps.glsl"
#include "brdf.glsl"
#include "lights.glsl"

layout(location = 0) out vec4 colour;

void main()
{
    surface s = sphere_at(gl_FragCoord.xy);
    vec3 f0 = ball_f0.rgb;
    float roughness = ball_albedo.a;

    vec2 rg = table(s.n_v, roughness);
    float ess = rg.x + rg.y;
    vec3 fss = f0 * rg.x + rg.y;

    vec3 reflected = reflect(-s.view, s.normal);
    vec3 specular = fss * specular_light(roughness, reflected);
    vec3 light = irradiance(s.normal);
    add_lights(s.position, s.normal, s.view, f0, roughness, specular, light);
    vec3 k = diffuse_factor(f0, ball_albedo.rgb, fss, ess, shading.x != 0);
    colour = vec4(specular + k * light, s.coverage);
}
