// SPDX-License-Identifier: MIT
// A picture of a face in the range of halves, without infinity or NaN.
#include "capture.glsl"

uniform sampler2D source;

void main()
{
    colour = kept(texelFetch(source, ivec2(gl_FragCoord.xy), 0));
}
