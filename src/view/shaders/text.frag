// SPDX-License-Identifier: MIT
// A rectangle's colour, or a scale from its left to its right; alpha times the
// part of the pixel that it covers.
#include "tone.glsl"

flat in vec4 edges;
flat in vec4 paint;

out vec4 colour;

void main() {
    vec2 cover = min(edges.zw, gl_FragCoord.xy + 0.5) -
                 max(edges.xy, gl_FragCoord.xy - 0.5);
    cover = clamp(cover, 0.0, 1.0);
    float share = (gl_FragCoord.x - edges.x) / (edges.z - edges.x);
    // As overlay.c has them.
    float y = 0.18 * exp2(STOPS * (2.0 * share - 1.0));
    vec4 c = paint.a == 2.0   ? vec4(false_colour(y, gl_FragCoord.xy), 1.0)
             : paint.a == 3.0 ? vec4(srgb(vec3(share)), 1.0)
                              : paint;
    colour = vec4(c.rgb, c.a * cover.x * cover.y);
}
