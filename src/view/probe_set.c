/* SPDX-License-Identifier: MIT */
#include "view/probe_set.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "common/json_at.h"
#include "common/names.h"
#include "common/path.h"
#include "view/file_stamp.h"
#include "view/harmonics.h"
#include "view/message.h"
#include "view/upload.h"

enum {
    VERSION = 1,
    INDEX_SH = 9,  /* coefficients of irradiance in an index */
    SH_EDGE = 16,  /* of cubes that are made of harmonics */
    DECODED = 1024 /* texels at a time */
};

/* More than a bake can hold as irradiance. */
static const double brightest = 1e30;

/* What a set is read from. */
enum {
    INDEX,
    SPECULAR,
    IRRADIANCE,
    FILES
};

/* What an index says of an array. */
typedef struct probe_array {
    char *path; /* NULL: there is none */
    ibl_pixel pixel;
    int size, levels, layers;
} probe_array;

typedef struct probe_index {
    int count;
    ibl_probe *probe; /* in the order of ibl_probes_order, with their layers */
    bool holes;       /* of some there are directions that have not been seen */
    probe_array specular, irradiance;
    ibl_roughness_map mapping;
    double lod_scale, lod_offset;
    double irradiance_scale; /* times the map, or sh, is E / pi */
    /* Without an irradiance array: INDEX_SH coefficients, RGBA, of each
     * probe. */
    double (*sh)[4 * INDEX_SH];
} probe_index;

struct view_probe_set {
    char *path;
    view_file_stamp read[FILES];
    probe_index index;
    view_probe_maps locals;
};

/* ---- files that change ------------------------------------------------- */

static void list_files(const view_probe_set *set, char *paths[FILES])
{
    paths[INDEX] = set->path;
    paths[SPECULAR] = set->index.specular.path;
    paths[IRRADIANCE] = set->index.irradiance.path;
}

bool view_probe_set_changed(const view_probe_set *set, double settle)
{
    char *paths[FILES];

    list_files(set, paths);
    return view_files_changed(paths, FILES, set->read, settle, settle);
}

void view_probe_set_seen(view_probe_set *set)
{
    char *paths[FILES];

    list_files(set, paths);
    view_files_see(paths, FILES, set->read);
}

/* ---- index ------------------------------------------------------------- */

static bool take_probe(ibl_json_at at, int layers, ibl_probe *p)
{
    const ibl_json_at proxy = ibl_json_optional(&at, "proxy");

    p->has_proxy = proxy.value != NULL;
    return ibl_json_int(ibl_json_member(&at, "layer"), 0, layers - 1,
                        &p->layer) &&
           ibl_json_int(ibl_json_member(&at, "priority"), -1000000, 1000000,
                        &p->priority) &&
           ibl_json_place(ibl_json_member(&at, "position"), p->position) &&
           ibl_json_volume(ibl_json_member(&at, "influence"), &p->influence) &&
           ibl_json_real(ibl_json_member(&at, "blend"), 0, IBL_JSON_FARTHEST,
                         false, &p->blend) &&
           ibl_json_volume(proxy, &p->proxy);
}

/* Probes that have seen everything have no harmonics of alpha. */
static bool take_sh(ibl_json_at at, double sh[4 * INDEX_SH])
{
    static const double constant = 3.5449077018110318; /* sqrt(4 pi): of 1 */
    const ibl_json_at all = ibl_json_member(&at, "sh");
    const ibl_json_at alphas = ibl_json_optional(&at, "alpha_sh");

    if (!ibl_json_array(all, INDEX_SH, INDEX_SH) ||
        !ibl_json_array(alphas, INDEX_SH, INDEX_SH))
        return false;
    for (size_t i = 0; i < INDEX_SH; i++) {
        double *to = &sh[4 * i];
        to[3] = i ? 0 : constant;
        if (!ibl_json_triple(ibl_json_element(&all, i), -brightest, brightest,
                             false, to) ||
            (alphas.value && !ibl_json_real(ibl_json_element(&alphas, i), -100,
                                            100, false, &to[3])))
            return false;
    }
    return true;
}

/* Programs write probes in their order; an edited index may have lost it. */
static bool sort(const char *path, probe_index *x)
{
    const size_t count = (size_t)x->count;
    ibl_probe *from = calloc(count, sizeof *from);
    double(*sh)[4 * INDEX_SH] = calloc(count, sizeof *sh);
    int *order = calloc(count, sizeof *order);
    const bool ok = from && sh && order;

    if (ok) {
        memcpy(from, x->probe, count * sizeof *from);
        memcpy(sh, x->sh, count * sizeof *sh);
        ibl_probes_order(from, x->count, order);
    } else {
        view_fail("%s: no memory for its probes", path);
    }
    for (size_t i = 0; i < count && ok; i++) {
        x->probe[i] = from[order[i]];
        memcpy(x->sh[i], sh[order[i]], sizeof *sh);
    }
    free(order);
    free(sh);
    free(from);
    return ok;
}

/* Older indices do not have it. */
static bool take_alpha(ibl_json_at at, probe_index *x)
{
    const ibl_json_at alpha = ibl_json_optional(&at, "alpha");

    x->holes |= json_is_true(alpha.value);
    return json_is_boolean(alpha.value) ||
           ibl_json_wrong(alpha, "true or false");
}

static bool take_probes(ibl_json_at root, probe_index *x)
{
    const ibl_json_at probes = ibl_json_member(&root, "probes");
    const size_t count = json_array_size(probes.value);

    if (json_is_array(probes.value) && count > IBL_MAX_TILE_PROBES)
        return ibl_json_wrong(probes,
                              "at most %d probes, which is what is drawn with",
                              IBL_MAX_TILE_PROBES);
    if (!ibl_json_array(probes, 1, IBL_MAX_TILE_PROBES))
        return false;
    x->probe = calloc(count, sizeof *x->probe);
    x->sh = calloc(count, sizeof *x->sh);
    if (!x->probe || !x->sh)
        return view_fail("%s: no memory for its probes", root.file->name);
    for (size_t i = 0; i < count; i++) {
        const ibl_json_at at = ibl_json_element(&probes, i);
        if (!take_probe(at, x->specular.layers, &x->probe[i]) ||
            !take_alpha(at, x) ||
            (!x->irradiance.path && !take_sh(at, x->sh[i])))
            return false;
    }
    x->count = (int)count;
    return sort(root.file->name, x);
}

static bool take_array(ibl_json_at at, probe_array *a)
{
    const ibl_json_at file = ibl_json_member(&at, "file");
    const char *name;
    int choice;

    if (!ibl_json_text_at(file, &name))
        return false;
    /* A name, never a way to somewhere else. */
    if (strchr(name, '/'))
        return ibl_json_wrong(file, "the name of a file beside the index");
    if (!ibl_json_choice(ibl_json_member(&at, "pixel"), ibl_pixel_names,
                         &choice) ||
        !ibl_json_int(ibl_json_member(&at, "size"), 1, IBL_MAX_CUBE_SIZE,
                      &a->size) ||
        !ibl_json_int(ibl_json_member(&at, "levels"), 1, IBL_MAX_LEVELS,
                      &a->levels) ||
        !ibl_json_int(ibl_json_member(&at, "layers"), 1, IBL_MAX_LAYERS,
                      &a->layers))
        return false;
    a->pixel = (ibl_pixel)choice;
    a->path = ibl_path_beside(at.file->name, name);
    return a->path || view_fail("%s: no memory for names in it", at.file->name);
}

static bool take_arrays(ibl_json_at root, probe_index *x)
{
    static const char *const kinds[] = {"cube", "sh", NULL};
    const ibl_json_at files = ibl_json_member(&root, "files");
    const ibl_json_at irradiance = ibl_json_member(&files, "irradiance");
    const ibl_json_at about = ibl_json_member(&root, "irradiance");
    int choice;

    if (!take_array(ibl_json_member(&files, "specular"), &x->specular) ||
        !ibl_json_choice(ibl_json_member(&about, "kind"), kinds, &choice))
        return false;
    if (choice == 1)
        return true;
    if (!take_array(irradiance, &x->irradiance))
        return false;
    return x->irradiance.layers == x->specular.layers ||
           ibl_json_wrong(ibl_json_member(&irradiance, "layers"),
                          "%d, as many as files.specular has",
                          x->specular.layers);
}

static bool take_lookups(ibl_json_at root, probe_index *x)
{
    static const char *const scales[] = {"E/pi", "E", NULL};
    const ibl_json_at specular = ibl_json_member(&root, "specular");
    const ibl_json_at irradiance = ibl_json_member(&root, "irradiance");
    int map, choice;

    if (!ibl_json_choice(ibl_json_member(&specular, "mapping"),
                         ibl_mapping_names, &map) ||
        !ibl_json_real(ibl_json_member(&specular, "lod_scale"), 0, 1e6, false,
                       &x->lod_scale) ||
        !ibl_json_real(ibl_json_member(&specular, "lod_offset"), -1e6, 1e6,
                       false, &x->lod_offset) ||
        !ibl_json_choice(ibl_json_member(&irradiance, "scale"), scales,
                         &choice))
        return false;
    x->mapping = map ? IBL_ROUGHNESS_FILAMENT : IBL_ROUGHNESS_LINEAR;
    x->irradiance_scale = choice ? 1 / M_PI : 1;
    return true;
}

static bool take_index(ibl_json_at root, probe_index *x)
{
    const ibl_json_at version = ibl_json_member(&root, "version");
    int number;

    if (!json_is_object(root.value))
        return ibl_json_wrong(root, "an object, the index of baked probes");
    if (json_is_integer(version.value) &&
        json_object_get(root.value, "probes") &&
        !json_object_get(root.value, "files"))
        return view_fail("%s: is a set to bake, not the index of one: run "
                         "iblbake probes, and give its index.json",
                         root.file->name);
    return ibl_json_int(version, VERSION, VERSION, &number) &&
           take_arrays(root, x) && take_lookups(root, x) &&
           take_probes(root, x);
}

static void fail(void *cookie, const char *text)
{
    (void)cookie;
    view_fail("%s", text);
}

static void free_index(probe_index *index)
{
    free(index->sh);
    free(index->irradiance.path);
    free(index->specular.path);
    free(index->probe);
    *index = (probe_index){0};
}

/* False, with a message, and *index zeroed. */
static bool read_index(const char *path, probe_index *index)
{
    ibl_json_file file = {.name = path, .fail = fail};

    *index = (probe_index){0};
    if (!ibl_json_open(&file))
        return false;
    const bool ok = take_index(ibl_json_root(&file), index);
    json_decref(file.root);
    if (!ok)
        free_index(index);
    return ok;
}

/* ---- arrays ------------------------------------------------------------ */

/* Whether a texture is what the index says of it. */
static bool check_shape(const probe_array *a, const ibl_texture *tex)
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

static GLuint load_array(ibl_ctx *ctx, const probe_array *a)
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
static void fill_cube(const double sh[4 * INDEX_SH], float *rgba)
{
    view_harmonics_cube(sh, INDEX_SH, 4, SH_EDGE, rgba);
    for (int i = 0; i < IBL_FACES * SH_EDGE * SH_EDGE; i++)
        rgba[4 * i + 3] = fminf(rgba[4 * i + 3], 1);
}

static GLuint make_irradiance(const probe_index *x, const char *name)
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
    probe_index *x = &set->index;
    view_probe_maps *l = &set->locals;

    if (!view_gl_has_cube_arrays())
        return view_fail("%s: needs cube map arrays: OpenGL 4.0, or "
                         "ARB_texture_cube_map_array",
                         set->path);
    view_files_see(&set->path, 1, &set->read[INDEX]);
    if (!read_index(set->path, x))
        return false;
    view_files_see(&x->specular.path, 1, &set->read[SPECULAR]);
    view_files_see(&x->irradiance.path, 1, &set->read[IRRADIANCE]);
    *l = (view_probe_maps){.count = x->count,
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
    free_index(&set->index);
    free(set->path);
    free(set);
}

const view_probe_maps *view_probe_set_locals(const view_probe_set *set)
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
