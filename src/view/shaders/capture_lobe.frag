// SPDX-License-Identifier: MIT
// A face of a filtered level: the weighted sum of lookups by one set of samples
// (capture_samples.c), turned to the texel's normal. The tangent follows the
// face's rows, so the pattern turns with no jump on a face.
#include "capture.glsl"

uniform samplerCube source;
uniform sampler2D samples; // x, y, weight and level of a direction around +Z
uniform int row, count;

void main()
{
    vec3 n = normalize(texel_direction());
    vec3 right = face_direction(face, vec2(1.0, 0.0)) -
                 face_direction(face, vec2(0.0));
    vec3 t = normalize(right - dot(n, right) * n);
    vec3 b = cross(n, t);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < count; i++) {
        vec4 s = texelFetch(samples, ivec2(i, row), 0);
        float z = sqrt(max(1.0 - dot(s.xy, s.xy), 0.0));
        sum += s.z * textureLod(source, s.x * t + s.y * b + z * n, s.w);
    }
    colour = nearest(min(sum, 65504.0));
}
