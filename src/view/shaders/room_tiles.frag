// SPDX-License-Identifier: MIT
// A pixel per tile of the picture: the mask of the local probes that are
// visible in it.
#include "room.glsl"
#include "probes.glsl"

uniform samplerBuffer probe_buffer;

layout(location = 0) out uvec2 mask;

void main()
{
    mask = ibl_tile_cull(probe_buffer, picture_size.w, clip, picture_size.xy,
                         picture_size.z, ivec2(gl_FragCoord.xy));
}
