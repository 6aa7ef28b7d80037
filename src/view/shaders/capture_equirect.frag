// SPDX-License-Identifier: MIT
// The cube as an equirectangular map, row 0 the zenith. Averages over each
// pixel's solid angle, so a light of one texel keeps its energy.
#include "capture.glsl"

uniform samplerCubeArray source;

const int SUB = 4; // lookups along each side of a pixel
const float PI = 3.14159265358979;

// edge: height of the map.
void main()
{
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int y = 0; y < SUB; y++) {
        float down = floor(gl_FragCoord.y) + (float(y) + 0.5) / float(SUB);
        float theta = PI * down / edge, s = sin(theta), c = cos(theta);
        for (int x = 0; x < SUB; x++) {
            float along = floor(gl_FragCoord.x) + (float(x) + 0.5) / float(SUB);
            float phi = PI * along / edge - PI;
            vec3 d = vec3(s * cos(phi), c, s * sin(phi));
            sum += s * textureLod(source, vec4(d, 0.0), 0.0);
        }
        weights += float(SUB) * s;
    }
    colour = sum / weights;
}
