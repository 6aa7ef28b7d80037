// SPDX-License-Identifier: MIT
// Blends a pass of samples into the mean of all passes so far.
uniform sampler2D pass_picture;
uniform float part; // this pass's share of all samples so far

layout(location = 0) out vec4 colour;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    colour = vec4(texelFetch(pass_picture, at, 0).rgb, part);
}
