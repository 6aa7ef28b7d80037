// SPDX-License-Identifier: MIT
// Normals that vary around a place in a pixel widen the lobe, as in Tokuyoshi
// and Kaplanyan 2019, "Improved Geometric Specular Antialiasing", eq. 5, with
// its maximum of 0.18. The filter is the box that the place stands for, so the
// variance is w^2 / 12; interpolated texels of level 0, of the angle 2 / edge,
// are a filter themselves, of w^2 / 6, and the half vector turns by half.
float widened(float roughness, vec3 normal, int edge)
{
    vec3 dx = turn.z * dFdx(normal), dy = turn.z * dFdy(normal);
    float texel = 1.0 / float(edge);
    float more = (dot(dx, dx) + dot(dy, dy)) / 12.0 - texel * texel / 3.0;
    return more > 0.0 ? pow(min(pow(roughness, 4.0) + min(more, 0.18), 1.0),
                            0.25)
                      : roughness;
}
