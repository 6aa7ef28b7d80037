/* SPDX-License-Identifier: MIT */
/* Meshes of glTF, section 3.7.2, as lists of triangles. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "scene/gltf_reader.h"

typedef enum mode {
    TRIANGLES = 4,
    STRIP,
    FAN
} mode;

/* The attributes of a vertex, with what a file must have at least. */
static const struct {
    const char *name;
    size_t at;
    int least, most;
} attributes[] = {
    {"POSITION", offsetof(ibl_scene_primitive, position), 3, 3},
    {"NORMAL", offsetof(ibl_scene_primitive, normal), 3, 3},
    {"TANGENT", offsetof(ibl_scene_primitive, tangent), 4, 4},
    {"TEXCOORD_0", offsetof(ibl_scene_primitive, texcoord[0]), 2, 2},
    {"TEXCOORD_1", offsetof(ibl_scene_primitive, texcoord[1]), 2, 2},
    {"COLOR_0", offsetof(ibl_scene_primitive, colour), 3, 4},
};

enum {
    ATTRIBUTES = sizeof attributes / sizeof *attributes
};

static float **field(ibl_scene_primitive *p, int i)
{
    return (float **)(void *)((char *)p + attributes[i].at);
}

static bool read_attributes(ibl_gltf *g, ibl_json_at at, ibl_scene_primitive *p)
{
    for (int i = 0; i < ATTRIBUTES; i++) {
        const ibl_json_at index = ibl_json_member(&at, attributes[i].name);
        uint32_t count = p->vertex_count;
        if (!index.value)
            continue;
        if (!ibl_gltf_floats(g, index, attributes[i].least, attributes[i].most,
                             field(p, i), &count))
            return false;
        if (i > 0 && count != p->vertex_count)
            return ibl_json_complain(index,
                                     "damaged: %u elements for %u vertices",
                                     count, p->vertex_count);
        p->vertex_count = count;
    }
    return true;
}

/* The indices as the file has them, or all vertices in order. */
static bool read_indices(ibl_gltf *g, ibl_json_at at, ibl_scene_primitive *p)
{
    const ibl_json_at index = ibl_json_member(&at, "indices");

    if (!index.value) {
        p->index = ibl_alloc_array(p->vertex_count, sizeof *p->index);
        if (!p->index)
            return ibl_gltf_no_memory(g);
        for (uint32_t i = 0; i < p->vertex_count; i++)
            p->index[i] = i;
        p->index_count = p->vertex_count;
        return true;
    }
    if (!ibl_gltf_indices(g, index, &p->index, &p->index_count))
        return false;
    for (uint32_t i = 0; i < p->index_count; i++)
        if (p->index[i] >= p->vertex_count)
            return ibl_json_complain(index,
                                     "damaged: vertex %u of %u: indices begin "
                                     "with 0",
                                     p->index[i], p->vertex_count);
    return true;
}

/* Makes triangles of strips and fans: figure of section 3.7.2.1. */
static bool unroll(ibl_gltf *g, mode m, ibl_scene_primitive *p)
{
    const uint32_t count = p->index_count < 3 ? 0 : p->index_count - 2;

    if (m == TRIANGLES) {
        p->index_count -= p->index_count % 3;
        return true;
    }
    uint32_t *all = ibl_alloc_array(3 * (size_t)count, sizeof *all);
    if (!all)
        return ibl_gltf_no_memory(g);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t first = m == FAN ? i + 1 : i, odd = m == STRIP && i % 2;
        all[3 * i] = p->index[first];
        all[3 * i + 1] = p->index[first + 1 + odd];
        all[3 * i + 2] = p->index[m == FAN ? 0 : first + 2 - odd];
    }
    ibl_free(p->index);
    p->index = all;
    p->index_count = 3 * count;
    return true;
}

/* ---- flat normals ----------------------------------------------------- */

/* Gives each corner of each triangle a vertex of its own. */
static bool separate(ibl_gltf *g, ibl_scene_primitive *p)
{
    for (int a = 0; a < ATTRIBUTES; a++) {
        float **values = field(p, a);
        const size_t most = (size_t)attributes[a].most;
        if (!*values)
            continue;
        float *all = ibl_alloc_array(p->index_count * most, sizeof *all);
        if (!all)
            return ibl_gltf_no_memory(g);
        for (uint32_t i = 0; i < p->index_count; i++)
            memcpy(all + i * most, *values + p->index[i] * most,
                   most * sizeof *all);
        ibl_free(*values);
        *values = all;
    }
    for (uint32_t i = 0; i < p->index_count; i++)
        p->index[i] = i;
    p->vertex_count = p->index_count;
    return true;
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

static bool flatten(ibl_gltf *g, ibl_scene_primitive *p)
{
    ibl_free(p->tangent); /* without normals it does not count */
    p->tangent = NULL;
    if (!separate(g, p))
        return false;
    p->normal = ibl_alloc_array(3 * (size_t)p->vertex_count, sizeof(float));
    if (!p->normal)
        return ibl_gltf_no_memory(g);
    for (size_t i = 0; i < p->vertex_count; i += 3)
        set_normal(p->position + 3 * i, p->normal + 3 * i);
    return true;
}

/* ---- the calls -------------------------------------------------------- */

static bool read_primitive(ibl_gltf *g, ibl_json_at at)
{
    ibl_scene *s = g->scene;
    const ibl_json_at list = ibl_json_member(&at, "attributes");
    int m = TRIANGLES, material;

    if (!ibl_json_int(ibl_json_optional(&at, "mode"), 0, FAN, &m))
        return false;
    if (!json_is_object(list.value))
        return ibl_json_wrong(list, "an object");
    if (m < TRIANGLES || !json_object_get(list.value, "POSITION")) {
        g->left_out++;
        return true;
    }
    if (!ibl_gltf_index(ibl_json_optional(&at, "material"),
                        s->material_count - 1, &material))
        return false;
    ibl_scene_primitive *p = &s->primitives[s->primitive_count++];
    *p = (ibl_scene_primitive){.material = material < 0 ? s->material_count - 1
                                                        : material};
    return read_attributes(g, list, p) && read_indices(g, at, p) &&
           unroll(g, (mode)m, p) && (p->normal || flatten(g, p));
}

static bool read_mesh(ibl_gltf *g, ibl_json_at at)
{
    ibl_scene *s = g->scene;
    const ibl_json_at list = ibl_json_member(&at, "primitives");

    if (!ibl_json_array(list, 1, INT32_MAX))
        return false;
    const size_t count = json_array_size(list.value);
    ibl_scene_primitive *all = realloc(
        s->primitives, ((size_t)s->primitive_count + count) * sizeof *all);
    if (!all)
        return ibl_gltf_no_memory(g);
    s->primitives = all;
    for (size_t i = 0; i < count; i++)
        if (!read_primitive(g, ibl_json_element(&list, i)))
            return false;
    return true;
}

bool ibl_gltf_meshes(ibl_gltf *g)
{
    const ibl_scene *s = g->scene;
    ibl_json_at meshes;

    if (!ibl_gltf_array(g, "meshes", &meshes, &g->mesh_count))
        return false;
    g->mesh_first = malloc(((size_t)g->mesh_count + 1) * sizeof(int));
    if (!g->mesh_first)
        return ibl_gltf_no_memory(g);
    for (int i = 0; i < g->mesh_count; i++) {
        g->mesh_first[i] = s->primitive_count;
        if (!read_mesh(g, ibl_json_element(&meshes, (size_t)i)))
            return false;
    }
    g->mesh_first[g->mesh_count] = s->primitive_count;
    return true;
}
