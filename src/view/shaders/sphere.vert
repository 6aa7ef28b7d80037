// SPDX-License-Identifier: MIT
// A quad that covers a sphere of the grid as seen from the eye, as view_grid of
// view/sphere_grid.h has them; four vertices per instance.
#include "frame.glsl"

flat out vec4 ball; // centre, radius
flat out vec4 ball_f0; // F0, metallic
flat out vec4 ball_albedo; // diffuse colour, roughness

// The i-th of count places in a row, 1 apart around 0, the farthest first.
int from_back(int i, int count, float from)
{
    int low = 0, high = count - 1;
    for (; i > 0; i--)
        if (2.0 * from > float(low + high - count + 1))
            low++;
        else
            high--;
    return 2.0 * from > float(low + high - count + 1) ? low : high;
}

void main()
{
    // From back to front: rows by their distance, and places in them. No sphere
    // is before one in a nearer row.
    ivec2 place = ivec2(from_back(gl_InstanceID % grid.x, grid.x, eye.x),
                        from_back(gl_InstanceID / grid.x, grid.y, eye.y));
    vec2 last = vec2(grid.xy) - 1.0, t = vec2(place) / max(last, 1.0);
    float metallic = mix(ranges.x, ranges.y, t.y), r = 0.45;
    ball = vec4(vec2(place) - 0.5 * last, 0.0, r);
    ball_f0 = vec4(mix(plastic.rgb, metal.rgb, metallic), metallic);
    ball_albedo = vec4(float(grid.z) * (1.0 - metallic) * metal.rgb,
                       mix(ranges.z, ranges.w, t.x));

    // The cone from the eye that touches the sphere, cut by the plane through
    // the centre that faces the eye, plus two pixels.
    vec3 to = ball.xyz - eye.xyz;
    float d2 = dot(to, to);
    float pixel = 2.0 * length(up.xyz) * viewport.w;
    float half_edge = r * sqrt(d2 / max(d2 - r * r, 1e-6 * d2)) +
                      2.0 * pixel * sqrt(d2);
    vec3 z = to * inversesqrt(d2);
    vec3 x = normalize(cross(z, up.xyz));
    vec3 y = cross(x, z);
    vec2 corner = 2.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0;
    vec3 p = ball.xyz + half_edge * (corner.x * x + corner.y * y);
    gl_Position = clip * vec4(p, 1.0);
}
