// SPDX-License-Identifier: MIT
// A pixel per tile of the picture: the mask of the local probes that are
// visible in it. The tiles of each 64 probes are above those of the last.
#include "room.glsl"
#include "probes.glsl"

uniform samplerBuffer probe_buffer;

layout(location = 0) out uvec2 mask;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    int first = 64 * (at.y / order.y);

    at.y %= order.y;
    mask = ibl_tile_cull(probe_buffer, first, min(64, picture_size.w - first),
                         clip, picture_size.xy, picture_size.z, at);
}
