/* SPDX-License-Identifier: MIT */
/* Keys that say what a texture holds, and how shaders look it up. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/context.h"
#include "io/colour_space.h"
#include "io/sidecar_facts.h"

/* Sets keys until one fails; status keeps that failure. */
typedef struct setter {
    ibl_ctx *ctx;
    ibl_texture *tex;
    ibl_status status;
} setter;

static void set(setter *s, const char *name, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
static void set(setter *s, const char *name, const char *fmt, ...)
{
    char key[40], value[512];
    va_list ap;

    snprintf(key, sizeof key, "iblbake.%s", name);
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

/* ---- what sidecars say, too --------------------------------------------- */

static const struct {
    const char *member, *key, *between; /* elements of an array */
} shared[] = {
    {"axes", "axes", NULL},
    {"geometry", "geometry", NULL},
    {"jitter", "jitter", NULL},
    {"layers", "layers", ";"},
    {"level_roughness", "roughness", ","},
    {"lobe", "lobe", NULL},
    {"lod_bias", "lod_bias", NULL},
    {"lod_offset", "lod_offset", NULL},
    {"lod_scale", "lod_scale", NULL},
    {"mapping", "mapping", NULL},
    {"method", "method", NULL},
    {"pdf_mip", "pdf_mip", NULL},
    {"roughness_range", "roughness_range", ":"},
    {"samples", "samples", NULL},
    {"scale", "irradiance_scale", NULL},
    {"step_rad", "step", NULL},
    {"tolerance", "tolerance", NULL},
};

static void add_value(char *text, size_t size, const json_t *j)
{
    const size_t used = strlen(text);
    if (json_is_number(j))
        snprintf(text + used, size - used, "%.9g", json_number_value(j));
    else
        snprintf(text + used, size - used, "%s",
                 json_is_string(j) ? json_string_value(j)
                 : json_is_true(j) ? "yes"
                                   : "no");
}

static void set_shared(setter *s, const ibl_sidecar_facts *f,
                       ibl_content content)
{
    json_t *all = json_object();

    ibl_sidecar_put_content(f, content, &all);
    if (!all && !s->status)
        s->status = ibl_no_memory(s->ctx, "a texture's keys");
    for (size_t i = 0; i < sizeof shared / sizeof *shared; i++) {
        const json_t *j = json_object_get(all, shared[i].member);
        char text[512] = "";
        for (size_t k = 0; k < json_array_size(j); k++) {
            if (k)
                strcat(text, shared[i].between);
            add_value(text, sizeof text - 1, json_array_get(j, k));
        }
        if (!json_is_array(j))
            add_value(text, sizeof text, j);
        if (j)
            set(s, shared[i].key, "%s", text);
    }
    json_decref(all);
}

/* ---- the others ---------------------------------------------------------- */

/* Lists of the levels, which a sidecar has one by one. */
static void set_levels(setter *s, const ibl_sidecar_facts *f)
{
    const ibl_specular_report *made = f->o.made ? &f->o.made->report : NULL;
    const ibl_specular_layout *layout = made ? &made->layout : &f->layout;
    char roughness[IBL_MAX_LEVELS * 24] = "", errors[IBL_MAX_LEVELS * 24] = "";
    char samples[IBL_MAX_LEVELS * 12] = "", degrees[IBL_MAX_LEVELS * 12] = "";

    for (int l = 0; l < layout->levels; l++)
        add_number(roughness, sizeof roughness, 9, layout->roughness[l]);
    set(s, "roughness", "%s", roughness);
    for (int l = 0; made && l < layout->levels; l++) {
        const ibl_specular_level *level = &made->level[l];
        add_number(samples, sizeof samples, 9, level->samples);
        add_number(degrees, sizeof degrees, 9, level->degree);
        add_number(errors, sizeof errors, 3, fmax(level->error, 0));
    }
    if (!made)
        return;
    set(s, "degrees", "%s", degrees);
    set(s, "estimate", "%s", errors);
    if (made->lookup_size)
        set(s, "samples", "%s", samples);
}

/* What was done to the environment. */
static void set_environment(setter *s, const ibl_sidecar_facts *f)
{
    const ibl_sidecar_options *o = &f->o;
    const ibl_read_options *read = &f->read;

    set(s, "yaw_deg", "%.9g", o->yaw_deg);
    if (o->axes.mirror)
        set(s, "mirror", "%s", ibl_mirror_name(o->axes.mirror));
    if (o->axes.up)
        set(s, "up", "%s", ibl_up_name(o->axes.up));
    if (read->primaries)
        set(s, "primaries", "%s", ibl_primaries_name(read->primaries));
    if (read->transfer)
        set(s, "transfer", "%s",
            read->transfer == IBL_TRANSFER_LINEAR ? "linear" : "srgb");
    if (read->exposure < 0 || read->exposure > 0)
        set(s, "exposure", "%.17g", read->exposure);
    if (read->clamp > 0)
        set(s, "clamp", "%.17g", read->clamp);
    if (read->primaries || o->report)
        s->tex->primaries = ibl_khronos_number(
            read->primaries ? ibl_primaries_xy(read->primaries)
                            : o->report->primaries);
}

ibl_status ibl_texture_describe(ibl_ctx *ctx, ibl_texture *tex,
                                const ibl_sidecar_options *facts,
                                const ibl_sidecar_output *output)
{
    ibl_sidecar_facts f = {0};
    setter s = {ctx, tex, IBL_OK};

    if (!tex || !facts || !output)
        return ibl_missing(ctx, "ibl_texture_describe: tex, facts or output");
    const ibl_content content = output->content;
    s.status = ibl_sidecar_take(ctx, facts, &f);
    if (!s.status)
        s.status = ibl_sidecar_check_content(ctx, output);
    if (!s.status && content == IBL_CONTENT_SPECULAR && !f.o.made &&
        ibl_specular_layout_of(&f.specular, &f.layout))
        s.status = ibl_fail(ctx, IBL_ERR_ARGUMENT,
                            "specular options that give no levels");
    if (s.status)
        return s.status;
    set(&s, "content", "%s", ibl_content_name(content));
    set_shared(&s, &f, content);
    if (content == IBL_CONTENT_SPECULAR)
        set_levels(&s, &f);
    if (!f.o.made)
        return s.status;
    if (content < IBL_CONTENT_LUT) {
        set_environment(&s, &f);
        if (content != IBL_CONTENT_SKYBOX && f.o.light_count >= 0)
            set(&s, "lights", "%d", f.o.light_count);
    }
    if (ibl_pixel_block(tex->pixel) > 1) {
        set(&s, "pixel", "%s", ibl_pixel_name(tex->pixel));
        set(&s, "quality", "%s",
            ibl_quality_name(output->texels
                                 ? output->texels->quality
                                 : ibl_texel_options_default().quality));
    }
    return s.status;
}
