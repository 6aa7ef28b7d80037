// SPDX-License-Identifier: MIT
//
// iblbake: reflection probes in a shader. The same as ibl/probes.h, which says
// what everything means, in GLSL 3.30 or later: to be put behind the #version
// line. All names begin with ibl_.
//
// Probes come in a buffer texture of RGBA32F, as ibl_probes_pack writes them,
// in their order: the index of a probe is its place in it. They may come in
// another way, too: only the functions that take a samplerBuffer need it.
//
//     uniform samplerBuffer probes;
//     uniform usampler2D tiles;    // of ibl_tiles_cull, or of ibl_tile_cull
//     ...
//     uvec2 mask = ibl_tile_mask(tiles, gl_FragCoord.xy, 16);
//     ibl_mix m = ibl_probes_blend(probes, mask, point);
//     vec3 light = m.rest * textureLod(sky, r, lod).rgb;
//     for (int i = 0; i < m.count; i++) {
//         ibl_probe p = ibl_probe_fetch(probes, m.probe[i]);
//         vec3 lookup;
//         ibl_probe_parallax(p, point, r, lookup);
//         light += m.weight[i] * textureLod(local, vec4(lookup, p.layer),
//                                           lod).rgb;
//     }
//
// Where captures have alpha, call ibl_mix_add for each probe with its influence
// times the alpha of its lookup, from ibl_mix_none() to ibl_mix_end.
//
// Lengths are from 1e-9 to 1e9 or 0, those of directions from 1e-30 to 1e30;
// then no result is NaN.
// Weights, and directions looked up, are those of C to the rounding of float.

struct ibl_volume {
    bool is_sphere;
    vec3 centre;
    vec3 extent; // of a box, half of each edge; of a sphere x is its radius
};

struct ibl_probe {
    vec3 position;
    ibl_volume influence;
    float blend;
    bool has_proxy;
    ibl_volume proxy;
    int layer;
};

const int ibl_probe_texels = 5;
const int ibl_max_probes_at = 8;

// Of a point, the global environment's share being rest. next is the largest
// share that found no room, until ibl_mix_end.
struct ibl_mix {
    int count;
    int probe[ibl_max_probes_at];
    float weight[ibl_max_probes_at];
    float rest;
    float next;
};

// ---- a probe ----------------------------------------------------------------

ibl_volume ibl_volume_unpack(vec4 first, vec4 second)
{
    return ibl_volume(second.w != 0.0, first.xyz, second.xyz);
}

ibl_probe ibl_probe_fetch(samplerBuffer probes, int i)
{
    int at = ibl_probe_texels * i;
    vec4 influence = texelFetch(probes, at);
    vec4 proxy = texelFetch(probes, at + 2);
    vec4 last = texelFetch(probes, at + 4);

    return ibl_probe(last.xyz,
                     ibl_volume_unpack(influence, texelFetch(probes, at + 1)),
                     influence.w, proxy.w != 0.0,
                     ibl_volume_unpack(proxy, texelFetch(probes, at + 3)),
                     int(last.w));
}

float ibl_volume_influence(ibl_volume volume, float blend, vec3 point)
{
    vec3 off = point - volume.centre;
    vec3 inside = volume.extent - abs(off);
    float depth = volume.is_sphere ? volume.extent.x - length(off)
                                   : min(min(inside.x, inside.y), inside.z);

    if (!(depth > 0.0))
        return 0.0;
    if (!(depth < blend))
        return 1.0;
    float t = depth / blend;

    return t * t * (3.0 - 2.0 * t);
}

float ibl_probe_influence(ibl_probe probe, vec3 point)
{
    return ibl_volume_influence(probe.influence, probe.blend, point);
}

// ---- parallax ---------------------------------------------------------------

// As in parallax.c.
const float ibl_slack = 1.0 + 1.0 / 1024.0;

// v, unit; false, and v as it is, if that is 0.
bool ibl_unit(inout vec3 v)
{
    float most = max(max(abs(v.x), abs(v.y)), abs(v.z));

    if (!(most > 0.0))
        return false;
    v = normalize(v / most);
    return true;
}

bool ibl_leave_box(vec3 extent, inout vec3 q, vec3 d)
{
    float least = 3e38;

    for (int i = 0; i < 3; i++) {
        if (!(abs(q[i]) <= extent[i] * ibl_slack))
            return false;
        q[i] = clamp(q[i], -extent[i], extent[i]);
        if (d[i] == 0.0)
            continue;
        float t = ((d[i] < 0.0 ? -extent[i] : extent[i]) - q[i]) / d[i];
        least = min(least, t);
    }
    q = clamp(q + least * d, -extent, extent);
    return true;
}

bool ibl_leave_sphere(float radius, inout vec3 q, vec3 d)
{
    float away = length(q);

    if (!(away <= radius * ibl_slack))
        return false;
    if (away > radius) {
        q *= radius / away;
        away = radius;
    }
    float along = dot(q, d);
    float inside = (radius - away) * (radius + away);

    q += (sqrt(along * along + inside) - along) * d;
    return true;
}

bool ibl_probe_parallax(ibl_probe probe, vec3 point, vec3 direction,
                        out vec3 lookup)
{
    vec3 q = point - probe.proxy.centre, d = direction;
    bool unit = ibl_unit(d);

    lookup = d;
    if (!unit || !probe.has_proxy)
        return false;
    if (probe.proxy.is_sphere ? !ibl_leave_sphere(probe.proxy.extent.x, q, d)
                              : !ibl_leave_box(probe.proxy.extent, q, d))
        return false;
    vec3 to = probe.proxy.centre - probe.position + q;
    if (!ibl_unit(to))
        return false;
    lookup = to;
    return true;
}

// ---- mixing by volumes ------------------------------------------------------

ibl_mix ibl_mix_none()
{
    return ibl_mix(0, int[ibl_max_probes_at](0, 0, 0, 0, 0, 0, 0, 0),
                   float[ibl_max_probes_at](0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
                                            0.0), 1.0, 0.0);
}

void ibl_mix_drop(inout ibl_mix m, int at)
{
    m.count--;
    for (int i = at; i < m.count; i++) {
        m.probe[i] = m.probe[i + 1];
        m.weight[i] = m.weight[i + 1];
    }
}

// The next probe in order. Until ibl_mix_end, rest is what is left for others:
// where it is 0 no more need be added.
void ibl_mix_add(inout ibl_mix m, int probe, float influence)
{
    float share = min(influence, m.rest);

    if (!(share > 0.0))
        return;
    m.rest -= share;
    if (m.count == ibl_max_probes_at) {
        int least = 0;

        for (int i = 1; i < ibl_max_probes_at; i++) {
            if (m.weight[i] <= m.weight[least])
                least = i;
        }
        m.next = max(m.next, min(share, m.weight[least]));
        if (share <= m.weight[least])
            return;
        ibl_mix_drop(m, least);
    }
    m.probe[m.count] = probe;
    m.weight[m.count] = share;
    m.count++;
}

void ibl_mix_end(inout ibl_mix m)
{
    float sum = 0.0;

    for (int i = 0; i < m.count; i++)
        sum += m.weight[i] - m.next;
    if (!(sum > 0.0)) { // all are equal
        sum += float(m.count) * m.next;
        m.next = 0.0;
    }
    for (int i = ibl_max_probes_at - 1; i >= 0; i--) {
        if (i >= m.count)
            continue;
        m.weight[i] = (m.weight[i] - m.next) / sum * (1.0 - m.rest);
        if (!(m.weight[i] > 0.0))
            ibl_mix_drop(m, i);
    }
}

void ibl_mix_add_fetched(inout ibl_mix m, samplerBuffer probes, int i,
                         vec3 point)
{
    vec4 first = texelFetch(probes, ibl_probe_texels * i);
    vec4 second = texelFetch(probes, ibl_probe_texels * i + 1);

    ibl_mix_add(m, i, ibl_volume_influence(ibl_volume_unpack(first, second),
                                           first.w, point));
}

// Of the first count, or of those in a tile's mask.
ibl_mix ibl_probes_blend(samplerBuffer probes, int count, vec3 point)
{
    ibl_mix m = ibl_mix_none();

    for (int i = 0; i < count && m.rest > 0.0; i++)
        ibl_mix_add_fetched(m, probes, i, point);
    ibl_mix_end(m);
    return m;
}

ibl_mix ibl_probes_blend(samplerBuffer probes, uvec2 mask, vec3 point)
{
    ibl_mix m = ibl_mix_none();

    for (int word = 0; word < 2; word++) {
        int i = 32 * word;

        for (uint bits = mask[word]; bits != 0u && m.rest > 0.0; bits >>= 1) {
            if ((bits & 1u) != 0u)
                ibl_mix_add_fetched(m, probes, i, point);
            i++;
        }
    }
    ibl_mix_end(m);
    return m;
}

// ---- tiles ------------------------------------------------------------------

// The mask of a pixel: x are the probes 0..31, y 32..63. The texture is RG32UI,
// a texel for each tile; the masks of ibl_tiles_cull can be given to it as they
// are where the low half of a number comes first.
uvec2 ibl_tile_mask(usampler2D masks, vec2 pixel, int tile)
{
    return texelFetch(masks, ivec2(pixel) / tile, 0).xy;
}

// As in tiles.c, where it is explained; margins are those of float.
const float ibl_tiny = 4e-6;

struct ibl_body {
    bool is_sphere;
    vec3 centre;
    float size;
    mat3 edge;
    mat3 d;
    vec3 apex;
};

struct ibl_cone {
    vec3 ray[4];
    vec3 face[4];
};

float ibl_size(vec3 v)
{
    return abs(v.x) + abs(v.y) + abs(v.z);
}

ibl_body ibl_body_make(mat4 clip, ibl_volume v)
{
    mat3 a = mat3(clip[0].xyw, clip[1].xyw, clip[2].xyw);
    vec3 extent = v.is_sphere ? v.extent.xxx : v.extent;
    ibl_body body;

    body.is_sphere = v.is_sphere;
    body.centre = a * v.centre + clip[3].xyw;
    body.size = ibl_size(clip[3].xyw);
    for (int j = 0; j < 3; j++) {
        body.edge[j] = a[j] * extent[j];
        body.size += ibl_size(a[j]) * (abs(v.centre[j]) + extent[j]);
    }
    mat3 squares = body.edge * transpose(body.edge);
    body.d = outerProduct(body.centre, body.centre) -
             (1.0 + ibl_tiny) * squares -
             mat3(ibl_tiny * body.size * body.size);
    mat3 adjoint = mat3(cross(squares[1], squares[2]),
                        cross(squares[2], squares[0]),
                        cross(squares[0], squares[1]));
    body.apex = -(adjoint * body.centre);
    return body;
}

ibl_cone ibl_cone_make(vec2 low, vec2 high)
{
    return ibl_cone(
        vec3[4](vec3(low, 1.0), vec3(high.x, low.y, 1.0), vec3(high, 1.0),
                vec3(low.x, high.y, 1.0)),
        vec3[4](vec3(0.0, 1.0, -low.y), vec3(-1.0, 0.0, high.x),
                vec3(0.0, -1.0, high.y), vec3(1.0, 0.0, -low.x)));
}

bool ibl_behind(ibl_body body, vec3 n)
{
    float middle = dot(n, body.centre);

    if (body.is_sphere)
        return middle < 0.0 && dot(n, body.d * n) > 0.0;
    return middle + ibl_size(n * body.edge) <
           -ibl_tiny * ibl_size(n) * body.size;
}

bool ibl_between(ibl_body body, ibl_cone cone, vec3 n)
{
    float margin = 0.1 * ibl_tiny * ibl_size(n);
    bool above = true, below = true;

    for (int i = 0; i < 4; i++) {
        float side = dot(n, cone.ray[i]);

        above = above && side >= -margin;
        below = below && side <= margin;
    }
    return (above && ibl_behind(body, n)) || (below && ibl_behind(body, -n));
}

bool ibl_box_apart(ibl_body body, ibl_cone cone)
{
    for (int i = 0; i < 3; i++) {
        if (ibl_between(body, cone,
                        cross(body.edge[i], body.edge[(i + 1) % 3])))
            return true;
        for (int k = 0; k < 4; k++) {
            if (ibl_between(body, cone, cross(body.edge[i], cone.ray[k])))
                return true;
        }
    }
    return false;
}

bool ibl_sphere_apart(ibl_body body, ibl_cone cone)
{
    for (int i = 0; i < 4; i++) {
        vec3 a = cone.face[i], b = cone.face[(i + 1) % 4], db = body.d * b;
        float aa = dot(a, body.d * a), bb = dot(b, db), ab = dot(a, db);

        if (aa <= 0.0 && bb < 0.0 && ab > 0.0 && ab * ab > aa * bb &&
            ab * dot(b, body.centre) - bb * dot(a, body.centre) < 0.0)
            return true;
    }
    return ibl_between(body, cone, body.apex);
}

// Whether a volume is seen in the part of the picture from low to high, -1..1.
// In float a little more of it is than ibl_tiles_cull says, never less.
bool ibl_tile_touches(mat4 clip, ibl_volume volume, vec2 low, vec2 high)
{
    ibl_body body = ibl_body_make(clip, volume);
    ibl_cone cone = ibl_cone_make(low, high);

    for (int i = 0; i < 4; i++) {
        if (ibl_behind(body, cone.face[i]))
            return false;
    }
    return body.is_sphere ? !ibl_sphere_apart(body, cone)
                          : !ibl_box_apart(body, cone);
}

// The mask of the tile `at` of a picture of size pixels, for a shader that
// writes one texel of RG32UI for each tile. Bit 0 is the probe `first`; count
// is at most 64.
uvec2 ibl_tile_cull(samplerBuffer probes, int first, int count, mat4 clip,
                    ivec2 size, int tile, ivec2 at)
{
    vec2 low = vec2(2 * at * tile) / vec2(size) - 1.0;
    vec2 high = vec2(2 * min((at + 1) * tile, size)) / vec2(size) - 1.0;
    uvec2 mask = uvec2(0u);

    for (int i = 0; i < count; i++) {
        int from = ibl_probe_texels * (first + i);
        vec4 one = texelFetch(probes, from);
        vec4 two = texelFetch(probes, from + 1);

        if (ibl_tile_touches(clip, ibl_volume_unpack(one, two), low, high))
            mask[i / 32] |= 1u << uint(i % 32);
    }
    return mask;
}

// From the first probe on.
uvec2 ibl_tile_cull(samplerBuffer probes, int count, mat4 clip, ivec2 size,
                    int tile, ivec2 at)
{
    return ibl_tile_cull(probes, 0, count, clip, size, tile, at);
}
