// SPDX-License-Identifier: MIT
// Places of a cube's texels on a flat picture: the geometry of inspect.c, which
// finds the texel under the cursor; a test compares the two.
#include "cube.glsl"

// view_layout of view/settings.h
const int CROSS = 0, STRIP = 1, EQUIRECT = 2;

// Keeps pixel centres off texel edges, where rounding would decide.
const float ASIDE = 1.0 / 32.0;

// Size of the picture of a cube with faces of n x n texels, in texels.
vec2 flat_size(int kind, float n) {
    return kind == CROSS ? vec2(4.0, 3.0) * n
         : kind == STRIP ? vec2(6.0, 1.0) * n
         : vec2(4.0, 2.0) * n;
}

// Pixels of the window per texel of a picture of that size.
float flat_scale(vec2 size) {
    return min(viewport.x / size.x, viewport.y / size.y) * inspect_at.x;
}

// Point of the picture, from its upper left corner, at this pixel.
vec2 flat_point(vec2 size) {
    vec2 pixel = vec2(gl_FragCoord.x, viewport.y - gl_FragCoord.y) + ASIDE;
    return size * (0.5 + inspect_at.yz) +
           (pixel - 0.5 * viewport.xy) / flat_scale(size);
}

bool within(vec2 p, vec2 size) {
    return all(greaterThanEqual(p, vec2(0.0))) && all(lessThan(p, size));
}

// A place on a face, in texels.
struct texel {
    int face; // -1: none
    vec2 at;
};

// Direction of the texel's centre or, with filtering, of the place; not
// normalised.
vec3 texel_direction(texel t, int n) {
    vec2 at = looks.y != 0 ? t.at : floor(t.at) + 0.5;
    return face_direction(t.face, 2.0 * at / float(n) - 1.0);
}

texel direction_texel(vec3 d, int n) {
    vec3 place = face_place(d);
    vec2 at = (place.xy + 1.0) * 0.5 * float(n);
    return texel(int(place.z), clamp(at, 0.0, float(n) - 1.0 / 64.0));
}

// The cross has +Y on top, -X +Z +X -Z in the middle, -Y below.
int cross_face(ivec2 cell) {
    const int middle[4] = int[4](1, 4, 0, 5);
    if (cell.y == 1)
        return middle[cell.x];
    return cell.x != 1 ? -1 : cell.y == 0 ? 2 : 3;
}

// Row 0 of an equirectangular map is the zenith, its middle column +X.
vec3 equirect_direction(vec2 share) {
    const float PI = 3.14159265358979;
    float phi = 2.0 * PI * (share.x - 0.5);
    float theta = PI * share.y;
    return vec3(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi));
}

// Texel at this pixel, of a cube with faces of n x n texels.
texel flat_texel(int kind, int n) {
    vec2 size = flat_size(kind, float(n));
    vec2 p = flat_point(size);
    if (!within(p, size))
        return texel(-1, vec2(0.0));
    if (kind == EQUIRECT)
        return direction_texel(equirect_direction(p / size), n);
    ivec2 cell = ivec2(p) / n;
    return texel(kind == STRIP ? cell.x : cross_face(cell),
                 p - vec2(cell * n));
}
