/* SPDX-License-Identifier: MIT */
/* The index of a set: what iblbake-probes(1) says of index.json. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/json_text.h"
#include "cli/probes.h"
#include "common/json_load.h"

enum {
    INDEX_VERSION = 1
};

static const char *const file_keys[] = {"specular", "irradiance", "brdf_lut"};

void ibl_probes_index_free(ibl_probes_index *index)
{
    free(index->layer);
    *index = (ibl_probes_index){0};
}

/* Name of what an index says, which has no hash of its own. False: no
 * memory. */
static bool hash_index(const json_t *root, char hash[IBL_HASH_SIZE])
{
    char *text = ibl_json_dump(root, JSON_COMPACT | JSON_SORT_KEYS |
                                         JSON_REAL_PRECISION(17));

    if (text)
        ibl_hash_bytes(text, strlen(text), hash);
    free(text);
    return text != NULL;
}

/* ---- reading ----------------------------------------------------------- */

static bool take_hash(const char *text, char hash[IBL_HASH_SIZE])
{
    if (!ibl_hash_is(text))
        return false;
    memcpy(hash, text, IBL_HASH_SIZE);
    return true;
}

static bool take_layer(json_t *entry, ibl_probes_index *index)
{
    json_t *sh = NULL, *alpha_sh = NULL;
    json_int_t saturated, texels = 0;
    ibl_probes_layer l = {0};
    const char *hash;
    int layer, alpha = 0;

    if (json_unpack(entry, "{si sI ss s?b s?{sI sF sF} s?o s?o}", "layer",
                    &layer, "saturated", &saturated, "hash", &hash, "alpha",
                    &alpha, "beyond", "texels", &texels, "moved",
                    &l.overflow.moved, "lost", &l.overflow.lost, "sh", &sh,
                    "alpha_sh", &alpha_sh) ||
        layer < 0 || layer >= index->layers || !take_hash(hash, l.hash))
        return false;
    l.overflow_values = (size_t)saturated;
    l.overflow.texels = (size_t)texels;
    l.alpha = alpha;
    for (size_t i = 0; i < IBL_PROBES_SH_NUMBERS; i++)
        l.sh[i] =
            json_number_value(json_array_get(json_array_get(sh, i / 3), i % 3));
    for (size_t i = 0; i < IBL_PROBES_SH_NUMBERS / 3; i++)
        l.alpha_sh[i] = json_number_value(json_array_get(alpha_sh, i));
    index->layer[layer] = l;
    return true;
}

static bool take_file(json_t *files, int kind, ibl_probes_index *index)
{
    const char *name, *hash, *inputs = NULL;
    json_t *file = json_object_get(files, file_keys[kind]);
    ibl_probes_texture *t = &index->file[kind];

    if (!file)
        return kind == IBL_PROBES_IRRADIANCE;
    if (json_unpack(file, "{ss ss s?s}", "file", &name, "hash", &hash, "inputs",
                    &inputs) ||
        strlen(name) >= sizeof t->name || strchr(name, '/'))
        return false;
    strcpy(t->name, name);
    return take_hash(hash, t->hash) &&
           (kind != IBL_PROBES_LUT || (inputs && take_hash(inputs, t->inputs)));
}

static bool take_index(json_t *root, ibl_probes_index *index)
{
    json_t *files, *probes, *global = NULL;
    char said[IBL_HASH_SIZE], is[IBL_HASH_SIZE];
    const char *hash;
    int version;
    bool ok = true;

    if (json_unpack(root, "{si ss so so s?o}", "version", &version, "hash",
                    &hash, "files", &files, "probes", &probes, "global",
                    &global) ||
        version != INDEX_VERSION || !take_hash(hash, said) ||
        json_object_del(root, "hash") || !hash_index(root, is) ||
        strcmp(said, is) != 0)
        return false;
    index->layers = (int)json_array_size(probes) + (global != NULL);
    index->layer = calloc((size_t)index->layers + 1, sizeof *index->layer);
    if (!index->layer)
        return false;
    for (size_t i = 0; i < json_array_size(probes) && ok; i++)
        ok = take_layer(json_array_get(probes, i), index);
    ok = ok && (!global || take_layer(global, index));
    for (int kind = 0; kind < IBL_PROBES_TEXTURES && ok; kind++)
        ok = take_file(files, kind, index);
    return ok;
}

/* Counts the probes that set does not have, by name. */
static void count_dropped(const json_t *root, const ibl_probe_set *set,
                          ibl_probes_index *index)
{
    json_t *probe;
    size_t k;

    json_array_foreach(json_object_get(root, "probes"), k, probe)
    {
        const char *name = json_string_value(json_object_get(probe, "name"));
        int i = 0;
        while (name && i < set->count && strcmp(set->entry[i].name, name) != 0)
            i++;
        index->probes++;
        index->dropped += name && i == set->count;
    }
}

void ibl_probes_index_read(const char *path, const ibl_probe_set *set,
                           char **text, ibl_probes_index *index)
{
    json_t *root = NULL;
    ibl_json_why why;
    size_t size;

    *index = (ibl_probes_index){0};
    *text = ibl_json_bytes(path, &size, &why);
    if (*text)
        root = ibl_json_parse(path, *text, size, JSON_REJECT_DUPLICATES, &why);
    if (root && take_index(root, index))
        count_dropped(root, set, index);
    else
        ibl_probes_index_free(index);
    json_decref(root);
}

/* ---- writing ----------------------------------------------------------- */

static json_t *triple(const double v[3])
{
    return json_pack("[fff]", v[0], v[1], v[2]);
}

static json_t *volume(const ibl_volume *v)
{
    if (v->shape == IBL_SHAPE_BOX)
        return json_pack("{s{so so}}", "box", "centre", triple(v->centre),
                         "half", triple(v->half));
    return json_pack("{s{so sf}}", "sphere", "centre", triple(v->centre),
                     "radius", v->half[0]);
}

static json_t *files(const ibl_probe_set *set, const ibl_probes_index *index,
                     const ibl_specular_layout *layout)
{
    const ibl_set_bake *bake = &set->bake;
    const int size[] = {layout->size, bake->irradiance, bake->lut_size};
    json_t *j = json_object();

    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++) {
        const ibl_probes_texture *t = &index->file[kind];
        const bool lut = kind == IBL_PROBES_LUT;
        if (!*t->name)
            continue;
        json_t *file = json_pack(
            "{ss ss ss si si si ss}", "file", t->name, "container",
            ibl_container_name((ibl_container)bake->container), "pixel",
            ibl_pixel_name(lut ? ibl_probes_lut_pixel(bake)
                               : (ibl_pixel)bake->pixel),
            "size", size[kind], "levels",
            kind == IBL_PROBES_SPECULAR ? layout->levels : 1, "layers",
            lut ? 1 : index->layers, "hash", t->hash);
        if (lut)
            put(&file, "inputs", json_string(t->inputs));
        put(&j, file_keys[kind], file);
    }
    return j;
}

static json_t *specular(const ibl_specular_options *options,
                        const ibl_specular_layout *layout)
{
    const bool linear = options->mapping == IBL_ROUGHNESS_LINEAR;
    json_t *roughness = json_array();

    for (int l = 0; l < layout->levels; l++)
        append(&roughness, json_real(layout->roughness[l]));
    return json_pack(
        "{ss ss so ss sf sf}", "lobe", ibl_lobe_name(options->lobe), "mapping",
        ibl_roughness_map_name(options->mapping), "roughness", roughness, "lod",
        linear ? "roughness * lod_scale + lod_offset"
               : "roughness * (2 - roughness) * lod_scale + "
                 "lod_offset",
        "lod_scale", layout->lod_scale, "lod_offset", layout->lod_offset);
}

static json_t *irradiance(const ibl_set_bake *bake)
{
    json_t *j = json_pack("{ss ss}", "kind", bake->irradiance ? "cube" : "sh",
                          "scale", "E/pi");

    if (!bake->irradiance)
        ibl_json_put_basis(&j, IBL_PROBES_SH_DEGREE);
    return j;
}

static void put_harmonics(json_t **j, const ibl_probes_layer *l)
{
    json_t *sh = json_array(), *alpha = json_array();

    for (int i = 0; i < IBL_PROBES_SH_NUMBERS; i += 3) {
        append(&sh, triple(&l->sh[i]));
        append(&alpha, json_real(l->alpha_sh[i / 3]));
    }
    put(j, "sh", sh);
    if (l->alpha)
        put(j, "alpha_sh", alpha);
    else
        json_decref(alpha);
}

/* Of layer i: a probe, or the global environment, which is the last. */
static json_t *entry(const ibl_probe_set *set, const ibl_probes_index *index,
                     int i)
{
    const ibl_set_entry *e = &set->entry[i];
    const ibl_probes_layer *l = &index->layer[i];
    json_t *j;

    if (i == set->count) {
        j = json_pack("{si}", "layer", i);
    } else {
        j = json_pack("{ss si si so so sf}", "name", e->name, "layer",
                      e->probe.layer, "priority", e->probe.priority, "position",
                      triple(e->probe.position), "influence",
                      volume(&e->probe.influence), "blend", e->probe.blend);
        if (e->probe.has_proxy)
            put(&j, "proxy", volume(&e->probe.proxy));
        put(&j, "alpha", json_boolean(l->alpha));
    }
    put(&j, "saturated", json_integer((json_int_t)l->overflow_values));
    if (l->overflow.texels)
        put(&j, "beyond", ibl_json_overflow(&l->overflow));
    if (!set->bake.irradiance)
        put_harmonics(&j, l);
    put(&j, "hash", json_string(l->hash));
    return j;
}

char *ibl_probes_index_text(const ibl_probe_set *set,
                            const ibl_probes_index *index,
                            const ibl_specular_options *options, ibl_isa isa)
{
    ibl_specular_layout layout;
    json_t *probes = json_array();
    char hash[IBL_HASH_SIZE], *text = NULL;

    ibl_specular_layout_of(options, &layout);
    for (int i = 0; i < set->count; i++)
        append(&probes, entry(set, index, i));
    json_t *root = json_pack(
        "{si so ss so so so so}", "version", INDEX_VERSION, "generator",
        ibl_json_generator(isa), "world",
        "right-handed, +Y up; faces +X -X +Y -Y +Z -Z, row 0 on top", "files",
        files(set, index, &layout), "specular", specular(options, &layout),
        "irradiance", irradiance(&set->bake), "probes", probes);
    if (set->has_global)
        put(&root, "global", entry(set, index, set->count));
    if (root && hash_index(root, hash)) {
        put(&root, "hash", json_string(hash));
        text = ibl_json_text(root);
    }
    json_decref(root);
    return text;
}
