// SPDX-License-Identifier: MIT
// A face of a filtered level: the weighted sum of lookups at a sample set
// (capture_samples.c) around the texel's normal. Tangents follow the face's
// rows, so there is no jump within a face.
#include "capture.glsl"

uniform samplerCubeArray source;
uniform sampler2D samples; // x, y, weight and level of a direction around +Z
uniform int row, count;

void main()
{
    vec3 n = normalize(texel_direction());
    vec3 t, b;
    texel_frame(n, t, b);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < count; i++) {
        vec4 s = texelFetch(samples, ivec2(i, row), 0);
        float z = sqrt(max(1.0 - dot(s.xy, s.xy), 0.0));
        vec3 d = s.x * t + s.y * b + z * n;
        sum += s.z * textureLod(source, vec4(d, 0.0), s.w);
    }
    // Weights sum to 1 but for rounding.
    colour = nearest(min(sum, vec4(vec3(LARGEST_HALF), 1.0)));
}
