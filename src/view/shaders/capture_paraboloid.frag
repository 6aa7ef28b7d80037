// SPDX-License-Identifier: MIT
// A face of the cube out of two paraboloids.
#include "capture.glsl"
#include "paraboloid.glsl"

uniform sampler2D source;  // towards +Z
uniform sampler2D source1; // towards -Z

vec4 lookup(sampler2D picture, vec3 d)
{
    return textureLod(picture, 0.5 + 0.5 * paraboloid_place(d), 0.0);
}

void main()
{
    vec3 d = normalize(texel_direction());
    colour = kept(d.z < 0.0 ? lookup(source1, vec3(d.x, d.y, -d.z))
                            : lookup(source, vec3(-d.x, d.y, d.z)));
}
