// SPDX-License-Identifier: MIT
// Maps a half space of directions to a disc: Heidrich and Seidel 1998,
// "View-independent Environment Maps", section 3. Edges between vertices stay
// straight, so triangles must be small.
//
// Vertex shader, with p = clip * vec4(world, 1.0):
//     gl_Position = paraboloid_position(p);
//     front = paraboloid_front(p);
// Fragment shader:
//     if (front < PARABOLOID_BACK)
//         discard;

// Radius of the half space's disc. The picture is larger, so that lookups on
// the rim find both halves.
const float PARABOLOID_FILL = 0.9375;
// Minimum cosine to the axis that is drawn: less than at the picture's edge,
// -0.064, since lookups on the rim touch the corners.
const float PARABOLOID_BACK = -0.3;

// Place of a unit direction, -1..1.
vec2 paraboloid_place(vec3 d)
{
    return PARABOLOID_FILL * d.xy / max(1.0 + d.z, 1e-3);
}

// p: distances in units of far, p.w = near / far. Depth is by distance.
vec4 paraboloid_position(vec4 p)
{
    float l = length(p.xyz);
    return vec4(paraboloid_place(p.xyz / max(l, 1e-20)),
                2.0 * (l - p.w) / (1.0 - p.w) - 1.0, 1.0);
}

// Cosine of the angle to the axis.
float paraboloid_front(vec4 p)
{
    return p.z / max(length(p.xyz), 1e-20);
}
