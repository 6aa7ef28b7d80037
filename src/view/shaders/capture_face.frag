// SPDX-License-Identifier: MIT
// A picture of a face as the cube keeps it: no infinity, nothing undefined, as
// every lookup near it would have it too.
#include "capture.glsl"

uniform sampler2D source;

void main()
{
    colour = kept(texelFetch(source, ivec2(gl_FragCoord.xy), 0));
}
