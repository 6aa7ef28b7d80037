/* SPDX-License-Identifier: MIT */
/* The text of a sidecar. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/axes.h"
#include "io/sidecar_facts.h"

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

/* ---- what was made of it --------------------------------------------------
 */

/* ---- the whole ------------------------------------------------------------
 */

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
