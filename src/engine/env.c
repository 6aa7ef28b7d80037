/* SPDX-License-Identifier: MIT */
/*
 * Babylon's .env: a magic number, JSON with a NUL behind it, and the images,
 * level by level, whose positions count from behind the NUL. Faces are in the
 * order of cubes, with rows from the bottom. Source: environmentTextureTools.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "core/context.h"
#include "engine/rgbd.h"
#include "engine/set.h"
#include "json/json_load.h"

static const unsigned char magic[8] = {0x86, 0x16, 0x87, 0x96,
                                       0xF6, 0xD6, 0x96, 0x36};

enum {
    JSON_BYTES = 1 << 20, /* that the text may have */
    MAX_FACES = IBL_FACES * IBL_MAX_LEVELS
};

/* What Babylon multiplies the level by, where files do not say. */
static const double usual_scale = 0.8;

static json_t *irradiance(const double *sh)
{
    static const char *const names[IBL_SH_NINE] = {"x",  "y",  "z",  "xx", "yy",
                                                   "zz", "yz", "zx", "xy"};
    double p[IBL_SH_NINE][3];
    json_t *j = json_object();

    ibl_sh_polynomial(sh, p);
    for (int i = 0; i < IBL_SH_NINE; i++)
        put(&j, names[i], json_pack("[fff]", p[i][0], p[i][1], p[i][2]));
    return j;
}

/* The places of count images, the first of which is at *position. */
static json_t *places(const ibl_blob *images, int count, size_t *position)
{
    json_t *list = json_array();

    for (int i = 0; i < count; i++) {
        append(&list, json_pack("{sI sI}", "length", (json_int_t)images[i].size,
                                "position", (json_int_t)*position));
        *position += images[i].size;
    }
    return list;
}

static json_t *manifest(const ibl_engine_set *set, const ibl_blob *faces)
{
    const int count = IBL_FACES * set->specular->levels;
    json_t *matte = irradiance(set->sh);
    size_t position = 0;
    json_t *levels = places(faces, count, &position);

    put(&matte, "irradianceTexture",
        json_pack("{si so}", "size", set->irradiance->size, "faces",
                  places(faces + count, IBL_FACES, &position)));
    return json_pack("{si si ss so s{so sf} so}", "version", 2, "width",
                     set->specular->width, "imageType", "image/png",
                     "irradiance", matte, "specular", "mipmaps", levels,
                     "lodGenerationScale", usual_scale, "iblbake",
                     ibl_engine_keys(set->specular));
}

ibl_status ibl_env_encode(ibl_ctx *ctx, const ibl_engine_set *set,
                          ibl_blob *main)
{
    const int levels = IBL_FACES * set->specular->levels;
    const int count = levels + IBL_FACES;
    ibl_blob faces[MAX_FACES + IBL_FACES] = {0};
    ibl_texel_options texels = ibl_texel_options_default();
    ibl_texture matte = {0};

    texels.pixel = IBL_PIXEL_RGBA32F;
    ibl_status status =
        ibl_texture_from_cube(ctx, set->irradiance, &texels, &matte, NULL);
    if (!status)
        status = ibl_rgbd_faces(ctx, set->specular, faces);
    if (!status)
        status = ibl_rgbd_faces(ctx, &matte, faces + levels);
    ibl_texture_free(&matte);
    bool ok = !status && ibl_blob_add(main, magic, sizeof magic) &&
              ibl_engine_put_json(manifest(set, faces), main) &&
              ibl_blob_add(main, "", 1);

    for (int i = 0; i < count; i++) {
        ok = ok && ibl_blob_add(main, faces[i].bytes, faces[i].size);
        ibl_blob_free(&faces[i]);
    }
    return ok ? IBL_OK : status ? status : ibl_no_memory(ctx, "an .env file");
}

/* ---- reading ---------------------------------------------------------- */

bool ibl_env_is(const unsigned char *bytes, size_t size)
{
    return size >= sizeof magic && !memcmp(bytes, magic, sizeof magic);
}

typedef struct reader {
    ibl_ctx *ctx;
    const char *name;
    const json_t *root;
    const unsigned char *images; /* what is behind the NUL */
    size_t size;
    ibl_blob faces[MAX_FACES]; /* not owned */
} reader;

static ibl_status wrong(const reader *r, const char *what)
{
    return ibl_fail(r->ctx, IBL_ERR_FORMAT, "%s: damaged: %s", r->name, what);
}

static ibl_status find_faces(reader *r, const json_t *list)
{
    size_t i;
    const json_t *image;

    json_array_foreach((json_t *)list, i, image)
    {
        const json_int_t at =
            json_integer_value(json_object_get(image, "position"));
        const json_int_t size =
            json_integer_value(json_object_get(image, "length"));
        if (at < 0 || size < 1 || (uint64_t)at > r->size ||
            (uint64_t)size > r->size - (uint64_t)at)
            return wrong(r, "an image lies beyond the end of the file");
        r->faces[i] = (ibl_blob){.bytes = (unsigned char *)r->images + at,
                                 .size = (size_t)size};
    }
    return IBL_OK;
}

/* Babylon's levels: alpha = 2^(level / scale) / width. */
static ibl_status set_roughness(const reader *r, double scale, ibl_texture *tex)
{
    double roughness[IBL_MAX_LEVELS] = {0};

    for (int l = 1; l < tex->levels; l++)
        roughness[l] = sqrt(fmin(exp2(l / scale) / tex->width, 1));
    return ibl_engine_set_roughness(r->ctx, roughness, tex);
}

static ibl_status read_set(reader *r, ibl_texture *tex)
{
    const json_t *specular = json_object_get(r->root, "specular");
    const json_t *mipmaps = json_object_get(specular, "mipmaps");
    const json_t *keys = json_object_get(r->root, "iblbake");
    const json_int_t width =
        json_integer_value(json_object_get(r->root, "width"));
    const char *type = json_string_value(json_object_get(r->root, "imageType"));
    double scale =
        json_number_value(json_object_get(specular, "lodGenerationScale"));
    int levels = 1;

    if (type && strcmp(type, "image/png") != 0)
        return ibl_fail(r->ctx, IBL_ERR_UNSUPPORTED,
                        "%s: images of type %.40s: only image/png is read",
                        r->name, type);
    if (width < 1 || width > IBL_MAX_CUBE_SIZE || (width & (width - 1)))
        return wrong(r, "its width is no power of two up to 16384");
    while (width >> levels)
        levels++;
    if (json_array_size(mipmaps) != (size_t)(IBL_FACES * levels))
        return wrong(r, "it has not six images for each level");
    /* Babylon's light on matte surfaces is there, but is not read. */
    const json_t *matte =
        json_object_get(json_object_get(json_object_get(r->root, "irradiance"),
                                        "irradianceTexture"),
                        "faces");
    if (matte && json_array_size(matte) != IBL_FACES)
        return wrong(r, "its irradianceTexture has not six images");
    ibl_status status = find_faces(r, matte);
    if (!status)
        status = find_faces(r, mipmaps);
    if (!status)
        status =
            ibl_rgbd_cube(r->ctx, r->name, (int)width, levels, r->faces, tex);
    if (!(scale > 0.01 && scale < 100))
        scale = usual_scale;
    if (!status)
        status = json_is_object(keys) ? ibl_engine_set_keys(r->ctx, keys, tex)
                                      : set_roughness(r, scale, tex);
    return status;
}

ibl_status ibl_env_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                          size_t size, ibl_texture *tex)
{
    const char *text = (const char *)bytes + sizeof magic;
    const size_t left = size - sizeof magic;
    const char *end = memchr(text, '\0', left < JSON_BYTES ? left : JSON_BYTES);
    reader r = {.ctx = ctx, .name = name};
    ibl_json_why why = {IBL_ERR_FORMAT, ""};

    json_t *root =
        end ? ibl_json_parse(name, text, (size_t)(end - text), 0, &why) : NULL;
    if (!root && why.status == IBL_ERR_MEMORY)
        return ibl_no_memory(ctx, name);
    if (!json_is_object(root)) {
        json_decref(root);
        return wrong(&r, "no JSON with a NUL behind it");
    }
    r.root = root;
    r.images = (const unsigned char *)end + 1;
    r.size = size - (size_t)(r.images - (const unsigned char *)bytes);
    const ibl_status status = read_set(&r, tex);
    json_decref(root);
    if (status)
        ibl_texture_free(tex);
    return status;
}
