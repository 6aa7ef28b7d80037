/* SPDX-License-Identifier: MIT */
#include "cli/job.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/names.h"
#include "common/path.h"
#include "ibl/sidecar.h"
#include "json/json_text.h"

ibl_lobe_table_options ibl_bake_lobe_options(const ibl_output_set *b)
{
    ibl_lobe_table_options o = ibl_lobe_table_options_default();

    o.size = b->opts->lobe_table_size;
    o.f0 = b->opts->lobe_f0;
    o.layout = b->lobe_layout;
    return o;
}

/* What keys and the sidecar say of the bake; lobe_table: its options. */
static ibl_sidecar_options facts_of(const ibl_output_set *b,
                                    const ibl_lobe_table_options *lobe_table)
{
    const ibl_opts *o = b->opts;

    return (ibl_sidecar_options){.source = o->input,
                                 .width = b->from->width,
                                 .height = b->from->height,
                                 .read = &o->common.read,
                                 .report = &b->from->report,
                                 .specular = &o->bake.specular_options,
                                 .irradiance = &o->bake.irradiance_options,
                                 .lut = &o->lut,
                                 .lobe_table = lobe_table,
                                 .yaw_deg = o->bake.yaw_deg,
                                 .axes = o->axes,
                                 .sh_degree = o->bake.sh_degree,
                                 .made = &b->made,
                                 .lights = b->from->lights,
                                 .light_count =
                                     o->lights ? b->from->light_count : -1,
                                 .revision = IBL_REVISION,
                                 .target = o->of ? o->of->name : NULL};
}

/* ---- keys ------------------------------------------------------------ */

/* Filament takes its harmonics from the KTX file of the levels. */
static bool set_harmonics(const ibl_output_set *b, ibl_texture *tex)
{
    char *text = ibl_sh_text(IBL_SH_NONE, b->made.sh);
    const bool ok = text && !ibl_texture_set(b->ctx, tex, "sh", text);

    free(text);
    return ok;
}

bool ibl_texture_metadata(const ibl_output_set *b, ibl_output_kind kind,
                          ibl_texture *tex)
{
    const ibl_opts *o = b->opts;
    const ibl_lobe_table_options lobe_table = ibl_bake_lobe_options(b);
    const ibl_sidecar_options facts = facts_of(b, &lobe_table);
    const ibl_sidecar_output output = {.content = (ibl_content)kind,
                                       .texels = &o->texels};
    char writer[32];

    snprintf(writer, sizeof writer, "--zstd %d", o->zstd);
    return (!o->zstd ||
            !ibl_texture_set(b->ctx, tex, "KTXwriterScParams", writer)) &&
           !ibl_texture_describe(b->ctx, tex, &facts, &output) &&
           (kind != IBL_OUTPUT_SPECULAR || o->format != IBL_CONTAINER_KTX ||
            o->bake.sh_degree < 2 || set_harmonics(b, tex));
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
static int list_options(const ibl_output_set *b,
                        ibl_key_value list[IBL_MOST_GIVEN])
{
    const ibl_given *given = &b->opts->given;
    ibl_opts *usual = calloc(1, sizeof *usual);
    int count = 0;

    if (!usual)
        return -1;
    ibl_bake_command.defaults(usual);
    for (int i = 0; i < given->count; i++) {
        const ibl_option *o = given->list[i].option;
        if (!o->aside && (b->opts->of || !is_usual(usual, b->opts, o)))
            list[count++] =
                (ibl_key_value){(char *)o->name, (char *)given->list[i].value};
    }
    free(usual);
    return count;
}

/* The time of each stage so far, rounded to microseconds. */
static json_t *timings(const ibl_output_set *b)
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
static char *more(const ibl_output_set *b, bool *ok)
{
    json_t *j = json_object();

    if (b->choice)
        put(&j, "choice", ibl_choice_json(b->choice));
    if (b->from->scenes)
        put(&j, "scene", ibl_scenes_json(b->from->scenes));
    if (b->opts->verify)
        put(&j, "verify", json_incref(b->judged.json));
    if (b->opts->timings)
        put(&j, "timings", timings(b));
    char *text = json_object_size(j) ? ibl_json_text(j) : NULL;
    *ok = j && (text || !json_object_size(j));
    json_decref(j);
    return text;
}

const char *ibl_baked_pixel(const ibl_opts *o, ibl_pixel pixel)
{
    const char *own = o->engine    ? ibl_engine_pixel(o->engine)
                      : o->picture ? ibl_picture_pixel(o->picture)
                                   : NULL;

    return own ? own : ibl_pixel_name(pixel);
}

/* The name of a file from the sidecar's folder. */
static bool name_file(const ibl_output_set *b, ibl_output_kind kind, char *name,
                      size_t size)
{
    const char *below = b->opts->below ? b->opts->below : "";
    size_t used = 0;

    for (; *below && ibl_set_is_shared(b->opts, kind); below++)
        if (*below == '/' && used + 3 < size) {
            memcpy(name + used, "../", 3);
            used += 3;
        }
    return (size_t)snprintf(name + used, size - used, "%s",
                            ibl_path_name(b->files[kind].path)) < size - used;
}

/* A file of the set. shape gets its texture's. */
static ibl_sidecar_output output(const ibl_output_set *b, ibl_output_kind kind,
                                 const char *name, ibl_texture *shape)
{
    const ibl_output *file = &b->files[kind];

    *shape = file->shape;
    shape->zstd = b->opts->zstd;
    return (ibl_sidecar_output){
        .content = (ibl_content)kind,
        .file = name,
        .container = ibl_format_names[b->opts->file],
        .texture = shape,
        .pixel = ibl_baked_pixel(b->opts, file->shape.pixel),
        .bytes = file->bytes,
        .hash = file->hash,
        .projection = b->opts->bake.skybox_projection,
        .texels = &b->opts->texels,
        .overflow = &file->overflow,
        .error = b->opts->picture == IBL_PICTURE_PNG ? NULL : file->error,
        .more = (const char *const *)file->more,
        .more_count = file->count - 1,
    };
}

char *ibl_set_sidecar(const ibl_output_set *b)
{
    const ibl_lobe_table_options lobe_table = ibl_bake_lobe_options(b);
    ibl_sidecar_options facts = facts_of(b, &lobe_table);
    ibl_texture shapes[IBL_OUTPUT_JSON];
    char names[IBL_OUTPUT_JSON][4096];
    ibl_sidecar_output outputs[IBL_OUTPUT_JSON];
    ibl_key_value given[IBL_MOST_GIVEN];
    int count = 0;
    bool ok;
    char *text = NULL, *own = more(b, &ok);
    const int options = list_options(b, given);

    for (int i = 0; i < IBL_OUTPUT_JSON; i++)
        if (b->files[i].path) {
            ok &= name_file(b, (ibl_output_kind)i, names[i], sizeof *names);
            outputs[count] =
                output(b, (ibl_output_kind)i, names[i], &shapes[count]);
            count++;
        }
    facts.outputs = outputs;
    facts.output_count = count;
    facts.options = given;
    facts.option_count = options;
    facts.more = own;
    if (ok && options >= 0)
        ibl_sidecar_text(b->ctx, &facts, &text);
    free(own);
    return text;
}
