/* SPDX-License-Identifier: MIT */
/* The text of a set's index, as iblbake-probes(1) describes it. */
#include "cli/probes.h"
#include "common/path.h"
#include "common/signals.h"
#include "json/json_text.h"

enum {
    VERSION = 1
};

static json_t *files(const ibl_probes_bake *p)
{
    static const char *const keys[] = {"specular", "irradiance", "brdf_lut"};
    const ibl_set_bake *bake = &p->set.bake;
    const int size[] = {p->layout.size, bake->options.irradiance_options.size,
                        bake->lut_size};
    json_t *j = json_object();

    for (int kind = 0; kind <= IBL_PROBES_LUT; kind++) {
        const bool lut = kind == IBL_PROBES_LUT;
        if (!p->path[kind])
            continue;
        json_t *file = json_pack(
            "{ss ss ss si si si}", "file", ibl_path_name(p->path[kind]),
            "container", ibl_container_name(bake->container), "pixel",
            ibl_pixel_name(lut ? p->lut_pixel : bake->texels.pixel), "size",
            size[kind], "levels",
            kind == IBL_PROBES_SPECULAR ? p->layout.levels : 1, "layers",
            lut ? 1 : p->set.layers);
        if (bake->zstd)
            json_object_set_new(file, "zstd", json_integer(bake->zstd));
        json_object_set_new(j, keys[kind], file);
    }
    return j;
}

static json_t *specular(const ibl_specular_options *options,
                        const ibl_specular_layout *layout)
{
    const bool linear = options->mapping == IBL_ROUGHNESS_LINEAR;
    json_t *roughness = json_array();

    for (int l = 0; l < layout->levels; l++)
        json_array_append_new(roughness, json_real(layout->roughness[l]));
    return json_pack(
        "{ss ss so ss sf sf}", "lobe", ibl_lobe_name(options->lobe), "mapping",
        ibl_roughness_map_name(options->mapping), "roughness", roughness, "lod",
        linear ? "roughness * lod_scale + lod_offset"
               : "roughness * (2 - roughness) * lod_scale + "
                 "lod_offset",
        "lod_scale", layout->lod_scale, "lod_offset", layout->lod_offset);
}

/* The entry of layer i: a probe, or the global environment, the last layer. */
static json_t *entry(const ibl_probes_bake *p, int i)
{
    const ibl_set_entry *e = &p->set.entry[i];
    json_t *j = json_pack("{ss* si}", "name", i < p->set.count ? e->name : NULL,
                          "layer", i);

    if (i < p->set.count) {
        json_object_update_new(j, ibl_json_probe_of(&p->set.probe[i]));
        json_object_set_new(j, "alpha", json_boolean(e->alpha));
    }
    json_object_update(j, e->note);
    return j;
}

char *ibl_probes_index_text(const ibl_probes_bake *p)
{
    const ibl_bake_options *options = &p->set.bake.options;
    json_t *probes = json_array();
    json_t *irradiance =
        options->irradiance
            ? json_pack("{ss ss}", "kind", "cube", "scale", "E/pi")
            : json_pack("{ss ss si}", "kind", "sh", "scale", "E/pi", "degree",
                        IBL_PROBES_SH_DEGREE);

    for (int i = 0; i < p->set.count; i++)
        json_array_append_new(probes, entry(p, i));
    json_t *root = json_pack(
        "{si so ss so so so so so* ss}", "version", VERSION, "generator",
        ibl_json_generator(ibl_ctx_isa(p->ctx), IBL_REVISION), "world",
        "right-handed, +Y up; faces +X -X +Y -Y +Z -Z, row 0 on top", "files",
        files(p), "specular", specular(&options->specular_options, &p->layout),
        "irradiance", irradiance, "probes", probes, "global",
        p->set.layers > p->set.count ? entry(p, p->set.count) : NULL, "hash",
        p->hash);
    char *text = ibl_need(ibl_json_text(root));
    json_decref(root);
    return text;
}
