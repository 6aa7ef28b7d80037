// SPDX-License-Identifier: MIT
// A pass of samples as its part of the mean over all so far, by blending.
uniform sampler2D pass_picture;
uniform float part; // of all samples that this pass has

layout(location = 0) out vec4 colour;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    colour = vec4(texelFetch(pass_picture, at, 0).rgb, part);
}
