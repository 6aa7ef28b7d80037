// SPDX-License-Identifier: MIT
// A level of lookups: the source blurred by a Gaussian of the same width
// everywhere on the sphere. Means of texels would make lights up to a third too
// bright or too dark: texels differ in solid angle by a factor of 5. Lookups
// are on rings, the nodes of Gauss-Laguerre quadrature in r^2 / (2 v)
// (Abramowitz and Stegun 1964, table 25.9), every second ring turned by half a
// step.
#include "capture.glsl"

uniform samplerCubeArray source; // the visible level is the one to blur
// Variance along an axis: x - y * the texel's relative solid angle.
uniform vec2 spread;
uniform int rings; // 2 or 3

const vec2 TWO[2] = vec2[](vec2(0.585786, 0.853553), vec2(3.414214, 0.146447));
const vec2 THREE[3] = vec2[](vec2(0.415775, 0.711093), vec2(2.294280, 0.278518),
                             vec2(6.289945, 0.010389));
const int POINTS = 8; // per ring
const float TURN = 6.28318530718;

void main()
{
    vec3 n = normalize(texel_direction());
    vec3 t, b;
    texel_frame(n, t, b);
    vec3 a = abs(n);
    float most = max(a.x, max(a.y, a.z));
    float v = spread.x - spread.y * most * most * most;
    vec4 sum = vec4(0.0);
    for (int r = 0; r < rings; r++) {
        vec2 ring = rings == 2 ? TWO[r] : THREE[r];
        float angle = sqrt(2.0 * v * ring.x), s = sin(angle);
        for (int i = 0; i < POINTS; i++) {
            float phi = TURN * (float(i) + 0.5 * float(r)) / float(POINTS);
            vec3 d = cos(angle) * n + s * (cos(phi) * t + sin(phi) * b);
            sum += ring.y / float(POINTS) *
                   textureLod(source, vec4(d, 0.0), 0.0);
        }
    }
    colour = nearest(sum);
}
