// SPDX-License-Identifier: MIT
// The environment behind everything: a cube, the equirectangular map that was
// baked, or a level of the specular chain.
#include "lights.glsl"

uniform samplerCube sky_map;
uniform sampler2D backdrop_map;

// d: unit, in the environment's frame.
vec3 backdrop_cube(vec3 d)
{
    // Further levels of a specular chain are other roughnesses, not smaller
    // pictures.
    vec3 rgb = shading.w != 0 ? texture(sky_map, d).rgb
                              : textureLod(sky_map, d, 0.0).rgb;
    for (int i = 0; i < reflection.w; i++) {
        float radius = disc_direction[i].w, s = sin(0.5 * radius);
        if (distance(d, disc_direction[i].xyz) < 2.0 * s)
            rgb += disc_irradiance[i].rgb / (4.0 * ibl_pi * s * s);
    }
    return rgb;
}

// By a cubic B-spline of 4 x 4 texels, whose steps are not seen where they are
// larger than pixels; two weights of a row are one linear lookup.
vec3 backdrop_smooth(vec2 at)
{
    vec2 size = vec2(textureSize(backdrop_map, 0));
    vec2 p = at * size - 0.5, f = fract(p), g = 1.0 - f;
    vec2 low = g * g * g / 6.0, high = f * f * f / 6.0;
    vec2 left = low + 0.5 * f * f * (f - 2.0) + 2.0 / 3.0;
    vec2 right = 1.0 - left;
    vec2 a = (floor(p) + 0.5 - low / left) / size;
    vec2 b = (floor(p) + 1.5 + high / right) / size;
    return mix(mix(textureLod(backdrop_map, b, 0.0).rgb,
                   textureLod(backdrop_map, vec2(a.x, b.y), 0.0).rgb, left.x),
               mix(textureLod(backdrop_map, vec2(b.x, a.y), 0.0).rgb,
                   textureLod(backdrop_map, a, 0.0).rgb, left.x), left.y);
}

vec3 backdrop_of_map(vec3 d)
{
    return backdrop_smooth(place_in_map(d));
}
