/* SPDX-License-Identifier: MIT */
/* The text of a sidecar: what it, and keys, say of each file, then the rest. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/axes.h"
#include "io/sidecar_facts.h"

const char *ibl_quality_name(ibl_quality quality)
{
    static const char *const names[] = {"fast", "normal", "best"};
    return names[quality];
}

/* ---- levels ------------------------------------------------------------ */

/* How a specular level was made; "environment": it is the map itself. */
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

const char *ibl_content_name(ibl_content content)
{
    static const char *const names[] = {[IBL_CONTENT_SKYBOX] = "skybox",
                                        [IBL_CONTENT_SPECULAR] = "specular",
                                        [IBL_CONTENT_IRRADIANCE] = "irradiance",
                                        [IBL_CONTENT_LUT] = "brdf_lut",
                                        [IBL_CONTENT_LOBE_TABLE] = "lobe_lut"};

    return (unsigned)content <= IBL_CONTENT_LOBE_TABLE ? names[content]
                                                       : "unknown";
}

ibl_sidecar_options ibl_sidecar_options_default(void)
{
    return (ibl_sidecar_options){.light_count = -1, .sh_degree = 2};
}

static json_t *numbers(const double *x, int count)
{
    json_t *j = json_array();
    for (int i = 0; i < count; i++)
        append(&j, json_real(x[i] + 0.0)); /* no negative zero */
    return j;
}

/* ---- the environment ----------------------------------------------------- */

static json_t *source(const ibl_sidecar_facts *f)
{
    const ibl_read_report *r = f->o.report;
    json_t *j = json_pack(
        "{so so si si sf sI sI sb sb}", "path", ibl_json_string(f->o.source),
        "format", ibl_json_string(r->format), "width", f->o.width, "height",
        f->o.height, "peak", (double)r->peak, "nonfinite_pixels",
        (json_int_t)r->nonfinite, "negative_pixels", (json_int_t)r->negative,
        "low_range", r->low_range, "bridged", r->bridged);

    if (*r->hash)
        put(&j, "xxh3_128", json_string(r->hash));
    put(&j, "primaries",
        *r->primaries_name ? ibl_json_string(r->primaries_name)
                           : numbers(r->primaries, 8));
    if (r->layout != IBL_INPUT_EQUIRECT)
        put(&j, "layout", json_string(ibl_input_layout_name(r->layout)));
    if (f->read.face_order[0] + f->read.face_order[1]) {
        char order[IBL_FACE_ORDER];
        ibl_face_order_text(f->read.face_order, order);
        put(&j, "face_order", json_string(order));
    }
    return j;
}

/* What was done to the colours of the source. */
static json_t *colour(const ibl_sidecar_facts *f)
{
    const ibl_read_options *o = &f->read;
    const ibl_read_report *r = f->o.report;
    json_t *j =
        json_pack("{ss sf}", "primaries", ibl_primaries_name(o->primaries),
                  "exposure_ev", o->exposure);

    if (o->transfer)
        put(&j, "transfer",
            json_string(o->transfer == IBL_TRANSFER_LINEAR ? "linear"
                                                           : "srgb"));
    if (o->primaries)
        put(&j, "outside_pixels", json_integer((json_int_t)r->outside));
    if (o->clamp > 0)
        put_all(&j, json_pack("{sf sI sf}", "clamp", o->clamp, "clamped_pixels",
                              (json_int_t)r->clamped, "clamp_removed",
                              r->clamp_removed));
    return j;
}

/* Its mean luminance is the constant of its harmonics, with the lights that
 * were taken out of it. */
static json_t *environment(const ibl_sidecar_facts *f)
{
    const double constant = 0.28209479177387814; /* sqrt(1 / 4 pi) */
    json_t *j = json_object();
    double sum = 0;

    for (int c = 0; c < 3 && f->o.made->sh; c++) {
        double mean = constant * f->o.made->sh[c];
        for (int i = 0; i < f->o.light_count; i++)
            mean += f->o.lights[i].irradiance[c] / (4 * IBL_PI);
        sum += f->o.report->luma[c] * mean;
    }
    if (f->o.made->sh)
        put(&j, "mean_luminance", json_real(sum));
    put(&j, "luminance_weights", numbers(f->o.report->luma, 3));
    return j;
}

/* ---- the whole --------------------------------------------------------- */

static ibl_status check_output(const ibl_sidecar_facts *f,
                               const ibl_sidecar_output *o)
{
    const int most = o->content == IBL_CONTENT_SPECULAR
                         ? f->o.made->report.layout.levels
                         : IBL_MAX_LEVELS;

    if (!o->file || !o->container || !o->texture)
        return ibl_missing(f->ctx, "ibl_sidecar_text: an output's file, "
                                   "container or texture");
    if (!ibl_json_is_text(o->file))
        return ibl_fail(f->ctx, IBL_ERR_ARGUMENT,
                        "%s: a name that is no UTF-8, which a sidecar cannot "
                        "hold: give another",
                        o->file);
    if (o->texture->levels < 1 || o->texture->levels > most)
        return ibl_fail(f->ctx, IBL_ERR_ARGUMENT,
                        "%s: %d levels: must be 1 to %d", o->file,
                        o->texture->levels, most);
    return ibl_sidecar_check_content(f->ctx, o);
}

static ibl_status put_everything(const ibl_sidecar_facts *f, json_t **root)
{
    const ibl_sidecar_options *o = &f->o;
    json_t *options = json_object(), *outputs = json_array();
    json_t *orientation = json_pack("{sf}", "yaw_deg", o->yaw_deg);

    put(root, "generator",
        ibl_json_generator(ibl_ctx_isa(f->ctx), o->revision));
    if (o->target)
        put(root, "target", ibl_json_string(o->target));
    put(root, "source", source(f));
    put(root, "colour", colour(f));
    for (int i = 0; i < o->option_count; i++)
        put(&options, o->options[i].key,
            o->options[i].value ? ibl_json_string(o->options[i].value)
                                : json_true());
    put(root, "options", options);
    put(root, "environment", environment(f));
    if (o->axes.mirror)
        put(&orientation, "mirror",
            json_string(ibl_mirror_name(o->axes.mirror)));
    if (o->axes.up)
        put(&orientation, "up", json_string(ibl_up_name(o->axes.up)));
    put(root, "orientation", orientation);
    for (int i = 0; i < o->output_count; i++)
        append(&outputs, ibl_sidecar_file(f, &o->outputs[i]));
    put(root, "outputs", outputs);
    if (o->made->sh)
        put(root, "sh",
            json_pack("{si so ss so}", "degree", o->sh_degree, "radiance",
                      ibl_json_harmonics(o->made->sh, o->sh_degree, false),
                      "irradiance_scale", "E/pi", "irradiance",
                      ibl_json_harmonics(o->made->sh, o->sh_degree, true)));
    if (o->light_count >= 0) {
        ibl_light lights[IBL_MAX_LIGHTS];
        for (int i = 0; i < o->light_count; i++) {
            lights[i] = o->lights[i];
            ibl_axes_turn(o->axes, 0, lights[i].direction, lights[i].direction);
        }
        put(root, "lights", ibl_lights_json(lights, o->light_count));
        if (o->light_count)
            put(root, "gltf", ibl_lights_gltf(lights, o->light_count));
    }
    if (!o->more)
        return IBL_OK;
    /* Members of a program. */
    ibl_json_why why;
    json_t *more = ibl_json_parse("more", o->more, strlen(o->more),
                                  JSON_REJECT_DUPLICATES, &why);
    if (!more && why.status == IBL_ERR_MEMORY)
        return ibl_no_memory(f->ctx, "a sidecar");
    if (json_is_object(more)) {
        put_all(root, more);
        return IBL_OK;
    }
    json_decref(more);
    return ibl_fail(f->ctx, IBL_ERR_ARGUMENT,
                    "more of a sidecar: must be the text of a JSON object");
}

ibl_status ibl_sidecar_check_content(ibl_ctx *ctx, const ibl_sidecar_output *o)
{
    return (unsigned)o->content <= IBL_CONTENT_LOBE_TABLE
               ? IBL_OK
               : ibl_fail(ctx, IBL_ERR_ARGUMENT, "content %d: must be 0 to %d",
                          (int)o->content, IBL_CONTENT_LOBE_TABLE);
}

ibl_status ibl_sidecar_take(ibl_ctx *ctx, const ibl_sidecar_options *facts,
                            ibl_sidecar_facts *f)
{
    const ibl_sidecar_options *o = &f->o;

    f->ctx = ctx;
    f->o = *facts;
    f->read = o->read ? *o->read : ibl_read_options_default();
    f->specular = o->specular ? *o->specular : ibl_specular_options_default();
    f->irradiance =
        o->irradiance ? *o->irradiance : ibl_irradiance_options_default();
    f->lut = o->lut ? *o->lut : ibl_lut_options_default();
    f->lobe_table =
        o->lobe_table ? *o->lobe_table : ibl_lobe_table_options_default();
    const struct {
        const char *what;
        int value, low, high;
    } all[] = {
        {"lights", o->light_count, -1, o->lights ? IBL_MAX_LIGHTS : 0},
        {"degree of sh", o->made && o->made->sh ? o->sh_degree : 0, 0,
         IBL_MAX_SH_DEGREE},
        {"outputs", o->output_count, 0, o->outputs ? INT_MAX : 0},
        {"options", o->option_count, 0, o->options ? INT_MAX : 0},
        {"kind of table", (int)f->lut.kind, 0, IBL_LUT_CHARLIE},
        {"F0 of the lobe table", (int)f->lobe_table.f0, 0, IBL_F0_DIELECTRICS},
        {"levels of the lobe table", f->lobe_table.layout.levels, 0,
         IBL_MAX_LEVELS},
        {"levels", o->made ? o->made->report.layout.levels : 0, 0,
         IBL_MAX_LEVELS},
    };
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (all[i].value < all[i].low || all[i].value > all[i].high)
            return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                            "facts of a bake: %s: %d: must be %d to %d",
                            all[i].what, all[i].value, all[i].low, all[i].high);
    return ibl_check_axes(ctx, o->axes);
}

/* Memory of the library with what is in malloc's, which is freed. */
static char *move_text(char *from)
{
    const size_t size = from ? strlen(from) + 1 : 0;
    char *to = from ? ibl_alloc_array(size, 1) : NULL;

    if (to)
        memcpy(to, from, size);
    free(from);
    return to;
}

ibl_status ibl_sidecar_text(ibl_ctx *ctx, const ibl_sidecar_options *facts,
                            char **text)
{
    ibl_sidecar_facts f = {0};

    if (!ctx || !facts || !text)
        return ibl_missing(ctx, "ibl_sidecar_text: facts or text");
    *text = NULL;
    ibl_status status = ibl_sidecar_take(ctx, facts, &f);
    if (!status && (!f.o.source || !f.o.report || !f.o.made))
        status = ibl_missing(ctx, "ibl_sidecar_text: source, report or made");
    for (int i = 0; i < f.o.output_count && !status; i++)
        status = check_output(&f, &f.o.outputs[i]);
    for (int i = 0; i < f.o.option_count && !status; i++)
        if (!f.o.options[i].key || !ibl_json_is_text(f.o.options[i].key))
            status = ibl_fail(ctx, IBL_ERR_ARGUMENT,
                              "options of a sidecar: a key is no UTF-8");
    if (status)
        return status;
    json_t *root = json_object();
    status = put_everything(&f, &root);
    if (!status)
        *text = move_text(ibl_json_text(root));
    json_decref(root);
    return status || *text ? status : ibl_no_memory(ctx, "a sidecar");
}
