/* SPDX-License-Identifier: MIT */
#include "common/probe_index.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/names.h"

/* Bound for coefficients: more than a bake can hold as irradiance. */
static const double most_irradiance = 1e30;

const char *const ibl_index_keys[IBL_INDEX_FILES] = {"specular", "irradiance",
                                                     "brdf_lut"};

/* ---- files ------------------------------------------------------------- */

static bool take_name(ibl_json_at at, ibl_index_file *f)
{
    const ibl_json_at name = ibl_json_member(&at, "file");

    f->hash = f->inputs = "";
    if (!ibl_json_text_at(name, &f->name))
        return false;
    /* A file name only, never a path to another folder. */
    if (strchr(f->name, '/'))
        return ibl_json_wrong(name, "the name of a file beside the index");
    return ibl_json_text_at(ibl_json_optional(&at, "hash"), &f->hash) &&
           ibl_json_text_at(ibl_json_optional(&at, "inputs"), &f->inputs) &&
           ibl_json_int(ibl_json_optional(&at, "zstd"), 0, IBL_MAX_ZSTD,
                        &f->zstd);
}

static bool take_array(ibl_json_at at, ibl_index_file *f)
{
    return take_name(at, f) &&
           ibl_json_choice(ibl_json_member(&at, "pixel"), ibl_pixel_names,
                           &f->pixel) &&
           ibl_json_int(ibl_json_member(&at, "size"), 1, IBL_MAX_CUBE_SIZE,
                        &f->size) &&
           ibl_json_int(ibl_json_member(&at, "levels"), 1, IBL_MAX_LEVELS,
                        &f->levels) &&
           ibl_json_int(ibl_json_member(&at, "layers"), 1, IBL_MAX_LAYERS,
                        &f->layers);
}

/* Only the specular array is in each set. */
static bool take_files(ibl_json_at root, ibl_probe_index *x)
{
    static const char *const kinds[] = {"cube", "sh", NULL};
    const ibl_json_at files = ibl_json_member(&root, "files");
    const ibl_json_at about = ibl_json_member(&root, "irradiance");
    const ibl_json_at second = ibl_json_member(&files, "irradiance");
    int harmonics;

    if (!take_array(ibl_json_member(&files, "specular"), &x->file[0]) ||
        !ibl_json_choice(ibl_json_member(&about, "kind"), kinds, &harmonics))
        return false;
    const int layers = x->file[0].layers;
    if (harmonics) {
        x->sh = calloc((size_t)layers, sizeof *x->sh);
        if (!x->sh)
            return ibl_json_complain(root,
                                     "no memory for irradiance of %d "
                                     "probes",
                                     layers);
    } else if (!take_array(second, &x->file[IBL_INDEX_IRRADIANCE])) {
        return false;
    } else if (x->file[IBL_INDEX_IRRADIANCE].layers != layers) {
        return ibl_json_wrong(ibl_json_member(&second, "layers"),
                              "%d, as many as files.specular has", layers);
    }
    const ibl_json_at lut = ibl_json_member(&files, "brdf_lut");
    return !lut.value || take_name(lut, &x->file[IBL_INDEX_LUT]);
}

static bool take_lookups(ibl_json_at root, ibl_probe_index *x)
{
    static const char *const scales[] = {"E/pi", "E", NULL};
    const ibl_json_at specular = ibl_json_member(&root, "specular");
    const ibl_json_at irradiance = ibl_json_member(&root, "irradiance");
    int whole = 0;

    const bool ok =
        ibl_json_choice(ibl_json_member(&specular, "mapping"),
                        ibl_formula_names, &x->filament) &&
        ibl_json_real(ibl_json_member(&specular, "lod_scale"), 0, 1e6, false,
                      &x->lod_scale) &&
        ibl_json_real(ibl_json_member(&specular, "lod_offset"), -1e6, 1e6,
                      false, &x->lod_offset) &&
        ibl_json_choice(ibl_json_member(&irradiance, "scale"), scales, &whole);
    x->irradiance_scale = whole ? 1 / M_PI : 1;
    return ok;
}

/* ---- probes ------------------------------------------------------------ */

/* Probes without holes have no harmonics of alpha. */
static bool take_sh(ibl_json_at at, double sh[4 * IBL_INDEX_SH])
{
    static const double constant = 3.5449077018110318; /* sqrt(4 pi), for 1 */
    const ibl_json_at all = ibl_json_member(&at, "sh");
    const ibl_json_at alphas = ibl_json_optional(&at, "alpha_sh");

    if (!ibl_json_array(all, IBL_INDEX_SH, IBL_INDEX_SH) ||
        !ibl_json_array(alphas, IBL_INDEX_SH, IBL_INDEX_SH))
        return false;
    for (size_t i = 0; i < IBL_INDEX_SH; i++) {
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

/* The member alpha: whether the probe has holes. Older indices lack it. */
static bool take_probe(ibl_json_at at, ibl_probe_index *x, ibl_probe *p)
{
    const ibl_json_at alpha = ibl_json_optional(&at, "alpha");

    x->holes |= json_is_true(alpha.value);
    return ibl_json_int(ibl_json_member(&at, "layer"), 0, x->file[0].layers - 1,
                        &p->layer) &&
           ibl_json_probe(at, p) &&
           (json_is_boolean(alpha.value) ||
            ibl_json_wrong(alpha, "true or false")) &&
           (!x->sh || take_sh(at, x->sh[p->layer]));
}

/* An edited index may not keep the order. */
static bool take_probes(ibl_json_at root, ibl_probe_index *x)
{
    const ibl_json_at probes = ibl_json_member(&root, "probes");
    const int count = (int)json_array_size(probes.value);
    ibl_probe probe[IBL_INDEX_PROBES] = {0};
    int order[IBL_INDEX_PROBES];

    if (!ibl_json_array(probes, 1, IBL_INDEX_PROBES))
        return false;
    for (int i = 0; i < count; i++)
        if (!take_probe(ibl_json_element(&probes, (size_t)i), x, &probe[i]))
            return false;
    ibl_probes_order(probe, count, order);
    for (int i = 0; i < count; i++)
        x->probe[i] = probe[order[i]];
    x->count = count;
    return true;
}

bool ibl_probe_index_take(const ibl_json_file *file, ibl_probe_index *index)
{
    const ibl_json_at root = ibl_json_root(file);
    const ibl_json_at version = ibl_json_member(&root, "version");
    int number;

    *index = (ibl_probe_index){0};
    if (!json_is_object(root.value))
        return ibl_json_wrong(root, "an object, the index of baked probes");
    if (json_is_integer(version.value) &&
        json_object_get(root.value, "probes") &&
        !json_object_get(root.value, "files"))
        return ibl_json_complain(root,
                                 "is a set to bake, not the index of one: run "
                                 "iblbake probes, and give its index.json");
    return ibl_json_int(version, IBL_INDEX_VERSION, IBL_INDEX_VERSION,
                        &number) &&
           take_files(root, index) && take_lookups(root, index) &&
           take_probes(root, index);
}
