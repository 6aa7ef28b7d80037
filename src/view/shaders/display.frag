// SPDX-License-Identifier: MIT
// The linear picture, that of the truth or both, as the display shows them.
#include "frame.glsl"
#include "tone.glsl"

uniform sampler2D picture;
uniform sampler2D truth;

out vec4 colour;

// view_compare of view/settings.h
const int REFERENCE = 1, SPLIT = 2, DIFFERENCE = 3;

// Linear RGB that is to be shown at a pixel.
vec3 compared(ivec2 at) {
    if (show.z == REFERENCE)
        return texelFetch(truth, at, 0).rgb;
    if (show.z == SPLIT && at.x >= int(floor(display.y * viewport.x)))
        return texelFetch(truth, at, 0).rgb;
    vec3 c = texelFetch(picture, at, 0).rgb;
    if (show.z == DIFFERENCE)
        return abs(c - texelFetch(truth, at, 0).rgb) * display.z;
    return c;
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    // The line of the split: a white and a black column, so that it is seen on
    // whatever is behind it.
    int beside = at.x - int(floor(display.y * viewport.x));
    if (show.z == SPLIT && (beside == 0 || beside == -1)) {
        colour = vec4(vec3(float(beside + 1)), 1.0);
        return;
    }

    vec3 c = compared(at);
    // inspect.frag: no map is here.
    if (inspect.x != 0 && texelFetch(picture, at, 0).a == 0.0)
        colour = vec4(vec3(0.1), 1.0);
    else if (any(not_number(c)))
        colour = vec4(1.0, 0.0, 1.0, 1.0);
    else if (any(beyond(c)))
        colour = vec4(0.0, 1.0, 1.0, 1.0);
    else if (show.y != 0)
        colour = vec4(false_colour(luminance(c) * display.x,
                                   gl_FragCoord.xy), 1.0);
    else
        colour = vec4(srgb(tone(c * display.x, show.x)), 1.0);
}
