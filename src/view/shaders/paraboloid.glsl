// SPDX-License-Identifier: MIT
// Half of all directions on a disc: Heidrich and Seidel 1998, "View-independent
// Environment Maps", section 3. Edges between vertices are straight, so
// triangles have to be small.
//
// Vertex shader, with p = clip * vec4(world, 1.0):
//     gl_Position = paraboloid_position(p);
//     front = paraboloid_front(p);
// Fragment shader:
//     if (front < PARABOLOID_BACK)
//         discard;

// Radius of the disc of the half space. The picture is larger, so that lookups
// on the rim find both halves.
const float PARABOLOID_FILL = 0.9375;
// Least cosine to the axis that is drawn: beyond the edge of the picture,
// -0.064, for the corners that lookups on the rim touch.
const float PARABOLOID_BACK = -0.3;

// Where a direction of unit length is, -1..1.
vec2 paraboloid_place(vec3 d)
{
    return PARABOLOID_FILL * d.xy / max(1.0 + d.z, 1e-3);
}

// p: distances are shares of far, p.w is near / far. Depth is by distance.
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
