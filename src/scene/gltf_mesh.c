/* SPDX-License-Identifier: MIT */
/* Meshes of glTF, section 3.7.2, as lists of triangles. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "core/alloc.h"
#include "scene/gltf_reader.h"

typedef enum mode {
    TRIANGLES = 4,
    STRIP,
    FAN
} mode;

/* The attributes of a vertex, with what a file must have at least. The number
 * of a set of texture coordinates is the material's. */
static const struct {
    const char *name;
    size_t at;
    int least, most;
} attributes[] = {
    {"POSITION", offsetof(ibl_scene_primitive, position), 3, 3},
    {"NORMAL", offsetof(ibl_scene_primitive, normal), 3, 3},
    {"TANGENT", offsetof(ibl_scene_primitive, tangent), 4, 4},
    {"COLOR_0", offsetof(ibl_scene_primitive, colour), 3, 4},
    {"JOINTS_0", offsetof(ibl_scene_primitive, joints[0]), 4, 4},
    {"JOINTS_1", offsetof(ibl_scene_primitive, joints[1]), 4, 4},
    {"WEIGHTS_0", offsetof(ibl_scene_primitive, weights[0]), 4, 4},
    {"WEIGHTS_1", offsetof(ibl_scene_primitive, weights[1]), 4, 4},
    {"TEXCOORD_%d", offsetof(ibl_scene_primitive, texcoord[0]), 2, 2},
    {"TEXCOORD_%d", offsetof(ibl_scene_primitive, texcoord[1]), 2, 2},
    {"TEXCOORD_%d", offsetof(ibl_scene_primitive, texcoord[2]), 2, 2},
    {"TEXCOORD_%d", offsetof(ibl_scene_primitive, texcoord[3]), 2, 2},
};

enum {
    ATTRIBUTES = sizeof attributes / sizeof *attributes,
    JOINTS = 4,    /* the first that skins need */
    TEXCOORDS = 8, /* the first set */
};

static float **field(ibl_scene_primitive *p, int i)
{
    return (float **)(void *)((char *)p + attributes[i].at);
}

/* Reads an attribute from its accessor, or from what was packed. */
static bool read_attribute(ibl_gltf *g, ibl_json_at index, ibl_json_at id,
                           const ibl_draco *packed, int i,
                           ibl_scene_primitive *p)
{
    float **to = field(p, i);
    const int most = attributes[i].most;
    uint32_t count = p->vertex_count;

    if (!id.value) {
        if (!ibl_gltf_floats(g, index, attributes[i].least, most, to, &count))
            return false;
    } else if (ibl_gltf_count(g, id, (uint64_t)count * (unsigned)most)) {
        int number = -1;
        *to = ibl_need(
            ibl_alloc_array((size_t)count * (size_t)most + 1, sizeof **to));
        if (!ibl_json_int(id, 0, INT32_MAX, &number))
            return false;
        if (!ibl_gltf_decoders()->draco_floats(
                packed, number, ibl_gltf_normalized(g, index), most, *to))
            return ibl_json_complain(id, "damaged: Draco has no such numbers");
    } else {
        return false;
    }
    if (i > 0)
        ibl_gltf_mend(g, *to, (size_t)count * (size_t)most);
    if ((i > 0 || packed) && count != p->vertex_count)
        return ibl_json_complain(index, "damaged: %u elements for %u vertices",
                                 count, p->vertex_count);
    p->vertex_count = count;
    return true;
}

/* An attribute that is wrong is left out, but for positions. */
static bool read_attributes(ibl_gltf *g, ibl_json_at at, ibl_json_at ids,
                            bool skinned, const ibl_draco *packed,
                            ibl_scene_primitive *p)
{
    const ibl_scene_material *m = &g->scene->materials[p->material];

    for (int i = 0; i < ATTRIBUTES; i++) {
        const int set = i < TEXCOORDS ? 0 : m->sets[i - TEXCOORDS];
        char name[32];
        snprintf(name, sizeof name, attributes[i].name, set);
        const ibl_json_at index = ibl_json_member(&at, name);
        if (!index.value || set < 0 ||
            (i >= JOINTS && i < TEXCOORDS && !skinned))
            continue;
        if (read_attribute(g, index, ibl_json_member(&ids, name), packed, i, p))
            continue;
        ibl_free(*field(p, i));
        *field(p, i) = NULL;
        if (!i || g->status)
            return false;
    }
    return true;
}

/* The indices as the file has them, or all vertices in order. */
static bool read_indices(ibl_gltf *g, ibl_json_at at, const ibl_draco *packed,
                         ibl_scene_primitive *p)
{
    const ibl_json_at index = ibl_json_member(&at, "indices");

    if (!packed && index.value) {
        if (!ibl_gltf_indices(g, index, &p->index, &p->index_count))
            return false;
    } else {
        if (!packed)
            p->index_count = p->vertex_count;
        p->index = ibl_need(
            ibl_alloc_array((size_t)p->index_count + 1, sizeof *p->index));
        for (uint32_t i = 0; i < p->index_count && !packed; i++)
            p->index[i] = i;
        if (packed)
            ibl_gltf_decoders()->draco_indices(packed, p->index);
    }
    for (uint32_t i = 0; i < p->index_count; i++)
        if (p->index[i] >= p->vertex_count)
            return ibl_json_complain(index,
                                     "damaged: vertex %u of %u: indices begin "
                                     "with 0",
                                     p->index[i], p->vertex_count);
    return true;
}

/* Reads what a primitive has, packed or not. Where the first cannot be had, the
 * accessors may have bytes of their own. */
static bool read_arrays(ibl_gltf *g, ibl_json_at at, bool skinned,
                        ibl_scene_primitive *p)
{
    const ibl_json_at list = ibl_json_member(&at, "attributes");
    ibl_json_at extension, ids;
    ibl_draco *packed = NULL;

    if (!ibl_gltf_extension(at, "KHR_draco_mesh_compression", &extension) ||
        !ibl_gltf_object(extension, "attributes", &ids))
        return false;
    if (extension.value &&
        !ibl_gltf_draco(g, extension, &packed, &p->vertex_count,
                        &p->index_count) &&
        g->status)
        return false;
    if (!packed)
        ids.value = NULL;
    if (extension.value && !packed) {
        ibl_json_at all;
        int i = -1, count = ibl_gltf_array(g, "accessors", &all);
        if (!ibl_gltf_index(ibl_json_member(&list, "POSITION"), count, &i) ||
            !json_object_get(json_array_get(all.value, (size_t)i),
                             "bufferView"))
            return false;
    }
    const bool ok = read_attributes(g, list, ids, skinned, packed, p) &&
                    read_indices(g, at, packed, p);
    if (packed)
        ibl_gltf_decoders()->draco_free(packed);
    return ok;
}

/* Makes triangles of strips and fans: figure of section 3.7.2.1. */
static void unroll(mode m, ibl_scene_primitive *p)
{
    const uint32_t count = p->index_count < 3 ? 0 : p->index_count - 2;

    if (m == TRIANGLES) {
        p->index_count -= p->index_count % 3;
        return;
    }
    uint32_t *all =
        ibl_need(ibl_alloc_array(3 * (size_t)count + 1, sizeof *all));
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t first = m == FAN ? i + 1 : i, odd = m == STRIP && i % 2;
        all[3 * i] = p->index[first];
        all[3 * i + 1] = p->index[first + 1 + odd];
        all[3 * i + 2] = p->index[m == FAN ? 0 : first + 2 - odd];
    }
    ibl_free(p->index);
    p->index = all;
    p->index_count = 3 * count;
}

/* ---- flat normals ----------------------------------------------------- */

/* Gives each corner of each triangle a vertex of its own. */
static void separate(ibl_scene_primitive *p)
{
    for (int a = 0; a < ATTRIBUTES; a++) {
        float **values = field(p, a);
        const size_t most = (size_t)attributes[a].most;
        if (!*values)
            continue;
        float *all =
            ibl_need(ibl_alloc_array(p->index_count * most, sizeof *all));
        for (uint32_t i = 0; i < p->index_count; i++)
            memcpy(all + i * most, *values + p->index[i] * most,
                   most * sizeof *all);
        ibl_free(*values);
        *values = all;
    }
    for (uint32_t i = 0; i < p->index_count; i++)
        p->index[i] = i;
    p->vertex_count = p->index_count;
}

static void set_normal(const float *corner, float *normal)
{
    double u[3], v[3], n[3], length = 0;

    for (int k = 0; k < 3; k++) {
        u[k] = (double)corner[3 + k] - corner[k];
        v[k] = (double)corner[6 + k] - corner[k];
    }
    for (int k = 0; k < 3; k++) {
        n[k] =
            u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        length += n[k] * n[k];
    }
    length = sqrt(length);
    for (int k = 0; k < 9; k++)
        normal[k] = length > 0 ? (float)(n[k % 3] / length) : k % 3 == 1;
}

static void flatten(ibl_scene_primitive *p)
{
    ibl_free(p->tangent); /* without normals it does not count */
    p->tangent = NULL;
    separate(p);
    p->normal =
        ibl_need(ibl_alloc_array(3 * (size_t)p->vertex_count, sizeof(float)));
    for (size_t i = 0; i < p->vertex_count; i += 3)
        set_normal(p->position + 3 * i, p->normal + 3 * i);
}

/* ---- the calls -------------------------------------------------------- */

bool ibl_gltf_drop_nowhere(ibl_gltf *g, ibl_scene_primitive *p)
{
    float *all = p->position;
    uint32_t kept = 0;

    for (uint32_t i = 0; i < p->index_count; i += 3) {
        double sum = 0;
        for (int k = 0; k < 9; k++)
            sum += (double)all[3 * (size_t)p->index[i + k / 3] + k % 3];
        memmove(p->index + kept, p->index + i, 3 * sizeof *p->index);
        kept += isfinite(sum) ? 3 : 0;
    }
    p->index_count = kept;
    /* No triangle has them: they stand where another does. */
    for (float *v = all; v < all + 3 * (size_t)p->vertex_count && kept; v += 3)
        if (!isfinite((double)v[0] + (double)v[1] + (double)v[2])) {
            memcpy(v, all + 3 * (size_t)p->index[0], 3 * sizeof *v);
            g->mended++;
        }
    return kept;
}

static void read_primitive(ibl_gltf *g, ibl_json_at at, bool skinned)
{
    ibl_scene *s = g->scene;
    const ibl_json_at list = ibl_json_member(&at, "attributes");
    int m = TRIANGLES, material;

    if (!ibl_json_int(ibl_json_optional(&at, "mode"), 0, FAN, &m))
        return;
    if (!json_is_object(list.value)) {
        ibl_json_wrong(list, "an object");
        return;
    }
    if (m < TRIANGLES || !json_object_get(list.value, "POSITION")) {
        g->left_out++;
        return;
    }
    if (!ibl_gltf_index(ibl_json_optional(&at, "material"),
                        s->material_count - 1, &material))
        material = -1;
    ibl_scene_primitive *p = &s->primitives[s->primitive_count];
    *p = (ibl_scene_primitive){.material = material < 0 ? s->material_count - 1
                                                        : material};
    bool ok = read_arrays(g, at, skinned, p);
    if (ok) {
        unroll((mode)m, p);
        ok = ibl_gltf_drop_nowhere(g, p);
    }
    if (ok && !p->normal)
        flatten(p);
    if (ok)
        s->primitive_count++;
    else
        ibl_scene_primitive_free(p);
}

bool ibl_gltf_mesh(ibl_gltf *g, int i, bool skinned, int *first, int *end)
{
    ibl_scene *s = g->scene;
    ibl_json_at meshes;
    const int total = ibl_gltf_array(g, "meshes", &meshes);

    if (!g->mesh) {
        g->mesh = ibl_need(calloc((size_t)total + 1, sizeof *g->mesh));
    }
    *first = g->mesh[i][0];
    *end = g->mesh[i][1] - 1;
    if (*end >= 0 && !skinned)
        return true;
    const ibl_json_at mesh = ibl_json_element(&meshes, (size_t)i);
    const ibl_json_at list = ibl_json_member(&mesh, "primitives");
    const ibl_json_at weights = ibl_json_member(&mesh, "weights");
    const size_t count = json_array_size(list.value);
    for (size_t k = 0; k < json_array_size(weights.value); k++)
        if (json_number_value(json_array_get(weights.value, k)) != 0) {
            ibl_json_complain(weights, "targets of morphs are not read");
            break;
        }
    if (!ibl_json_array(list, 0, INT32_MAX) ||
        !ibl_gltf_count(g, list, 256 * count))
        return false;
    const size_t all = (size_t)s->primitive_count + count + 1;
    s->primitives =
        ibl_need(realloc(s->primitives, all * sizeof *s->primitives));
    *first = s->primitive_count;
    for (size_t k = 0; k < count && !g->status; k++)
        read_primitive(g, ibl_json_element(&list, k), skinned);
    *end = s->primitive_count;
    if (!skinned) {
        g->mesh[i][0] = *first;
        g->mesh[i][1] = *end + 1;
    }
    return !g->status;
}
