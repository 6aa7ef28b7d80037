/* SPDX-License-Identifier: MIT */
#include "scene/gltf_reader.h"

#include <math.h>
#include <stdlib.h>

#include "core/alloc.h"
#include "core/context.h"

/* ---- helpers of the reader -------------------------------------------- */

bool ibl_gltf_no_memory(ibl_gltf *g)
{
    g->status = ibl_no_memory(g->ctx, "a scene");
    return false;
}

/* `fail` of an ibl_json_file. */
static void fail(void *cookie, const char *text)
{
    ibl_gltf *g = cookie;

    g->status = ibl_fail(g->ctx, IBL_ERR_FORMAT, "%s", text);
}

bool ibl_gltf_array(ibl_gltf *g, const char *key, ibl_json_at *array,
                    int *count)
{
    *array = ibl_json_optional(&g->root, key);
    *count = (int)json_array_size(array->value);
    return !array->value || ibl_json_array(*array, 0, INT32_MAX);
}

bool ibl_gltf_index(ibl_json_at at, int count, int *index)
{
    if (at.optional)
        *index = -1;
    if (count || (at.optional && !at.value))
        return ibl_json_int(at, 0, count - 1, index);
    return ibl_json_wrong(at, "no index, since there is nothing of the kind");
}

bool ibl_gltf_reals(ibl_json_at at, int count, double low, double high,
                    float *out)
{
    if (!at.value && at.optional)
        return true;
    if (count > 1 && !ibl_json_array(at, (size_t)count, (size_t)count))
        return false;
    for (int i = 0; i < count; i++) {
        const ibl_json_at part =
            count > 1 ? ibl_json_element(&at, (size_t)i) : at;
        double x;
        if (!ibl_json_real(part, -1e30, 1e30, false, &x))
            return false;
        out[i] = (float)fmin(fmax(x, low), high);
    }
    return true;
}

/* ---- the calls -------------------------------------------------------- */

/* Says what was left out, a line for each kind. */
static void warn(const ibl_gltf *g)
{
    if (g->left_out)
        ibl_warn(g->ctx,
                 "%s: %d primitives are points, lines or without positions: "
                 "left out",
                 g->path, g->left_out);
    if (g->mended)
        ibl_warn(g->ctx, "%s: %llu values are no numbers: taken as 0", g->path,
                 (unsigned long long)g->mended);
}

ibl_status ibl_scene_read(ibl_ctx *ctx, const char *path, ibl_scene *out)
{
    ibl_gltf g = {.ctx = ctx, .path = path, .scene = out};

    *out = (ibl_scene){0};
    g.json = (ibl_json_file){.name = path, .fail = fail, .cookie = &g};
    g.root = ibl_json_root(&g.json);
    const bool ok = ibl_gltf_open(&g) && ibl_gltf_images(&g) &&
                    ibl_gltf_materials(&g) && ibl_gltf_meshes(&g) &&
                    ibl_gltf_nodes(&g);
    if (ok)
        warn(&g);
    json_decref(g.json.root);
    free(g.buffers);
    free(g.mesh_first);
    return ok ? IBL_OK : g.status;
}

static void free_primitive(ibl_scene_primitive *p)
{
    ibl_free(p->position);
    ibl_free(p->normal);
    ibl_free(p->tangent);
    ibl_free(p->texcoord[0]);
    ibl_free(p->texcoord[1]);
    ibl_free(p->colour);
    ibl_free(p->index);
}

void ibl_scene_free(ibl_scene *s)
{
    for (int i = 0; i < s->primitive_count; i++)
        free_primitive(&s->primitives[i]);
    for (int i = 0; i < s->material_count; i++)
        free(s->materials[i].name);
    for (int i = 0; i < s->image_count && s->images; i++) {
        free(s->images[i].name);
        ibl_free(s->images[i].rgba);
    }
    for (int i = 0; i < s->file_count; i++)
        free(s->files[i]);
    for (struct ibl_scene_store *at = s->store, *next; at; at = next) {
        next = at->next;
        ibl_input_close(&at->in);
        free(at);
    }
    free(s->primitives);
    free(s->materials);
    free(s->draws);
    free(s->images);
    free(s->files);
    *s = (ibl_scene){0};
}
