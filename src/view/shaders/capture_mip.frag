// SPDX-License-Identifier: MIT
// Halves the edge. Along each edge four texels are averaged by 1/8 3/8 3/8 1/8
// (the tent of bilinear lookups), also across faces, weighted by solid angle. A
// mean of 2x2 would move a small light to the middle of its texel. Each of four
// lookups, 3/4 of a texel off the middle, has 1/4 and 3/4 of two texels.
#include "capture.glsl"

uniform samplerCubeArray source; // the visible level is the larger one

void main()
{
    vec2 p = texel_place();
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = 0; i < 4; i++) {
        vec2 side = vec2(2 * (i & 1) - 1, 2 * (i >> 1) - 1);
        vec3 d = face_direction(face, p + side * (0.75 / edge));
        float r2 = dot(d, d), w = inversesqrt(r2) / r2;
        sum += w * textureLod(source, vec4(d, 0.0), 0.0);
        weights += w;
    }
    colour = nearest(sum / weights);
}
