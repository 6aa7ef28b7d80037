// SPDX-License-Identifier: MIT
// A quad that covers a sphere as seen from the eye; four vertices per instance.
#include "frame.glsl"

layout(location = 0) in vec4 centre_radius;
layout(location = 1) in vec4 f0_metallic;
layout(location = 2) in vec4 albedo_roughness;

flat out vec4 ball; // centre, radius
flat out vec4 ball_f0;
flat out vec4 ball_albedo;

void main()
{
    ball = centre_radius;
    ball_f0 = f0_metallic;
    ball_albedo = albedo_roughness;

    // The cone from the eye that touches the sphere, cut by the plane through
    // the centre that faces the eye, plus two pixels.
    vec3 to = centre_radius.xyz - eye.xyz;
    float d2 = dot(to, to), r = centre_radius.w;
    float pixel = 2.0 * length(up.xyz) * viewport.w;
    float half_edge = r * sqrt(d2 / max(d2 - r * r, 1e-6 * d2)) +
                      2.0 * pixel * sqrt(d2);
    vec3 z = to * inversesqrt(d2);
    vec3 x = normalize(cross(z, up.xyz));
    vec3 y = cross(x, z);
    vec2 corner = 2.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0;
    vec3 p = centre_radius.xyz + half_edge * (corner.x * x + corner.y * y);
    gl_Position = clip * vec4(p, 1.0);
}
