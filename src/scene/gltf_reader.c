/* SPDX-License-Identifier: MIT */
#include "scene/gltf_reader.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/alloc.h"
#include "core/context.h"

enum {
    MOST_WARNINGS = 8 /* of parts that are wrong, a line each */
};

/* ---- helpers of the reader -------------------------------------------- */

bool ibl_gltf_refuse(ibl_gltf *g, const char *fmt, ...)
{
    char text[1024];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    g->status = ibl_fail(g->ctx, IBL_ERR_FORMAT, "%s: %s", g->path, text);
    return false;
}

/* `fail` of an ibl_json_file. */
static void fail(void *cookie, const char *text)
{
    ibl_gltf *g = cookie;

    if (g->strict)
        g->status = ibl_fail(g->ctx, IBL_ERR_FORMAT, "%s", text);
    else if (g->wrong++ < MOST_WARNINGS)
        ibl_warn(g->ctx, "%s: left out", text);
}

int ibl_gltf_array(ibl_gltf *g, const char *key, ibl_json_at *array)
{
    *array = ibl_json_optional(&g->root, key);
    return !array->value || ibl_json_array(*array, 0, INT32_MAX)
               ? (int)json_array_size(array->value)
               : 0;
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
                    double *out)
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
        out[i] = fmin(fmax(x, low), high);
    }
    return true;
}

bool ibl_gltf_object(ibl_json_at at, const char *key, ibl_json_at *object)
{
    *object = ibl_json_optional(&at, key);
    return !object->value || json_is_object(object->value) ||
           ibl_json_wrong(*object, "an object");
}

bool ibl_gltf_extension(ibl_json_at at, const char *name, ibl_json_at *object)
{
    ibl_json_at all;

    return ibl_gltf_object(at, "extensions", &all) &&
           ibl_gltf_object(all, name, object);
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
        ibl_warn(g->ctx,
                 "%s: %llu values are no numbers: triangles with such a vertex "
                 "are left out, the others taken as 0",
                 g->path, (unsigned long long)g->mended);
    if (g->wrong > MOST_WARNINGS)
        ibl_warn(g->ctx, "%s: %d other parts are wrong, too: left out", g->path,
                 g->wrong - MOST_WARNINGS);
}

ibl_status ibl_scene_read(ibl_ctx *ctx, const char *path, bool strict,
                          ibl_scene *out)
{
    static void (*const parts[])(ibl_gltf *) = {
        ibl_gltf_images, ibl_gltf_materials, ibl_gltf_nodes};
    ibl_gltf g = {.ctx = ctx, .path = path, .scene = out, .strict = strict};

    *out = (ibl_scene){.strict = strict};
    g.json = (ibl_json_file){.name = path, .fail = fail, .cookie = &g};
    g.root = ibl_json_root(&g.json);
    if (ibl_gltf_open(&g))
        for (size_t i = 0; i < sizeof parts / sizeof *parts && !g.status; i++)
            parts[i](&g);
    if (!g.status && strict && g.mended)
        ibl_gltf_refuse(&g, "%llu values are no numbers",
                        (unsigned long long)g.mended);
    if (!g.status)
        warn(&g);
    json_decref(g.json.root);
    free(g.buffers);
    free(g.views);
    free(g.mesh);
    return g.status;
}

void ibl_scene_primitive_free(ibl_scene_primitive *p)
{
    for (int i = 0; i < IBL_SCENE_TEXCOORDS; i++)
        ibl_free(p->texcoord[i]);
    for (int i = 0; i < IBL_SCENE_JOINTS; i++) {
        ibl_free(p->joints[i]);
        ibl_free(p->weights[i]);
    }
    ibl_free(p->position);
    ibl_free(p->normal);
    ibl_free(p->tangent);
    ibl_free(p->colour);
    ibl_free(p->index);
    *p = (ibl_scene_primitive){0};
}

void ibl_scene_free(ibl_scene *s)
{
    for (int i = 0; i < s->primitive_count; i++)
        ibl_scene_primitive_free(&s->primitives[i]);
    for (int i = 0; i < s->material_count; i++)
        free(s->materials[i].name);
    for (int i = 0; i < s->image_count && s->images; i++) {
        free(s->images[i].name);
        ibl_free(s->images[i].rgba);
    }
    for (int i = 0; i < s->camera_count; i++)
        free(s->cameras[i].name);
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
    free(s->cameras);
    free(s->files);
    *s = (ibl_scene){0};
}
