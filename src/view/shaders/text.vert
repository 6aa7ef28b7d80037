// SPDX-License-Identifier: MIT
// A rectangle per instance, extended to whole pixels.
layout(location = 0) in vec4 rectangle; // left, top, right, bottom: pixels
layout(location = 1) in vec4 tint;      // sRGB-encoded, alpha not multiplied in

uniform vec2 window; // pixels

flat out vec4 edges; // left, bottom, right, top, from the lower left
flat out vec4 paint;

void main() {
    vec2 low = floor(rectangle.xy);
    vec2 high = ceil(rectangle.zw);
    vec2 at = mix(low, high, vec2(gl_VertexID & 1, gl_VertexID >> 1));
    edges = vec4(rectangle.x, window.y - rectangle.w,
                 rectangle.z, window.y - rectangle.y);
    paint = tint;
    gl_Position = vec4((2.0 * at / window - 1.0) * vec2(1.0, -1.0), 0.0, 1.0);
}
