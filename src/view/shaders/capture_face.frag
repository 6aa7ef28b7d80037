// SPDX-License-Identifier: MIT
// Clamps a face's picture to the range of halves, without infinity or NaN.
#include "capture.glsl"

uniform sampler2D source;

void main()
{
    colour = kept(texelFetch(source, ivec2(gl_FragCoord.xy), 0));
}
