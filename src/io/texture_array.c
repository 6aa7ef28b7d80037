/* SPDX-License-Identifier: MIT */
/* Joins textures to arrays and takes arrays apart. */
#include <string.h>

#include "core/alloc.h"
#include "io/container.h"

/* Sets out to tex's shape with `layers` layers and allocates its texels. */
static ibl_status begin(ibl_ctx *ctx, const ibl_texture *tex, int layers,
                        ibl_texture *out)
{
    *out = (ibl_texture){.pixel = tex->pixel,
                         .width = tex->width,
                         .height = tex->height,
                         .levels = tex->levels,
                         .layers = layers,
                         .faces = tex->faces,
                         .premultiplied = tex->premultiplied,
                         .primaries = tex->primaries};
    const size_t layer_bytes = tex->bytes / (size_t)tex->layers;
    out->data = ibl_alloc_array(layer_bytes, (size_t)layers);
    if (!out->data)
        return ibl_no_memory(ctx, "a texture");
    out->bytes = layer_bytes * (size_t)layers;
    return IBL_OK;
}

/* Copies count layers; in each level they are one block. */
static void copy_layers(const ibl_texture *tex, int from, int count,
                        ibl_texture *out, int to)
{
    for (int l = 0; l < tex->levels; l++)
        memcpy(out->data + ibl_texture_layer_offset(out, l, to, 0),
               tex->data + ibl_texture_layer_offset(tex, l, from, 0),
               (size_t)count * (size_t)tex->faces *
                   ibl_texture_face_bytes(tex, l));
}

/* Copies the keys of tex that have the same value in all `count` layers. */
static ibl_status add_keys(ibl_ctx *ctx, const ibl_texture *tex,
                           const ibl_texture *const *layers, int count,
                           ibl_texture *out)
{
    ibl_status status = IBL_OK;
    for (int k = 0; k < tex->key_count && !status; k++) {
        const ibl_key_value *pair = &tex->keys[k];
        bool common = true;
        for (int i = 0; i < count && common; i++) {
            const char *value = ibl_texture_get(layers[i], pair->key);
            common = value && !strcmp(value, pair->value);
        }
        if (common)
            status = ibl_texture_set(ctx, out, pair->key, pair->value);
    }
    return status;
}

static bool is_alike(const ibl_texture *a, const ibl_texture *b)
{
    return a->pixel == b->pixel && a->width == b->width &&
           a->height == b->height && a->levels == b->levels &&
           a->faces == b->faces;
}

static ibl_status check_alike(ibl_ctx *ctx, const ibl_texture *first,
                              const ibl_texture *tex, int i)
{
    const ibl_status status = ibl_texture_check(ctx, tex);
    if (status || is_alike(first, tex))
        return status;
    return ibl_fail(
        ctx, IBL_ERR_ARGUMENT,
        "texture %d of an array has %dx%d %s texels, %d levels and %d faces, "
        "the first %dx%d %s, %d and %d: all must be alike",
        i, tex->width, tex->height, ibl_pixel_name(tex->pixel), tex->levels,
        tex->faces, first->width, first->height, ibl_pixel_name(first->pixel),
        first->levels, first->faces);
}

ibl_status ibl_texture_array(ibl_ctx *ctx, const ibl_texture *const *layers,
                             int count, ibl_texture *out)
{
    ibl_status status = IBL_OK;
    int total = 0, premultiplied = 0;

    if (!ctx || !layers || !out)
        return ibl_missing(ctx, "ibl_texture_array: layers or out");
    *out = (ibl_texture){0};
    if (count < 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an array of %d textures: must be 1 or more", count);
    for (int i = 0; i < count; i++) {
        status = check_alike(ctx, layers[0], layers[i], i);
        if (status)
            return status;
        premultiplied |= layers[i]->premultiplied;
        total += layers[i]->layers;
        if (total > IBL_MAX_LAYERS)
            return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                            "an array of %d textures, %d layers in the first "
                            "%d: the limit is %d",
                            count, total, i + 1, IBL_MAX_LAYERS);
    }
    status = begin(ctx, layers[0], total, out);
    out->premultiplied = premultiplied;
    for (int i = 0, to = 0; i < count && !status; to += layers[i++]->layers)
        copy_layers(layers[i], 0, layers[i]->layers, out, to);
    if (!status)
        status = add_keys(ctx, layers[0], layers, count, out);
    if (status)
        ibl_texture_free(out);
    return status;
}

/* Checks that tex can be a layer. */
static ibl_status check_layer(ibl_ctx *ctx, const ibl_texture *tex)
{
    const ibl_status status = ibl_texture_check(ctx, tex);
    if (status || tex->layers == 1)
        return status;
    return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                    "an array of %d for a layer of another: must be one layer",
                    tex->layers);
}

ibl_status ibl_texture_array_begin(ibl_ctx *ctx, const ibl_texture *tex,
                                   int layers, ibl_texture *out)
{
    if (!out)
        return ibl_missing(ctx, "ibl_texture_array_begin: out");
    *out = (ibl_texture){0};
    const ibl_status status = check_layer(ctx, tex);
    if (status)
        return status;
    if (layers < 1 || layers > IBL_MAX_LAYERS)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an array of %d layers: must be 1 to %d", layers,
                        IBL_MAX_LAYERS);
    return begin(ctx, tex, layers, out);
}

ibl_status ibl_texture_array_put(ibl_ctx *ctx, ibl_texture *array, int layer,
                                 const ibl_texture *tex)
{
    ibl_status status = check_layer(ctx, tex);
    if (!status)
        status = ibl_texture_check(ctx, array);
    if (status)
        return status;
    if (layer < 0 || layer >= array->layers)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "layer %d of an array: must be 0 to %d", layer,
                        array->layers - 1);
    if (!is_alike(array, tex))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "layer %d of an array: its texels, size, levels or "
                        "faces are not the array's",
                        layer);
    copy_layers(tex, 0, 1, array, layer);
    array->premultiplied |= tex->premultiplied;
    return IBL_OK;
}

ibl_status ibl_texture_layer(ibl_ctx *ctx, const ibl_texture *tex, int layer,
                             ibl_texture *out)
{
    if (!out)
        return ibl_missing(ctx, "ibl_texture_layer: out");
    *out = (ibl_texture){0};
    ibl_status status = ibl_texture_check(ctx, tex);
    if (status)
        return status;
    if (layer < 0 || layer >= tex->layers)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "layer %d of a texture: must be 0 to %d", layer,
                        tex->layers - 1);
    status = begin(ctx, tex, 1, out);
    if (!status) {
        copy_layers(tex, layer, 1, out, 0);
        status = add_keys(ctx, tex, NULL, 0, out);
    }
    if (status)
        ibl_texture_free(out);
    return status;
}
