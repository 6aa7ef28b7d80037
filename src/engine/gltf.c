/* SPDX-License-Identifier: MIT */
/*
 * glTF 2.0 with EXT_lights_image_based: levels of linear roughness, each face a
 * PNG of RGBD. Rows are from the bottom, as Babylon's loader has them.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/path.h"
#include "core/context.h"
#include "engine/engine.h"
#include "engine/rgbd.h"
#include "engine/set.h"
#include "io/input.h"
#include "json/json_load.h"

static const char extension[] = "EXT_lights_image_based";

enum {
    MAX_FACES = IBL_FACES * IBL_MAX_LEVELS
};

/* A name as a URI: bytes other than letters, digits and -._~ as %XX. */
static json_t *uri(const char *stem, int index)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRST"
                                "UVWXYZ0123456789-._~";
    char *name = ibl_engine_face_name(stem, index);
    char *text = name ? malloc(3 * strlen(name) + 1) : NULL;
    char *to = text;

    for (const char *at = name; text && *at; at++)
        if (strchr(plain, *at))
            *to++ = *at;
        else
            to += sprintf(to, "%%%02X", (unsigned char)*at);
    json_t *j = text ? json_stringn(text, (size_t)(to - text)) : NULL;
    free(name);
    free(text);
    return j;
}

static json_t *light(const ibl_engine_set *set)
{
    double c[IBL_SH_NINE][3];
    json_t *levels = json_array();

    ibl_sh_gltf(set->sh, c);
    for (int l = 0; l < set->specular->levels; l++) {
        json_t *level = json_array();
        for (int face = 0; face < IBL_FACES; face++)
            append(&level, json_integer(IBL_FACES * l + face));
        append(&levels, level);
    }
    return json_pack("{sf s[ffff] so si so}", "intensity", 1.0, "rotation", 0.0,
                     0.0, 0.0, 1.0, "irradianceCoefficients",
                     ibl_engine_triples((const double(*)[3])c, IBL_SH_NINE),
                     "specularImageSize", set->specular->width,
                     "specularImages", levels);
}

static json_t *document(const ibl_engine_set *set)
{
    json_t *images = json_array();

    for (int i = 0; i < IBL_FACES * set->specular->levels; i++)
        append(&images, json_pack("{so ss}", "uri", uri(set->stem, i),
                                  "mimeType", "image/png"));
    return json_pack(
        "{s{ss ss so} s[s] s{s{s[o]}} so si s[{s{s{si}}}]}", "asset", "version",
        "2.0", "generator", "iblbake " IBL_VERSION, "extras",
        ibl_engine_keys(set->specular), "extensionsUsed", extension,
        "extensions", extension, "lights", light(set), "images", images,
        "scene", 0, "scenes", "extensions", extension, "light", 0);
}

ibl_status ibl_gltf_encode(ibl_ctx *ctx, const ibl_engine_set *set,
                           ibl_blob *main, ibl_blob *faces)
{
    const ibl_status status = ibl_rgbd_faces(ctx, set->specular, faces);

    if (status)
        return status;
    return ibl_engine_put_json(document(set), main) &&
                   ibl_blob_add(main, "\n", 1)
               ? IBL_OK
               : ibl_no_memory(ctx, "a .gltf file");
}

/* ---- reading ---------------------------------------------------------- */

typedef struct reader {
    ibl_ctx *ctx;
    const char *name;
    const json_t *root, *light;
    int size, levels;
    ibl_input input[MAX_FACES];
    int opened;
} reader;

static ibl_status wrong(const reader *r, ibl_status status, const char *what)
{
    return ibl_fail(r->ctx, status, "%s: %s", r->name, what);
}

/* Reads the file of an image into memory. */
static ibl_status open_image(reader *r, const json_t *index)
{
    const json_t *images = json_object_get(r->root, "images");
    const json_t *image =
        json_is_integer(index) && json_integer_value(index) >= 0
            ? json_array_get(images, (size_t)json_integer_value(index))
            : NULL;
    const char *text = json_string_value(json_object_get(image, "uri"));

    if (!image)
        return wrong(r, IBL_ERR_FORMAT, "damaged: it has no such image");
    if (!text || strchr(text, ':'))
        return wrong(r, IBL_ERR_UNSUPPORTED,
                     "only images in files beside it are read");
    char *name = strdup(text);
    char *path =
        name && ibl_uri_decode(name) ? ibl_path_beside(r->name, name) : NULL;
    ibl_input *in = &r->input[r->opened];
    ibl_status status =
        path ? ibl_input_open(r->ctx, path, in)
             : wrong(r, IBL_ERR_FORMAT, "damaged: an image has no name");
    if (path && !status) {
        r->opened++;
        status = ibl_input_load(in);
    }
    free(name);
    free(path);
    return status;
}

/* Finds the light of the first scene that has one, else the first. */
static const json_t *find_light(const json_t *root)
{
    const json_t *lights = json_object_get(
        json_object_get(json_object_get(root, "extensions"), extension),
        "lights");
    const json_t *scene;
    size_t i, index = 0;

    json_array_foreach(json_object_get(root, "scenes"), i, scene)
    {
        const json_t *chosen = json_object_get(
            json_object_get(json_object_get(scene, "extensions"), extension),
            "light");
        if (json_is_integer(chosen) && json_integer_value(chosen) >= 0) {
            index = (size_t)json_integer_value(chosen);
            break;
        }
    }
    return json_array_get(lights, index);
}

static bool is_turned(const json_t *rotation)
{
    for (size_t i = 0; i < 3; i++)
        if (json_number_value(json_array_get(rotation, i)) < -1e-6 ||
            json_number_value(json_array_get(rotation, i)) > 1e-6)
            return true;
    return false;
}

static ibl_status find_shape(reader *r)
{
    const json_t *levels = json_object_get(r->light, "specularImages");
    const json_int_t size =
        json_integer_value(json_object_get(r->light, "specularImageSize"));

    if (!json_is_object(r->light))
        return wrong(r, IBL_ERR_FORMAT,
                     "no texture: JSON without a light of "
                     "EXT_lights_image_based");
    if (is_turned(json_object_get(r->light, "rotation")))
        return wrong(r, IBL_ERR_UNSUPPORTED, "a light with a rotation");
    if (size < 1 || size > IBL_MAX_CUBE_SIZE || json_array_size(levels) < 1 ||
        json_array_size(levels) > IBL_MAX_LEVELS ||
        !(size >> (json_array_size(levels) - 1)))
        return wrong(r, IBL_ERR_FORMAT,
                     "damaged: its levels do not fit its specularImageSize");
    r->size = (int)size;
    r->levels = (int)json_array_size(levels);
    return IBL_OK;
}

static ibl_status open_images(reader *r)
{
    const json_t *levels = json_object_get(r->light, "specularImages");
    ibl_status status = IBL_OK;

    for (int i = 0; i < IBL_FACES * r->levels && !status; i++) {
        const json_t *level = json_array_get(levels, (size_t)i / IBL_FACES);
        if (json_array_size(level) != IBL_FACES)
            return wrong(r, IBL_ERR_FORMAT,
                         "damaged: a level has not six images");
        status = open_image(r, json_array_get(level, (size_t)i % IBL_FACES));
    }
    return status;
}

static void brighten(ibl_texture *tex, double intensity)
{
    float *texels = (float *)(void *)tex->data;

    for (size_t i = 0; i < tex->bytes / sizeof *texels; i++)
        if (i % 4 < 3)
            texels[i] = (float)(texels[i] * intensity);
}

static ibl_status set_keys(const reader *r, ibl_texture *tex)
{
    const json_t *extras =
        json_object_get(json_object_get(r->root, "asset"), "extras");
    double roughness[IBL_MAX_LEVELS] = {0};

    if (json_object_get(extras, "iblbake.content"))
        return ibl_engine_set_keys(r->ctx, extras, tex);
    for (int l = 1; l < tex->levels; l++)
        roughness[l] = (double)l / (tex->levels - 1);
    return ibl_engine_set_roughness(r->ctx, roughness, tex);
}

static ibl_status read_set(reader *r, ibl_texture *tex)
{
    const json_t *intensity = json_object_get(r->light, "intensity");
    ibl_blob faces[MAX_FACES];
    ibl_status status = open_images(r);

    for (int i = 0; i < r->opened; i++)
        faces[i] = (ibl_blob){.bytes = (unsigned char *)r->input[i].bytes,
                              .size = r->input[i].size};
    if (!status)
        status = ibl_rgbd_cube(r->ctx, r->name, r->size, r->levels, faces, tex);
    if (status)
        return status;
    if (json_is_number(intensity) && json_number_value(intensity) != 1.0)
        brighten(tex, json_number_value(intensity));
    return set_keys(r, tex);
}

bool ibl_gltf_is_light(const char *path)
{
    ibl_json_why why;
    json_t *root = ibl_json_load(path, 0, &why);
    const bool is =
        json_is_object(find_light(root)) && !json_object_get(root, "meshes");

    json_decref(root);
    return is;
}

ibl_status ibl_gltf_decode(ibl_ctx *ctx, const char *name,
                           const unsigned char *bytes, size_t size,
                           ibl_texture *tex)
{
    ibl_json_why why;
    json_t *root = ibl_json_parse(name, bytes, size, 0, &why);
    reader r = {.ctx = ctx, .name = name, .root = root};

    if (!root && why.status == IBL_ERR_MEMORY)
        return ibl_no_memory(ctx, name);
    r.light = find_light(root);
    ibl_status status = find_shape(&r);
    if (!status)
        status = read_set(&r, tex);
    for (int i = 0; i < r.opened; i++)
        ibl_input_close(&r.input[i]);
    json_decref(root);
    if (status)
        ibl_texture_free(tex);
    return status;
}
