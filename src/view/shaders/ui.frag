// SPDX-License-Identifier: MIT
// Letters and shapes of the user interface, or a scale from its left to its
// right: the false colours, or greys.
#include "tone.glsl"

uniform sampler2D picture; // the letters
uniform int kind;          // as ui.cpp has them

in vec2 at;
in vec4 paint;

out vec4 colour;

const int FALSE_COLOURS = 1, GREYS = 2;

void main()
{
    float y = 0.18 * exp2(STOPS * (2.0 * at.x - 1.0));
    colour = kind == FALSE_COLOURS
                 ? vec4(false_colour(y, gl_FragCoord.xy), 1.0)
             : kind == GREYS ? vec4(srgb(vec3(at.x)), 1.0)
                             : paint * texture(picture, at);
}
