/* SPDX-License-Identifier: MIT */
/* What a sidecar, and keys, say of each file. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "io/sidecar_facts.h"

const char *ibl_quality_name(ibl_quality quality)
{
    static const char *const names[] = {"fast", "normal", "best"};
    return names[quality];
}

/* ---- levels ------------------------------------------------------------ */

/* How a specular level was made. "environment": it is the environment itself.
 */
static void put_made(json_t **j, const ibl_specular_report *report, int l)
{
    const ibl_specular_level *made = &report->level[l];

    put(j, "roughness", json_real(report->layout.roughness[l]));
    put(j, "method",
        json_string(made->samples  ? "sampled"
                    : made->degree ? "spectral"
                                   : "environment"));
    if (made->samples)
        put(j, "samples", json_integer(made->samples));
    if (made->degree)
        put(j, "degree", json_integer(made->degree));
    /* JSON has no infinity. */
    if (made->error >= 0)
        put(j, "estimated_error",
            json_real(fmin(ibl_json_digits(made->error), DBL_MAX)));
}

static json_t *levels(const ibl_sidecar_facts *f, const ibl_sidecar_output *o)
{
    json_t *list = json_array();

    for (int l = 0; l < o->texture->levels; l++) {
        json_t *j = json_object();
        put(&j, "size", json_integer(ibl_cube_edge(o->texture->width, l)));
        if (o->content == IBL_CONTENT_SPECULAR)
            put_made(&j, &f->o.made->report, l);
        if (o->error)
            put(&j, "pixel_error", ibl_json_pixel_error(&o->error[l]));
        if (o->overflow && o->overflow->level[l].texels)
            put(&j, "beyond", ibl_json_overflow(&o->overflow->level[l]));
        append(&list, j);
    }
    return list;
}

/* ---- what a file is for -------------------------------------------------- */

static void put_specular(const ibl_sidecar_facts *f, json_t **j)
{
    const ibl_specular_options *o = &f->specular;
    const ibl_specular_report *made = f->o.made ? &f->o.made->report : NULL;
    const ibl_specular_layout *layout = made ? &made->layout : &f->layout;

    put(j, "lobe", json_string(ibl_lobe_name(o->lobe)));
    if (made)
        put(j, "method", json_string(ibl_specular_report_method(made)));
    put(j, "mapping", json_string(ibl_roughness_map_name(layout->mapping)));
    put(j, "lod_scale", json_real(layout->lod_scale));
    put(j, "lod_offset", json_real(layout->lod_offset));
    if (!made)
        return;
    /* A part of the range, and the whole chain that it is a part of. */
    if (o->roughness_min > 0 || o->roughness_max < 1) {
        put(j, "roughness_range",
            json_pack("[ff]", o->roughness_min, o->roughness_max));
        put(j, "whole_chain",
            json_pack("{si si}", "size", o->size, "levels",
                      ibl_default_levels(o->size)));
    }
    put(j, "tolerance", json_real(o->tolerance));
    if (!made->lookup_size)
        return;
    put(j, "lookup_size", json_integer(made->lookup_size));
    put(j, "lod_bias",
        isnan(o->lod_bias)
            ? json_string("log2(samples / 64) / 6, within 0 to 1")
            : json_real(o->lod_bias));
    put(j, "jitter", json_boolean(o->jitter));
    put(j, "pdf_mip", json_boolean(o->pdf_mip));
}

static void put_irradiance(const ibl_sidecar_facts *f, json_t **j)
{
    const int degree = f->o.made ? f->o.made->irradiance_degree : 0;

    put(j, "scale", json_string("E/pi"));
    if (f->o.made)
        put(j, "method", json_string(degree ? "spectral" : "hemisphere grid"));
    if (degree)
        put(j, "degree", json_integer(degree));
    if (f->o.made && f->irradiance.step > 0)
        put(j, "step_rad", json_real(f->irradiance.step));
}

static void put_lut(const ibl_lut_options *o, json_t **j)
{
    put(j, "axes", json_string("u=N.V,v=roughness"));
    if (o->kind)
        put(j, "table", json_string(ibl_lut_name(o->kind)));
    else
        put(j, "geometry", json_string(ibl_geometry_name(o->geometry)));
    put(j, "method", json_string(o->samples ? "hammersley" : "quadrature"));
    if (o->samples)
        put(j, "samples", json_integer(o->samples));
}

static void put_lobes(const ibl_lobe_table_options *o, json_t **j)
{
    static const char *const names[IBL_LOBE_LAYERS] = {
        "one tap, F0 = 1", "one tap, F0 = 0.04", "four taps, F0 = 1",
        "four taps, F0 = 0.04"};
    const bool both = o->f0 == IBL_F0_BOTH;
    json_t *layers = json_array(), *roughness = json_array();

    for (int i = o->f0 == IBL_F0_DIELECTRICS; i < IBL_LOBE_LAYERS;
         i += both ? 1 : 2)
        append(&layers, json_string(names[i]));
    for (int l = 0; l < o->layout.levels; l++)
        append(&roughness, json_real(o->layout.roughness[l]));
    put(j, "axes", json_string("u=N.V,v=roughness"));
    put(j, "layers", layers);
    put(j, "level_roughness", roughness);
}

void ibl_sidecar_put_content(const ibl_sidecar_facts *f, ibl_content content,
                             json_t **j)
{
    if (content == IBL_CONTENT_SPECULAR)
        put_specular(f, j);
    else if (content == IBL_CONTENT_IRRADIANCE)
        put_irradiance(f, j);
    else if (content == IBL_CONTENT_LUT)
        put_lut(&f->lut, j);
    else if (content == IBL_CONTENT_LOBE_TABLE)
        put_lobes(&f->lobe_table, j);
}

/* ---- files --------------------------------------------------------------- */

json_t *ibl_sidecar_file(const ibl_sidecar_facts *f,
                         const ibl_sidecar_output *o)
{
    const ibl_texel_options texels =
        o->texels ? *o->texels : ibl_texel_options_default();
    const ibl_texture *t = o->texture;
    const bool table = o->content >= IBL_CONTENT_LUT;
    const size_t saturated = o->overflow ? o->overflow->values : 0;
    json_t *j = json_pack(
        "{ss so so so si si si sI sI}", "content", ibl_content_name(o->content),
        "file", json_string(o->file), "container",
        ibl_json_string(o->container), "pixel",
        ibl_json_string(o->pixel ? o->pixel : ibl_pixel_name(t->pixel)),
        "width", t->width, "height", t->height, "faces", t->faces, "bytes",
        (json_int_t)o->bytes, "saturated", (json_int_t)saturated);

    if (o->hash && *o->hash)
        put(&j, "xxh3_128", json_string(o->hash));
    if (o->more_count > 0) {
        json_t *files = json_array();
        append(&files, json_string(o->file));
        for (int i = 0; i < o->more_count; i++) {
            const char *slash = strrchr(o->more[i], '/');
            append(&files, ibl_json_string(slash ? slash + 1 : o->more[i]));
        }
        put(&j, "files", files);
    }
    if (t->zstd)
        put(&j, "zstd", json_integer(t->zstd));
    if (ibl_pixel_block(t->pixel) > 1)
        put(&j, "quality", json_string(ibl_quality_name(texels.quality)));
    if (!table && t->faces == 1)
        put(&j, "layout", json_string(ibl_projection_name(o->projection)));
    if (!table)
        put(&j, "overflow", json_string(texels.overflow ? "clip" : "spread"));
    ibl_sidecar_put_content(f, o->content, &j);
    if (!table)
        put(&j, "levels", levels(f, o));
    return j;
}
