// SPDX-License-Identifier: MIT
// Half of all directions on a disc: Heidrich and Seidel 1998, "View-independent
// Environment Maps", section 3. For the shaders of a scene that is captured as
// two paraboloids (view/capture.h). Vertices go where they should and edges
// between them are straight, so what is drawn has to be of small triangles.
//
// Vertex shader, with p = (clip * vec4(world, 1.0)).xyz:
//     gl_Position = paraboloid_position(p, near, far);
//     front = paraboloid_front(p);
// Fragment shader:
//     if (front < PARABOLOID_BACK)
//         discard;

// Cosine of the angle to the axis: a little behind the rim is drawn as well,
// for lookups between pixels.
const float PARABOLOID_BACK = -0.1;

// Where a direction of unit length is: inside the unit circle if it is in
// front.
vec2 paraboloid_place(vec3 d)
{
    return d.xy / max(1.0 + d.z, 1e-3);
}

// p is from the eye, with z along the axis. Depth is by distance.
vec4 paraboloid_position(vec3 p, float near, float far)
{
    float l = length(p);
    return vec4(paraboloid_place(p / max(l, 1e-20)),
                2.0 * (l - near) / (far - near) - 1.0, 1.0);
}

// Cosine of the angle to the axis.
float paraboloid_front(vec3 p)
{
    return p.z / max(length(p), 1e-20);
}
