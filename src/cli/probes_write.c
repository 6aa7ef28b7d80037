/* SPDX-License-Identifier: MIT */
/* The files of a set. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/probes.h"

static ibl_status set_keys(const ibl_probes_bake *p, ibl_probes_file kind,
                           ibl_texture *tex)
{
    const ibl_specular_options *o = &p->options.specular_options;
    ibl_specular_layout layout;
    char roughness[IBL_MAX_LEVELS * 24] = "", scale[32], offset[32];
    ibl_status status = IBL_OK;

    ibl_specular_layout_of(o, &layout);
    for (int l = 0; l < layout.levels; l++) {
        const size_t used = strlen(roughness);
        snprintf(roughness + used, sizeof roughness - used, "%s%.9g",
                 l ? "," : "", layout.roughness[l]);
    }
    snprintf(scale, sizeof scale, "%.9g", layout.lod_scale);
    snprintf(offset, sizeof offset, "%.9g", layout.lod_offset);
    /* Alpha in any case: layers of old arrays bring their keys along. */
    const char *alpha = tex->premultiplied ? "premultiplied" : "opaque";
    const struct {
        ibl_probes_file kind;
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
    for (size_t i = 0; i < sizeof keys / sizeof *keys && !status; i++)
        if (keys[i].kind == kind)
            status = ibl_texture_set(p->ctx, tex, keys[i].key, keys[i].value);
    return status;
}

/* Writes tex, which is empty afterwards. */
static ibl_status put_texture(ibl_probes_bake *p, ibl_probes_file kind,
                              ibl_texture *tex)
{
    const ibl_container container = (ibl_container)p->set.bake.container;
    ibl_status status = set_keys(p, kind, tex);

    ibl_console_progress(p->console, "hash", 0);
    if (!status)
        status =
            ibl_hash_texture(p->ctx, tex, container, p->index.file[kind].hash);
    ibl_console_progress(p->console, "write", 0);
    if (!status)
        status = ibl_outputs_take_texture(p->outputs, p->path[kind], tex,
                                          container, NULL);
    return status;
}

static ibl_status put_array(ibl_probes_bake *p, ibl_probes_file kind)
{
    ibl_texture *array = &p->array[kind];

    /* Layers of old arrays are as the array was. */
    array->premultiplied = 0;
    for (int i = 0; i < p->layers; i++)
        array->premultiplied |= p->index.layer[i].alpha;
    return put_texture(p, kind, array);
}

ibl_pixel ibl_probes_lut_pixel(const ibl_set_bake *bake)
{
    return bake->pixel == IBL_PIXEL_RGBA32F ? IBL_PIXEL_RG32F : IBL_PIXEL_RG16F;
}

static ibl_status put_lut(ibl_probes_bake *p)
{
    ibl_lut_options options = ibl_lut_options_default();
    ibl_lut lut = {0};
    ibl_texture tex = {0};

    options.size = p->set.bake.lut_size;
    ibl_console_progress(p->console, "lut", 0);
    ibl_status status = ibl_bake_lut(p->ctx, &options, &lut);
    if (!status)
        status = ibl_texture_from_lut(
            p->ctx, &lut, ibl_probes_lut_pixel(&p->set.bake), &tex, NULL);
    if (!status)
        status = put_texture(p, IBL_PROBES_LUT, &tex);
    ibl_texture_free(&tex);
    ibl_lut_free(&lut);
    return status;
}

/* Writes the index unless it is there, to the byte. */
static ibl_status put_index(ibl_probes_bake *p)
{
    char *text = ibl_probes_index_text(&p->set, &p->index,
                                       &p->options.specular_options, p->isa);
    ibl_status status = text ? IBL_OK : ibl_probes_no_memory(p);

    p->same[IBL_PROBES_INDEX] =
        text && p->old_text && !p->opts->force && !strcmp(text, p->old_text);
    if (!status && !p->same[IBL_PROBES_INDEX])
        status = ibl_outputs_add(p->outputs, p->path[IBL_PROBES_INDEX], text,
                                 strlen(text));
    free(text);
    return status;
}

ibl_status ibl_probes_put(ibl_probes_bake *p)
{
    ibl_status status = IBL_OK;

    for (int kind = 0; kind < IBL_PROBES_TEXTURES && !status; kind++) {
        if (!p->path[kind])
            continue;
        if (p->same[kind])
            p->index.file[kind] = p->old.file[kind];
        else if (kind == IBL_PROBES_LUT)
            status = put_lut(p);
        else
            status = put_array(p, (ibl_probes_file)kind);
    }
    return status ? status : put_index(p);
}
