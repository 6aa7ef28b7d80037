// SPDX-License-Identifier: MIT
// ibl_probe_influence and ibl_probe_parallax of ibl/probes.h, of boxes.

float probe_influence(vec3 point, vec3 centre, vec3 half_size, float blend)
{
    vec3 inside = half_size - abs(point - centre);
    float depth = min(inside.x, min(inside.y, inside.z));
    if (depth <= 0.0)
        return 0.0;
    if (depth >= blend)
        return 1.0;
    float x = depth / blend;
    return x * x * (3.0 - 2.0 * x);
}

// Lagarde and Zanuttini 2012, "Local Image-based Lighting with
// Parallax-corrected Cubemap".
vec3 probe_parallax(vec3 point, vec3 direction, vec3 position, vec3 centre,
                    vec3 half_size)
{
    vec3 p = point - centre;
    vec3 d = normalize(direction);
    if (any(greaterThan(abs(p), half_size * (1.0 + 1.0 / 1024.0))))
        return d;
    p = clamp(p, -half_size, half_size);
    // A component of 0 never meets its walls.
    vec3 to = vec3(d.x < 0.0 ? -half_size.x : half_size.x,
                   d.y < 0.0 ? -half_size.y : half_size.y,
                   d.z < 0.0 ? -half_size.z : half_size.z) - p;
    float t = 3e38;
    for (int k = 0; k < 3; k++)
        if (d[k] != 0.0)
            t = min(t, to[k] / d[k]);
    vec3 hit = p + t * d + (centre - position);
    return dot(hit, hit) > 0.0 ? normalize(hit) : d;
}
