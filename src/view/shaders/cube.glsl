// SPDX-License-Identifier: MIT
// Faces of a cube as in GL, KTX and DDS: OpenGL 4.6 core, table 8.19. A place
// is u, v in -1..1, with row 0 at the top, and the face.

// Not normalised: the face is at a distance of 1.
vec3 face_direction(int face, vec2 p)
{
    return face == 0 ? vec3(1.0, -p.y, -p.x)
         : face == 1 ? vec3(-1.0, -p.y, p.x)
         : face == 2 ? vec3(p.x, 1.0, p.y)
         : face == 3 ? vec3(p.x, -1.0, -p.y)
         : face == 4 ? vec3(p.x, -p.y, 1.0)
                     : vec3(-p.x, -p.y, -1.0);
}

// Place where a direction of any length meets the cube.
vec3 face_place(vec3 d)
{
    vec3 a = abs(d);
    vec4 s; // u, v, their divisor, the face
    if (a.x >= a.y && a.x >= a.z)
        s = d.x < 0.0 ? vec4(d.z, -d.y, a.x, 1.0) : vec4(-d.z, -d.y, a.x, 0.0);
    else if (a.y >= a.z)
        s = d.y < 0.0 ? vec4(d.x, -d.z, a.y, 3.0) : vec4(d.x, d.z, a.y, 2.0);
    else
        s = d.z < 0.0 ? vec4(-d.x, -d.y, a.z, 5.0) : vec4(d.x, -d.y, a.z, 4.0);
    return vec3(s.xy / s.z, s.w);
}
