/* SPDX-License-Identifier: MIT */
/* The index of a set, as iblbake-probes(1) describes it. Reads the old one and
 * plans which layers and files to keep; makes the text of the new one. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"
#include "common/path.h"
#include "json/json_load.h"
#include "json/json_text.h"

enum {
    VERSION = 1
};

const char *const ibl_probes_keys[IBL_PROBES_TEXTURES] = {
    "specular", "irradiance", "brdf_lut"};

/* Hashes an index without its member "hash". False: no memory. */
static bool hash_index(const json_t *root, char hash[IBL_HASH_SIZE])
{
    char *text = ibl_json_text(root);

    if (text)
        ibl_hash_bytes(text, strlen(text), hash);
    free(text);
    return text != NULL;
}

/* ---- reading ----------------------------------------------------------- */

/* Removes "hash". NULL if the index has the right hash, else what it is not. */
static const char *find_flaw(json_t *root)
{
    json_t *said = json_incref(json_object_get(root, "hash"));
    char hash[IBL_HASH_SIZE];
    const char *flaw = NULL;

    json_object_del(root, "hash");
    if (!hash_index(root, hash))
        flaw = "no memory to read it";
    else if (!json_is_string(said) ||
             strcmp(json_string_value(said), hash) != 0)
        flaw = "is damaged or was edited";
    json_decref(said);
    return flaw;
}

/* Counts the old probes, and those whose names the set does not have. */
static void count_dropped(ibl_probes_bake *p, const json_t *probes)
{
    json_t *probe;
    size_t k;

    json_array_foreach(probes, k, probe)
    {
        const char *name = text_of(probe, "name");
        int i = 0;
        while (i < p->set.count && strcmp(p->set.entry[i].name, name) != 0)
            i++;
        p->old_probes++;
        p->dropped += i == p->set.count;
    }
}

json_t *ibl_probes_index_load(const char *path, ibl_ctx *ctx,
                              ibl_console *console, ibl_probe_index *index)
{
    ibl_json_why why;
    json_t *root = ibl_json_load(path, JSON_REJECT_DUPLICATES, &why);
    const char *flaw = root ? find_flaw(root) : NULL;

    *index = (ibl_probe_index){0};
    if (console && !root)
        ibl_console_fail(console, "%s", why.line);
    if (console && flaw)
        ibl_console_fail(console, "%s: %s", path, flaw);
    if (root && !flaw && !ibl_probe_index_read(ctx, path, index))
        return root;
    json_decref(root);
    return NULL;
}

/* Reads the old index and appends "global" to its "probes", which are then all
 * layers. NULL: there is no sound index. */
static json_t *read_index(ibl_probes_bake *p, ibl_probe_index *old)
{
    ibl_probes_file *f = &p->file[IBL_PROBES_INDEX];
    json_t *root = ibl_probes_index_load(f->path, NULL, NULL, old);
    json_t *probes = json_object_get(root, "probes");

    if (!root || !ibl_hash_file(f->path, f->hash)) {
        json_decref(root);
        return NULL;
    }
    count_dropped(p, probes);
    json_array_append(probes, json_object_get(root, "global"));
    return root;
}

/* Finds the old file of a kind, unless its hash differs from the index's. */
static bool find_file(ibl_probes_bake *p, int kind, const char *name,
                      const json_t *was)
{
    ibl_probes_file *f = &p->file[kind];

    if (!name)
        return true;
    f->old = ibl_path_join(p->opts->output, name);
    if (!f->old)
        return ibl_probes_no_memory(p);
    if (!ibl_hash_file(f->old, f->hash) ||
        strcmp(f->hash, text_of(was, "hash")) != 0) {
        free(f->old);
        f->old = NULL;
    }
    f->same =
        f->old && f->path && !strcmp(f->old, f->path) &&
        json_integer_value(json_object_get(was, "zstd")) == p->set.bake.zstd &&
        (kind != IBL_PROBES_LUT ||
         !strcmp(p->lut_inputs, text_of(was, "inputs")));
    return true;
}

/* ---- plan -------------------------------------------------------------- */

/* The old layer with this hash, `layer` itself if it has it; -1: none. */
static int find_old(const json_t *layers, int layer, const char *hash)
{
    const json_t *own = json_array_get(layers, (size_t)layer);
    json_t *was;
    size_t i;

    if (!strcmp(text_of(own, "hash"), hash))
        return layer;
    json_array_foreach(layers, i, was)
    {
        if (!strcmp(text_of(was, "hash"), hash))
            return (int)i;
    }
    return -1;
}

/* An earlier layer with the same inputs; -1: none. */
static int find_twin(const ibl_probes_bake *p, int layer)
{
    for (int i = 0; i < layer; i++)
        if (!strcmp(p->set.entry[i].hash, p->set.entry[layer].hash))
            return i;
    return -1;
}

/* Copies the note of a layer from its entry in the old index. */
static bool keep_note(const ibl_probes_bake *p, ibl_set_entry *e,
                      const json_t *was)
{
    static const char *const keys[] = {"saturated", "beyond", "sh", "alpha_sh",
                                       "pixel_error"};

    e->alpha = json_is_true(json_object_get(was, "alpha"));
    e->note = json_object();
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        json_t *value = json_object_get(was, keys[i]);
        if (value)
            put(&e->note, keys[i], json_incref(value));
    }
    return e->note || ibl_probes_no_memory(p);
}

static bool plan_layers(ibl_probes_bake *p, const json_t *layers, bool usable)
{
    bool moved = (int)json_array_size(layers) != p->set.layers, ok = true;

    for (int i = 0; i < p->set.layers && ok; i++) {
        ibl_set_entry *e = &p->set.entry[i];
        const int old = usable ? find_old(layers, i, e->hash) : -1;
        const int twin = find_twin(p, i);
        e->from = old >= 0    ? IBL_FROM_OLD
                  : twin >= 0 ? IBL_FROM_TWIN
                              : IBL_FROM_BAKE;
        e->source = old >= 0 ? old : twin;
        if (old >= 0)
            ok = keep_note(p, e, json_array_get(layers, (size_t)old));
        moved |= old != i;
    }
    for (int kind = 0; kind < IBL_PROBES_ARRAYS; kind++)
        p->file[kind].same &= !moved;
    return ok;
}

static const char *what_has(int shard, char text[32])
{
    snprintf(text, 32, shard ? "shard %d" : "a whole set", shard);
    return text;
}

/* A shard, and a whole set, replaces only its own like. */
static bool check_shard(const ibl_probes_bake *p, const json_t *old)
{
    const int number = p->opts->shard.number;
    const int was = (int)json_integer_value(
        json_object_get(json_object_get(old, "shard"), "number"));
    char has[32], gets[32];

    return !old || was == number ||
           ibl_console_fail(
               p->console, "%s: has %s: give %s a directory of its own",
               p->opts->output, what_has(was, has), what_has(number, gets));
}

bool ibl_probes_plan(ibl_probes_bake *p)
{
    ibl_probe_index index;
    json_t *old = read_index(p, &index);
    const json_t *files = json_object_get(old, "files");
    const char *const names[] = {index.specular.name, index.irradiance.name,
                                 index.lut};
    bool ok = check_shard(p, old);

    for (int kind = 0; kind < IBL_PROBES_TEXTURES && ok && old; kind++)
        ok = p->opts->force ||
             find_file(p, kind, names[kind],
                       json_object_get(files, ibl_probes_keys[kind]));
    const bool usable =
        p->file[IBL_PROBES_SPECULAR].old &&
        (!p->set.bake.options.irradiance || p->file[IBL_PROBES_IRRADIANCE].old);
    ok = ok && plan_layers(p, json_object_get(old, "probes"), usable);
    json_decref(old);
    ibl_probe_index_free(&index);
    return ok;
}

/* ---- notes -------------------------------------------------------------- */

/* The first number of each triple; frees triples. */
static json_t *firsts(json_t *triples)
{
    json_t *list = triples ? json_array() : NULL, *triple;
    size_t i;

    json_array_foreach(triples, i, triple)
    {
        append(&list, json_incref(json_array_get(triple, 0)));
    }
    json_decref(triples);
    return list;
}

json_t *ibl_probes_note(const ibl_bake_result made[IBL_CAPTURE_PARTS],
                        const ibl_probes_loss *loss)
{
    const double *sh = made[IBL_CAPTURE_COLOUR].sh;
    const double *alpha = made[IBL_CAPTURE_ALPHA].sh;
    json_t *note = json_pack("{sI}", "saturated", (json_int_t)loss->values);
    json_t *errors = loss->blocks ? json_array() : NULL;

    if (loss->beyond.texels)
        put(&note, "beyond", ibl_json_overflow(&loss->beyond));
    for (int l = 0; l < loss->levels && loss->blocks; l++)
        append(&errors, ibl_json_pixel_error(&loss->error[l]));
    if (loss->blocks)
        put(&note, "pixel_error", errors);
    if (sh)
        put(&note, "sh", ibl_json_harmonics(sh, IBL_PROBES_SH_DEGREE, true));
    if (alpha)
        put(&note, "alpha_sh",
            firsts(ibl_json_harmonics(alpha, IBL_PROBES_SH_DEGREE, true)));
    return note;
}

/* ---- writing ----------------------------------------------------------- */

static json_t *files(const ibl_probes_bake *p)
{
    const ibl_set_bake *bake = &p->set.bake;
    const int size[] = {p->layout.size, bake->options.irradiance_options.size,
                        bake->lut_size};
    json_t *j = json_object();

    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++) {
        const ibl_probes_file *f = &p->file[kind];
        const bool lut = kind == IBL_PROBES_LUT;
        if (!f->path)
            continue;
        json_t *file =
            json_pack("{ss ss ss si si si ss}", "file", ibl_path_name(f->path),
                      "container", ibl_container_name(bake->container), "pixel",
                      ibl_pixel_name(lut ? p->lut_pixel : bake->texels.pixel),
                      "size", size[kind], "levels",
                      kind == IBL_PROBES_SPECULAR ? p->layout.levels : 1,
                      "layers", lut ? 1 : p->set.layers, "hash", f->hash);
        if (bake->zstd)
            put(&file, "zstd", json_integer(bake->zstd));
        if (lut)
            put(&file, "inputs", json_string(p->lut_inputs));
        put(&j, ibl_probes_keys[kind], file);
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

static json_t *irradiance(const ibl_bake_options *options)
{
    const bool cubes = options->irradiance;
    json_t *j =
        json_pack("{ss ss}", "kind", cubes ? "cube" : "sh", "scale", "E/pi");

    if (!cubes)
        put(&j, "degree", json_integer(IBL_PROBES_SH_DEGREE));
    return j;
}

/* The entry of layer i: a probe, or the global environment, the last layer. */
static json_t *entry(const ibl_probes_bake *p, int i)
{
    const ibl_set_entry *e = &p->set.entry[i];
    const char *key;
    json_t *j, *value;

    if (i == p->set.count) {
        j = json_pack("{si}", "layer", i);
    } else {
        j = json_pack("{ss si}", "name", e->name, "layer", i);
        put_all(&j, ibl_json_probe_of(&e->probe));
        put(&j, "alpha", json_boolean(e->alpha));
    }
    json_object_foreach(e->note, key, value)
    {
        put(&j, key, json_incref(value));
    }
    put(&j, "hash", json_string(e->hash));
    return j;
}

static json_t *shard(const ibl_probes_bake *p)
{
    json_t *layers = json_array();

    for (int i = 0; i < p->set.layers; i++)
        append(&layers, json_integer(p->set.entry[i].whole));
    return json_pack("{si si ss so}", "number", p->opts->shard.number, "of",
                     p->opts->shard.count, "whole", p->whole, "layers", layers);
}

char *ibl_probes_index_seal(json_t *root)
{
    char hash[IBL_HASH_SIZE], *text = NULL;

    if (root && hash_index(root, hash)) {
        put(&root, "hash", json_string(hash));
        text = ibl_json_text(root);
    }
    json_decref(root);
    return text;
}

char *ibl_probes_index_text(const ibl_probes_bake *p)
{
    const ibl_bake_options *options = &p->set.bake.options;
    json_t *probes = json_array();

    for (int i = 0; i < p->set.count; i++)
        append(&probes, entry(p, i));
    json_t *root = json_pack(
        "{si so ss so so so so}", "version", VERSION, "generator",
        ibl_json_generator(p->isa, IBL_REVISION), "world",
        "right-handed, +Y up; faces +X -X +Y -Y +Z -Z, row 0 on top", "files",
        files(p), "specular", specular(&options->specular_options, &p->layout),
        "irradiance", irradiance(options), "probes", probes);
    if (p->set.layers > p->set.count)
        put(&root, "global", entry(p, p->set.count));
    if (p->opts->shard.count)
        put(&root, "shard", shard(p));
    return ibl_probes_index_seal(root);
}
