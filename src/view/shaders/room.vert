// SPDX-License-Identifier: MIT
// A box at its place, or a sphere about the origin, with its material.
#include "room.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 centre_radius; // of a sphere; boxes: 0, 0, 0, 1
layout(location = 2) in vec4 albedo_roughness;
layout(location = 3) in vec3 f0;
layout(location = 4) in vec3 emission;
layout(location = 5) in vec3 normal;

out vec3 surface_position;
out vec3 surface_normal;
flat out vec4 surface_albedo; // w: roughness
flat out vec3 surface_f0;
flat out vec3 surface_emission;

void main()
{
    surface_position = centre_radius.xyz + centre_radius.w * position;
    surface_normal = normal;
    surface_albedo = albedo_roughness;
    surface_f0 = f0;
    surface_emission = emission;
    gl_Position = projected(surface_position, gl_ClipDistance[0]);
}
