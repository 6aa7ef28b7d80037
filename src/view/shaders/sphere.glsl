// SPDX-License-Identifier: MIT
// The sphere of an instance under a pixel, and the part of the pixel it covers.
#include "ray.glsl"

flat in vec4 ball; // centre, radius
flat in vec4 ball_f0; // F0, metallic
flat in vec4 ball_albedo; // diffuse colour, roughness

struct surface {
    vec3 position, normal, view; // view: towards the eye
    float n_v;
    float coverage; // 0..1
};

// Rays that miss the sphere by less than a pixel hit its outline. The edge is
// as wide as places in the pixel are apart: their mean is the part of it that
// is covered. All vectors are relative to the centre, so no digits cancel.
surface sphere_at(vec2 pixel)
{
    vec3 d = ray_through(pixel);
    vec3 to = ball.xyz - eye.xyz;
    vec3 off = dot(to, d) * d - to; // the ray's nearest point to the centre
    float miss = length(off), r = ball.w;
    float pixel_step = length(vec2(dFdx(miss), dFdy(miss)));
    float half_chord = sqrt(max((r - miss) * (r + miss), 0.0));
    surface s;
    s.coverage = (r - miss) / max(pixel_step * turn.w, 1e-20);
    s.coverage = clamp(s.coverage + 0.5, 0.0, 1.0);
    if (dot(to, d) <= half_chord)
        s.coverage = 0.0; // sphere behind or around the eye
    s.normal = normalize(off - half_chord * d);
    s.position = ball.xyz + r * s.normal;
    s.view = -d;
    s.n_v = half_chord / r;
    return s;
}
