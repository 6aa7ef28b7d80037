/* SPDX-License-Identifier: MIT */
/* The index.json of baked probes, as iblbake-probes(1) describes it. */
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "ibl/io.h"
#include "ibl/probes.h"
#include "json/json_at.h"
#include "json/json_load.h"

enum {
    VERSION = 1
};

/* Bound for coefficients: more than a bake can hold as irradiance. */
static const double most_irradiance = 1e30;

/* Who reads, and the status of a failure. */
typedef struct reader {
    ibl_ctx *ctx; /* NULL: silence */
    ibl_status status;
    ibl_probe_index *x;
} reader;

static void fail(void *cookie, const char *text)
{
    const reader *r = cookie;
    ibl_fail(r->ctx, IBL_ERR_FORMAT, "%s", text);
}

/* Whether there was memory. */
static bool needed(reader *r, const void *memory)
{
    if (!memory)
        r->status = IBL_ERR_MEMORY;
    return memory;
}

/* Leaves *to where there is no text. */
static bool copy(reader *r, ibl_json_at at, char **to)
{
    const char *text = NULL;

    if (!ibl_json_text_at(at, &text))
        return false;
    if (!text)
        return true;
    *to = ibl_alloc_array(strlen(text) + 1, 1);
    return needed(r, *to) && strcpy(*to, text);
}

/* ---- files ------------------------------------------------------------- */

/* A file name only, never a path to another folder. */
static bool take_name(reader *r, ibl_json_at at, char **to)
{
    const ibl_json_at name = ibl_json_member(&at, "file");

    return copy(r, name, to) &&
           (!strchr(*to, '/') ||
            ibl_json_wrong(name, "the name of a file beside the index"));
}

static bool take_array(reader *r, ibl_json_at at, ibl_probe_file *f)
{
    const char *pixels[IBL_PIXEL_RG16F + 1] = {0}; /* of cubes */

    for (int i = 0; i < IBL_PIXEL_RG16F; i++)
        pixels[i] = ibl_pixel_name((ibl_pixel)i);
    return take_name(r, at, &f->name) &&
           ibl_json_choice(ibl_json_member(&at, "pixel"), pixels, &f->pixel) &&
           ibl_json_int(ibl_json_member(&at, "size"), 1, IBL_MAX_CUBE_SIZE,
                        &f->size) &&
           ibl_json_int(ibl_json_member(&at, "levels"), 1, IBL_MAX_LEVELS,
                        &f->levels) &&
           ibl_json_int(ibl_json_member(&at, "layers"), 1, IBL_MAX_LAYERS,
                        &f->layers);
}

/* Only the specular array is in each set. */
static bool take_files(reader *r, ibl_json_at root)
{
    static const char *const kinds[] = {"cube", "sh", NULL};
    const ibl_json_at files = ibl_json_member(&root, "files");
    const ibl_json_at about = ibl_json_member(&root, "irradiance");
    const ibl_json_at second = ibl_json_member(&files, "irradiance");
    ibl_probe_index *x = r->x;
    int harmonics;

    if (!take_array(r, ibl_json_member(&files, "specular"), &x->specular) ||
        !ibl_json_choice(ibl_json_member(&about, "kind"), kinds, &harmonics))
        return false;
    const int layers = x->specular.layers;
    if (harmonics) {
        x->sh = ibl_alloc_zeroed((size_t)layers, sizeof *x->sh);
        if (!needed(r, x->sh))
            return false;
    } else if (!take_array(r, second, &x->irradiance)) {
        return false;
    } else if (x->irradiance.layers != layers) {
        return ibl_json_wrong(ibl_json_member(&second, "layers"),
                              "%d, as many as files.specular has", layers);
    }
    const ibl_json_at lut = ibl_json_member(&files, "brdf_lut");
    return !lut.value || take_name(r, lut, &x->lut);
}

static bool take_lookups(ibl_json_at root, ibl_probe_index *x)
{
    static const char *const scales[] = {"E/pi", "E", NULL};
    const char *const formulas[] = {
        ibl_roughness_map_name(IBL_ROUGHNESS_LINEAR),
        ibl_roughness_map_name(IBL_ROUGHNESS_FILAMENT), NULL};
    const ibl_json_at specular = ibl_json_member(&root, "specular");
    const ibl_json_at irradiance = ibl_json_member(&root, "irradiance");
    int whole = 0;

    const bool ok =
        ibl_json_choice(ibl_json_member(&specular, "mapping"), formulas,
                        &x->mapping) &&
        ibl_json_real(ibl_json_member(&specular, "lod_scale"), 0, 1e6, false,
                      &x->lod_scale) &&
        ibl_json_real(ibl_json_member(&specular, "lod_offset"), -1e6, 1e6,
                      false, &x->lod_offset) &&
        ibl_json_choice(ibl_json_member(&irradiance, "scale"), scales, &whole);
    x->irradiance_scale = whole ? 1 / IBL_PI : 1;
    return ok;
}

/* ---- layers ------------------------------------------------------------ */

/* Layers without holes have no harmonics of alpha. */
static bool take_sh(ibl_json_at at, double sh[4 * IBL_PROBE_SH])
{
    static const double constant = 3.5449077018110318; /* sqrt(4 pi), for 1 */
    const ibl_json_at all = ibl_json_member(&at, "sh");
    const ibl_json_at alphas = ibl_json_optional(&at, "alpha_sh");

    if (!ibl_json_array(all, IBL_PROBE_SH, IBL_PROBE_SH) ||
        !ibl_json_array(alphas, IBL_PROBE_SH, IBL_PROBE_SH))
        return false;
    for (size_t i = 0; i < IBL_PROBE_SH; i++) {
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

static bool take_layer(ibl_json_at at, const ibl_probe_index *x, int *layer)
{
    return ibl_json_int(ibl_json_member(&at, "layer"), 0,
                        x->specular.layers - 1, layer);
}

/* The member alpha: whether the probe has holes. Older indices lack it. */
static bool take_probe(reader *r, ibl_json_at at, ibl_probe *p, char **name)
{
    const ibl_json_at alpha = ibl_json_optional(&at, "alpha");

    r->x->holes |= json_is_true(alpha.value);
    return take_layer(at, r->x, &p->layer) && ibl_json_probe(at, p) &&
           (json_is_boolean(alpha.value) ||
            ibl_json_wrong(alpha, "true or false")) &&
           (!r->x->sh || take_sh(at, r->x->sh[p->layer])) &&
           copy(r, ibl_json_optional(&at, "name"), name);
}

/* An edited index may not keep the order. */
static bool take_probes(reader *r, ibl_json_at root)
{
    const ibl_json_at probes = ibl_json_member(&root, "probes");
    const int count = (int)json_array_size(probes.value);
    ibl_probe_index *x = r->x;
    ibl_probe probe[IBL_MAX_PROBES] = {0};
    char *name[IBL_MAX_PROBES] = {0};
    int order[IBL_MAX_PROBES];
    bool ok = true;

    if (!ibl_json_array(probes, 1, IBL_MAX_PROBES))
        return false;
    x->probe = ibl_alloc_array((size_t)count, sizeof *x->probe);
    x->name = ibl_alloc_array((size_t)count, sizeof *x->name);
    if (!needed(r, x->probe) || !needed(r, x->name))
        return false;
    for (int i = 0; i < count && ok; i++)
        ok = take_probe(r, ibl_json_element(&probes, (size_t)i), &probe[i],
                        &name[i]);
    ibl_probes_order(probe, count, order);
    for (int i = 0; i < count; i++) {
        x->probe[i] = probe[order[i]];
        x->name[i] = name[order[i]];
    }
    x->count = count;
    return ok;
}

/* ---- the whole --------------------------------------------------------- */

static bool take_index(reader *r, const ibl_json_file *file)
{
    const ibl_json_at root = ibl_json_root(file);
    const ibl_json_at version = ibl_json_member(&root, "version");
    const ibl_json_at global = ibl_json_optional(&root, "global");
    ibl_probe_index *x = r->x;

    if (!json_is_object(root.value))
        return ibl_json_wrong(root, "an object, the index of baked probes");
    if (json_is_integer(version.value) &&
        json_object_get(root.value, "probes") &&
        !json_object_get(root.value, "files"))
        return ibl_json_complain(root,
                                 "is a set to bake, not the index of one: run "
                                 "iblbake probes, and give its index.json");
    if (json_integer_value(version.value) != VERSION)
        return ibl_json_wrong(version, "%d (bake the set again)", VERSION);
    x->global = -1;
    return take_files(r, root) && take_lookups(root, x) &&
           take_probes(r, root) &&
           (!global.value || (take_layer(global, x, &x->global) &&
                              (!x->sh || take_sh(global, x->sh[x->global]))));
}

ibl_status ibl_probe_index_read(ibl_ctx *ctx, const char *path,
                                ibl_probe_index *index)
{
    reader r = {ctx, IBL_ERR_FORMAT, index};
    ibl_json_file file = {.name = path, .fail = fail, .cookie = &r};
    ibl_json_why why;

    if (!path || !index)
        return ibl_missing(ctx, "ibl_probe_index_read: path or index");
    *index = (ibl_probe_index){0};
    file.root = ibl_json_load(path, JSON_REJECT_DUPLICATES, &why);
    if (!file.root)
        return ibl_fail(ctx, why.status, "%s", why.line);
    const bool ok = take_index(&r, &file);
    json_decref(file.root);
    if (ok)
        return IBL_OK;
    ibl_probe_index_free(index);
    return r.status == IBL_ERR_MEMORY ? ibl_no_memory(ctx, path) : r.status;
}

void ibl_probe_index_free(ibl_probe_index *index)
{
    if (!index)
        return;
    for (int i = 0; i < index->count; i++)
        ibl_free(index->name[i]);
    ibl_free(index->name);
    ibl_free(index->probe);
    ibl_free(index->sh);
    ibl_free(index->lut);
    ibl_free(index->irradiance.name);
    ibl_free(index->specular.name);
    *index = (ibl_probe_index){0};
}
