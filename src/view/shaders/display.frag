// SPDX-License-Identifier: MIT
// Shows the linear picture, alone or beside another, on the display.
#include "frame.glsl"
#include "tone.glsl"

uniform sampler2D picture;
uniform sampler2D other;

out vec4 colour;

// view_mode and view_compare of view/settings.h
const int SPHERES = 0, MODEL = 5;
const int ALONE = 0, SPLIT = 1, DIFFERENCE = 2;

// First column of the right side.
int split_column() {
    return int(floor(display.y * viewport.x));
}

vec3 compared(ivec2 at, vec3 c) {
    vec3 against = texelFetch(other, at, 0).rgb;
    if (show.z == DIFFERENCE)
        return abs(c - against) * display.z;
    return at.x < split_column() ? c : against;
}

// Display colour of scene-linear RGB: magenta for NaN, cyan for infinity.
vec3 shown(vec3 c) {
    if (any(not_number(c)))
        return vec3(1.0, 0.0, 1.0);
    if (any(beyond(c)))
        return vec3(0.0, 1.0, 1.0);
    if (show.y != 0)
        return false_colour(luminance(c) * display.x, gl_FragCoord.xy);
    return srgb(tone(c * display.x, show.x));
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 c = texelFetch(picture, at, 0);
    // Maps are not compared. Their background has alpha 0.
    if (choice.x != SPHERES && choice.x != MODEL) {
        colour = vec4(c.a == 0.0 ? vec3(0.1) : shown(c.rgb), 1.0);
        return;
    }
    // A white and a black column, visible on any picture.
    int beside = at.x - split_column();
    if (show.z == SPLIT && (beside == 0 || beside == -1)) {
        colour = vec4(vec3(float(beside + 1)), 1.0);
        return;
    }
    if (show.z != ALONE)
        c.rgb = compared(at, c.rgb);
    colour = vec4(shown(c.rgb), 1.0);
}
