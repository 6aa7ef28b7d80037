/* SPDX-License-Identifier: MIT */
/* Arrays of textures, layer by layer. */
#include <string.h>

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
    return ibl_texture_room(ctx, out);
}

/* Copies a layer. */
static void copy_layer(const ibl_texture *tex, int from, ibl_texture *out,
                       int to)
{
    for (int l = 0; l < tex->levels; l++)
        memcpy(out->data + ibl_texture_layer_offset(out, l, to, 0),
               tex->data + ibl_texture_layer_offset(tex, l, from, 0),
               (size_t)tex->faces * ibl_texture_face_bytes(tex, l));
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
    if (array->pixel != tex->pixel || array->width != tex->width ||
        array->height != tex->height || array->levels != tex->levels ||
        array->faces != tex->faces)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "layer %d of an array: its texels, size, levels or "
                        "faces are not the array's",
                        layer);
    copy_layer(tex, 0, array, layer);
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
    if (!status)
        copy_layer(tex, layer, out, 0);
    for (int i = 0; i < tex->key_count && !status; i++)
        status =
            ibl_texture_set(ctx, out, tex->keys[i].key, tex->keys[i].value);
    if (status)
        ibl_texture_free(out);
    return status;
}
