// SPDX-License-Identifier: MIT
// A rectangle's colour; alpha times the part of the pixel that it covers.
flat in vec4 edges;
flat in vec4 paint;

out vec4 colour;

void main() {
    vec2 cover = min(edges.zw, gl_FragCoord.xy + 0.5) -
                 max(edges.xy, gl_FragCoord.xy - 0.5);
    cover = clamp(cover, 0.0, 1.0);
    colour = vec4(paint.rgb, paint.a * cover.x * cover.y);
}
