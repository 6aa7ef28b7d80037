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
#include "view/message.h"
#include "view/upload.h"
#include "view/vector.h"

enum {
    VERSION = 1,
    INDEX_SH = 9,  /* coefficients of irradiance in an index */
    SH_EDGE = 16,  /* edge of cubes made from harmonics */
    DECODED = 1024 /* texels decoded at a time */
};

/* Bound for coefficients: more than a bake can hold as irradiance. */
static const double most_irradiance = 1e30;

/* The files of a set. */
enum {
    INDEX,
    SPECULAR,
    IRRADIANCE,
    FILES
};

struct view_probe_set {
    char *paths[FILES]; /* NULL: no such file */
    view_file_stamp read[FILES];
    ibl_texture shape[FILES];          /* as in the index, without data */
    ibl_probe probe[VIEW_ROOM_PROBES]; /* as in locals */
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

/* Probes without holes have no harmonics of alpha. */
static bool take_sh(ibl_json_at at, double sh[4 * INDEX_SH])
{
    static const double constant = 3.5449077018110318; /* sqrt(4 pi), for 1 */
    const ibl_json_at all = ibl_json_member(&at, "sh");
    const ibl_json_at alphas = ibl_json_optional(&at, "alpha_sh");

    if (!ibl_json_array(all, INDEX_SH, INDEX_SH) ||
        !ibl_json_array(alphas, INDEX_SH, INDEX_SH))
        return false;
    for (size_t i = 0; i < INDEX_SH; i++) {
        double *to = &sh[4 * i];
        to[3] = i ? 0 : constant;
        if (!ibl_json_triple(ibl_json_element(&all, i), -most_irradiance,
                             most_irradiance, false, to) ||
            (alphas.value && !ibl_json_real(ibl_json_element(&alphas, i), -100,
                                            100, false, &to[3])))
            return false;
    }
    return true;
}

/* Sums overshoot: a little below 0 in the dark, alpha above 1. */
static bool take_light(ibl_json_at at, const ibl_texture *light, int layer)
{
    const int floats = 4 * IBL_FACES * SH_EDGE * SH_EDGE;
    float *texels = (float *)light->data + (size_t)floats * (size_t)layer;
    double sh[4 * INDEX_SH];

    if (!take_sh(at, sh))
        return false;
    view_harmonics_cube(sh, INDEX_SH, 4, SH_EDGE, texels);
    for (int i = 3; i < floats; i += 4)
        texels[i] = fminf(texels[i], 1);
    return true;
}

/* The member alpha: whether the probe has holes. Older indices lack it. */
static bool take_probe(ibl_json_at at, view_probe_set *set, ibl_probe *p)
{
    const ibl_json_at proxy = ibl_json_optional(&at, "proxy");
    const ibl_json_at alpha = ibl_json_optional(&at, "alpha");

    p->has_proxy = proxy.value != NULL;
    set->locals.holes |= json_is_true(alpha.value);
    return ibl_json_int(ibl_json_member(&at, "layer"), 0,
                        set->shape[SPECULAR].layers - 1, &p->layer) &&
           ibl_json_int(ibl_json_member(&at, "priority"), -1000000, 1000000,
                        &p->priority) &&
           ibl_json_place(ibl_json_member(&at, "position"), p->position) &&
           ibl_json_volume(ibl_json_member(&at, "influence"), &p->influence) &&
           ibl_json_real(ibl_json_member(&at, "blend"), 0, IBL_JSON_FARTHEST,
                         false, &p->blend) &&
           ibl_json_volume(proxy, &p->proxy) &&
           (json_is_boolean(alpha.value) ||
            ibl_json_wrong(alpha, "true or false")) &&
           (!set->light.data || take_light(at, &set->light, p->layer));
}

/* An edited index may not keep the order of ibl_probes_order. */
static bool take_probes(ibl_json_at root, view_probe_set *set)
{
    const ibl_json_at probes = ibl_json_member(&root, "probes");
    const int count = (int)json_array_size(probes.value);
    ibl_probe probe[VIEW_ROOM_PROBES] = {0};
    int order[VIEW_ROOM_PROBES];

    if (!ibl_json_array(probes, 1, VIEW_ROOM_PROBES))
        return false;
    for (int i = 0; i < count; i++)
        if (!take_probe(ibl_json_element(&probes, (size_t)i), set, &probe[i]))
            return false;
    ibl_probes_order(probe, count, order);
    for (int i = 0; i < count; i++)
        set->probe[i] = probe[order[i]];
    set->locals.count = count;
    set->locals.probe = set->probe;
    return true;
}

static bool take_array(ibl_json_at at, char **path, ibl_texture *shape)
{
    const ibl_json_at file = ibl_json_member(&at, "file");
    const char *name;
    int pixel;

    if (!ibl_json_text_at(file, &name))
        return false;
    /* A file name only, never a path to another folder. */
    if (strchr(name, '/'))
        return ibl_json_wrong(file, "the name of a file beside the index");
    if (!ibl_json_choice(ibl_json_member(&at, "pixel"), ibl_pixel_names,
                         &pixel) ||
        !ibl_json_int(ibl_json_member(&at, "size"), 1, IBL_MAX_CUBE_SIZE,
                      &shape->width) ||
        !ibl_json_int(ibl_json_member(&at, "levels"), 1, IBL_MAX_LEVELS,
                      &shape->levels) ||
        !ibl_json_int(ibl_json_member(&at, "layers"), 1, IBL_MAX_LAYERS,
                      &shape->layers))
        return false;
    shape->pixel = (ibl_pixel)pixel;
    *path = ibl_path_beside(at.file->name, name);
    return *path || view_fail("%s: no memory for names in it", at.file->name);
}

/* As many layers as the specular array; a layer without a probe stays black. */
static bool make_light(const char *name, int layers, ibl_texture *light)
{
    *light = (ibl_texture){.pixel = IBL_PIXEL_RGBA32F,
                           .width = SH_EDGE,
                           .height = SH_EDGE,
                           .levels = 1,
                           .layers = layers,
                           .faces = IBL_FACES};
    light->bytes = ibl_pixel_bytes(light->pixel) * IBL_FACES * SH_EDGE *
                   SH_EDGE * (size_t)layers;
    light->data = calloc(1, light->bytes);
    return light->data ||
           view_fail("%s: no memory for irradiance of %d probes", name, layers);
}

static bool take_arrays(ibl_json_at root, view_probe_set *set)
{
    static const char *const kinds[] = {"cube", "sh", NULL};
    const ibl_json_at files = ibl_json_member(&root, "files");
    const ibl_json_at irradiance = ibl_json_member(&files, "irradiance");
    const ibl_json_at about = ibl_json_member(&root, "irradiance");
    ibl_texture *shape = set->shape;
    int harmonics;

    if (!take_array(ibl_json_member(&files, "specular"), &set->paths[SPECULAR],
                    &shape[SPECULAR]) ||
        !ibl_json_choice(ibl_json_member(&about, "kind"), kinds, &harmonics))
        return false;
    if (harmonics)
        return make_light(root.file->name, shape[SPECULAR].layers, &set->light);
    if (!take_array(irradiance, &set->paths[IRRADIANCE], &shape[IRRADIANCE]))
        return false;
    return shape[IRRADIANCE].layers == shape[SPECULAR].layers ||
           ibl_json_wrong(ibl_json_member(&irradiance, "layers"),
                          "%d, as many as files.specular has",
                          shape[SPECULAR].layers);
}

static bool take_lookups(ibl_json_at root, view_probe_set *set)
{
    static const char *const scales[] = {"E/pi", "E", NULL};
    const ibl_json_at specular = ibl_json_member(&root, "specular");
    const ibl_json_at irradiance = ibl_json_member(&root, "irradiance");
    view_probe_maps *l = &set->locals;
    double scale, offset;
    int filament, whole;

    if (!ibl_json_choice(ibl_json_member(&specular, "mapping"),
                         ibl_formula_names, &filament) ||
        !ibl_json_real(ibl_json_member(&specular, "lod_scale"), 0, 1e6, false,
                       &scale) ||
        !ibl_json_real(ibl_json_member(&specular, "lod_offset"), -1e6, 1e6,
                       false, &offset) ||
        !ibl_json_choice(ibl_json_member(&irradiance, "scale"), scales, &whole))
        return false;
    l->filament = filament;
    l->lod_scale = (float)scale;
    l->lod_offset = (float)offset;
    l->last_level = (float)(set->shape[SPECULAR].levels - 1);
    l->irradiance_scale = (float)(whole ? 1 / M_PI : 1);
    return true;
}

static bool take_index(ibl_json_at root, view_probe_set *set)
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
           take_arrays(root, set) && take_lookups(root, set) &&
           take_probes(root, set);
}

static void fail(void *cookie, const char *text)
{
    (void)cookie;
    view_fail("%s", text);
}

static bool read_index(view_probe_set *set)
{
    ibl_json_file file = {.name = set->paths[INDEX], .fail = fail};

    if (!ibl_json_open(&file))
        return false;
    const bool ok = take_index(ibl_json_root(&file), set);
    json_decref(file.root);
    return ok;
}

/* ---- arrays ------------------------------------------------------------ */

/* Checks that a texture matches the index. */
static bool check_shape(const char *path, const ibl_texture *expected,
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
    if (tex->width != expected->width || tex->levels != expected->levels)
        return view_fail("%s: %d texels with levels: %d, its index says %d "
                         "with %d: bake the probes again",
                         path, tex->width, tex->levels, expected->width,
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
                         const ibl_texture *expected)
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
    const ibl_texture *shape = set->shape;
    view_probe_maps *l = &set->locals;
    char **paths = set->paths;

    if (!view_gl_has_cube_arrays())
        return view_fail("%s: needs cube map arrays: OpenGL 4.0, or "
                         "ARB_texture_cube_map_array",
                         paths[INDEX]);
    view_files_see(paths, 1, set->read);
    if (!read_index(set))
        return false;
    view_files_see(paths + 1, FILES - 1, set->read + 1);
    l->specular = load_array(ctx, paths[SPECULAR], &shape[SPECULAR]);
    if (l->specular && set->light.data)
        l->irradiance = view_upload(&set->light, true, paths[INDEX]);
    else if (l->specular)
        l->irradiance = load_array(ctx, paths[IRRADIANCE], &shape[IRRADIANCE]);
    free(set->light.data);
    set->light.data = NULL;
    gl.BindTexture(GL_TEXTURE_CUBE_MAP_ARRAY, 0);
    return l->irradiance;
}

view_probe_set *view_probe_set_load(ibl_ctx *ctx, const char *index)
{
    view_probe_set *set = calloc(1, sizeof *set);

    if (set)
        set->paths[INDEX] = strdup(index);
    if (!set || !set->paths[INDEX])
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
    free(set->light.data);
    for (int i = 0; i < FILES; i++)
        free(set->paths[i]);
    free(set);
}

const view_probe_maps *view_probe_set_locals(const view_probe_set *set)
{
    return &set->locals;
}

const char *view_probe_set_path(const view_probe_set *set)
{
    return set->paths[INDEX];
}
