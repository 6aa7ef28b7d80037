// SPDX-License-Identifier: MIT
// Shows a map as linear RGB, laid out flat. Alpha is 1, outside the map 0.
#include "cube.glsl"
#include "frame.glsl"
#include "ibl.glsl"
#include "tone.glsl"

uniform samplerCube specular_map;
uniform samplerCube irradiance_map;
uniform sampler2D lut_map;
uniform sampler2D backdrop_map;
// z 1: draws what is at that pixel, as view_renderer_texel has it.
uniform vec4 pointer;

out vec4 colour;

// view_mode, view_diffuse, view_layout and view_channel of view/settings.h
const int IRRADIANCE_MAP = 2, TABLE = 3, SOURCE_MAP = 6;
const int SH = 1, LAST = 2;
const int CROSS = 0, STRIP = 1, EQUIRECT = 2;
const int ALPHA = 4, LUMINANCE = 5;
const int HARMONICS_EDGE = 32; // texels that harmonics are shown by

// What of a map is at this pixel.
struct texel {
    vec4 value;     // alpha below 0: nothing
    vec4 place;     // face, or -1; level; column; row
    vec3 direction; // of its centre; of the table N.V and roughness
};
const texel OUTSIDE = texel(vec4(-1.0), vec4(-1.0), vec3(0.0));

bool filtered() {
    return looks.y != 0 && pointer.z == 0.0;
}

// Point of the picture, from its upper left corner, at this pixel. Centres of
// pixels are kept off the edges of texels, where rounding would decide.
vec2 flat_point(vec2 size) {
    vec2 at = pointer.z == 0.0 ? gl_FragCoord.xy : pointer.xy;
    at = vec2(at.x, viewport.y - at.y) + 1.0 / 32.0;
    vec2 fit = viewport.xy / size; // pixels per texel
    return size * (0.5 + inspect_at.yz) +
           (at - 0.5 * viewport.xy) / (min(fit.x, fit.y) * inspect_at.x);
}

bool within(vec2 p, vec2 size) {
    return all(greaterThanEqual(p, vec2(0.0))) && all(lessThan(p, size));
}

// The cross has +Y on top, -X +Z +X -Z in the middle, -Y below.
int cross_face(ivec2 cell) {
    const int middle[4] = int[4](1, 4, 0, 5);
    if (cell.y == 1)
        return middle[cell.x];
    return cell.x != 1 ? -1 : cell.y == 0 ? 2 : 3;
}

// Place on the faces of a cube, in texels of n x n, and the face, or -1.
vec3 cube_place(int n) {
    vec2 size = choice.z == CROSS ? vec2(4 * n, 3 * n)
              : choice.z == STRIP ? vec2(6 * n, n)
                                  : vec2(4 * n, 2 * n);
    vec2 p = flat_point(size);
    ivec2 cell = ivec2(p) / n;
    if (!within(p, size))
        return vec3(-1.0);
    if (choice.z != EQUIRECT)
        return vec3(p - vec2(cell * n),
                    choice.z == STRIP ? cell.x : cross_face(cell));
    vec3 place = face_place(direction_in_map(p / size + vec2(diffuse.z, 0.0)));
    vec2 at = (place.xy + 1.0) * 0.5 * float(n);
    return vec3(clamp(at, 0.0, float(n) - 1.0 / 64.0), place.z);
}

// Without filtering, samplers take the nearest texel, so a bright neighbour,
// such as the sun, adds nothing.
texel cube() {
    bool irradiance = choice.x == IRRADIANCE_MAP;
    bool last = irradiance && choice.y == LAST;
    bool harmonics = irradiance && choice.y == SH;
    int level = last       ? int(lod.z)
              : irradiance ? 0 : clamp(choice.w, 0, int(lod.z));
    int n = harmonics           ? HARMONICS_EDGE
          : irradiance && !last ? textureSize(irradiance_map, 0).x
                                : textureSize(specular_map, level).x;
    vec3 at = cube_place(n);
    int face = int(at.z);
    if (face < 0)
        return OUTSIDE;
    vec2 middle = floor(at.xy);
    vec3 centre = face_direction(face, 2.0 * (middle + 0.5) / float(n) - 1.0);
    vec3 d = filtered() ? face_direction(face, 2.0 * at.xy / float(n) - 1.0)
                        : centre;
    vec4 value =
        harmonics ? vec4(ibl_irradiance_sh4(sh, normalize(d)), 1.0)
        : irradiance && !last ? textureLod(irradiance_map, d, 0.0)
                              : textureLod(specular_map, d, float(level));
    return texel(value, vec4(face, level, middle), normalize(centre));
}

// The environment at its own resolution, if it is at hand.
texel source_map() {
    vec2 size = vec2(textureSize(backdrop_map, 0));
    vec2 p = flat_point(size);
    if (diffuse.w == 0.0 || !within(p, size))
        return OUTSIDE;
    return texel(filtered() ? texture(backdrop_map, p / size)
                            : texelFetch(backdrop_map, ivec2(p), 0),
                 vec4(-1.0, 0.0, floor(p)),
                 direction_in_map((floor(p) + 0.5) / size));
}

// One channel as grey.
vec4 channel(vec4 c) {
    float grey = looks.x == LUMINANCE ? luminance(c.rgb)
                 : looks.x == ALPHA   ? c.a
                                      : c[max(looks.x - 1, 0)];
    return vec4(looks.x == 0 ? c.rgb : vec3(grey), 1.0);
}

// N.V to the right, roughness upwards; scale and bias are red and green.
texel flat_table() {
    vec2 size = vec2(textureSize(lut_map, 0));
    vec2 p = flat_point(size);
    if (!within(p, size))
        return OUTSIDE;
    p.y = size.y - p.y;
    vec2 at = min(floor(p), size - 1.0);
    return texel(vec4(texelFetch(lut_map, ivec2(at), 0).rg, 0.0, 1.0),
                 vec4(-1.0, 0.0, at), vec3((at + 0.5) / size, 0.0));
}

void main() {
    texel t = choice.x == TABLE        ? flat_table()
              : choice.x == SOURCE_MAP ? source_map()
                                       : cube();
    int told = int(gl_FragCoord.x);
    if (pointer.z != 0.0)
        colour = told == 0   ? t.place
                 : told == 1 ? vec4(t.direction, 0.0)
                             : t.value;
    else
        colour = t.value.a < 0.0 ? vec4(0.0) : channel(t.value);
}
