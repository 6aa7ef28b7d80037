// SPDX-License-Identifier: MIT
// The environment behind everything.
#include "backdrop.glsl"
#include "maps.glsl"

layout(location = 0) out vec4 colour;

vec3 blurred(vec3 d)
{
    vec3 rgb = textureLod(specular_map, d, ibl_lod(lod, diffuse.w)).rgb;
    vec3 rest = vec3(0.0);
    for (int i = 0; i < reflection.z; i++)
        ibl_add_light(d, d, vec3(1.0), diffuse.w, disc_direction[i].xyz,
                      disc_direction[i].w, disc_irradiance[i].rgb, rgb, rest);
    return rgb;
}

// Each has a program of its own, which defines BACKDROP: software draws all
// branches of a pixel. view_backdrop of view/frame.h, and what is blurred.
const int NONE = 0, MAP = 2, BLURRED = 3;

void main()
{
    vec3 d = turned(ray_through(gl_FragCoord.xy));
    vec3 rgb = BACKDROP == NONE      ? vec3(0.0)
               : BACKDROP == BLURRED ? blurred(d)
               : BACKDROP == MAP     ? backdrop_of_map(d)
                                     : backdrop_cube(d);
    colour = vec4(rgb, 1.0);
}
