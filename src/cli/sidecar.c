/* SPDX-License-Identifier: MIT */
#include "cli/sidecar.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/json_text.h"

/* jansson's setters take the value over and cope with NULL ones: they fail,
 * which json_failed remembers, so that building reads as a list. */
typedef struct builder {
    const ibl_bake *b;
    bool failed;
} builder;

static void put(builder *s, json_t *object, const char *key, json_t *value)
{
    s->failed |= json_object_set_new(object, key, value) != 0;
}

static void append(builder *s, json_t *array, json_t *value)
{
    s->failed |= json_array_append_new(array, value) != 0;
}

static json_t *generator(builder *s)
{
    json_t *j = json_object();
    put(s, j, "name", json_string("iblbake"));
    put(s, j, "version", json_string(IBL_VERSION));
    if (*IBL_REVISION)
        put(s, j, "revision", json_string(IBL_REVISION));
    put(s, j, "isa", json_string(ibl_isa_name(ibl_ctx_isa(s->b->ctx))));
    return j;
}

static json_t *source(builder *s)
{
    const ibl_read_report *r = &s->b->report;
    json_t *j = json_object();
    put(s, j, "path", ibl_json_string(s->b->opts->input));
    put(s, j, "format", ibl_json_string(r->format));
    put(s, j, "width", json_integer(s->b->width));
    put(s, j, "height", json_integer(s->b->height));
    put(s, j, "peak", json_real((double)r->peak));
    put(s, j, "nonfinite_pixels", json_integer((json_int_t)r->nonfinite));
    put(s, j, "negative_pixels", json_integer((json_int_t)r->negative));
    put(s, j, "low_range", json_boolean(r->low_range));
    put(s, j, "bridged", json_boolean(r->bridged));
    return j;
}

static json_t *orientation(builder *s)
{
    json_t *j = json_object();
    put(s, j, "world", json_string("right-handed, +Y up"));
    put(s, j, "equirect",
        json_string("row 0 is +Y, u = atan2(z, x) / 2pi + 1/2"));
    put(s, j, "faces", json_string("+X -X +Y -Y +Z -Z, row 0 on top"));
    put(s, j, "yaw_deg", json_real(s->b->opts->yaw_deg));
    return j;
}

static json_t *levels(builder *s, ibl_output_kind kind)
{
    const ibl_texture *shape = &s->b->files[kind].shape;
    json_t *j = json_array();

    for (int l = 0; l < shape->levels; l++) {
        json_t *level = json_object();
        put(s, level, "size", json_integer(ibl_cube_edge(shape->width, l)));
        if (kind == IBL_OUTPUT_SPECULAR) {
            const ibl_specular_level *made = &s->b->made.report.level[l];
            put(s, level, "roughness",
                json_real(s->b->made.report.layout.roughness[l]));
            put(s, level, "method",
                json_string(made->samples  ? "sampled"
                            : made->degree ? "spectral"
                                           : "environment"));
            if (made->samples)
                put(s, level, "samples", json_integer(made->samples));
            if (made->degree)
                put(s, level, "degree", json_integer(made->degree));
            /* JSON has no infinity; a bound beyond all use says as much. */
            if (made->error >= 0)
                put(s, level, "estimated_error",
                    json_real(fmin(made->error, DBL_MAX)));
        }
        append(s, j, level);
    }
    return j;
}

/* Where a shader finds a roughness: in words for the whole chain, else with
 * its numbers. */
static json_t *lod(const builder *s)
{
    const ibl_specular_layout *layout = &s->b->made.report.layout;
    const bool linear = s->b->opts->specular.mapping == IBL_ROUGHNESS_LINEAR;
    const char *x = linear ? "roughness" : "roughness * (2 - roughness)";
    if (!ibl_bake_is_part(s->b))
        return json_sprintf("%s * (levels - 1)", x);
    return json_sprintf("%s * %.9g + %.9g", x, layout->lod_scale,
                        layout->lod_offset);
}

/* Of the whole chain, what was not made. */
static void put_part(builder *s, json_t *j)
{
    const ibl_specular_options *o = &s->b->opts->specular;
    json_t *whole = json_object();
    put(s, j, "roughness_range",
        json_pack("[ff]", o->roughness_min, o->roughness_max));
    put(s, whole, "size", json_integer(o->size));
    put(s, whole, "levels", json_integer(ibl_default_levels(o->size)));
    put(s, j, "whole_chain", whole);
}

/* The lobe, N = V = R. */
static const char *weight_of(ibl_lobe lobe)
{
    switch (lobe) {
    case IBL_LOBE_CHARLIE:
        return "sin(theta_h)^(1 / alpha) N.L, alpha = roughness^2";
    case IBL_LOBE_PHONG:
        return "(R.L)^n N.L, n = (1 / alpha^2 - 1) / 2, alpha = roughness^2";
    case IBL_LOBE_GGX:
        break;
    }
    return "D_GGX(N.H) N.L, alpha = roughness^2";
}

static void put_specular(builder *s, json_t *j)
{
    const ibl_specular_options *o = &s->b->opts->specular;
    const ibl_specular_report *made = &s->b->made.report;
    put(s, j, "lobe", json_string(ibl_lobe_name(o->lobe)));
    put(s, j, "weight", json_string(weight_of(o->lobe)));
    put(s, j, "method", json_string(ibl_bake_specular_method(s->b)));
    put(s, j, "mapping", json_string(ibl_roughness_map_name(o->mapping)));
    put(s, j, "lod", lod(s));
    put(s, j, "lod_scale", json_real(made->layout.lod_scale));
    put(s, j, "lod_offset", json_real(made->layout.lod_offset));
    if (ibl_bake_is_part(s->b))
        put_part(s, j);
    if (o->tolerance > 0)
        put(s, j, "tolerance", json_real(o->tolerance));
    put(s, j, "estimate",
        json_string("bound of the 95th percentile of the relative error, "
                    "before rounding to the pixel"));
    if (!ibl_bake_is_sampled(s->b))
        return;
    put(s, j, "lookup_size", json_integer(made->lookup_size));
    put(s, j, "lod_bias", json_real(o->lod_bias));
    put(s, j, "jitter", json_boolean(o->jitter));
    put(s, j, "pdf_mip", json_boolean(o->pdf_mip));
}

static void put_irradiance(builder *s, json_t *j)
{
    put(s, j, "scale", json_string("E/pi"));
    put(s, j, "method", json_string(ibl_bake_irradiance_method(s->b)));
    if (s->b->made.irradiance_degree)
        put(s, j, "degree", json_integer(s->b->made.irradiance_degree));
    if (s->b->opts->irradiance.step > 0)
        put(s, j, "step_rad", json_real(s->b->opts->irradiance.step));
}

static void put_lut(builder *s, json_t *j)
{
    const ibl_lut_options *o = &s->b->opts->lut;
    put(s, j, "axes",
        json_string("u = N.V, v = roughness, at texel centres; row 0 is the "
                    "smoothest"));
    put(s, j, "values", json_string("specular = F0 * R + G"));
    put(s, j, "geometry", json_string(ibl_geometry_name(o->geometry)));
    put(s, j, "method", json_string(ibl_bake_lut_method(s->b)));
    if (o->samples)
        put(s, j, "samples", json_integer(o->samples));
}

static json_t *output(builder *s, ibl_output_kind kind)
{
    const ibl_baked *file = &s->b->files[kind];
    const char *slash = strrchr(file->path, '/');
    json_t *j = json_object();

    put(s, j, "content",
        json_string(kind == IBL_OUTPUT_LUT ? "brdf_lut"
                                           : ibl_output_name(kind)));
    put(s, j, "file", ibl_json_string(slash ? slash + 1 : file->path));
    put(s, j, "container",
        json_string(ibl_container_name((ibl_container)s->b->opts->format)));
    put(s, j, "pixel", json_string(ibl_pixel_name(file->shape.pixel)));
    put(s, j, "width", json_integer(file->shape.width));
    put(s, j, "height", json_integer(file->shape.height));
    put(s, j, "faces", json_integer(file->shape.faces));
    put(s, j, "bytes", json_integer((json_int_t)file->bytes));
    put(s, j, "saturated", json_integer((json_int_t)file->saturated));
    if (kind == IBL_OUTPUT_SPECULAR)
        put_specular(s, j);
    else if (kind == IBL_OUTPUT_IRRADIANCE)
        put_irradiance(s, j);
    else if (kind == IBL_OUTPUT_LUT)
        put_lut(s, j);
    if (kind != IBL_OUTPUT_LUT)
        put(s, j, "levels", levels(s, kind));
    return j;
}

static json_t *outputs(builder *s)
{
    json_t *j = json_array();
    for (int kind = 0; kind < IBL_OUTPUT_JSON; kind++)
        if (s->b->files[kind].path)
            append(s, j, output(s, (ibl_output_kind)kind));
    return j;
}

/* The coefficients, as radiance or each l times ibl_sh_cosine(l). */
static json_t *coefficients(builder *s, bool cosine)
{
    const int degree = s->b->opts->sh_degree;
    const double *a = s->b->made.sh;
    json_t *j = json_array();

    for (int l = 0; l <= degree; l++) {
        const double k = cosine ? ibl_sh_cosine(l) : 1;
        for (int m = -l; m <= l; m++, a += 3)
            append(s, j,
                   json_pack("[fff]", k * a[0] + 0.0, k * a[1] + 0.0,
                             k * a[2] + 0.0));
    }
    return j;
}

/* The basis up to l = 2 as polynomials in the direction (Ramamoorthi and
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

static json_t *spherical_harmonics(builder *s)
{
    json_t *j = json_object();
    put(s, j, "degree", json_integer(s->b->opts->sh_degree));
    put(s, j, "basis",
        json_string("real, orthonormal, polar axis +Z, no Condon-Shortley "
                    "phase: Y(1,-1), Y(1,0), Y(1,1) = +sqrt(3/4pi) y, z, x"));
    put(s, j, "order", json_string("coefficient l (l + 1) + m, [R, G, B]"));
    put(s, j, "radiance", coefficients(s, false));
    put(s, j, "irradiance_scale", json_string("E/pi"));
    put(s, j, "irradiance", coefficients(s, true));
    put(s, j, "glsl", glsl(s->b->opts->sh_degree));
    put(s, j, "glsl_use",
        json_string("c: the first of \"irradiance\", n: unit normal in the "
                    "world; gives E/pi up to l = 2"));
    return j;
}

/* What was spent until now, to the microsecond. */
static json_t *timings(builder *s)
{
    const ibl_console *c = s->b->console;
    json_t *j = json_object(), *stages = json_object();

    put(s, j, "threads", json_integer(ibl_ctx_threads(s->b->ctx)));
    for (int i = 0; i < c->count; i++)
        put(s, stages, c->stages[i].name,
            json_real(round(c->stages[i].seconds * 1e6) / 1e6));
    put(s, j, "seconds", stages);
    return j;
}

char *ibl_sidecar_text(const ibl_bake *b)
{
    builder s = {.b = b};
    json_t *root = json_object();
    char *text = NULL;

    put(&s, root, "generator", generator(&s));
    put(&s, root, "source", source(&s));
    put(&s, root, "orientation", orientation(&s));
    put(&s, root, "outputs", outputs(&s));
    put(&s, root, "sh", spherical_harmonics(&s));
    if (b->opts->verify)
        put(&s, root, "verify", ibl_report_json(&b->judged));
    if (b->opts->timings)
        put(&s, root, "timings", timings(&s));
    if (!s.failed)
        text = ibl_json_text(root);
    json_decref(root);
    return text;
}
