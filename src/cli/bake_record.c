/* SPDX-License-Identifier: MIT */
#include "cli/bake_record.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/json_text.h"
#include "common/names.h"
#include "common/path.h"
#include "common/sidecar.h"

/* Whether only a part of the range of roughness was requested. */
static bool is_part(const ibl_bake *b)
{
    const ibl_specular_options *o = &b->opts->bake.specular_options;
    return o->roughness_min > 0 || o->roughness_max < 1;
}

/* "environment": the level is the environment itself. */
static const char *level_method(const ibl_specular_level *level)
{
    if (level->samples)
        return "sampled";
    return level->degree || level->reach > 0 ? "spectral" : "environment";
}

bool ibl_bake_without_lights(const ibl_bake *b, ibl_output_kind kind)
{
    return b->opts->lights &&
           (kind == IBL_OUTPUT_SPECULAR || kind == IBL_OUTPUT_IRRADIANCE);
}

static const char *irradiance_method(const ibl_bake *b)
{
    return b->made.irradiance_degree ? "spectral" : "hemisphere grid";
}

static const char *lut_method(const ibl_bake *b)
{
    return b->opts->lut.samples ? "hammersley" : "quadrature";
}

/* ---- keys ------------------------------------------------------------ */

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

/* Filament takes its harmonics from the KTX file of the levels. */
static void set_harmonics(setter *s, const ibl_bake *b)
{
    char *text = ibl_sh_key(b->made.sh);

    if (!text || (!s->status && ibl_texture_set(s->ctx, s->tex, "sh", text)))
        s->status = IBL_ERR_MEMORY;
    free(text);
}

static void set_specular(setter *s, const ibl_bake *b)
{
    if (b->opts->format == IBL_CONTAINER_KTX && b->opts->bake.sh_degree >= 2)
        set_harmonics(s, b);
    if (!s->status)
        s->status = ibl_texture_describe_specular(
            s->ctx, s->tex, &b->opts->bake.specular_options, &b->made.report);
}

static void set_irradiance(setter *s, const ibl_bake *b)
{
    set(s, "iblbake.method", "%s", irradiance_method(b));
    if (b->opts->bake.irradiance_options.step > 0)
        set(s, "iblbake.step", "%.9g", b->opts->bake.irradiance_options.step);
    if (!s->status)
        s->status = ibl_texture_describe_irradiance(s->ctx, s->tex);
}

static void set_lut(setter *s, const ibl_bake *b)
{
    if (!s->status)
        s->status = ibl_texture_describe_lut(s->ctx, s->tex, &b->opts->lut);
}

static const char *fitted_to(const ibl_bake *b)
{
    return b->opts->lobe_table == IBL_LOBES_FITTED ? "map" : "photographs";
}

/* Names of the layers, in order; NULL after the last. */
static const char *lobe_layer(const ibl_bake *b, int i)
{
    static const char *const names[IBL_LOBE_LAYERS] = {
        "one tap, F0 = 1", "one tap, F0 = 0.04", "two taps, F0 = 1",
        "two taps, F0 = 0.04"};
    const ibl_f0 f0 = b->opts->lobe_f0;

    if (f0 != IBL_F0_BOTH)
        i = 2 * i + (f0 == IBL_F0_DIELECTRICS);
    return i < IBL_LOBE_LAYERS ? names[i] : NULL;
}

static void set_lobes(setter *s, const ibl_bake *b)
{
    char roughness[IBL_MAX_LEVELS * 24] = "", layers[96] = "";

    for (int i = 0; lobe_layer(b, i); i++) {
        const size_t used = strlen(layers);
        snprintf(layers + used, sizeof layers - used, "%s%s", i ? ";" : "",
                 lobe_layer(b, i));
    }
    for (int l = 0; l < b->lobe_layout.levels; l++) {
        const size_t used = strlen(roughness);
        snprintf(roughness + used, sizeof roughness - used, "%s%.9g",
                 l ? "," : "", b->lobe_layout.roughness[l]);
    }
    set(s, "iblbake.fitted_to", "%s", fitted_to(b));
    set(s, "iblbake.axes", "u=N.V,v=roughness");
    set(s, "iblbake.layers", "%s", layers);
    set(s, "iblbake.roughness", "%s", roughness);
}

/* Tables are of no environment's orientation and have one level. */
static bool is_table(ibl_output_kind kind)
{
    return kind == IBL_OUTPUT_LUT || kind == IBL_OUTPUT_LOBES;
}

static void set_colour(setter *s, const ibl_read_options *o)
{
    if (o->primaries)
        set(s, "iblbake.primaries", "%s", ibl_primaries_name(o->primaries));
    if (o->exposure < 0 || o->exposure > 0)
        set(s, "iblbake.exposure", "%.17g", o->exposure);
    if (o->clamp > 0)
        set(s, "iblbake.clamp", "%.17g", o->clamp);
}

static void set_orientation(setter *s, const ibl_bake *b)
{
    const ibl_axes *axes = &b->opts->axes;
    set(s, "iblbake.yaw_deg", "%.9g", b->opts->bake.yaw_deg);
    if (axes->mirror)
        set(s, "iblbake.mirror", "%s", ibl_mirror_names[axes->mirror]);
    if (axes->up)
        set(s, "iblbake.up", "%s", ibl_up_names[axes->up]);
}

bool ibl_texture_metadata(const ibl_bake *b, ibl_output_kind kind,
                          ibl_texture *tex)
{
    setter s = {b->ctx, tex, IBL_OK};

    if (b->opts->zstd)
        set(&s, "KTXwriterScParams", "--zstd %d", b->opts->zstd);
    set(&s, "iblbake.content", "%s", ibl_output_content(kind));
    if (!is_table(kind))
        set_orientation(&s, b);
    if (!is_table(kind))
        set_colour(&s, &b->opts->common.read);
    if (ibl_bake_without_lights(b, kind))
        set(&s, "iblbake.lights", "%d", b->from->light_count);
    if (ibl_pixel_block(tex->pixel) > 1) {
        set(&s, "iblbake.pixel", "%s", ibl_pixel_name(tex->pixel));
        set(&s, "iblbake.quality", "%s",
            ibl_quality_name(b->opts->texels.quality));
    }
    if (kind == IBL_OUTPUT_SPECULAR)
        set_specular(&s, b);
    else if (kind == IBL_OUTPUT_IRRADIANCE)
        set_irradiance(&s, b);
    else if (kind == IBL_OUTPUT_LUT)
        set_lut(&s, b);
    else if (kind == IBL_OUTPUT_LOBES)
        set_lobes(&s, b);
    return !s.status;
}

/* ---- the sidecar ------------------------------------------------------ */

/* A sidecar encodes all its file names if one of them is not UTF-8. */
static bool has_encoded_names(const ibl_bake *b)
{
    return !ibl_json_is_text(b->opts->input) ||
           !ibl_json_is_text(b->opts->name);
}

static json_t *file_name(const ibl_bake *b, const char *name)
{
    return has_encoded_names(b) ? ibl_json_encoded(name) : json_string(name);
}

/* Degrees in a radian. */
static const double degrees = 57.295779513082320877;

static json_t *numbers(const double *x, int count)
{
    json_t *j = json_array();
    for (int i = 0; i < count; i++)
        append(&j, json_real(x[i] + 0.0)); /* no negative zero */
    return j;
}

static json_t *source(const ibl_bake *b)
{
    const ibl_read_report *r = &b->from->report;
    json_t *j = json_pack(
        "{so so si si sf sI sI sb sb}", "path", file_name(b, b->opts->input),
        "format", ibl_json_string(r->format), "width", b->from->width, "height",
        b->from->height, "peak", (double)r->peak, "nonfinite_pixels",
        (json_int_t)r->nonfinite, "negative_pixels", (json_int_t)r->negative,
        "low_range", r->low_range, "bridged", r->bridged);

    if (*r->hash)
        put(&j, "xxh3_128", json_string(r->hash));
    put(&j, "primaries",
        *r->primaries_name ? json_string(r->primaries_name)
                           : numbers(r->primaries, 8));
    if (r->layout != IBL_INPUT_EQUIRECT)
        put(&j, "layout", json_string(ibl_input_layout_name(r->layout)));
    return j;
}

/* What was done to the colours of the source. */
static json_t *colour(const ibl_bake *b)
{
    const ibl_read_options *o = &b->opts->common.read;
    const ibl_read_report *r = &b->from->report;
    json_t *j =
        json_pack("{ss sf}", "primaries", ibl_primaries_name(o->primaries),
                  "exposure_ev", o->exposure);

    if (o->primaries)
        put(&j, "outside_pixels", json_integer((json_int_t)r->outside));
    if (o->clamp > 0)
        put_all(&j, json_pack("{sf sI sf}", "clamp", o->clamp, "clamped_pixels",
                              (json_int_t)r->clamped, "clamp_removed",
                              r->clamp_removed));
    return j;
}

/* Whether a value given is that of the defaults. */
static bool is_usual(const ibl_opts *usual, const ibl_opts *opts,
                     const ibl_option *option)
{
    const size_t at = option->offset;
    const char *a = (const char *)usual + at, *b = (const char *)opts + at;

    switch (option->kind) {
    case IBL_OPTION_INT:
    case IBL_OPTION_CHOICE:
    case IBL_OPTION_FLAG:
        return !memcmp(a, b, sizeof(int));
    case IBL_OPTION_REAL:
        return !memcmp(a, b, sizeof(double));
    default:
        return false;
    }
}

/* The options that were given and are not the default, or the target's, as
 * text. */
static json_t *options(const ibl_bake *b)
{
    const ibl_given *given = &b->opts->given;
    ibl_opts *usual = calloc(1, sizeof *usual);
    json_t *j = json_object();

    if (usual)
        ibl_bake_command.defaults(usual);
    else
        put(&j, "", NULL);
    for (int i = 0; usual && i < given->count; i++) {
        const ibl_option *o = given->list[i].option;
        const char *value = given->list[i].value;
        if (b->opts->of || !is_usual(usual, b->opts, o))
            put(&j, o->name, value ? ibl_json_string(value) : json_true());
    }
    free(usual);
    return j;
}

/* The luminance of the environment: the constant of its harmonics, with the
 * lights that were taken out of it. */
static double mean_luminance(const ibl_bake *b)
{
    const double constant = 0.28209479177387814; /* sqrt(1 / 4 pi) */
    double sum = 0;

    for (int c = 0; c < 3; c++) {
        double mean = constant * b->made.sh[c];
        for (int i = 0; i < b->from->light_count; i++)
            mean += b->from->lights[i].irradiance[c] / (4 * M_PI);
        sum += b->from->report.luma[c] * mean;
    }
    return sum;
}

/* Turned as the outputs are. */
static json_t *brightest(const ibl_bake *b)
{
    const ibl_brightest *s = &b->from->report.brightest;
    const double yaw = b->opts->bake.yaw_deg / degrees, *d = s->direction;
    double turned[3] = {cos(yaw) * d[0] + sin(yaw) * d[2], d[1],
                        cos(yaw) * d[2] - sin(yaw) * d[0]};

    ibl_axes_turn(b->opts->axes, 0, turned, turned);
    if (!s->found)
        return json_null();
    return json_pack("{so so sf sf ss}", "direction", numbers(turned, 3),
                     "irradiance", numbers(s->irradiance, 3), "solid_angle_sr",
                     s->solid_angle, "share", round(s->share * 10) / 10, "is",
                     "the pixels within 10 degrees of the brightest that have "
                     "that share of it or more");
}

static json_t *environment(const ibl_bake *b)
{
    return json_pack("{sf so so}", "mean_luminance", mean_luminance(b),
                     "luminance_weights", numbers(b->from->report.luma, 3),
                     "brightest", brightest(b));
}

static const char *axes_text(const ibl_axes *axes)
{
    static const char *const text[2][4] = {
        {"x, y, z", "-x, y, z", "x, y, -z", "z, y, x"},
        {"x, -z, y", "-x, -z, y", "x, z, y", "z, -x, y"}};
    return text[axes->up][axes->mirror];
}

static json_t *orientation(const ibl_bake *b)
{
    const ibl_axes *axes = &b->opts->axes;
    json_t *j = json_pack(
        "{ss ss ss sf}", "world", "right-handed, +Y up", "equirect",
        "row 0 is +Y, u = atan2(z, x) / 2pi + 1/2", "faces",
        "+X -X +Y -Y +Z -Z, row 0 on top", "yaw_deg", b->opts->bake.yaw_deg);
    if (axes->mirror)
        put(&j, "mirror", json_string(ibl_mirror_names[axes->mirror]));
    if (axes->up)
        put(&j, "up", json_string(ibl_up_names[axes->up]));
    if (axes->mirror || axes->up)
        put(&j, "outputs",
            json_sprintf("(x, y, z) of the world is (%s) in cubes, sh and "
                         "lights",
                         axes_text(axes)));
    return j;
}

static json_t *levels(const ibl_bake *b, ibl_output_kind kind)
{
    const ibl_texture *shape = &b->files[kind].shape;
    json_t *j = json_array();

    for (int l = 0; l < shape->levels; l++) {
        json_t *level = json_object();
        put(&level, "size", json_integer(ibl_cube_edge(shape->width, l)));
        if (kind == IBL_OUTPUT_SPECULAR) {
            const ibl_specular_level *made = &b->made.report.level[l];
            put(&level, "roughness",
                json_real(b->made.report.layout.roughness[l]));
            put(&level, "method", json_string(level_method(made)));
            if (made->samples)
                put(&level, "samples", json_integer(made->samples));
            if (made->degree)
                put(&level, "degree", json_integer(made->degree));
            if (made->reach > 0)
                put(&level, "reach_deg", json_real(made->reach * degrees));
            /* JSON has no infinity. */
            if (made->error >= 0)
                put(&level, "estimated_error",
                    json_real(fmin(made->error, DBL_MAX)));
        }
        put(&level, "pixel_error",
            ibl_json_pixel_error(&b->files[kind].error[l]));
        const ibl_overflow_level *overflow = &b->files[kind].overflow.level[l];
        if (overflow->texels)
            put(&level, "beyond", ibl_json_overflow(overflow));
        append(&j, level);
    }
    return j;
}

/* The formula of the lod: with "levels" for the whole range, else numbers. */
static json_t *lod(const ibl_bake *b)
{
    const ibl_specular_layout *layout = &b->made.report.layout;
    const ibl_roughness_map map = layout->mapping;
    const char *x = map == IBL_ROUGHNESS_LINEAR ? "roughness"
                                                : "roughness * (2 - roughness)";
    if (map == IBL_ROUGHNESS_BABYLON)
        return json_sprintf("%.9g * log2(%d * roughness * roughness)",
                            layout->lod_scale, layout->size);
    if (map == IBL_ROUGHNESS_BEST)
        return json_string("of the lobe table; without it, straight lines "
                           "between the levels' roughnesses");
    if (!is_part(b))
        return json_sprintf("%s * (levels - 1)", x);
    return json_sprintf("%s * %.9g + %.9g", x, layout->lod_scale,
                        layout->lod_offset);
}

/* The requested range, and the whole chain that it is a part of. */
static void put_part(const ibl_bake *b, json_t **j)
{
    const ibl_specular_options *o = &b->opts->bake.specular_options;
    put(j, "roughness_range",
        json_pack("[ff]", o->roughness_min, o->roughness_max));
    put(j, "whole_chain",
        json_pack("{si si}", "size", o->size, "levels",
                  ibl_default_levels(o->size)));
}

static void put_specular(const ibl_bake *b, json_t **j)
{
    const ibl_specular_options *o = &b->opts->bake.specular_options;
    const ibl_specular_report *made = &b->made.report;
    put(j, "lobe", json_string(ibl_lobe_name(o->lobe)));
    put(j, "weight", json_string(ibl_lobe_formula(o->lobe)));
    put(j, "method", json_string(ibl_specular_report_method(made)));
    put(j, "mapping",
        json_string(ibl_roughness_map_name(made->layout.mapping)));
    put(j, "lod", lod(b));
    put(j, "lod_scale", json_real(made->layout.lod_scale));
    put(j, "lod_offset", json_real(made->layout.lod_offset));
    if (is_part(b))
        put_part(b, j);
    put(j, "tolerance", json_real(o->tolerance));
    put(j, "estimate",
        json_string("bound of the 95th percentile of the relative error, "
                    "before rounding to the pixel"));
    if (!made->lookup_size)
        return;
    put(j, "lookup_size", json_integer(made->lookup_size));
    put(j, "lod_bias", json_real(o->lod_bias));
    put(j, "jitter", json_boolean(o->jitter));
    put(j, "pdf_mip", json_boolean(o->pdf_mip));
}

static void put_irradiance(const ibl_bake *b, json_t **j)
{
    put(j, "scale", json_string("E/pi"));
    put(j, "method", json_string(irradiance_method(b)));
    if (b->made.irradiance_degree)
        put(j, "degree", json_integer(b->made.irradiance_degree));
    if (b->opts->bake.irradiance_options.step > 0)
        put(j, "step_rad", json_real(b->opts->bake.irradiance_options.step));
}

static void put_lut(const ibl_bake *b, json_t **j)
{
    static const char *const values[] = {
        "specular = F0 * R + G",
        "specular = (1 - F0) * R + F0 * G; B: albedo of cloth",
        "albedo of sheen; R: with Ashikhmin's V, G: with Charlie's"};
    const ibl_lut_options *o = &b->opts->lut;
    put(j, "axes",
        json_string("u = N.V, v = roughness, at texel centres; row 0 is the "
                    "smoothest"));
    put(j, "values", json_string(values[o->kind]));
    if (o->kind)
        put(j, "table", json_string(ibl_lut_name(o->kind)));
    else
        put(j, "geometry", json_string(ibl_geometry_name(o->geometry)));
    put(j, "method", json_string(lut_method(b)));
    if (o->samples)
        put(j, "samples", json_integer(o->samples));
}

static void put_lobes(const ibl_bake *b, json_t **j)
{
    const ibl_specular_layout *layout = &b->lobe_layout;
    json_t *layers = json_array(), *roughness = json_array();

    for (int i = 0; lobe_layer(b, i); i++)
        append(&layers, json_string(lobe_layer(b, i)));
    for (int l = 0; l < layout->levels; l++)
        append(&roughness, json_real(layout->roughness[l]));
    put(j, "axes",
        json_string("u = N.V, v = roughness, at texel centres; row 0 is the "
                    "smoothest"));
    put(j, "values",
        json_string("R: bend of mix(reflection, N, R), G: lod / (levels - 1), "
                    "B: share of irradiance at N, A: half the difference of "
                    "the bends of two taps"));
    put(j, "layers", layers);
    put(j, "fitted_to", json_string(fitted_to(b)));
    put(j, "level_roughness", roughness);
}

static const char *pixel_name(const ibl_bake *b, const ibl_baked *file)
{
    return b->opts->engine ? ibl_engine_pixel(b->opts->engine)
                           : ibl_pixel_name(file->shape.pixel);
}

static json_t *output(const ibl_bake *b, ibl_output_kind kind)
{
    const ibl_baked *file = &b->files[kind];
    json_t *j = json_pack(
        "{ss so ss ss si si si sI sI}", "content", ibl_output_content(kind),
        "file", file_name(b, ibl_path_name(file->path)), "container",
        ibl_format_names[b->opts->file], "pixel", pixel_name(b, file), "width",
        file->shape.width, "height", file->shape.height, "faces",
        file->shape.faces, "bytes", (json_int_t)file->bytes, "saturated",
        (json_int_t)file->overflow.values);

    if (b->opts->zstd)
        put(&j, "zstd", json_integer(b->opts->zstd));
    if (ibl_pixel_block(file->shape.pixel) > 1)
        put(&j, "quality",
            json_string(ibl_quality_name(b->opts->texels.quality)));
    if (!is_table(kind) && file->shape.faces == 1)
        put(&j, "layout",
            json_string(ibl_projection_name(b->opts->bake.skybox_projection)));
    if (!is_table(kind))
        put(&j, "overflow",
            json_string(ibl_overflow_name(b->opts->texels.overflow)));
    if (kind == IBL_OUTPUT_SPECULAR)
        put_specular(b, &j);
    else if (kind == IBL_OUTPUT_IRRADIANCE)
        put_irradiance(b, &j);
    else if (kind == IBL_OUTPUT_LUT)
        put_lut(b, &j);
    else if (kind == IBL_OUTPUT_LOBES)
        put_lobes(b, &j);
    if (!is_table(kind))
        put(&j, "levels", levels(b, kind));
    return j;
}

static json_t *outputs(const ibl_bake *b)
{
    json_t *j = json_array();
    for (int kind = 0; kind < IBL_OUTPUT_JSON; kind++)
        if (b->files[kind].path)
            append(&j, output(b, (ibl_output_kind)kind));
    return j;
}

/* The sum up to l = 2, with the basis as polynomials in n (Ramamoorthi and
 * Hanrahan 2001, eq. 3): sqrt(1/4pi), sqrt(3/4pi), sqrt(15/4pi),
 * sqrt(5/16pi), sqrt(15/16pi). */
static json_t *glsl(int degree)
{
    static const char *const terms[] = {
        "0.28209479 * c[0]",
        " + 0.48860251 * (n.y * c[1] + n.z * c[2] + n.x * c[3])",
        " + 1.09254843 * (n.x * n.y * c[4] + n.y * n.z * c[5] + n.z * n.x * "
        "c[7]) + 0.31539157 * (3.0 * n.z * n.z - 1.0) * c[6] + 0.54627422 * "
        "(n.x * n.x - n.y * n.y) * c[8]"};
    const int last = degree < 2 ? degree : 2;

    return json_sprintf("vec3 irradiance(vec3 n, vec3 c[%d]) { return %s%s%s; "
                        "}",
                        (last + 1) * (last + 1), terms[0],
                        last > 0 ? terms[1] : "", last > 1 ? terms[2] : "");
}

static json_t *spherical_harmonics(const ibl_bake *b)
{
    const int degree = b->opts->bake.sh_degree;
    json_t *j = json_object();

    ibl_json_put_basis(&j, degree);
    put(&j, "radiance", ibl_json_harmonics(b->made.sh, degree, false));
    put(&j, "irradiance_scale", json_string("E/pi"));
    put(&j, "irradiance", ibl_json_harmonics(b->made.sh, degree, true));
    put(&j, "glsl", glsl(degree));
    put(&j, "glsl_use",
        json_string("c: the first of \"irradiance\", n: unit normal in the "
                    "world; gives E/pi up to l = 2"));
    return j;
}

static void put_lights(const ibl_bake *b, json_t **root)
{
    const int count = b->from->light_count;
    ibl_light lights[IBL_MAX_LIGHTS];

    memcpy(lights, b->from->lights, sizeof lights);
    for (int i = 0; i < count; i++)
        ibl_axes_turn(b->opts->axes, 0, lights[i].direction,
                      lights[i].direction);
    put(root, "lights", ibl_lights_json(lights, count));
    if (count)
        put(root, "gltf", ibl_lights_gltf(lights, count));
}

static const double expected_at[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.85, 1};

enum {
    EXPECTED = sizeof expected_at / sizeof *expected_at
};

/* What can be expected of what is rendered with F0 = 1 (f 0) or .04. */
static json_t *expected_of(const ibl_bake *b, int f,
                           const ibl_expected_error error[EXPECTED])
{
    static const char *const names[IBL_LOOKUP_COUNT] = {"split", "table",
                                                        "two_taps"};
    json_t *j = json_object();

    put(&j, "f0", json_real(f ? 0.04 : 1));
    for (int way = 0; way < (b->lobes.data ? IBL_LOOKUP_COUNT : 1); way++) {
        json_t *list = json_array();
        for (int i = 0; i < EXPECTED; i++)
            append(&list, json_real(round(error[i].nrmse[f][way] * 1e4) / 1e4));
        put(&j, names[way], list);
    }
    return j;
}

/* NULL, after a message, if it fails. */
static json_t *expected(const ibl_bake *b)
{
    const ibl_lobe_table_options o = {.struct_size = sizeof o,
                                      .size = 16,
                                      .layout = b->made.report.layout,
                                      .power = b->made.power,
                                      .power_degree = b->made.power_degree};
    ibl_expected_error error[EXPECTED];
    json_t *j = json_object(), *at = json_array(), *of = json_array();

    if (ibl_bake_expected_error(b->ctx, &o, b->lobes.data ? &b->lobes : NULL,
                                expected_at, EXPECTED, error)) {
        json_decref(j);
        json_decref(at);
        json_decref(of);
        return NULL;
    }
    for (int i = 0; i < EXPECTED; i++)
        append(&at, json_real(expected_at[i]));
    for (int f = 0; f < 2; f++)
        append(&of, expected_of(b, f, error));
    put(&j, "measure",
        json_string("nRMSE of what a shader draws, over all rotations of the "
                    "map and the views of a sphere, from the map's spectrum"));
    put(&j, "roughness", at);
    put(&j, "errors", of);
    return j;
}

/* The time of each stage so far, rounded to microseconds. */
static json_t *timings(const ibl_bake *b)
{
    const ibl_console *c = b->console;
    json_t *j = json_object(), *stages = json_object();

    put(&j, "threads", json_integer(ibl_ctx_threads(b->ctx)));
    for (int i = 0; i < c->count; i++)
        put(&stages, c->stages[i].name,
            json_real(round(c->stages[i].seconds * 1e6) / 1e6));
    put(&j, "seconds", stages);
    return j;
}

char *ibl_sidecar_text(const ibl_bake *b)
{
    json_t *root = json_object();

    put(&root, "generator", ibl_json_generator(ibl_ctx_isa(b->ctx)));
    if (b->opts->of)
        put(&root, "target", json_string(b->opts->of->name));
    if (has_encoded_names(b))
        put(&root, "names", json_string(IBL_NAMES_ENCODED));
    put(&root, "source", source(b));
    put(&root, "colour", colour(b));
    put(&root, "options", options(b));
    put(&root, "environment", environment(b));
    put(&root, "orientation", orientation(b));
    put(&root, "outputs", outputs(b));
    put(&root, "sh", spherical_harmonics(b));
    if (b->opts->lights)
        put_lights(b, &root);
    if (b->made.power && b->made.specular.data)
        put(&root, "expected_rendered_error", expected(b));
    if (b->choice)
        put(&root, "choice", ibl_choice_json(b->choice));
    if (b->from->scenes)
        put(&root, "scene", ibl_scenes_json(b->from->scenes));
    if (b->opts->verify)
        put(&root, "verify", ibl_report_json(&b->judged));
    if (b->opts->timings)
        put(&root, "timings", timings(b));
    char *text = ibl_json_text(root);
    json_decref(root);
    return text;
}
