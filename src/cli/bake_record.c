/* SPDX-License-Identifier: MIT */
#include "cli/bake_record.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/names.h"
#include "common/path.h"
#include "ibl/sidecar.h"
#include "json/json_text.h"

bool ibl_bake_without_lights(const ibl_bake *b, ibl_output_kind kind)
{
    return b->opts->lights &&
           (kind == IBL_OUTPUT_SPECULAR || kind == IBL_OUTPUT_IRRADIANCE);
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
    set(s, "iblbake.method", "%s",
        b->made.irradiance_degree ? "spectral" : "hemisphere grid");
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

ibl_lobe_table_options ibl_bake_lobe_options(const ibl_bake *b)
{
    ibl_lobe_table_options o = ibl_lobe_table_options_default();

    o.size = b->opts->lobe_table_size;
    o.f0 = b->opts->lobe_f0;
    if (b->opts->lobe_table == IBL_LOBES_FITTED) {
        o.power = b->made.power;
        o.power_degree = b->made.power_degree;
    }
    o.layout = b->lobe_layout;
    return o;
}

static void set_lobes(setter *s, const ibl_bake *b)
{
    const ibl_lobe_table_options o = ibl_bake_lobe_options(b);

    if (!s->status)
        s->status = ibl_texture_describe_lobe_table(s->ctx, s->tex, &o);
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
        set(s, "iblbake.mirror", "%s", ibl_mirror_name(axes->mirror));
    if (axes->up)
        set(s, "iblbake.up", "%s", ibl_up_name(axes->up));
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

/* The options that were given and are not the default, or the target's; their
 * number, -1: no memory. */
static int list_options(const ibl_bake *b, ibl_key_value list[IBL_MOST_GIVEN])
{
    const ibl_given *given = &b->opts->given;
    ibl_opts *usual = calloc(1, sizeof *usual);
    int count = 0;

    if (!usual)
        return -1;
    ibl_bake_command.defaults(usual);
    for (int i = 0; i < given->count; i++) {
        const ibl_option *o = given->list[i].option;
        if (b->opts->of || !is_usual(usual, b->opts, o))
            list[count++] =
                (ibl_key_value){(char *)o->name, (char *)given->list[i].value};
    }
    free(usual);
    return count;
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

/* What only the program knows; NULL: nothing, or no memory, *ok false. */
static char *more(const ibl_bake *b, bool *ok)
{
    json_t *j = json_object();

    if (b->choice)
        put(&j, "choice", ibl_choice_json(b->choice));
    if (b->from->scenes)
        put(&j, "scene", ibl_scenes_json(b->from->scenes));
    if (b->opts->verify)
        put(&j, "verify", ibl_report_json(&b->judged));
    if (b->opts->timings)
        put(&j, "timings", timings(b));
    char *text = json_object_size(j) ? ibl_json_text(j) : NULL;
    *ok = j && (text || !json_object_size(j));
    json_decref(j);
    return text;
}

/* A file of the set. shape gets its texture's. */
static ibl_sidecar_output output(const ibl_bake *b, ibl_output_kind kind,
                                 ibl_texture *shape)
{
    const ibl_baked *file = &b->files[kind];

    *shape = file->shape;
    shape->zstd = b->opts->zstd;
    return (ibl_sidecar_output){
        .struct_size = sizeof(ibl_sidecar_output),
        .content = (ibl_content)kind,
        .file = ibl_path_name(file->path),
        .container = ibl_format_names[b->opts->file],
        .texture = shape,
        .pixel = b->opts->engine ? ibl_engine_pixel(b->opts->engine) : NULL,
        .bytes = file->bytes,
        .projection = b->opts->bake.skybox_projection,
        .texels = &b->opts->texels,
        .overflow = &file->overflow,
        .error = file->error,
    };
}

char *ibl_bake_sidecar(const ibl_bake *b)
{
    const ibl_bake_source *from = b->from;
    const ibl_lobe_table_options lobe_table = ibl_bake_lobe_options(b);
    ibl_texture shapes[IBL_OUTPUT_JSON];
    ibl_sidecar_output outputs[IBL_OUTPUT_JSON];
    ibl_key_value given[IBL_MOST_GIVEN];
    int count = 0;
    bool ok;
    char *text = NULL, *own = more(b, &ok);
    const int options = list_options(b, given);

    for (int i = 0; i < IBL_OUTPUT_JSON; i++)
        if (b->files[i].path) {
            outputs[count] = output(b, (ibl_output_kind)i, &shapes[count]);
            count++;
        }
    const ibl_sidecar_options facts = {
        .struct_size = sizeof facts,
        .source = b->opts->input,
        .width = from->width,
        .height = from->height,
        .read = &b->opts->common.read,
        .report = &from->report,
        .specular = &b->opts->bake.specular_options,
        .irradiance = &b->opts->bake.irradiance_options,
        .lut = &b->opts->lut,
        .lobe_table = &lobe_table,
        .yaw_deg = b->opts->bake.yaw_deg,
        .axes = b->opts->axes,
        .sh_degree = b->opts->bake.sh_degree,
        .made = &b->made,
        .lights = from->lights,
        .light_count = b->opts->lights ? from->light_count : -1,
        .lobes = b->lobes.data ? &b->lobes : NULL,
        .outputs = outputs,
        .output_count = count,
        .revision = IBL_REVISION,
        .target = b->opts->of ? b->opts->of->name : NULL,
        .options = given,
        .option_count = options,
        .more = own};
    if (ok && options >= 0)
        ibl_sidecar_text(b->ctx, &facts, &text);
    free(own);
    return text;
}
