/* SPDX-License-Identifier: MIT */
/* The index of a set: what iblbake-probes(1) says of index.json. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/json_put.h"
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

static bool get_hash(const json_t *object, const char *key,
                     char hash[IBL_HASH_SIZE])
{
    const char *text = json_string_value(json_object_get(object, key));

    if (!text || !ibl_hash_is(text))
        return false;
    memcpy(hash, text, IBL_HASH_SIZE);
    return true;
}

static bool get_layer(const json_t *entry, ibl_probes_index *index)
{
    const json_t *number = json_object_get(entry, "layer");
    const json_t *saturated = json_object_get(entry, "saturated");
    const json_t *sh = json_object_get(entry, "sh");
    const json_int_t layer = json_integer_value(number);

    if (!json_is_integer(number) || layer < 0 || layer >= index->layers ||
        !json_is_integer(saturated))
        return false;
    ibl_probes_layer *l = &index->layer[layer];
    l->saturated = (size_t)json_integer_value(saturated);
    const json_t *beyond = json_object_get(entry, "beyond");
    l->beyond.texels =
        (size_t)json_integer_value(json_object_get(beyond, "texels"));
    l->beyond.moved = json_number_value(json_object_get(beyond, "moved"));
    l->beyond.lost = json_number_value(json_object_get(beyond, "lost"));
    for (size_t i = 0; sh && i < IBL_PROBES_SH_NUMBERS; i++)
        l->sh[i] =
            json_number_value(json_array_get(json_array_get(sh, i / 3), i % 3));
    l->alpha = json_is_true(json_object_get(entry, "alpha"));
    const json_t *alpha_sh = json_object_get(entry, "alpha_sh");
    for (size_t i = 0; alpha_sh && i < IBL_PROBES_SH_NUMBERS / 3; i++)
        l->alpha_sh[i] = json_number_value(json_array_get(alpha_sh, i));
    return get_hash(entry, "hash", l->hash);
}

static bool get_file(const json_t *files, int kind, ibl_probes_index *index)
{
    const json_t *file = json_object_get(files, file_keys[kind]);
    const char *name = json_string_value(json_object_get(file, "file"));
    ibl_probes_texture *t = &index->file[kind];

    if (!file)
        return kind == IBL_PROBES_IRRADIANCE;
    if (!name || strlen(name) >= sizeof t->name || strchr(name, '/'))
        return false;
    strcpy(t->name, name);
    return get_hash(file, "hash", t->hash) &&
           (kind != IBL_PROBES_LUT || get_hash(file, "inputs", t->inputs));
}

static bool take_index(json_t *root, ibl_probes_index *index)
{
    const json_t *files = json_object_get(root, "files");
    const json_t *probes = json_object_get(root, "probes"), *probe;
    const json_t *global = json_object_get(root, "global");
    char said[IBL_HASH_SIZE], is[IBL_HASH_SIZE];
    size_t i;

    if (json_integer_value(json_object_get(root, "version")) != INDEX_VERSION ||
        !get_hash(root, "hash", said) || json_object_del(root, "hash") ||
        !hash_index(root, is) || strcmp(said, is) != 0)
        return false;
    index->layers = (int)json_array_size(probes) + (global != NULL);
    index->layer = calloc((size_t)index->layers + 1, sizeof *index->layer);
    if (!index->layer)
        return false;
    json_array_foreach((json_t *)probes, i, probe)
    {
        if (!get_layer(probe, index))
            return false;
    }
    if (global && !get_layer(global, index))
        return false;
    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++)
        if (!get_file(files, kind, index))
            return false;
    return true;
}

/* Counts the probes that set does not have, by name. */
static void count_dropped(const json_t *root, const ibl_probe_set *set,
                          ibl_probes_index *index)
{
    const json_t *probes = json_object_get(root, "probes"), *probe;
    size_t k;

    json_array_foreach((json_t *)probes, k, probe)
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

typedef struct builder {
    const ibl_probe_set *set;
    const ibl_probes_index *index;
    const ibl_specular_options *options;
    ibl_isa isa;
    ibl_specular_layout layout;
} builder;

static json_t *triple(const double v[3])
{
    json_t *j = json_array();
    for (int k = 0; k < 3; k++)
        append(&j, json_real(v[k]));
    return j;
}

static json_t *volume(const ibl_volume *v)
{
    json_t *j = json_object(), *shape = json_object();
    put(&shape, "centre", triple(v->centre));
    if (v->shape == IBL_SHAPE_BOX)
        put(&shape, "half", triple(v->half));
    else
        put(&shape, "radius", json_real(v->half[0]));
    put(&j, v->shape == IBL_SHAPE_BOX ? "box" : "sphere", shape);
    return j;
}

static json_t *file(const builder *b, ibl_probes_file kind)
{
    const ibl_probes_texture *t = &b->index->file[kind];
    const ibl_set_bake *bake = &b->set->bake;
    const bool lut = kind == IBL_PROBES_LUT;
    const ibl_pixel pixel = !lut ? (ibl_pixel)bake->pixel
                            : bake->pixel == IBL_PIXEL_RGBA32F
                                ? IBL_PIXEL_RG32F
                                : IBL_PIXEL_RG16F;
    json_t *j = json_object();

    put(&j, "file", json_string(t->name));
    put(&j, "container",
        json_string(ibl_container_name((ibl_container)bake->container)));
    put(&j, "pixel", json_string(ibl_pixel_name(pixel)));
    put(&j, "size",
        json_integer(kind == IBL_PROBES_SPECULAR     ? b->layout.size
                     : kind == IBL_PROBES_IRRADIANCE ? bake->irradiance
                                                     : bake->lut_size));
    put(&j, "levels",
        json_integer(kind == IBL_PROBES_SPECULAR ? b->layout.levels : 1));
    put(&j, "layers", json_integer(lut ? 1 : b->index->layers));
    put(&j, "hash", json_string(t->hash));
    if (lut)
        put(&j, "inputs", json_string(t->inputs));
    return j;
}

static json_t *files(const builder *b)
{
    json_t *j = json_object();
    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++)
        if (*b->index->file[kind].name)
            put(&j, file_keys[kind], file(b, (ibl_probes_file)kind));
    return j;
}

static json_t *specular(const builder *b)
{
    const bool linear = b->options->mapping == IBL_ROUGHNESS_LINEAR;
    json_t *j = json_object(), *roughness = json_array();

    for (int l = 0; l < b->layout.levels; l++)
        append(&roughness, json_real(b->layout.roughness[l]));
    put(&j, "lobe", json_string(ibl_lobe_name(b->options->lobe)));
    put(&j, "mapping",
        json_string(ibl_roughness_map_name(b->options->mapping)));
    put(&j, "roughness", roughness);
    put(&j, "lod",
        json_string(linear ? "roughness * lod_scale + lod_offset"
                           : "roughness * (2 - roughness) * lod_scale + "
                             "lod_offset"));
    put(&j, "lod_scale", json_real(b->layout.lod_scale));
    put(&j, "lod_offset", json_real(b->layout.lod_offset));
    return j;
}

static json_t *irradiance(const builder *b)
{
    const bool sh = !b->set->bake.irradiance;
    json_t *j = json_object();

    put(&j, "kind", json_string(sh ? "sh" : "cube"));
    put(&j, "scale", json_string("E/pi"));
    if (!sh)
        return j;
    ibl_json_put_basis(&j, IBL_PROBES_SH_DEGREE);
    return j;
}

static json_t *alpha_harmonics(const ibl_probes_layer *l)
{
    json_t *j = json_array();
    for (int i = 0; i < IBL_PROBES_SH_NUMBERS / 3; i++)
        append(&j, json_real(l->alpha_sh[i]));
    return j;
}

static void put_layer(const builder *b, json_t **j, int layer)
{
    const ibl_probes_layer *l = &b->index->layer[layer];

    /* The global environment has none. */
    if (layer < b->set->count)
        put(j, "alpha", json_boolean(l->alpha));
    put(j, "saturated", json_integer((json_int_t)l->saturated));
    if (l->beyond.texels)
        put(j, "beyond", ibl_json_overflow(&l->beyond));
    if (!b->set->bake.irradiance) {
        json_t *sh = json_array();
        for (int i = 0; i < IBL_PROBES_SH_NUMBERS; i += 3)
            append(&sh, triple(&l->sh[i]));
        put(j, "sh", sh);
        if (l->alpha)
            put(j, "alpha_sh", alpha_harmonics(l));
    }
    put(j, "hash", json_string(l->hash));
}

static json_t *probe(const builder *b, int i)
{
    const ibl_set_entry *e = &b->set->entry[i];
    json_t *j = json_object();

    put(&j, "name", json_string(e->name));
    put(&j, "layer", json_integer(e->probe.layer));
    put(&j, "priority", json_integer(e->probe.priority));
    put(&j, "position", triple(e->probe.position));
    put(&j, "influence", volume(&e->probe.influence));
    put(&j, "blend", json_real(e->probe.blend));
    if (e->probe.has_proxy)
        put(&j, "proxy", volume(&e->probe.proxy));
    put_layer(b, &j, i);
    return j;
}

char *ibl_probes_index_text(const ibl_probe_set *set,
                            const ibl_probes_index *index,
                            const ibl_specular_options *options, ibl_isa isa)
{
    builder b = {.set = set, .index = index, .options = options, .isa = isa};
    json_t *root = json_object(), *probes = json_array();
    char hash[IBL_HASH_SIZE], *text = NULL;

    ibl_specular_layout_of(options, &b.layout);
    put(&root, "version", json_integer(INDEX_VERSION));
    put(&root, "generator", ibl_json_generator(isa));
    put(&root, "world",
        json_string("right-handed, +Y up; faces +X -X +Y -Y +Z -Z, row 0 on "
                    "top"));
    put(&root, "files", files(&b));
    put(&root, "specular", specular(&b));
    put(&root, "irradiance", irradiance(&b));
    for (int i = 0; i < set->count; i++)
        append(&probes, probe(&b, i));
    put(&root, "probes", probes);
    if (set->has_global) {
        json_t *global = json_object();
        put(&global, "layer", json_integer(set->count));
        put_layer(&b, &global, set->count);
        put(&root, "global", global);
    }
    if (root && hash_index(root, hash)) {
        put(&root, "hash", json_string(hash));
        text = ibl_json_text(root);
    }
    json_decref(root);
    return text;
}
