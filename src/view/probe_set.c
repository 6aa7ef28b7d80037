/* SPDX-License-Identifier: MIT */
#include "view/probe_set.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/path.h"
#include "common/signals.h"
#include "view/file_stamp.h"
#include "view/message.h"
#include "view/upload.h"
#include "view/vector.h"

enum {
    SH_EDGE = 16,  /* edge of cubes made from harmonics */
    DECODED = 1024 /* texels decoded at a time */
};

/* The files of a set: the index, and its arrays. */
enum {
    INDEX,
    ARRAYS,
    SPECULAR = ARRAYS,
    IRRADIANCE,
    FILES
};

struct view_probe_set {
    char *paths[FILES]; /* NULL: no such file */
    view_file_stamp read[FILES];
    ibl_probe_index index;
    ibl_texture light; /* cubes from the index's harmonics; data NULL: none */
    view_probe_maps locals;
};

/* ---- changed files ----------------------------------------------------- */

bool view_probe_set_changed(const view_probe_set *set, double settle)
{
    return view_files_changed(set->paths, FILES, set->read, settle, settle);
}

void view_probe_set_seen(view_probe_set *set)
{
    view_files_see(set->paths, FILES, set->read);
}

/* ---- index ------------------------------------------------------------- */

/* Cubes of the harmonics. Sums overshoot: a little below 0 in the dark, alpha
 * above 1. A layer without a probe stays black. */
static void make_light(view_probe_set *set)
{
    const int layers = set->index.specular.layers;
    const int floats = 4 * IBL_FACES * SH_EDGE * SH_EDGE;
    ibl_texture *light = &set->light;

    *light = (ibl_texture){.pixel = IBL_PIXEL_RGBA32F,
                           .width = SH_EDGE,
                           .height = SH_EDGE,
                           .levels = 1,
                           .layers = layers,
                           .faces = IBL_FACES,
                           .bytes = (size_t)floats * layers * sizeof(float)};
    light->data = ibl_need(malloc(light->bytes));
    float *texels = (float *)light->data;
    for (int i = 0; i < layers; i++, texels += floats) {
        view_harmonics_cube(set->index.sh[i], IBL_PROBE_SH, 4, SH_EDGE, texels);
        for (int k = 3; k < floats; k += 4)
            texels[k] = fminf(texels[k], 1);
    }
}

static void name_file(view_probe_set *set, int i, const char *name)
{
    if (name)
        set->paths[i] = ibl_need(ibl_path_beside(set->paths[INDEX], name));
}

static bool read_index(ibl_ctx *ctx, view_probe_set *set)
{
    ibl_probe_index *x = &set->index;

    if (ibl_probe_index_read(ctx, set->paths[INDEX], x))
        return false;
    name_file(set, SPECULAR, x->specular.name);
    name_file(set, IRRADIANCE, x->irradiance.name);
    set->locals =
        (view_probe_maps){.count = x->count,
                          .probe = x->probe,
                          .holes = x->holes,
                          .filament = x->mapping == IBL_ROUGHNESS_FILAMENT,
                          .lod_scale = (float)x->lod_scale,
                          .lod_offset = (float)x->lod_offset,
                          .last_level = (float)(x->specular.levels - 1),
                          .irradiance_scale = (float)x->irradiance_scale};
    if (x->sh)
        make_light(set);
    return true;
}

/* ---- arrays ------------------------------------------------------------ */

/* Checks that a texture matches the index. */
static bool check_shape(const char *path, const ibl_probe_file *expected,
                        const ibl_texture *tex)
{
    if (tex->faces != IBL_FACES)
        return view_fail("%s: is flat, its index says %d cubes: bake the "
                         "probes again",
                         path, expected->layers);
    if (tex->layers != expected->layers)
        return view_fail("%s: has %d layers, its index says %d: bake the "
                         "probes again",
                         path, tex->layers, expected->layers);
    if (tex->width != expected->size || tex->levels != expected->levels)
        return view_fail("%s: %d texels with levels: %d, its index says %d "
                         "with %d: bake the probes again",
                         path, tex->width, tex->levels, expected->size,
                         expected->levels);
    return tex->pixel == expected->pixel ||
           view_fail("%s: holds %s, its index says %s: bake the probes again",
                     path, ibl_pixel_name(tex->pixel),
                     ibl_pixel_name(expected->pixel));
}

/* A texel that is not finite would spread to everything that it lights.
 * Decoding drops alpha: RGBA is read as two texels of RG. */
static bool check_texels(const char *path, const ibl_texture *tex)
{
    const ibl_pixel pixel = tex->pixel == IBL_PIXEL_RGBA16F   ? IBL_PIXEL_RG16F
                            : tex->pixel == IBL_PIXEL_RGBA32F ? IBL_PIXEL_RG32F
                                                              : tex->pixel;
    const size_t step = ibl_pixel_bytes(pixel), count = tex->bytes / step;
    const size_t channels = (size_t)ibl_pixel_channels(pixel);
    float values[3 * DECODED];

    for (size_t at = 0; at < count; at += DECODED) {
        const size_t n = count - at < DECODED ? count - at : DECODED;
        ibl_pixel_decode(pixel, tex->data + at * step, n, values);
        for (size_t i = 0; i < n * channels; i++)
            if (!isfinite(values[i]))
                return view_fail("%s: texel %zu is no finite number: bake the "
                                 "probes again",
                                 path,
                                 (at + i / channels) * step /
                                     ibl_pixel_bytes(tex->pixel));
    }
    return true;
}

static GLuint load_array(ibl_ctx *ctx, const char *path,
                         const ibl_probe_file *expected)
{
    ibl_texture tex = {0};
    GLuint cubes = 0;

    if (ibl_texture_read(ctx, path, &tex, NULL))
        return 0;
    if (check_shape(path, expected, &tex) && !ibl_texture_unblock(ctx, &tex) &&
        check_texels(path, &tex))
        cubes = view_upload(&tex, true, path);
    ibl_texture_free(&tex);
    return cubes;
}

/* ---- load and free ----------------------------------------------------- */

static bool load(ibl_ctx *ctx, view_probe_set *set)
{
    const ibl_probe_index *x = &set->index;
    view_probe_maps *l = &set->locals;
    char **paths = set->paths;

    if (!view_gl_has_cube_arrays())
        return view_fail("%s: needs cube map arrays: OpenGL 4.0, or "
                         "ARB_texture_cube_map_array",
                         paths[INDEX]);
    view_files_see(paths, 1, set->read);
    if (!read_index(ctx, set))
        return false;
    view_files_see(paths + 1, FILES - 1, set->read + 1);
    l->specular = load_array(ctx, paths[SPECULAR], &x->specular);
    if (l->specular && set->light.data)
        l->irradiance = view_upload(&set->light, true, paths[INDEX]);
    else if (l->specular)
        l->irradiance = load_array(ctx, paths[IRRADIANCE], &x->irradiance);
    free(set->light.data);
    set->light.data = NULL;
    gl.BindTexture(GL_TEXTURE_CUBE_MAP_ARRAY, 0);
    return l->irradiance;
}

view_probe_set *view_probe_set_load(ibl_ctx *ctx, const char *index)
{
    view_probe_set *set = ibl_need(calloc(1, sizeof *set));

    set->paths[INDEX] = ibl_need(strdup(index));
    if (load(ctx, set))
        return set;
    view_probe_set_free(set);
    return NULL;
}

void view_probe_set_free(view_probe_set *set)
{
    if (!set)
        return;
    gl.DeleteTextures(1, &set->locals.irradiance);
    gl.DeleteTextures(1, &set->locals.specular);
    free(set->light.data);
    ibl_probe_index_free(&set->index);
    for (int i = 0; i < FILES; i++)
        free(set->paths[i]);
    free(set);
}

const view_probe_maps *view_probe_set_locals(const view_probe_set *set)
{
    return &set->locals;
}
