/* SPDX-License-Identifier: MIT */
/* The files of a set. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"

static bool set_keys(const ibl_probes_bake *p, ibl_probes_kind kind,
                     ibl_texture *tex)
{
    const ibl_specular_options *o = &p->set.bake.options.specular_options;
    const ibl_specular_layout *layout = &p->layout;
    char roughness[IBL_MAX_LEVELS * 24] = "", scale[32], offset[32];
    bool ok = true;

    for (int l = 0; l < layout->levels; l++) {
        const size_t used = strlen(roughness);
        snprintf(roughness + used, sizeof roughness - used, "%s%.9g",
                 l ? "," : "", layout->roughness[l]);
    }
    snprintf(scale, sizeof scale, "%.9g", layout->lod_scale);
    snprintf(offset, sizeof offset, "%.9g", layout->lod_offset);
    /* Alpha in any case: layers of old arrays bring their keys along. */
    const char *alpha = tex->premultiplied ? "premultiplied" : "opaque";
    const struct {
        ibl_probes_kind kind;
        const char *key, *value;
    } keys[] = {
        {IBL_PROBES_LUT, "iblbake.content", "brdf_lut"},
        {IBL_PROBES_LUT, "iblbake.axes", "u=N.V,v=roughness"},
        {IBL_PROBES_LUT, "iblbake.geometry", "smith"},
        {IBL_PROBES_IRRADIANCE, "iblbake.alpha", alpha},
        {IBL_PROBES_IRRADIANCE, "iblbake.content", "irradiance"},
        {IBL_PROBES_IRRADIANCE, "iblbake.irradiance_scale", "E/pi"},
        {IBL_PROBES_SPECULAR, "iblbake.alpha", alpha},
        {IBL_PROBES_SPECULAR, "iblbake.content", "specular"},
        {IBL_PROBES_SPECULAR, "iblbake.lobe", ibl_lobe_name(o->lobe)},
        {IBL_PROBES_SPECULAR, "iblbake.mapping",
         ibl_roughness_map_name(o->mapping)},
        {IBL_PROBES_SPECULAR, "iblbake.roughness", roughness},
        {IBL_PROBES_SPECULAR, "iblbake.lod_scale", scale},
        {IBL_PROBES_SPECULAR, "iblbake.lod_offset", offset},
    };
    for (size_t i = 0; i < sizeof keys / sizeof *keys && ok; i++)
        ok = keys[i].kind != kind ||
             !ibl_texture_set(p->ctx, tex, keys[i].key, keys[i].value);
    return ok;
}

/* Writes tex, which is empty afterwards. */
static bool put_texture(ibl_probes_bake *p, ibl_probes_kind kind,
                        ibl_texture *tex)
{
    const ibl_container container = p->set.bake.container;
    ibl_probes_file *f = &p->file[kind];

    ibl_console_progress(p->console, "hash", 0);
    if (!set_keys(p, kind, tex) ||
        ibl_hash_texture(p->ctx, tex, container, f->hash))
        return false;
    ibl_console_progress(p->console, "write", 0);
    return !ibl_outputs_take_texture(p->outputs, f->path, tex, container, NULL);
}

static bool put_array(ibl_probes_bake *p, ibl_probes_kind kind)
{
    ibl_texture *array = &p->array[kind];

    /* Layers of old arrays are as the array was. */
    array->premultiplied = 0;
    for (int i = 0; i < p->set.layers; i++)
        array->premultiplied |= p->layer[i].alpha;
    return put_texture(p, kind, array);
}

static bool put_lut(ibl_probes_bake *p)
{
    ibl_lut_options options = ibl_lut_options_default();
    ibl_lut lut = {0};
    ibl_texture tex = {0};

    options.size = p->set.bake.lut_size;
    ibl_console_progress(p->console, "lut", 0);
    const bool ok =
        !ibl_bake_lut(p->ctx, &options, &lut) &&
        !ibl_texture_from_lut(p->ctx, &lut, p->lut_pixel, &tex, NULL) &&
        put_texture(p, IBL_PROBES_LUT, &tex);
    ibl_texture_free(&tex);
    ibl_lut_free(&lut);
    return ok;
}

/* Writes the index unless it is there, to the byte. */
static bool put_index(ibl_probes_bake *p)
{
    ibl_probes_file *f = &p->file[IBL_PROBES_INDEX];
    char *text = ibl_probes_index_text(p), hash[IBL_HASH_SIZE];

    if (!text)
        return ibl_probes_no_memory(p);
    ibl_hash_bytes(text, strlen(text), hash);
    f->same = !p->opts->force && !strcmp(hash, f->hash);
    const bool ok =
        f->same || !ibl_outputs_add(p->outputs, f->path, text, strlen(text));
    free(text);
    return ok;
}

bool ibl_probes_put(ibl_probes_bake *p)
{
    bool ok = true;

    for (int kind = 0; kind < IBL_PROBES_TEXTURES && ok; kind++)
        if (p->file[kind].path && !p->file[kind].same)
            ok = kind == IBL_PROBES_LUT ? put_lut(p)
                                        : put_array(p, (ibl_probes_kind)kind);
    return ok && put_index(p);
}
