/* SPDX-License-Identifier: MIT */
#include "cli/keys.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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

static void set_specular(setter *s, const ibl_bake *b)
{
    const ibl_specular_options *o = &b->opts->specular;
    const ibl_specular_report *made = &b->made.report;
    const int levels = made->layout.levels;
    char roughness[IBL_MAX_LEVELS * 24] = "";
    char samples[IBL_MAX_LEVELS * 12] = "";
    char degrees[IBL_MAX_LEVELS * 12] = "";
    char errors[IBL_MAX_LEVELS * 24] = "";

    for (int l = 0; l < levels; l++) {
        const ibl_specular_level *level = &made->level[l];
        const size_t r = strlen(roughness), n = strlen(samples);
        const size_t e = strlen(errors), d = strlen(degrees);
        snprintf(roughness + r, sizeof roughness - r, "%s%.9g", l ? "," : "",
                 made->layout.roughness[l]);
        snprintf(samples + n, sizeof samples - n, "%s%d", l ? "," : "",
                 level->samples);
        snprintf(degrees + d, sizeof degrees - d, "%s%d", l ? "," : "",
                 level->degree);
        snprintf(errors + e, sizeof errors - e, "%s%.3g", l ? "," : "",
                 level->error >= 0 ? level->error : 0);
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
    if (b->opts->irradiance.step > 0)
        set(s, "iblbake.step", "%.9g", b->opts->irradiance.step);
}

static void set_lut(setter *s, const ibl_bake *b)
{
    set(s, "iblbake.method", "%s", ibl_bake_lut_method(b));
    set(s, "iblbake.geometry", "%s", ibl_geometry_name(b->opts->lut.geometry));
    set(s, "iblbake.axes", "u=N.V,v=roughness");
    if (b->opts->lut.samples)
        set(s, "iblbake.samples", "%d", b->opts->lut.samples);
}

ibl_status ibl_keys_set(const ibl_bake *b, ibl_output_kind kind,
                        ibl_texture *tex)
{
    setter s = {b->ctx, tex, IBL_OK};

    set(&s, "iblbake.content", "%s",
        kind == IBL_OUTPUT_LUT ? "brdf_lut" : ibl_output_name(kind));
    if (kind != IBL_OUTPUT_LUT)
        set(&s, "iblbake.yaw_deg", "%.9g", b->opts->yaw_deg);
    if (kind == IBL_OUTPUT_SPECULAR)
        set_specular(&s, b);
    else if (kind == IBL_OUTPUT_IRRADIANCE)
        set_irradiance(&s, b);
    else if (kind == IBL_OUTPUT_LUT)
        set_lut(&s, b);
    return s.status;
}
