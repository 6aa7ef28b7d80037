// SPDX-License-Identifier: MIT
// A face of the cube from two paraboloids.
#include "capture.glsl"
#include "paraboloid.glsl"

uniform sampler2D source;  // towards +Z
uniform sampler2D source1; // towards -Z

vec4 lookup(sampler2D picture, vec3 d)
{
    return textureLod(picture, 0.5 + 0.5 * paraboloid_place(d), 0.0);
}

// Both pictures are mixed where the cosine to the axis is within +-RIM: each
// has its own errors there.
const float RIM = 0.04;

void main()
{
    vec3 d = normalize(texel_direction());
    float share = clamp(0.5 + 0.5 * d.z / RIM, 0.0, 1.0);
    vec4 towards = vec4(0.0), away = vec4(0.0);
    if (share > 0.0)
        towards = lookup(source, vec3(-d.x, d.y, d.z));
    if (share < 1.0)
        away = lookup(source1, vec3(d.x, d.y, -d.z));
    colour = kept(mix(away, towards, share));
}
