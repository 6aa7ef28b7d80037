// SPDX-License-Identifier: MIT
// Spheres by the integral itself.
#include "sphere.glsl"
#include "maps.glsl"
#include "lights.glsl"
#include "integral.glsl"

layout(location = 0) out vec4 colour;

void main()
{
    surface at = sphere_at(gl_FragCoord.xy);
    colour = vec4(0.0);
    if (at.coverage <= 0.0)
        return;
    float roughness = ball_albedo.a;
    vec3 f0 = ball_f0.rgb, specular, light;
    vec2 rg = ibl_brdf(lut_map, at.n_v, roughness);
    vec3 k = diffuse_factor(f0, ball_albedo.rgb, rg);
    integrate(at.normal, at.view, at.n_v, f0, roughness,
              any(notEqual(k, vec3(0.0))), 0u, specular, light);
    add_lights(at.position, at.normal, at.view, f0, roughness, sampling.w,
               specular, light);
    colour = vec4(specular + k * light, at.coverage);
}
