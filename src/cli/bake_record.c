/* SPDX-License-Identifier: MIT */
#include "cli/bake_record.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

bool ibl_bake_is_part(const ibl_bake *b)
{
    const ibl_specular_options *o = &b->opts->bake.specular_options;
    return o->roughness_min > 0 || o->roughness_max < 1;
}

bool ibl_bake_is_sampled(const ibl_bake *b)
{
    bool sampled = false;
    for (int l = 0; l < b->made.report.layout.levels; l++)
        sampled |= b->made.report.level[l].samples > 0;
    return sampled;
}

const char *ibl_level_method(const ibl_specular_level *level)
{
    if (level->samples)
        return "sampled";
    return level->degree || level->reach > 0 ? "spectral" : "environment";
}

const char *ibl_bake_specular_method(const ibl_bake *b)
{
    bool spectral = false;
    for (int l = 0; l < b->made.report.layout.levels; l++)
        spectral |= b->made.report.level[l].degree > 0 ||
                    b->made.report.level[l].reach > 0;
    if (ibl_bake_is_sampled(b))
        return spectral ? "mixed" : "sampled";
    return spectral ? "spectral" : "environment";
}

const char *ibl_bake_irradiance_method(const ibl_bake *b)
{
    return b->made.irradiance_degree ? "spectral" : "hemisphere grid";
}

const char *ibl_bake_lut_method(const ibl_bake *b)
{
    return b->opts->lut.samples ? "hammersley" : "quadrature";
}

/* ---- keys ------------------------------------------------------------ */

/* Sets keys until the first failure, which it keeps. */
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

/* Appends to a list with commas. */
static void append(char *list, size_t size, int digits, double x)
{
    const size_t used = strlen(list);
    snprintf(list + used, size - used, "%s%.*g", used ? "," : "", digits, x);
}

static void set_specular(setter *s, const ibl_bake *b)
{
    const ibl_specular_options *o = &b->opts->bake.specular_options;
    const ibl_specular_report *made = &b->made.report;
    char roughness[IBL_MAX_LEVELS * 24] = "";
    char samples[IBL_MAX_LEVELS * 12] = "";
    char degrees[IBL_MAX_LEVELS * 12] = "";
    char errors[IBL_MAX_LEVELS * 24] = "";

    for (int l = 0; l < made->layout.levels; l++) {
        const ibl_specular_level *level = &made->level[l];
        append(roughness, sizeof roughness, 9, made->layout.roughness[l]);
        append(samples, sizeof samples, 9, level->samples);
        append(degrees, sizeof degrees, 9, level->degree);
        append(errors, sizeof errors, 3, fmax(level->error, 0));
    }
    set(s, "iblbake.method", "%s", ibl_bake_specular_method(b));
    set(s, "iblbake.lobe", "%s", ibl_lobe_name(o->lobe));
    set(s, "iblbake.mapping", "%s", ibl_roughness_map_name(o->mapping));
    set(s, "iblbake.roughness", "%s", roughness);
    set(s, "iblbake.lod_scale", "%.9g", made->layout.lod_scale);
    set(s, "iblbake.lod_offset", "%.9g", made->layout.lod_offset);
    if (ibl_bake_is_part(b))
        set(s, "iblbake.roughness_range", "%.9g:%.9g", o->roughness_min,
            o->roughness_max);
    set(s, "iblbake.degrees", "%s", degrees);
    set(s, "iblbake.estimate", "%s", errors);
    set(s, "iblbake.tolerance", "%.9g", o->tolerance);
    if (!ibl_bake_is_sampled(b))
        return;
    set(s, "iblbake.samples", "%s", samples);
    set(s, "iblbake.lod_bias", "%.9g", o->lod_bias);
    set(s, "iblbake.jitter", "%s", o->jitter ? "yes" : "no");
    set(s, "iblbake.pdf_mip", "%s", o->pdf_mip ? "yes" : "no");
}

static void set_irradiance(setter *s, const ibl_bake *b)
{
    set(s, "iblbake.method", "%s", ibl_bake_irradiance_method(b));
    set(s, "iblbake.irradiance_scale", "E/pi");
    if (b->opts->bake.irradiance_options.step > 0)
        set(s, "iblbake.step", "%.9g", b->opts->bake.irradiance_options.step);
}

static void set_lut(setter *s, const ibl_bake *b)
{
    set(s, "iblbake.method", "%s", ibl_bake_lut_method(b));
    set(s, "iblbake.geometry", "%s", ibl_geometry_name(b->opts->lut.geometry));
    set(s, "iblbake.axes", "u=N.V,v=roughness");
    if (b->opts->lut.samples)
        set(s, "iblbake.samples", "%d", b->opts->lut.samples);
}

ibl_status ibl_texture_metadata(const ibl_bake *b, ibl_output_kind kind,
                                ibl_texture *tex)
{
    setter s = {b->ctx, tex, IBL_OK};

    set(&s, "iblbake.content", "%s", ibl_output_content(kind));
    if (kind != IBL_OUTPUT_LUT)
        set(&s, "iblbake.yaw_deg", "%.9g", b->opts->bake.yaw_deg);
    if (kind == IBL_OUTPUT_SPECULAR)
        set_specular(&s, b);
    else if (kind == IBL_OUTPUT_IRRADIANCE)
        set_irradiance(&s, b);
    else if (kind == IBL_OUTPUT_LUT)
        set_lut(&s, b);
    return s.status;
}
