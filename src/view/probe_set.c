/* SPDX-License-Identifier: MIT */
#include "view/probe_set.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "view/file_stamp.h"
#include "view/harmonics.h"
#include "view/message.h"
#include "view/probe_index.h"
#include "view/upload.h"

enum {
    SH_EDGE = 16,  /* of cubes that are made of harmonics */
    DECODED = 1024 /* texels at a time */
};

/* What a set is read from. */
enum {
    INDEX,
    SPECULAR,
    IRRADIANCE,
    FILES
};

struct view_probe_set {
    char *path;
    view_file_stamp read[FILES];
    view_probe_index index;
    view_room_locals locals;
};

/* ---- files that change ------------------------------------------------- */

/* NULL: there is none. */
static const char *file_of(const view_probe_set *set, int i)
{
    return i == INDEX      ? set->path
           : i == SPECULAR ? set->index.specular.path
                           : set->index.irradiance.path;
}

bool view_probe_set_changed(const view_probe_set *set, double settle)
{
    view_watched_file files[FILES];

    for (int i = 0; i < FILES; i++)
        files[i] =
            (view_watched_file){file_of(set, i), i == INDEX, &set->read[i]};
    return view_files_changed(files, FILES, settle, settle);
}

static void see(view_probe_set *set, int i)
{
    set->read[i] = view_file_stamp_of(file_of(set, i), NULL);
}

void view_probe_set_seen(view_probe_set *set)
{
    for (int i = 0; i < FILES; i++)
        see(set, i);
}

/* ---- arrays ------------------------------------------------------------ */

/* Whether a texture is what the index says of it. */
static bool check_shape(const view_probe_array *a, const ibl_texture *tex)
{
    if (tex->faces != IBL_FACES)
        return view_fail("%s: is flat, its index says %d cubes: bake the "
                         "probes again",
                         a->path, a->layers);
    if (tex->layers != a->layers)
        return view_fail("%s: has %d layers, its index says %d: bake the "
                         "probes again",
                         a->path, tex->layers, a->layers);
    if (tex->width != a->size || tex->levels != a->levels)
        return view_fail("%s: %d texels with levels: %d, its index says %d "
                         "with %d: bake the probes again",
                         a->path, tex->width, tex->levels, a->size, a->levels);
    if (tex->pixel != a->pixel)
        return view_fail("%s: holds %s, its index says %s: bake the probes "
                         "again",
                         a->path, ibl_pixel_name(tex->pixel),
                         ibl_pixel_name(a->pixel));
    return true;
}

/* Of those that have one; decoding leaves it out. */
static bool alpha_is_finite(ibl_pixel pixel, const unsigned char *texel)
{
    uint16_t half[4];
    float whole[4];

    if (pixel == IBL_PIXEL_RGBA16F) {
        memcpy(half, texel, sizeof half);
        return (half[3] & 0x7c00) != 0x7c00;
    }
    if (pixel == IBL_PIXEL_RGBA32F) {
        memcpy(whole, texel, sizeof whole);
        return isfinite(whole[3]);
    }
    return true;
}

/* A texel that is no finite number would spread over all that it lights. */
static bool check_texels(const char *path, const ibl_texture *tex)
{
    const size_t step = ibl_pixel_bytes(tex->pixel);
    const size_t count = tex->bytes / step;
    float rgb[3 * DECODED];

    for (size_t at = 0; at < count; at += DECODED) {
        const size_t n = count - at < DECODED ? count - at : DECODED;
        const unsigned char *from = tex->data + at * step;
        ibl_pixel_decode(tex->pixel, from, n, rgb);
        for (size_t i = 0; i < n; i++)
            if (!isfinite(rgb[3 * i]) || !isfinite(rgb[3 * i + 1]) ||
                !isfinite(rgb[3 * i + 2]) ||
                !alpha_is_finite(tex->pixel, from + i * step))
                return view_fail("%s: texel %zu is no finite number: bake the "
                                 "probes again",
                                 path, at + i);
    }
    return true;
}

static GLuint load_array(ibl_ctx *ctx, const view_probe_array *a)
{
    ibl_texture tex = {0};
    GLuint cubes = 0;

    if (ibl_texture_read(ctx, a->path, &tex, NULL))
        return 0;
    if (check_shape(a, &tex) && check_texels(a->path, &tex))
        cubes = view_upload_cubes(&tex, a->path);
    ibl_texture_free(&tex);
    return cubes;
}

/* ---- spherical harmonics ----------------------------------------------- */

/* A sum may be a little below 0 where it is dark, that of alpha above 1. */
static void fill_cube(const double sh[4 * VIEW_PROBE_SH], float *rgba)
{
    double d[3], y[VIEW_SH_COUNT];

    for (int at = 0; at < IBL_FACES * SH_EDGE * SH_EDGE; at++, rgba += 4) {
        const int face = at / (SH_EDGE * SH_EDGE);
        ibl_cube_direction(SH_EDGE, face, at % SH_EDGE, at / SH_EDGE % SH_EDGE,
                           d);
        view_harmonics(d, y);
        for (int c = 0; c < 4; c++) {
            double sum = 0;
            for (int i = 0; i < VIEW_PROBE_SH; i++)
                sum += sh[4 * i + c] * y[i];
            rgba[c] = (float)fmax(sum, 0);
        }
        rgba[3] = fminf(rgba[3], 1);
    }
}

/* Layers as those of the specular array; one that no probe has stays black. */
static GLuint make_irradiance(const view_probe_index *x, const char *name)
{
    const size_t floats = (size_t)4 * IBL_FACES * SH_EDGE * SH_EDGE;
    ibl_texture tex = {.pixel = IBL_PIXEL_RGBA32F,
                       .width = SH_EDGE,
                       .height = SH_EDGE,
                       .levels = 1,
                       .layers = x->specular.layers,
                       .faces = IBL_FACES};
    float *texels = calloc((size_t)tex.layers, floats * sizeof *texels);
    GLuint cubes;

    if (!texels) {
        view_fail("%s: no memory for irradiance of %d probes", name, x->count);
        return 0;
    }
    for (int i = 0; i < x->count; i++)
        fill_cube(x->sh[i], texels + floats * (size_t)x->probe[i].layer);
    tex.data = (unsigned char *)texels;
    tex.bytes = (size_t)tex.layers * floats * sizeof *texels;
    cubes = view_upload_cubes(&tex, name);
    free(texels);
    return cubes;
}

/* ---- the set ----------------------------------------------------------- */

static bool load(ibl_ctx *ctx, view_probe_set *set)
{
    view_probe_index *x = &set->index;
    view_room_locals *l = &set->locals;

    if (!view_gl_has_cube_arrays())
        return view_fail("%s: needs cube map arrays: OpenGL 4.0, or "
                         "ARB_texture_cube_map_array",
                         set->path);
    see(set, INDEX);
    if (!view_probe_index_read(set->path, x))
        return false;
    see(set, SPECULAR);
    see(set, IRRADIANCE);
    *l = (view_room_locals){.count = x->count,
                            .probe = x->probe,
                            .filament = x->mapping == IBL_ROUGHNESS_FILAMENT,
                            .lod_scale = (float)x->lod_scale,
                            .lod_offset = (float)x->lod_offset,
                            .last_level = (float)(x->specular.levels - 1),
                            .irradiance_scale = (float)x->irradiance_scale};
    l->specular = load_array(ctx, &x->specular);
    if (l->specular)
        l->irradiance = x->irradiance.path ? load_array(ctx, &x->irradiance)
                                           : make_irradiance(x, set->path);
    gl.BindTexture(GL_TEXTURE_CUBE_MAP_ARRAY, 0);
    return l->irradiance;
}

view_probe_set *view_probe_set_load(ibl_ctx *ctx, const char *index)
{
    view_probe_set *set = calloc(1, sizeof *set);

    if (set)
        set->path = strdup(index);
    if (!set || !set->path)
        view_fail("%s: no memory for its name", index);
    else if (load(ctx, set))
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
    view_probe_index_free(&set->index);
    free(set->path);
    free(set);
}

const view_room_locals *view_probe_set_locals(const view_probe_set *set)
{
    return &set->locals;
}

bool view_probe_set_holes(const view_probe_set *set)
{
    return set->index.holes;
}

const char *view_probe_set_path(const view_probe_set *set)
{
    return set->path;
}
