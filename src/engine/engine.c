/* SPDX-License-Identifier: MIT */
#include "engine/engine.h"

#include <errno.h>
#include <string.h>

#include "core/context.h"
#include "engine/rgbd.h"
#include "io/container.h"
#include "json/text.h"

static const struct {
    const char *suffix, *pixel;
    float max;
} kinds[] = {[IBL_ENGINE_ENV] = {".env", "rgbd", IBL_RGBD_MAX},
             [IBL_ENGINE_GLTF] = {".gltf", "rgbd", IBL_RGBD_MAX},
             [IBL_ENGINE_PLAYCANVAS] = {"_envatlas.png", "rgbp", 64}};

const char *ibl_engine_suffix(ibl_engine engine)
{
    return kinds[engine].suffix;
}

ibl_engine ibl_engine_of_name(const char *name)
{
    const size_t length = strlen(name);

    for (int i = IBL_ENGINE_ENV; i <= IBL_ENGINE_PLAYCANVAS; i++) {
        const size_t size = strlen(kinds[i].suffix);
        if (length > size && !strcmp(name + length - size, kinds[i].suffix))
            return (ibl_engine)i;
    }
    return IBL_ENGINE_NONE;
}

const char *ibl_engine_pixel(ibl_engine engine)
{
    return kinds[engine].pixel;
}

float ibl_engine_max(ibl_engine engine)
{
    return kinds[engine].max;
}

int ibl_engine_faces(ibl_engine engine, int levels)
{
    return engine == IBL_ENGINE_GLTF ? IBL_FACES * levels : 0;
}

char *ibl_engine_face_name(const char *stem, int index)
{
    static const char *const faces[IBL_FACES] = {"px", "nx", "py",
                                                 "ny", "pz", "nz"};

    return ibl_format("%s_%d_%s.png", stem, index / IBL_FACES,
                      faces[index % IBL_FACES]);
}

/* ---- the calls -------------------------------------------------------- */

ibl_status ibl_engine_encode(ibl_ctx *ctx, ibl_engine engine,
                             const ibl_engine_set *set, ibl_blob *main,
                             ibl_blob *faces)
{
    const ibl_texture *tex = set->specular;

    *main = (ibl_blob){0};
    if (tex->faces != IBL_FACES || tex->pixel != IBL_PIXEL_RGBA32F ||
        (engine == IBL_ENGINE_PLAYCANVAS && set->irradiance->projection))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an engine's file of %d face(s) of %s: must be cubes, "
                        "of rgba32f",
                        tex->faces, ibl_pixel_name(tex->pixel));
    if (engine == IBL_ENGINE_ENV)
        return ibl_env_encode(ctx, set, main);
    return engine == IBL_ENGINE_GLTF ? ibl_gltf_encode(ctx, set, main, faces)
                                     : ibl_atlas_encode(ctx, set, main);
}

/* Whether bytes begin as JSON does. */
static bool is_json(const unsigned char *bytes, size_t size)
{
    size_t at = 0;

    while (at < size && bytes[at] && strchr(" \t\r\n", bytes[at]))
        at++;
    return at < size && bytes[at] == '{';
}

static bool is_png(const unsigned char *bytes, size_t size)
{
    return size >= 8 && !memcmp(bytes, "\x89PNG\r\n\x1a\n", 8);
}

static ibl_status decode(ibl_ctx *ctx, const ibl_input *in, ibl_texture *tex)
{
    if (ibl_env_is(in->bytes, in->size))
        return ibl_env_decode(ctx, in->name, in->bytes, in->size, tex);
    if (is_json(in->bytes, in->size))
        return ibl_gltf_decode(ctx, in->name, in->bytes, in->size, tex);
    if (is_png(in->bytes, in->size))
        return ibl_atlas_decode(ctx, in->name, in->bytes, in->size, tex);
    return ibl_texture_decode(ctx, in->name, in->bytes, in->size, tex, NULL);
}

ibl_status ibl_engine_read(ibl_ctx *ctx, const char *path, int layer,
                           ibl_texture *tex)
{
    ibl_input in;

    *tex = (ibl_texture){0};
    ibl_status status = ibl_input_open(ctx, path, &in);
    if (status)
        return status;
    status = ibl_input_load(&in);
    if (!status)
        status = decode(ctx, &in, tex);
    ibl_input_close(&in);
    if (status || tex->faces == 1 || layer < 0 || (tex->layers == 1 && !layer))
        return status;
    ibl_texture all = *tex;
    if (layer < all.layers)
        status = ibl_texture_layer(ctx, &all, layer, tex);
    else
        status = ibl_fail(ctx, IBL_ERR_ARGUMENT,
                          "%s: has no layer %d, but 0 to %d: choose one by "
                          "--array-layer",
                          path, layer, all.layers - 1);
    if (status)
        *tex = (ibl_texture){0};
    ibl_texture_free(&all);
    return status;
}

/* The silent try fails where keys lie behind the head, too. */
ibl_status ibl_engine_look(ibl_ctx *ctx, const char *path, bool texels,
                           ibl_texture *tex, int *format)
{
    const ibl_engine engine = ibl_engine_of_name(path);
    ibl_container container = IBL_CONTAINER_COUNT;
    unsigned char head[1 << 14];
    ibl_input in;

    *tex = (ibl_texture){0};
    *format = engine ? IBL_CONTAINER_COUNT + (int)engine - IBL_ENGINE_ENV : -1;
    if (engine)
        return ibl_engine_read(ctx, path, -1, tex);
    ibl_status status = ibl_input_open(ctx, path, &in);
    if (status)
        return status;
    ibl_input first = ibl_input_of(NULL, in.name, head, in.size);
    if (!ibl_input_read(&in, 0, sizeof head, head, &first.head))
        status = ibl_input_unread(&in, errno);
    else if (ibl_container_of(head, first.head) < IBL_CONTAINER_COUNT &&
             (texels || first.head == in.size ||
              ibl_texture_take(&first, tex, &container))) {
        status = ibl_input_load(&in);
        if (!status)
            status = ibl_texture_take(&in, tex, &container);
    }
    if (container < IBL_CONTAINER_COUNT)
        *format = (int)container;
    ibl_input_close(&in);
    return status;
}
