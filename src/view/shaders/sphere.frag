// SPDX-License-Identifier: MIT
// Spheres as shaders of games draw them, by the functions of ibl/ibl.glsl.
#include "sphere.glsl"
#include "maps.glsl"
#include "lights.glsl"
#include "lookup.glsl"
#include "widen.glsl"

layout(location = 0) out vec4 colour;

void main()
{
    surface s = sphere_at(gl_FragCoord.xy);
    vec3 f0 = ball_f0.rgb;
    float roughness = widened(ball_albedo.a, s.normal,
                              textureSize(specular_map, 0).x);

    vec2 rg = ibl_brdf(lut_map, s.n_v, roughness);
    vec3 light = irradiance(s.normal);
    vec3 seen = ibl_specular(specular_map, lobe_of(s.n_v, roughness, f0, rg),
                             turned(s.normal), turned(s.view), light);
    vec3 direct = vec3(0.0);
    add_lights(s.position, s.normal, s.view, f0, roughness, reflection.z,
               direct, light);
    vec3 k = diffuse_factor(f0, ball_albedo.rgb, rg);
    colour = vec4((f0 * rg.x + rg.y) * seen + direct + k * light, s.coverage);
}
