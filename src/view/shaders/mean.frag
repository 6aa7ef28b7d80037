// SPDX-License-Identifier: MIT
// A picture, which blending adds to the mean of several.
uniform sampler2D picture;

layout(location = 0) out vec4 colour;

void main()
{
    colour = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
}
