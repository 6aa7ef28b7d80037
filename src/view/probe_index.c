/* SPDX-License-Identifier: MIT */
#include "view/probe_index.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/json_volume.h"
#include "common/names.h"
#include "common/path.h"
#include "view/message.h"

/* What a bake can hold as irradiance, and more. */
static const double brightest = 1e30;

enum {
    VERSION = 1
};

/* ---- probes ------------------------------------------------------------ */

static bool take_probe(const ibl_json_at *at, int layers, ibl_probe *p)
{
    const ibl_json_at layer = ibl_json_member(at, "layer");
    const ibl_json_at priority = ibl_json_member(at, "priority");
    const ibl_json_at position = ibl_json_member(at, "position");
    const ibl_json_at influence = ibl_json_member(at, "influence");
    const ibl_json_at blend = ibl_json_member(at, "blend");
    const ibl_json_at proxy = ibl_json_member(at, "proxy");

    p->has_proxy = proxy.value != NULL;
    return ibl_json_int(&layer, 0, layers - 1, &p->layer) &&
           ibl_json_int(&priority, -1000000, 1000000, &p->priority) &&
           ibl_json_triple(&position, -IBL_JSON_FARTHEST, IBL_JSON_FARTHEST,
                           false, p->position) &&
           ibl_json_volume(&influence, &p->influence) &&
           ibl_json_real(&blend, 0, IBL_JSON_FARTHEST, false, &p->blend) &&
           (!proxy.value || ibl_json_volume(&proxy, &p->proxy));
}

/* Probes that have seen everything have no harmonics of alpha. */
static bool take_sh(const ibl_json_at *at, double sh[4 * VIEW_PROBE_SH])
{
    static const double constant = 3.5449077018110318; /* sqrt(4 pi): of 1 */
    const ibl_json_at all = ibl_json_member(at, "sh");
    const ibl_json_at alphas = ibl_json_member(at, "alpha_sh");

    if (!ibl_json_array(&all, VIEW_PROBE_SH, VIEW_PROBE_SH) ||
        (alphas.value &&
         !ibl_json_array(&alphas, VIEW_PROBE_SH, VIEW_PROBE_SH)))
        return false;
    for (size_t i = 0; i < VIEW_PROBE_SH; i++) {
        const ibl_json_at one = ibl_json_element(&all, i);
        const ibl_json_at alpha = ibl_json_element(&alphas, i);
        double *to = &sh[4 * i];
        to[3] = i ? 0 : constant;
        if (!ibl_json_triple(&one, -brightest, brightest, false, to) ||
            (alphas.value && !ibl_json_real(&alpha, -100, 100, false, &to[3])))
            return false;
    }
    return true;
}

/* Programs write probes in their order; an index that was edited may have lost
 * it. */
static bool sort(const char *path, view_probe_index *x)
{
    const size_t count = (size_t)x->count;
    ibl_probe *from = calloc(count, sizeof *from);
    double(*sh)[4 * VIEW_PROBE_SH] = calloc(count, sizeof *sh);
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
static bool take_alpha(const ibl_json_at *at, view_probe_index *x)
{
    const ibl_json_at alpha = ibl_json_member(at, "alpha");

    x->holes |= json_is_true(alpha.value);
    return !alpha.value || json_is_boolean(alpha.value) ||
           ibl_json_wrong(&alpha, "true or false");
}

static bool take_probes(const ibl_json_at *root, view_probe_index *x)
{
    const ibl_json_at probes = ibl_json_member(root, "probes");
    const size_t count = json_array_size(probes.value);

    if (json_is_array(probes.value) && count > IBL_MAX_TILE_PROBES)
        return ibl_json_wrong(&probes,
                              "at most %d probes, which is what is drawn with",
                              IBL_MAX_TILE_PROBES);
    if (!ibl_json_array(&probes, 1, IBL_MAX_TILE_PROBES))
        return false;
    x->probe = calloc(count, sizeof *x->probe);
    x->sh = calloc(count, sizeof *x->sh);
    if (!x->probe || !x->sh)
        return view_fail("%s: no memory for its probes", root->file->name);
    for (size_t i = 0; i < count; i++) {
        const ibl_json_at at = ibl_json_element(&probes, i);
        if (!take_probe(&at, x->specular.layers, &x->probe[i]) ||
            !take_alpha(&at, x) ||
            (!x->irradiance.path && !take_sh(&at, x->sh[i])))
            return false;
    }
    x->count = (int)count;
    return sort(root->file->name, x);
}

/* ---- arrays ------------------------------------------------------------ */

static bool take_array(const ibl_json_at *at, view_probe_array *a)
{
    const ibl_json_at file = ibl_json_member(at, "file");
    const ibl_json_at pixel = ibl_json_member(at, "pixel");
    const ibl_json_at size = ibl_json_member(at, "size");
    const ibl_json_at levels = ibl_json_member(at, "levels");
    const ibl_json_at layers = ibl_json_member(at, "layers");
    const char *name;
    int choice;

    if (!ibl_json_text_at(&file, &name))
        return false;
    /* A name, never a way to somewhere else. */
    if (strchr(name, '/'))
        return ibl_json_wrong(&file, "the name of a file beside the index");
    if (!ibl_json_choice(&pixel, ibl_pixel_names, &choice) ||
        !ibl_json_int(&size, 1, IBL_MAX_CUBE_SIZE, &a->size) ||
        !ibl_json_int(&levels, 1, IBL_MAX_LEVELS, &a->levels) ||
        !ibl_json_int(&layers, 1, IBL_MAX_LAYERS, &a->layers))
        return false;
    a->pixel = (ibl_pixel)choice;
    a->path = ibl_path_beside(at->file->name, name);
    return a->path ||
           view_fail("%s: no memory for names in it", at->file->name);
}

static bool take_arrays(const ibl_json_at *root, view_probe_index *x)
{
    static const char *const kinds[] = {"cube", "sh", NULL};
    const ibl_json_at files = ibl_json_member(root, "files");
    const ibl_json_at specular = ibl_json_member(&files, "specular");
    const ibl_json_at irradiance = ibl_json_member(&files, "irradiance");
    const ibl_json_at about = ibl_json_member(root, "irradiance");
    const ibl_json_at kind = ibl_json_member(&about, "kind");
    int choice;

    if (!take_array(&specular, &x->specular) ||
        !ibl_json_choice(&kind, kinds, &choice))
        return false;
    if (choice == 1)
        return true;
    if (!take_array(&irradiance, &x->irradiance))
        return false;
    const ibl_json_at layers = ibl_json_member(&irradiance, "layers");
    return x->irradiance.layers == x->specular.layers ||
           ibl_json_wrong(&layers, "%d, as many as files.specular has",
                          x->specular.layers);
}

/* ---- how to look things up --------------------------------------------- */

static bool take_lookups(const ibl_json_at *root, view_probe_index *x)
{
    static const char *const scales[] = {"E/pi", "E", NULL};
    const ibl_json_at specular = ibl_json_member(root, "specular");
    const ibl_json_at irradiance = ibl_json_member(root, "irradiance");
    const ibl_json_at mapping = ibl_json_member(&specular, "mapping");
    const ibl_json_at scale = ibl_json_member(&specular, "lod_scale");
    const ibl_json_at offset = ibl_json_member(&specular, "lod_offset");
    const ibl_json_at unit = ibl_json_member(&irradiance, "scale");
    int map, choice;

    if (!ibl_json_choice(&mapping, ibl_mapping_names, &map) ||
        !ibl_json_real(&scale, 0, 1e6, false, &x->lod_scale) ||
        !ibl_json_real(&offset, -1e6, 1e6, false, &x->lod_offset) ||
        !ibl_json_choice(&unit, scales, &choice))
        return false;
    x->mapping = map ? IBL_ROUGHNESS_FILAMENT : IBL_ROUGHNESS_LINEAR;
    x->irradiance_scale = choice ? 1 / M_PI : 1;
    return true;
}

static bool take_index(const ibl_json_at *root, view_probe_index *x)
{
    const ibl_json_at version = ibl_json_member(root, "version");
    int number;

    if (!json_is_object(root->value))
        return ibl_json_wrong(root, "an object, the index of baked probes");
    if (json_is_integer(version.value) &&
        json_object_get(root->value, "probes") &&
        !json_object_get(root->value, "files"))
        return view_fail("%s: is a set to bake, not the index of one: run "
                         "iblbake probes, and give its index.json",
                         root->file->name);
    return ibl_json_int(&version, VERSION, VERSION, &number) &&
           take_arrays(root, x) && take_lookups(root, x) &&
           take_probes(root, x);
}

static void fail(void *cookie, const char *text)
{
    (void)cookie;
    view_fail("%s", text);
}

bool view_probe_index_read(const char *path, view_probe_index *index)
{
    ibl_json_file file = {.name = path, .fail = fail};

    *index = (view_probe_index){0};
    if (!ibl_json_open(&file))
        return false;
    const ibl_json_at root = ibl_json_root(&file);
    const bool ok = take_index(&root, index);
    json_decref(file.root);
    if (!ok)
        view_probe_index_free(index);
    return ok;
}

void view_probe_index_free(view_probe_index *index)
{
    free(index->sh);
    free(index->irradiance.path);
    free(index->specular.path);
    free(index->probe);
    *index = (view_probe_index){0};
}
