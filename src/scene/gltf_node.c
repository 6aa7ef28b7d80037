/* SPDX-License-Identifier: MIT */
/* Nodes of glTF, section 3.5: where meshes stand. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/gltf_reader.h"

/* A node of the scene; its matrix is stored by columns. */
typedef struct placed {
    int node;
    int mesh; /* -1: none */
    double to_world[16];
} placed;

/* The nodes that were found, each once; their children follow. */
typedef struct nodes {
    ibl_gltf *g;
    ibl_json_at array;
    int total;
    placed *list;
    int count;
    bool *seen;
} nodes;

static void multiply(const double a[16], const double b[16], double out[16])
{
    for (int i = 0; i < 16; i++) {
        out[i] = 0;
        for (int k = 0; k < 4; k++)
            out[i] += a[i % 4 + 4 * k] * b[4 * (i / 4) + k];
    }
}

/* Rotation by the quaternion q, with scale and translation. */
static void compose(const float t[3], const float q[4], const float s[3],
                    double m[16])
{
    const double x = (double)q[0], y = (double)q[1], z = (double)q[2];
    const double w = (double)q[3], n = x * x + y * y + z * z + w * w;
    const double k = n > 0 ? 2 / n : 0;
    const double columns[3][3] = {
        {1 - k * (y * y + z * z), k * (x * y + z * w), k * (x * z - y * w)},
        {k * (x * y - z * w), 1 - k * (x * x + z * z), k * (y * z + x * w)},
        {k * (x * z + y * w), k * (y * z - x * w), 1 - k * (x * x + y * y)}};

    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++) {
            m[4 * c + r] = columns[c][r] * (double)s[c];
            m[12 + c] = (double)t[c];
        }
    m[3] = m[7] = m[11] = 0;
    m[15] = 1;
}

static bool read_local(ibl_json_at at, double m[16])
{
    float t[3] = {0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1}, all[16];
    const ibl_json_at matrix = ibl_json_member(&at, "matrix");

    if (matrix.value) {
        if (!ibl_gltf_reals(matrix, 16, -1e30, 1e30, all))
            return false;
        for (int i = 0; i < 16; i++)
            m[i] = (double)all[i];
        return true;
    }
    if (!ibl_gltf_reals(ibl_json_optional(&at, "translation"), 3, -1e30, 1e30,
                        t) ||
        !ibl_gltf_reals(ibl_json_optional(&at, "rotation"), 4, -1, 1, q) ||
        !ibl_gltf_reals(ibl_json_optional(&at, "scale"), 3, -1e30, 1e30, s))
        return false;
    compose(t, q, s, m);
    return true;
}

/* Adds a node below a parent, whose matrix is above. */
static bool add_node(nodes *n, ibl_json_at index, const double above[16])
{
    double local[16];
    int i;

    if (!ibl_gltf_index(index, n->total, &i))
        return false;
    if (n->seen[i])
        return ibl_json_complain(index, "damaged: node %d is in two places", i);
    n->seen[i] = true;
    const ibl_json_at at = ibl_json_element(&n->array, (size_t)i);
    placed *p = &n->list[n->count++];
    p->node = i;
    if (!ibl_gltf_index(ibl_json_optional(&at, "mesh"), n->g->mesh_count,
                        &p->mesh) ||
        !read_local(at, local))
        return false;
    multiply(above, local, p->to_world);
    return true;
}

static bool add_all(nodes *n, ibl_json_at list, const double above[16])
{
    bool ok = !list.value || ibl_json_array(list, 0, INT32_MAX);

    for (size_t i = 0; i < json_array_size(list.value) && ok; i++)
        ok = add_node(n, ibl_json_element(&list, i), above);
    return ok;
}

/* Finds all nodes of the default scene, or of the first. */
static bool find_nodes(nodes *n)
{
    static const double unit[16] = {[0] = 1, [5] = 1, [10] = 1, [15] = 1};
    ibl_json_at scenes;
    int count, scene;

    if (!ibl_gltf_array(n->g, "scenes", &scenes, &count))
        return false;
    if (!count)
        return true;
    if (!ibl_gltf_index(ibl_json_optional(&n->g->root, "scene"), count, &scene))
        return false;
    const ibl_json_at at =
        ibl_json_element(&scenes, scene < 0 ? 0 : (size_t)scene);
    if (!add_all(n, ibl_json_member(&at, "nodes"), unit))
        return false;
    for (int i = 0; i < n->count; i++) {
        const ibl_json_at node =
            ibl_json_element(&n->array, (size_t)n->list[i].node);
        if (!add_all(n, ibl_json_member(&node, "children"),
                     n->list[i].to_world))
            return false;
        /* A skin moves its mesh in place of the node. */
        if (json_object_get(node.value, "skin"))
            memcpy(n->list[i].to_world, unit, sizeof unit);
    }
    return true;
}

/* ---- draws ------------------------------------------------------------ */

static void widen(ibl_scene *s, const ibl_scene_draw *d, bool first)
{
    const ibl_scene_primitive *p = &s->primitives[d->primitive];

    for (size_t v = 0; v < p->vertex_count; v++) {
        for (int k = 0; k < 3; k++) {
            double x = (double)d->to_world[12 + k];
            for (int c = 0; c < 3; c++)
                x += (double)d->to_world[4 * c + k] *
                     (double)p->position[3 * v + (size_t)c];
            s->bounds[0][k] = first ? x : fmin(x, s->bounds[0][k]);
            s->bounds[1][k] = first ? x : fmax(x, s->bounds[1][k]);
        }
        first = false;
    }
}

static void add_draws(nodes *n, const placed *p)
{
    ibl_scene *s = n->g->scene;

    for (int i = n->g->mesh_first[p->mesh]; i < n->g->mesh_first[p->mesh + 1];
         i++) {
        ibl_scene_draw *d = &s->draws[s->draw_count++];
        d->primitive = i;
        for (int k = 0; k < 16; k++)
            d->to_world[k] = (float)p->to_world[k];
        widen(s, d, s->draw_count == 1);
    }
}

static bool make_draws(nodes *n)
{
    ibl_gltf *g = n->g;
    const int *first = g->mesh_first;
    uint64_t count = 0;

    for (int i = 0; i < n->count; i++)
        if (n->list[i].mesh >= 0)
            count +=
                (uint64_t)(first[n->list[i].mesh + 1] - first[n->list[i].mesh]);
    if (!count)
        return ibl_json_complain(g->root, "its scene has no triangles");
    if (count > IBL_SCENE_DRAWS)
        return ibl_json_complain(g->root, "over %d parts: join its meshes",
                                 IBL_SCENE_DRAWS);
    g->scene->draws = calloc((size_t)count, sizeof *g->scene->draws);
    if (!g->scene->draws)
        return ibl_gltf_no_memory(g);
    for (int i = 0; i < n->count; i++)
        if (n->list[i].mesh >= 0)
            add_draws(n, &n->list[i]);
    return true;
}

bool ibl_gltf_nodes(ibl_gltf *g)
{
    nodes n = {.g = g};

    if (!ibl_gltf_array(g, "nodes", &n.array, &n.total))
        return false;
    n.list = malloc(((size_t)n.total + 1) * sizeof *n.list);
    n.seen = calloc((size_t)n.total + 1, sizeof *n.seen);
    const bool ok = n.list && n.seen ? find_nodes(&n) && make_draws(&n)
                                     : ibl_gltf_no_memory(g);
    free(n.list);
    free(n.seen);
    return ok;
}
