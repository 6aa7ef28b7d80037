/* SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/console.h"
#include "cli/probe_capture.h"
#include "cli/probes.h"
#include "common/path.h"
#include "common/signals.h"

ibl_status ibl_probes_no_memory(const ibl_probes_bake *p)
{
    return ibl_refuse(p->console, IBL_ERR_MEMORY, "%s: no memory for the set",
                      p->opts->input);
}

/* ---- what is asked for -------------------------------------------------- */

/* Puts what the command line says in place of the set's. */
static void override(ibl_set_bake *b, const ibl_set_bake *said)
{
    static const size_t fields[] = {
        offsetof(ibl_set_bake, size),      offsetof(ibl_set_bake, levels),
        offsetof(ibl_set_bake, pixel),     offsetof(ibl_set_bake, overflow),
        offsetof(ibl_set_bake, container), offsetof(ibl_set_bake, irradiance),
        offsetof(ibl_set_bake, alpha)};

    /* Levels of the set go with its size. */
    if (said->size >= 0)
        b->levels = 0;
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        const int value = *(const int *)((const char *)said + fields[i]);
        if (value >= 0)
            *(int *)((char *)b + fields[i]) = value;
    }
}

/* The set's options and the command line's, into the library's. */
static ibl_status find_options(ibl_probes_bake *p)
{
    ibl_set_bake *b = &p->set.bake;
    ibl_specular_options *s = &p->options.specular_options;
    ibl_specular_layout layout;

    override(b, &p->opts->said);
    p->options = ibl_bake_options_default();
    s->size = b->size;
    s->levels = b->levels;
    s->mapping = (ibl_roughness_map)b->mapping;
    s->method = (ibl_method)b->method;
    if (b->tolerance > 0)
        s->tolerance = b->tolerance;
    if (b->samples)
        s->samples = b->samples;
    p->options.irradiance = b->irradiance > 0;
    if (b->irradiance)
        p->options.irradiance_options.size = b->irradiance;
    p->options.sh_degree = b->irradiance ? -1 : IBL_PROBES_SH_DEGREE;
    if (ibl_specular_layout_of(s, &layout))
        return ibl_refuse(p->console, IBL_ERR_ARGUMENT,
                          "--levels %d: a cube of size %d has 1 to %d levels",
                          b->levels, b->size, ibl_most_levels(b->size));
    ibl_warn_of_small_faces(p->console, &layout);
    return IBL_OK;
}

static ibl_status name_files(ibl_probes_bake *p)
{
    static const char *const stems[] = {"probes_specular", "probes_irradiance",
                                        "brdf_lut"};
    const char *ext = ibl_container_name((ibl_container)p->set.bake.container);

    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++) {
        ibl_probes_texture *t = &p->index.file[kind];
        if (kind == IBL_PROBES_IRRADIANCE && !p->set.bake.irradiance)
            continue;
        snprintf(t->name, sizeof t->name, "%s.%s", stems[kind], ext);
        p->path[kind] = ibl_path_join(p->opts->output, t->name);
        if (!p->path[kind])
            return ibl_probes_no_memory(p);
    }
    p->path[IBL_PROBES_INDEX] = ibl_path_join(p->opts->output, "index.json");
    return p->path[IBL_PROBES_INDEX] ? IBL_OK : ibl_probes_no_memory(p);
}

ibl_status ibl_probes_check_input(const ibl_probes_bake *p, const char *input)
{
    for (int i = 0; i < IBL_PROBES_FILES; i++)
        if (p->path[i] && ibl_path_same(p->path[i], input))
            return ibl_refuse(
                p->console, IBL_ERR_ARGUMENT,
                "%s: is both input and output: choose another directory",
                p->path[i]);
    return IBL_OK;
}

/* ---- layers -------------------------------------------------------------- */

/* Puts a layer into its array, and frees it. */
static ibl_status take_texture(ibl_probes_bake *p, int kind, int layer,
                               ibl_texture *tex)
{
    ibl_texture *array = &p->array[kind];
    ibl_status status = IBL_OK;

    if (!array->data)
        status = ibl_texture_array_begin(p->ctx, tex, p->layers, array);
    if (!status)
        status = ibl_texture_array_put(p->ctx, array, layer, tex);
    ibl_texture_free(tex);
    return status;
}

/* alpha without texels: it is 1. */
static ibl_status take_cube(ibl_probes_bake *p, int kind, int layer,
                            const ibl_cube *cube, const ibl_cube *alpha)
{
    ibl_probes_layer *l = &p->index.layer[layer];
    ibl_overflow_report report = {0};
    ibl_texture tex = {0};

    ibl_console_progress(p->console, "texels", 0);
    ibl_status status = ibl_texture_from_cube(
        p->ctx, cube, (ibl_pixel)p->set.bake.pixel,
        (ibl_overflow)p->set.bake.overflow, &tex, &report);

    l->overflow_values += report.values;
    for (int i = 0; i < cube->levels; i++)
        ibl_overflow_add(&report.level[i], &l->overflow);
    if (!status && alpha->data)
        status = ibl_texture_set_alpha(p->ctx, &tex, alpha);
    if (!status)
        return take_texture(p, kind, layer, &tex);
    ibl_texture_free(&tex);
    return status;
}

/* Of radiance; of greys the first of three numbers is each. */
static void take_sh(ibl_probes_layer *layer, const double *sh,
                    const double *alpha)
{
    int i = 0;

    for (int l = 0; l <= IBL_PROBES_SH_DEGREE; l++)
        for (int k = 0; k < 3 * (2 * l + 1); k++, i++) {
            layer->sh[i] = ibl_sh_cosine(l) * sh[i] + 0.0;
            if (alpha)
                layer->alpha_sh[i / 3] =
                    ibl_sh_cosine(l) * alpha[i / 3 * 3] + 0.0;
        }
}

/* Whether there is room for alpha. */
static ibl_status check_alpha(const ibl_probes_bake *p, const ibl_set_entry *e)
{
    const ibl_pixel pixel = (ibl_pixel)p->set.bake.pixel;

    if (ibl_pixel_has_alpha(pixel))
        return IBL_OK;
    return ibl_refuse(p->console, IBL_ERR_UNSUPPORTED,
                      "%s: %s: has alpha below 1, which %s has no room for: "
                      "choose --pixel rgba16f or rgba32f, or --alpha ignore",
                      p->opts->input, e->capture.place, ibl_pixel_name(pixel));
}

static ibl_status take_capture(ibl_probes_bake *p, int layer,
                               const ibl_bake_result made[IBL_CAPTURE_PARTS])
{
    const ibl_bake_result *colour = &made[IBL_CAPTURE_COLOUR];
    const ibl_bake_result *alpha = &made[IBL_CAPTURE_ALPHA];
    const ibl_set_entry *e = &p->set.entry[layer];
    ibl_probes_layer *l = &p->index.layer[layer];
    ibl_status status = IBL_OK;
    char name[512];

    l->alpha = alpha->specular.data != NULL;
    if (l->alpha)
        status = check_alpha(p, e);
    if (!status)
        status = take_cube(p, IBL_PROBES_SPECULAR, layer, &colour->specular,
                           &alpha->specular);
    if (!status && p->set.bake.irradiance)
        status = take_cube(p, IBL_PROBES_IRRADIANCE, layer, &colour->irradiance,
                           &alpha->irradiance);
    if (status)
        return status;
    if (colour->sh)
        take_sh(l, colour->sh, alpha->sh);
    snprintf(name, sizeof name, "%s: %s", p->opts->input, e->capture.place);
    ibl_warn_of_overflow(p->console, name, (ibl_pixel)p->set.bake.pixel,
                         (ibl_overflow)p->set.bake.overflow, &l->overflow);
    return IBL_OK;
}

static ibl_status bake_layer(ibl_probes_bake *p, int layer)
{
    ibl_read_options read = p->opts->common.read;
    ibl_bake_result made[IBL_CAPTURE_PARTS] = {0};

    read.alpha = ibl_probes_alpha(&p->set, layer);
    ibl_status status = ibl_capture_bake(p->ctx, p->console, p->opts->input,
                                         &p->set.entry[layer].capture, &read,
                                         &p->options, made);
    if (!status)
        status = take_capture(p, layer, made);
    for (int part = 0; part < IBL_CAPTURE_PARTS; part++)
        ibl_bake_result_free(&made[part]);
    return status;
}

static ibl_status copy_layer(ibl_probes_bake *p, int kind, int layer,
                             const ibl_texture *array, int from)
{
    ibl_texture tex = {0};
    const ibl_status status = ibl_texture_layer(p->ctx, array, from, &tex);

    return status ? status : take_texture(p, kind, layer, &tex);
}

/* Copies what does not have to be baked from the old array. */
static ibl_status take_old(ibl_probes_bake *p, int kind)
{
    char *path = ibl_path_join(p->opts->output, p->old.file[kind].name);
    ibl_texture array = {0};
    ibl_status status = path ? ibl_texture_read(p->ctx, path, &array, NULL)
                             : ibl_probes_no_memory(p);

    for (int i = 0; i < p->layers && !status; i++)
        if (p->source[i].from == IBL_FROM_OLD)
            status = copy_layer(p, kind, i, &array, p->source[i].layer);
    ibl_texture_free(&array);
    free(path);
    return status;
}

/* A layer that is as an earlier one. */
static ibl_status take_twin(ibl_probes_bake *p, int layer)
{
    const int twin = p->source[layer].layer;
    ibl_status status = IBL_OK;

    p->index.layer[layer] = p->index.layer[twin];
    for (int kind = 0; kind < IBL_PROBES_ARRAYS && !status; kind++)
        if (p->array[kind].data)
            status = copy_layer(p, kind, layer, &p->array[kind], twin);
    return status;
}

/* Where a layer came from, for -v. */
static void log_layer(const ibl_probes_bake *p, int layer)
{
    const ibl_probes_source *s = &p->source[layer];
    const char *name =
        layer < p->set.count ? p->set.entry[layer].name : "(global)";

    if (s->from == IBL_FROM_TWIN)
        ibl_console_info(p->console, "layer %d: %s: as layer %d", layer, name,
                         s->layer);
    else
        ibl_console_info(p->console, "layer %d: %s: %s", layer, name,
                         s->from != IBL_FROM_BAKE      ? "kept"
                         : p->index.layer[layer].alpha ? "baked, with alpha"
                                                       : "baked");
}

static ibl_status make_layers(ibl_probes_bake *p)
{
    ibl_status status = IBL_OK;
    bool old = false;

    for (int i = 0; i < p->layers; i++)
        if (p->source[i].from == IBL_FROM_OLD) {
            p->index.layer[i] = p->old.layer[p->source[i].layer];
            old = true;
        }
    for (int kind = 0; kind < IBL_PROBES_ARRAYS && !status; kind++)
        if (old && p->path[kind] && !p->same[kind])
            status = take_old(p, kind);
    for (int i = 0; i < p->layers && !status; i++) {
        if (p->source[i].from == IBL_FROM_BAKE)
            status = bake_layer(p, i);
        else if (p->source[i].from == IBL_FROM_TWIN)
            status = take_twin(p, i);
        if (!status)
            log_layer(p, i);
    }
    return status;
}

/* ---- the whole --------------------------------------------------------- */

static ibl_status prepare(ibl_probes_bake *p)
{
    const ibl_isa isa = (ibl_isa)p->opts->common.isa;
    bool there;
    ibl_status status;

    p->isa = isa == IBL_ISA_AUTO ? ibl_isa_best() : isa;
    if (!ibl_probe_set_read(p->opts->input, p->console, &p->set))
        return IBL_ERR_FORMAT;
    p->layers = ibl_probe_set_layers(&p->set);
    status = find_options(p);
    if (!status)
        status = name_files(p);
    if (!status)
        status = ibl_probes_check_input(p, p->opts->input);
    if (status)
        return status;
    const size_t n = (size_t)p->layers;
    p->index.layers = p->layers;
    p->index.layer = calloc(n, sizeof *p->index.layer);
    p->source = calloc(n, sizeof *p->source);
    if (!p->index.layer || !p->source)
        return ibl_probes_no_memory(p);
    ibl_console_progress(p->console, "look", 0);
    there = ibl_probes_hold(p);
    status = ibl_probes_hash_inputs(p);
    return status || !there ? status : ibl_probes_look_back(p);
}

/* How much was done, for -v. */
static void log_summary(const ibl_probes_bake *p)
{
    int baked = 0;

    for (int i = 0; i < p->layers; i++)
        baked += p->source[i].from == IBL_FROM_BAKE;
    ibl_console_info(p->console, "baked %d of %d layers", baked, p->layers);
    for (int i = 0; i < IBL_PROBES_FILES; i++)
        if (p->path[i])
            ibl_console_info(p->console, "%s %s", p->same[i] ? "kept" : "wrote",
                             p->path[i]);
    ibl_console_print_times(p->console);
}

static void free_probes(ibl_probes_bake *p)
{
    ibl_end_outputs(p->outputs);
    if (p->held >= 0)
        close(p->held);
    for (int kind = 0; kind < IBL_PROBES_ARRAYS; kind++)
        ibl_texture_free(&p->array[kind]);
    for (int i = 0; i < IBL_PROBES_FILES; i++)
        free(p->path[i]);
    free(p->source);
    free(p->old_text);
    ibl_probes_index_free(&p->old);
    ibl_probes_index_free(&p->index);
    ibl_probe_set_free(&p->set);
    ibl_ctx_free(p->ctx);
}

int ibl_probes_run(const void *settings)
{
    const ibl_probes_opts *opts = settings;
    ibl_console console;
    ibl_probes_bake p = {.opts = opts, .console = &console, .held = -1};
    ibl_status status;

    if (opts->grid)
        return ibl_probes_grid(opts);
    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    ibl_signals_catch();
    status = prepare(&p);
    if (!status)
        ibl_probes_plan(&p);
    if (!status)
        status = ibl_start(&opts->common, &console, &p.ctx);
    if (!status)
        status = ibl_start_outputs(p.ctx, opts->sync, &p.outputs);
    if (!status)
        status = ibl_outputs_mkdir(p.outputs, opts->output);
    if (!status && p.held < 0)
        ibl_probes_hold(&p);
    if (!status)
        status = make_layers(&p);
    if (!status)
        status = ibl_probes_put(&p);
    ibl_console_progress(&console, "write", 1);
    if (!status)
        status = ibl_outputs_wait(p.outputs);
    if (!status)
        status = ibl_commit_outputs(p.outputs);
    ibl_console_finish(&console);
    if (!status && p.old.dropped)
        ibl_console_warn(&console,
                         "%s: %d of the %d probes that were there are not in "
                         "%s and are gone",
                         opts->output, p.old.dropped, p.old.probes,
                         opts->input);
    if (status)
        ibl_console_fail(&console, "%s", ibl_status_text(status));
    else if (opts->common.verbose)
        log_summary(&p);
    free_probes(&p);
    return status ? 1 : 0;
}
