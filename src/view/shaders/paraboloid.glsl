// SPDX-License-Identifier: MIT
// Half of all directions on a disc: Heidrich and Seidel 1998, "View-independent
// Environment Maps", section 3. For the shaders of a scene that is captured as
// two paraboloids (view/capture.h). Vertices go where they should and edges
// between them are straight, so what is drawn has to be of small triangles.
//
// Vertex shader, with p = clip * vec4(world, 1.0):
//     gl_Position = paraboloid_position(p);
//     front = paraboloid_front(p);
// Fragment shader:
//     if (front < PARABOLOID_BACK)
//         discard;

// The disc of the half space in front is smaller than the picture: what is a
// little way behind is drawn as well, so that lookups on the rim find both.
const float PARABOLOID_FILL = 0.9375;
// Cosine of the angle to the axis, up to which is drawn: some way beyond the
// edge of the picture, which is at r = 1 / FILL or -0.064, for the pixels in
// its corners that lookups on the rim are near.
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
