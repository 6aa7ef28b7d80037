// SPDX-License-Identifier: MIT
// The environment behind everything.
#include "ray.glsl"

uniform samplerCube sky_map;

layout(location = 0) out vec4 colour;

const float PI = 3.14159265358979;

void main()
{
    vec3 d = turned(ray_through(gl_FragCoord.xy));
    // Further levels of a specular chain are other roughnesses, not smaller
    // pictures.
    vec3 rgb = shading.w != 0 ? texture(sky_map, d).rgb
                               : textureLod(sky_map, d, 0.0).rgb;
    for (int i = 0; i < reflection.w; i++) {
        float radius = disc_direction[i].w, s = sin(0.5 * radius);
        if (distance(d, disc_direction[i].xyz) < 2.0 * s)
            rgb += disc_irradiance[i].rgb / (4.0 * PI * s * s);
    }
    colour = vec4(shading.z != 0 ? rgb : vec3(0.0), 1.0);
}
