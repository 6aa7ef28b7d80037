// SPDX-License-Identifier: MIT
// Blends a picture into the mean of several.
uniform sampler2D picture;
uniform float part; // its share of all so far

layout(location = 0) out vec4 colour;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    colour = vec4(texelFetch(picture, at, 0).rgb, part);
}
