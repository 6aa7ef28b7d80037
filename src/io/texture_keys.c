/* SPDX-License-Identifier: MIT */
/* Keys that say what a texture holds, and how shaders look it up. */
#include "io/texture_keys.h"
#include "io/colour_space.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/context.h"
#include "io/sidecar_facts.h"

/* Sets keys until one fails; status keeps that failure. */
typedef struct setter {
    ibl_ctx *ctx;
    ibl_texture *tex;
    ibl_status status;
} setter;

static void set(setter *s, const char *key, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
static void set(setter *s, const char *key, const char *fmt, ...)
{
    char value[512];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(value, sizeof value, fmt, ap);
    va_end(ap);
    if (!s->status)
        s->status = ibl_texture_set(s->ctx, s->tex, key, value);
}

/* Appends a number to a list, after a comma if the list is not empty. */
static void add_number(char *list, size_t size, int digits, double x)
{
    const size_t used = strlen(list);
    snprintf(list + used, size - used, "%s%.*g", used ? "," : "", digits, x);
}

static void set_levels(setter *s, ibl_lobe lobe,
                       const ibl_specular_layout *layout)
{
    char roughness[IBL_MAX_LEVELS * 24] = "";

    for (int l = 0; l < layout->levels; l++)
        add_number(roughness, sizeof roughness, 9, layout->roughness[l]);
    set(s, "iblbake.lobe", "%s", ibl_lobe_name(lobe));
    set(s, "iblbake.mapping", "%s", ibl_roughness_map_name(layout->mapping));
    set(s, "iblbake.roughness", "%s", roughness);
    set(s, "iblbake.lod_scale", "%.9g", layout->lod_scale);
    set(s, "iblbake.lod_offset", "%.9g", layout->lod_offset);
}

/* How the levels were made. */
static void set_made(setter *s, const ibl_specular_options *o,
                     const ibl_specular_report *made)
{
    char samples[IBL_MAX_LEVELS * 12] = "";
    char degrees[IBL_MAX_LEVELS * 12] = "";
    char errors[IBL_MAX_LEVELS * 24] = "";
    int sampled = 0;

    for (int l = 0; l < made->layout.levels; l++) {
        const ibl_specular_level *level = &made->level[l];
        add_number(samples, sizeof samples, 9, level->samples);
        add_number(degrees, sizeof degrees, 9, level->degree);
        add_number(errors, sizeof errors, 3, fmax(level->error, 0));
        sampled |= level->samples > 0;
    }
    set(s, "iblbake.method", "%s", ibl_specular_report_method(made));
    if (o->roughness_min > 0 || o->roughness_max < 1)
        set(s, "iblbake.roughness_range", "%.9g:%.9g", o->roughness_min,
            o->roughness_max);
    set(s, "iblbake.degrees", "%s", degrees);
    set(s, "iblbake.estimate", "%s", errors);
    set(s, "iblbake.tolerance", "%.9g", o->tolerance);
    if (!sampled)
        return;
    set(s, "iblbake.samples", "%s", samples);
    if (isnan(o->lod_bias))
        set(s, "iblbake.lod_bias", "%s", IBL_LOD_BIAS_USUAL);
    else
        set(s, "iblbake.lod_bias", "%.9g", o->lod_bias);
    set(s, "iblbake.jitter", "%s", o->jitter ? "yes" : "no");
    set(s, "iblbake.pdf_mip", "%s", o->pdf_mip ? "yes" : "no");
}

static void set_specular(setter *s, const ibl_sidecar_facts *f)
{
    ibl_specular_layout layout;

    if (f->o.made) {
        set_levels(s, f->specular.lobe, &f->o.made->report.layout);
        set_made(s, &f->specular, &f->o.made->report);
    } else if (!ibl_specular_layout_of(&f->specular, &layout)) {
        set_levels(s, f->specular.lobe, &layout);
    } else {
        s->status = ibl_fail(s->ctx, IBL_ERR_ARGUMENT,
                             "specular options that give no levels");
    }
}

static void set_irradiance(setter *s, const ibl_sidecar_facts *f)
{
    if (f->o.made)
        set(s, "iblbake.method", "%s",
            f->o.made->irradiance_degree ? "spectral" : "hemisphere grid");
    if (f->o.made && f->irradiance.step > 0)
        set(s, "iblbake.step", "%.9g", f->irradiance.step);
    set(s, "iblbake.irradiance_scale", "E/pi");
}

static void set_lut(setter *s, const ibl_lut_options *o)
{
    set(s, "iblbake.axes", "u=N.V,v=roughness");
    if (!o->kind)
        set(s, "iblbake.geometry", "%s", ibl_geometry_name(o->geometry));
    set(s, "iblbake.method", "%s", o->samples ? "hammersley" : "quadrature");
    if (o->samples)
        set(s, "iblbake.samples", "%d", o->samples);
}

/* ---- lobe tables ----------------------------------------------------------
 */

const char *ibl_lobe_layer_name(ibl_f0 f0, int i)
{
    static const char *const names[IBL_LOBE_LAYERS] = {
        "one tap, F0 = 1", "one tap, F0 = 0.04", "four taps, F0 = 1",
        "four taps, F0 = 0.04"};

    if (f0 != IBL_F0_BOTH)
        i = 2 * i + (f0 == IBL_F0_DIELECTRICS);
    return i < IBL_LOBE_LAYERS ? names[i] : NULL;
}

static void set_lobe_table(setter *s, const ibl_lobe_table_options *o)
{
    char roughness[IBL_MAX_LEVELS * 24] = "", layers[96] = "";

    for (int i = 0; ibl_lobe_layer_name(o->f0, i); i++) {
        const size_t used = strlen(layers);
        snprintf(layers + used, sizeof layers - used, "%s%s", i ? ";" : "",
                 ibl_lobe_layer_name(o->f0, i));
    }
    for (int l = 0; l < o->layout.levels; l++)
        add_number(roughness, sizeof roughness, 9, o->layout.roughness[l]);
    set(s, "iblbake.axes", "u=N.V,v=roughness");
    set(s, "iblbake.layers", "%s", layers);
    set(s, "iblbake.roughness", "%s", roughness);
}

/* ---- all keys ------------------------------------------------------------ */

static void set_orientation(setter *s, const ibl_sidecar_options *o)
{
    set(s, "iblbake.yaw_deg", "%.9g", o->yaw_deg);
    if (o->axes.mirror)
        set(s, "iblbake.mirror", "%s", ibl_mirror_name(o->axes.mirror));
    if (o->axes.up)
        set(s, "iblbake.up", "%s", ibl_up_name(o->axes.up));
}

static void set_colour(setter *s, const ibl_read_options *o)
{
    if (o->primaries)
        set(s, "iblbake.primaries", "%s", ibl_primaries_name(o->primaries));
    if (o->transfer)
        set(s, "iblbake.transfer", "%s",
            o->transfer == IBL_TRANSFER_LINEAR ? "linear" : "srgb");
    if (o->exposure < 0 || o->exposure > 0)
        set(s, "iblbake.exposure", "%.17g", o->exposure);
    if (o->clamp > 0)
        set(s, "iblbake.clamp", "%.17g", o->clamp);
}

/* What was done to the environment, and by which encoder. */
static void set_bake(setter *s, const ibl_sidecar_facts *f,
                     const ibl_sidecar_output *output)
{
    const ibl_texel_options texels =
        output->texels ? *output->texels : ibl_texel_options_default();

    if (output->content < IBL_CONTENT_LUT) {
        set_orientation(s, &f->o);
        set_colour(s, &f->read);
        if (f->read.primaries || f->o.report)
            s->tex->primaries = ibl_khronos_number(
                f->read.primaries ? ibl_primaries_xy(f->read.primaries)
                                  : f->o.report->primaries);
        if (output->content != IBL_CONTENT_SKYBOX && f->o.light_count >= 0)
            set(s, "iblbake.lights", "%d", f->o.light_count);
    }
    if (ibl_pixel_block(s->tex->pixel) > 1) {
        set(s, "iblbake.pixel", "%s", ibl_pixel_name(s->tex->pixel));
        set(s, "iblbake.quality", "%s", ibl_quality_name(texels.quality));
    }
}

ibl_status ibl_texture_describe(ibl_ctx *ctx, ibl_texture *tex,
                                const ibl_sidecar_options *facts,
                                const ibl_sidecar_output *output)
{
    ibl_sidecar_facts f = {0};
    setter s = {ctx, tex, IBL_OK};

    if (!tex || !facts || !output)
        return ibl_missing(ctx, "ibl_texture_describe: tex, facts or output");
    s.status = ibl_sidecar_take(ctx, facts, &f);
    if (!s.status)
        s.status = ibl_sidecar_check_content(ctx, output);
    if (s.status)
        return s.status;
    set(&s, "iblbake.content", "%s", ibl_content_name(output->content));
    if (f.o.made)
        set_bake(&s, &f, output);
    switch (output->content) {
    case IBL_CONTENT_SKYBOX:
        break;
    case IBL_CONTENT_SPECULAR:
        set_specular(&s, &f);
        break;
    case IBL_CONTENT_IRRADIANCE:
        set_irradiance(&s, &f);
        break;
    case IBL_CONTENT_LUT:
        set_lut(&s, &f.lut);
        break;
    case IBL_CONTENT_LOBE_TABLE:
        set_lobe_table(&s, &f.lobe_table);
        break;
    }
    return s.status;
}
