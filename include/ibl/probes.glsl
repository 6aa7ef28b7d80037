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
//     uniform usampler2D tiles;    // of ibl_tile_cull
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
// a texel for each tile.
uvec2 ibl_tile_mask(usampler2D masks, vec2 pixel, int tile)
{
    return texelFetch(masks, ivec2(pixel) / tile, 0).xy;
}

// Whether a volume may be seen in the part of the picture from low to high,
// -1..1: no plane through a side of that part, nor the one through the eye, has
// all of it behind. Rounding misses none.
bool ibl_tile_touches(mat4 clip, ibl_volume volume, vec2 low, vec2 high)
{
    mat4 row = transpose(clip);
    vec4 plane[5] = vec4[5](row[0] - low.x * row[3], high.x * row[3] - row[0],
                            row[1] - low.y * row[3], high.y * row[3] - row[1],
                            row[3]);
    vec3 extent = volume.is_sphere ? volume.extent.xxx : volume.extent;
    vec4 size = abs(row[0]) + abs(row[1]) + abs(row[3]);
    float margin =
        1e-6 * (dot(size.xyz, abs(volume.centre) + extent) + size.w);

    for (int i = 0; i < 5; i++) {
        vec3 n = plane[i].xyz;
        float reach = volume.is_sphere ? extent.x * length(n)
                                       : dot(abs(n), extent);

        if (dot(n, volume.centre) + plane[i].w + reach < -margin)
            return false;
    }
    return true;
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
