/* SPDX-License-Identifier: MIT */
/* Nodes of glTF, section 3.5: where meshes and cameras stand. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "core/alloc.h"
#include "core/context.h"
#include "scene/gltf_reader.h"

/* A node of the scene. */
typedef struct placed {
    int node;
    int mesh; /* -1: none */
    bool hidden;
} placed;

static const double unit[16] = {[0] = 1, [5] = 1, [10] = 1, [15] = 1};

/* The nodes that were found, each once; their children follow. */
typedef struct nodes {
    ibl_gltf *g;
    ibl_json_at array;
    int total, meshes;
    placed *list;
    int count;
    bool *seen;
    double (*world)[16]; /* of each node of the file, by columns */
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
static void compose(const double t[3], const double q[4], const double s[3],
                    double m[16])
{
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double n = x * x + y * y + z * z + w * w;
    const double k = n > 0 ? 2 / n : 0;
    const double columns[3][3] = {
        {1 - k * (y * y + z * z), k * (x * y + z * w), k * (x * z - y * w)},
        {k * (x * y - z * w), 1 - k * (x * x + z * z), k * (y * z + x * w)},
        {k * (x * z + y * w), k * (y * z - x * w), 1 - k * (x * x + y * y)}};

    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++) {
            m[4 * c + r] = columns[c][r] * s[c];
            m[12 + c] = t[c];
        }
    m[3] = m[7] = m[11] = 0;
    m[15] = 1;
}

static bool read_local(ibl_json_at at, double m[16])
{
    double t[3] = {0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    const ibl_json_at matrix = ibl_json_member(&at, "matrix");

    if (matrix.value)
        return ibl_gltf_reals(matrix, 16, -1e30, 1e30, m);
    if (!ibl_gltf_reals(ibl_json_optional(&at, "translation"), 3, -1e30, 1e30,
                        t) ||
        !ibl_gltf_reals(ibl_json_optional(&at, "rotation"), 4, -1, 1, q) ||
        !ibl_gltf_reals(ibl_json_optional(&at, "scale"), 3, -1e30, 1e30, s))
        return false;
    compose(t, q, s, m);
    return true;
}

/* Adds a node below a parent, whose matrix is above. */
static void add_node(nodes *n, ibl_json_at index, const double above[16],
                     bool hidden)
{
    double local[16];
    ibl_json_at visibility;
    int i;

    if (!ibl_gltf_index(index, n->total, &i))
        return;
    if (n->seen[i]) {
        ibl_json_complain(index, "damaged: node %d is in two places", i);
        return;
    }
    n->seen[i] = true;
    const ibl_json_at at = ibl_json_element(&n->array, (size_t)i);
    placed *p = &n->list[n->count];
    *p = (placed){.node = i, .hidden = hidden};
    if (!read_local(at, local))
        return;
    if (!ibl_gltf_index(ibl_json_optional(&at, "mesh"), n->meshes, &p->mesh))
        p->mesh = -1;
    if (ibl_gltf_extension(at, "KHR_node_visibility", &visibility) &&
        json_is_false(json_object_get(visibility.value, "visible")))
        p->hidden = true;
    multiply(above, local, n->world[i]);
    n->count++;
}

static void add_all(nodes *n, ibl_json_at list, const double above[16],
                    bool hidden)
{
    if (!list.value || !ibl_json_array(list, 0, INT32_MAX))
        return;
    for (size_t i = 0; i < json_array_size(list.value); i++)
        add_node(n, ibl_json_element(&list, i), above, hidden);
}

/* Finds all nodes of the default scene, or of the first. */
static bool find_nodes(nodes *n)
{
    ibl_json_at scenes;
    const int count = ibl_gltf_array(n->g, "scenes", &scenes);
    int scene;

    if (!count)
        return ibl_gltf_refuse(n->g, "it has no scenes, so that nothing is "
                                     "shown, as glTF allows: export it with "
                                     "one");
    if (!ibl_gltf_index(ibl_json_optional(&n->g->root, "scene"), count, &scene))
        scene = 0;
    const ibl_json_at at =
        ibl_json_element(&scenes, scene < 0 ? 0 : (size_t)scene);
    add_all(n, ibl_json_member(&at, "nodes"), unit, false);
    for (int i = 0; i < n->count; i++) {
        const placed p = n->list[i];
        const ibl_json_at node = ibl_json_element(&n->array, (size_t)p.node);
        add_all(n, ibl_json_member(&node, "children"), n->world[p.node],
                p.hidden);
    }
    return !n->g->status;
}

/* ---- draws ------------------------------------------------------------ */

static void widen(ibl_scene *s, const ibl_scene_draw *d, bool first)
{
    const ibl_scene_primitive *p = &s->primitives[d->primitive];

    for (size_t v = 0; v < p->vertex_count; v++) {
        for (int k = 0; k < 3; k++) {
            double x = d->to_world[12 + k];
            for (int c = 0; c < 3; c++)
                x += d->to_world[4 * c + k] *
                     (double)p->position[3 * v + (size_t)c];
            s->bounds[0][k] = first ? x : fmin(x, s->bounds[0][k]);
            s->bounds[1][k] = first ? x : fmax(x, s->bounds[1][k]);
        }
        first = false;
    }
}

/* Draws primitives first to end at a place. */
static bool add_draws(ibl_gltf *g, int first, int end, const double world[16])
{
    ibl_scene *s = g->scene;

    for (int i = first; i < end; i++) {
        const ibl_scene_primitive *p = &s->primitives[i];
        g->drawn += (uint64_t)p->vertex_count + p->index_count;
        if (s->draw_count == IBL_SCENE_DRAWS || g->drawn > IBL_SCENE_VALUES)
            return ibl_gltf_refuse(g,
                                   "over %d parts, or %d million vertices in "
                                   "all of them: simplify it",
                                   IBL_SCENE_DRAWS, IBL_SCENE_VALUES / 1000000);
        if (!(s->draw_count & (s->draw_count - 1))) {
            s->draws = ibl_need(realloc(
                s->draws, (size_t)(2 * s->draw_count + 1) * sizeof *s->draws));
        }
        ibl_scene_draw *d = &s->draws[s->draw_count++];
        d->primitive = i;
        memcpy(d->to_world, world, sizeof d->to_world);
        widen(s, d, s->draw_count == 1);
    }
    return true;
}

/* EXT_mesh_gpu_instancing: translation, rotation and scale of each. */
static void add_instances(nodes *n, const placed *p, ibl_json_at list,
                          int first, int end)
{
    static const char *const names[] = {"TRANSLATION", "ROTATION", "SCALE"};
    static const int sizes[] = {3, 4, 3};
    ibl_gltf *g = n->g;
    float *values[3] = {NULL};
    uint32_t count = 0, all = 0;
    bool ok = true;

    for (int i = 0; i < 3 && ok; i++) {
        const ibl_json_at index = ibl_json_member(&list, names[i]);
        if (!index.value)
            continue;
        ok = ibl_gltf_floats(g, index, sizes[i], sizes[i], &values[i], &count);
        if (ok && all && count != all)
            ok = ibl_json_complain(index, "damaged: %u of %u instances", count,
                                   all);
        if (ok)
            ibl_gltf_mend(g, values[i], (size_t)count * (size_t)sizes[i]);
        all = count;
    }
    for (uint32_t i = 0; i < all && ok; i++) {
        double v[3][4] = {{0}, {0, 0, 0, 1}, {1, 1, 1}}, local[16], world[16];
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < sizes[k] && values[k]; c++)
                v[k][c] = (double)values[k][i * (size_t)sizes[k] + (size_t)c];
        compose(v[0], v[1], v[2], local);
        multiply(n->world[p->node], local, world);
        ok = add_draws(g, first, end, world);
    }
    for (int i = 0; i < 3; i++)
        ibl_free(values[i]);
}

/* A skin moves its mesh in place of the node. */
static void draw_node(nodes *n, const placed *p)
{
    ibl_gltf *g = n->g;
    const ibl_json_at at = ibl_json_element(&n->array, (size_t)p->node);
    const ibl_json_at skin = ibl_json_member(&at, "skin");
    ibl_json_at instances;
    int first, end;
    double world[16];

    if (!ibl_gltf_extension(at, "EXT_mesh_gpu_instancing", &instances) ||
        !ibl_gltf_mesh(g, p->mesh, skin.value, &first, &end))
        return;
    memcpy(world, skin.value ? unit : n->world[p->node], sizeof world);
    if (instances.value && !skin.value)
        add_instances(n, p, ibl_json_member(&instances, "attributes"), first,
                      end);
    else if (!skin.value ||
             ibl_gltf_skin(g, skin, (const double(*)[16])n->world, n->total,
                           first, world + 12))
        add_draws(g, first, skin.value ? g->scene->primitive_count : end,
                  world);
}

/* Section 3.10. */
static void add_camera(nodes *n, int node)
{
    ibl_scene *s = n->g->scene;
    ibl_json_at cameras, lens;
    const ibl_json_at at = ibl_json_element(&n->array, (size_t)node);
    const int count = ibl_gltf_array(n->g, "cameras", &cameras);
    ibl_scene_camera c = {0};
    const char *type;
    int i;

    if (!ibl_gltf_index(ibl_json_optional(&at, "camera"), count, &i) || i < 0)
        return;
    const ibl_json_at camera = ibl_json_element(&cameras, (size_t)i);
    if (!ibl_json_text_at(ibl_json_member(&camera, "type"), &type))
        return;
    if (strcmp(type, "perspective") != 0) {
        ibl_warn(n->g->ctx, "%s: cameras[%d] is %s: left out", n->g->path, i,
                 strcmp(type, "orthographic") ? "of no known type" : type);
        return;
    }
    if (!ibl_gltf_object(camera, "perspective", &lens) ||
        !ibl_json_real(ibl_json_member(&lens, "yfov"), 0, M_PI, true,
                       &c.yfov) ||
        !ibl_json_real(ibl_json_optional(&lens, "aspectRatio"), 0, 1e6, true,
                       &c.aspect))
        return;
    const char *name = json_string_value(json_object_get(camera.value, "name"));
    if (!name)
        name = json_string_value(json_object_get(at.value, "name"));
    c.name = ibl_need(strdup(name ? name : ""));
    memcpy(c.to_world, n->world[node], sizeof c.to_world);
    s->cameras = ibl_need(realloc(s->cameras, ((size_t)s->camera_count + 1) *
                                                  sizeof *s->cameras));
    s->cameras[s->camera_count++] = c;
}

void ibl_gltf_nodes(ibl_gltf *g)
{
    nodes n = {.g = g};

    n.meshes = ibl_gltf_array(g, "meshes", &n.array);
    n.total = ibl_gltf_array(g, "nodes", &n.array);
    n.list = ibl_need(malloc(((size_t)n.total + 1) * sizeof *n.list));
    n.seen = ibl_need(calloc((size_t)n.total + 1, sizeof *n.seen));
    n.world = ibl_need(malloc(((size_t)n.total + 1) * sizeof *n.world));
    for (int i = 0; i < n.total; i++)
        memcpy(n.world[i], unit, sizeof unit);
    if (find_nodes(&n))
        for (int i = 0; i < n.count && !g->status; i++) {
            if (n.list[i].mesh >= 0 && !n.list[i].hidden)
                draw_node(&n, &n.list[i]);
            add_camera(&n, n.list[i].node);
        }
    if (!g->status && !g->scene->draw_count)
        ibl_gltf_refuse(g, "its scene has no triangles");
    free(n.list);
    free(n.seen);
    free(n.world);
}
