/* SPDX-License-Identifier: MIT */
/* What a sidecar says of each file. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "io/sidecar_facts.h"
#include "io/texture_keys.h"

/* ---- levels ------------------------------------------------------------ */

/* "environment": the level is the environment itself. */
static const char *level_method(const ibl_specular_level *level)
{
    if (level->samples)
        return "sampled";
    return level->degree ? "spectral" : "environment";
}

/* How a specular level was made. */
static void put_made(json_t **j, const ibl_specular_report *report, int l)
{
    const ibl_specular_level *made = &report->level[l];

    put(j, "roughness", json_real(report->layout.roughness[l]));
    put(j, "method", json_string(level_method(made)));
    if (made->samples)
        put(j, "samples", json_integer(made->samples));
    if (made->degree)
        put(j, "degree", json_integer(made->degree));
    /* JSON has no infinity. */
    if (made->error >= 0)
        put(j, "estimated_error",
            json_real(fmin(ibl_json_digits(made->error), DBL_MAX)));
}

static json_t *level(const ibl_sidecar_facts *f, const ibl_sidecar_output *o,
                     int l)
{
    json_t *j = json_object();

    put(&j, "size", json_integer(ibl_cube_edge(o->texture->width, l)));
    if (o->content == IBL_CONTENT_SPECULAR)
        put_made(&j, &f->o.made->report, l);
    if (o->error)
        put(&j, "pixel_error", ibl_json_pixel_error(&o->error[l]));
    if (o->overflow && o->overflow->level[l].texels)
        put(&j, "beyond", ibl_json_overflow(&o->overflow->level[l]));
    return j;
}

static json_t *levels(const ibl_sidecar_facts *f, const ibl_sidecar_output *o)
{
    json_t *j = json_array();

    for (int l = 0; l < o->texture->levels; l++)
        append(&j, level(f, o, l));
    return j;
}

/* ---- what a file is for -------------------------------------------------- */

/* Whether only a part of the range of roughness was requested. */
static bool is_part(const ibl_specular_options *o)
{
    return o->roughness_min > 0 || o->roughness_max < 1;
}

/* The formula of the lod: with "levels" for the whole range, else numbers. */
static json_t *lod(const ibl_sidecar_facts *f)
{
    const ibl_specular_layout *layout = &f->o.made->report.layout;
    const ibl_roughness_map map = layout->mapping;
    const char *x = map == IBL_ROUGHNESS_LINEAR ? "roughness"
                                                : "roughness * (2 - roughness)";
    if (map == IBL_ROUGHNESS_BABYLON)
        return json_sprintf("%.9g * log2(%d * roughness * roughness)",
                            layout->lod_scale, layout->size);
    if (!is_part(&f->specular))
        return json_sprintf("%s * (levels - 1)", x);
    return json_sprintf("%s * %.9g + %.9g", x, layout->lod_scale,
                        layout->lod_offset);
}

/* The requested range, and the whole chain that it is a part of. */
static void put_part(const ibl_specular_options *o, json_t **j)
{
    put(j, "roughness_range",
        json_pack("[ff]", o->roughness_min, o->roughness_max));
    put(j, "whole_chain",
        json_pack("{si si}", "size", o->size, "levels",
                  ibl_default_levels(o->size)));
}

static void put_specular(const ibl_sidecar_facts *f, json_t **j)
{
    const ibl_specular_options *o = &f->specular;
    const ibl_specular_report *made = &f->o.made->report;
    put(j, "lobe", json_string(ibl_lobe_name(o->lobe)));
    put(j, "weight", json_string(ibl_lobe_formula(o->lobe)));
    put(j, "method", json_string(ibl_specular_report_method(made)));
    put(j, "mapping",
        json_string(ibl_roughness_map_name(made->layout.mapping)));
    put(j, "lod", lod(f));
    put(j, "lod_scale", json_real(made->layout.lod_scale));
    put(j, "lod_offset", json_real(made->layout.lod_offset));
    if (is_part(o))
        put_part(o, j);
    put(j, "tolerance", json_real(o->tolerance));
    put(j, "estimate",
        json_string("bound of the 95th percentile of the relative error, "
                    "before rounding to the pixel"));
    if (!made->lookup_size)
        return;
    put(j, "lookup_size", json_integer(made->lookup_size));
    put(j, "lod_bias",
        isnan(o->lod_bias) ? json_string(IBL_LOD_BIAS_USUAL)
                           : json_real(o->lod_bias));
    put(j, "jitter", json_boolean(o->jitter));
    put(j, "pdf_mip", json_boolean(o->pdf_mip));
}

static void put_irradiance(const ibl_sidecar_facts *f, json_t **j)
{
    const int degree = f->o.made->irradiance_degree;

    put(j, "scale", json_string("E/pi"));
    put(j, "method", json_string(degree ? "spectral" : "hemisphere grid"));
    if (degree)
        put(j, "degree", json_integer(degree));
    if (f->irradiance.step > 0)
        put(j, "step_rad", json_real(f->irradiance.step));
}

static void put_lut(const ibl_lut_options *o, json_t **j)
{
    static const char *const values[] = {
        "specular = F0 * R + G",
        "specular = (1 - F0) * R + F0 * G; B: albedo of cloth",
        "albedo of sheen; R: with Ashikhmin's V, G: with Charlie's"};
    put(j, "axes",
        json_string("u = N.V, v = roughness, at texel centres; row 0 is the "
                    "smoothest"));
    put(j, "values", json_string(values[o->kind]));
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
    const ibl_specular_layout *layout = &o->layout;
    json_t *layers = json_array(), *roughness = json_array();

    for (int i = 0; ibl_lobe_layer_name(o->f0, i); i++)
        append(&layers, json_string(ibl_lobe_layer_name(o->f0, i)));
    for (int l = 0; l < layout->levels; l++)
        append(&roughness, json_real(layout->roughness[l]));
    put(j, "axes",
        json_string("u = N.V, v = roughness, 0 and 1 at the centres of the "
                    "outer texels; row 0 is the smoothest"));
    put(j, "values",
        json_string("R: bend of mix(reflection, N, R), G: lod / (levels - 1), "
                    "B: share of irradiance at N, A: half the difference of "
                    "the bends of the outer taps"));
    put(j, "layers", layers);
    put(j, "level_roughness", roughness);
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
        put(&j, "overflow", json_string(ibl_overflow_name(texels.overflow)));
    if (o->content == IBL_CONTENT_SPECULAR)
        put_specular(f, &j);
    else if (o->content == IBL_CONTENT_IRRADIANCE)
        put_irradiance(f, &j);
    else if (o->content == IBL_CONTENT_LUT)
        put_lut(&f->lut, &j);
    else if (o->content == IBL_CONTENT_LOBE_TABLE)
        put_lobes(&f->lobe_table, &j);
    if (!table)
        put(&j, "levels", levels(f, o));
    return j;
}
