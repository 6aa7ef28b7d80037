// SPDX-License-Identifier: MIT
// Shows the linear picture, alone or beside another, on the display. Programs
// for materials alone, without false colours, define TONE as their curve:
// software draws all branches of a pixel.
#include "frame.glsl"
#include "tone.glsl"

uniform sampler2D picture;
uniform sampler2D other;

// Not gl_FragCoord: Mesa turns its rows upside down where the same program
// draws a window, then a picture.
in vec2 place;
out vec4 colour;
// view_compare of view/settings.h
const int ALONE = 0, SPLIT = 1, DIFFERENCE = 2;

vec2 pixel;

// Exposure, tone curve and gain are left out: linear values, for files.
bool raw() {
    return show.x < 0;
}

// Where a pixel is from the left to the right end of what is split, 0..1, and,
// of a sphere, from its bottom to its top; -1: no sphere is there. Spheres are
// split one by one: in cells of 1 around their centres, in the plane z = 0.
vec2 split_place(vec2 pixel) {
    vec3 d = ray_through(pixel);
    vec2 size = vec2(grid.xy);
    if (grid.x == 0 || d.z * eye.z >= 0.0)
        return vec2(pixel.x / viewport.x, 0.0);
    vec2 cell = eye.xy - eye.z / d.z * d.xy + 0.5 * size;
    bool beyond = any(lessThan(cell, vec2(0.0))) ||
                  any(greaterThan(cell, size));
    return vec2(fract(cell.x), beyond ? -1.0 : fract(cell.y));
}

bool on_left(vec2 pixel) {
    return split_place(pixel).x < display.y;
}

// A white and a black column at the seam, visible on any picture, of spheres
// only at bottom and top, so that both sides meet; 0: neither.
float seam() {
    vec2 at = split_place(pixel);
    bool left = at.x < display.y;
    vec2 beside = pixel + vec2(left ? 1.0 : -1.0, 0.0);
    float y = abs(at.y - 0.5);
    if (on_left(beside) == left || abs(split_place(beside).x - at.x) > 0.5 ||
        (grid.x != 0 && (y < 0.4 || y > 0.5)))
        return 0.0;
    return left ? -1.0 : 1.0;
}

vec4 compared(vec4 c) {
    vec4 against = texelFetch(other, ivec2(pixel), 0);
    if (show.z == DIFFERENCE)
        return vec4(abs(c - against).rgb * (raw() ? 1.0 : display.z), 1.0);
    return on_left(pixel) ? c : against;
}

// Display colour of scene-linear RGB: magenta for NaN, cyan for infinity.
vec3 shown(vec3 c) {
    if (raw())
        return c;
    if (any(not_number(c)))
        return vec3(1.0, 0.0, 1.0);
    if (any(beyond(c)))
        return vec3(0.0, 1.0, 1.0);
#ifdef TONE
    return srgb(tone(c * display.x, TONE));
#else
    if (show.y != 0)
        return false_colour(luminance(c) * display.x, pixel);
    // Differences are linear: a legend says what is white.
    return srgb(tone(c * display.x, show.z == DIFFERENCE ? 0 : show.x));
#endif
}

void main() {
#ifdef COPY // which blending adds to the mean of several
    colour = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
    return;
#endif
    pixel = floor(place * viewport.xy) + 0.5;
    vec4 c = texelFetch(picture, ivec2(pixel), 0);
#ifndef TONE
    float line = show.z == SPLIT && !raw() ? seam() : 0.0;
    if (line != 0.0) {
        colour = vec4(vec3(max(line, 0.0)), 1.0);
        return;
    }
    if (show.z != ALONE)
        c = compared(c);
    // Outside of a map, or of what a transparent background is behind.
    if (c.a < 1.0 && !raw()) {
        colour = vec4(c.a > 0.0 ? shown(c.rgb / c.a) : vec3(0.1),
                      looks.z != 0 ? c.a : 1.0);
        return;
    }
#endif
    colour = vec4(shown(c.rgb), 1.0);
}
