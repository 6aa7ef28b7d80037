/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "cli/probes.h"
#include "common/path.h"
#include "common/signals.h"
#include "ibl/sidecar.h"

bool ibl_probes_no_memory(const ibl_probes_bake *p)
{
    return ibl_console_fail(p->console, "%s: no memory for the set",
                            p->opts->input);
}

/* ---- options ------------------------------------------------------------ */

/* Whether the files can hold the texels, and the texels have the quality. */
static bool check_texels(const ibl_probes_bake *p)
{
    const ibl_set_bake *b = &p->set.bake;
    const ibl_texel_options *t = &b->texels;

    if (b->zstd && b->container != IBL_CONTAINER_KTX2)
        return ibl_console_fail(
            p->console,
            "zstd %d: %s files cannot hold it: take the container ktx2",
            b->zstd, ibl_container_name(b->container));
    if (!ibl_container_holds(b->container, t->pixel))
        return ibl_console_fail(p->console,
                                "pixel %s: %s files cannot hold it: take the "
                                "container ktx2",
                                ibl_pixel_name(t->pixel),
                                ibl_container_name(b->container));
    if (t->pixel == IBL_PIXEL_RGBA32F &&
        ibl_is_given(&p->opts->given, "overflow"))
        return ibl_console_fail(p->console,
                                "--overflow %s: rgba32f holds all light: leave "
                                "it out",
                                ibl_overflow_name(t->overflow));
    return ibl_pixel_block(t->pixel) > 1 ||
           (t->quality == IBL_QUALITY_NORMAL &&
            !ibl_is_given(&p->opts->given, "quality")) ||
           ibl_console_fail(p->console,
                            "quality %s: %s has none: it is for bc6h, "
                            "uastc-hdr and astc4x4hdr",
                            ibl_quality_name(t->quality),
                            ibl_pixel_name(t->pixel));
}

/* Completes the set's options by the command line's; finds the layout. */
static bool find_options(ibl_probes_bake *p)
{
    ibl_set_bake *b = &p->set.bake;
    ibl_bake_options *o = &b->options;

    ibl_probes_override(p->opts, b);
    o->irradiance = o->irradiance_options.size > 0;
    o->sh_degree = o->irradiance ? -1 : IBL_PROBES_SH_DEGREE;
    b->texels.alike = b->zstd > 0;
    p->lut_pixel = ibl_lut_pixel(b->texels.pixel, IBL_LUT_SPLIT);
    if (ibl_specular_layout_of(&o->specular_options, &p->layout))
        return ibl_console_fail(
            p->console, "levels %d: a cube of size %d has 1 to %d levels",
            o->specular_options.levels, o->specular_options.size,
            ibl_most_levels(o->specular_options.size));
    if (!check_texels(p))
        return false;
    ibl_warn_of_small_faces(p->console, &p->layout);
    return true;
}

static bool name_files(ibl_probes_bake *p)
{
    static const char *const stems[] = {"probes_specular", "probes_irradiance",
                                        "brdf_lut", "index"};
    char name[64];

    for (int kind = 0; kind < IBL_PROBES_FILES; kind++) {
        if (kind == IBL_PROBES_IRRADIANCE && !p->set.bake.options.irradiance)
            continue;
        snprintf(name, sizeof name, "%s.%s", stems[kind],
                 kind == IBL_PROBES_INDEX
                     ? "json"
                     : ibl_container_name(p->set.bake.container));
        p->file[kind].path = ibl_path_join(p->opts->output, name);
        if (!p->file[kind].path)
            return ibl_probes_no_memory(p);
    }
    return true;
}

bool ibl_probes_check_input(const ibl_probes_bake *p, const char *input)
{
    bool ok = true;

    for (int i = 0; i < IBL_PROBES_FILES && ok; i++)
        ok =
            !p->file[i].path ||
            ibl_console_differ(p->console, input, p->file[i].path, "directory");
    return ok;
}

/* ---- layers -------------------------------------------------------------- */

/* Copies tex into a layer of its array, and frees it. */
static bool take_texture(ibl_probes_bake *p, int kind, int layer,
                         ibl_texture *tex)
{
    ibl_texture *array = &p->array[kind];

    const bool ok = (array->data || !ibl_texture_array_begin(
                                        p->ctx, tex, p->set.layers, array)) &&
                    !ibl_texture_array_put(p->ctx, array, layer, tex);
    ibl_texture_free(tex);
    return ok;
}

/* Encodes a cube as a layer; adds what its format loses to loss, and of
 * specular blocks the errors. Empty alpha means 1. */
static bool take_cube(ibl_probes_bake *p, int kind, int layer,
                      const ibl_cube *cube, const ibl_cube *alpha,
                      ibl_probes_loss *loss)
{
    const ibl_set_bake *b = &p->set.bake;
    ibl_overflow_report report = {0};
    ibl_pixel_error error[IBL_MAX_LEVELS] = {0};
    ibl_texture tex = {0};

    ibl_console_progress(p->console, "texels", 0);
    loss->blocks = ibl_pixel_block(b->texels.pixel) > 1;
    const bool ok =
        !ibl_texture_from_cube(p->ctx, cube, &b->texels, &tex, &report) &&
        !ibl_texture_errors(p->ctx, &tex, cube, error) &&
        (!alpha->data || !ibl_texture_set_alpha(p->ctx, &tex, alpha)) &&
        take_texture(p, kind, layer, &tex);
    ibl_texture_free(&tex);
    loss->values += report.values;
    for (int i = 0; i < cube->levels; i++) {
        ibl_overflow_add(&report.level[i], &loss->beyond);
        loss->dark = fmax(loss->dark, error[i].lost);
    }
    if (kind == IBL_PROBES_SPECULAR)
        memcpy(loss->error, error, sizeof error);
    return ok;
}

static bool take_capture(ibl_probes_bake *p, int layer,
                         const ibl_bake_result made[IBL_CAPTURE_PARTS])
{
    const ibl_bake_result *colour = &made[IBL_CAPTURE_COLOUR];
    const ibl_bake_result *alpha = &made[IBL_CAPTURE_ALPHA];
    const ibl_set_bake *b = &p->set.bake;
    ibl_set_entry *l = &p->set.entry[layer];
    ibl_probes_loss loss = {.levels = colour->specular.levels};
    char name[512];

    l->alpha = alpha->specular.data != NULL;
    if (l->alpha && !ibl_pixel_has_alpha(b->texels.pixel))
        return ibl_console_fail(
            p->console,
            "%s: %s: has alpha below 1, which %s has no room for: choose "
            "--pixel rgba16f or rgba32f, or --alpha ignore",
            p->opts->input, l->capture.place, ibl_pixel_name(b->texels.pixel));
    if (!take_cube(p, IBL_PROBES_SPECULAR, layer, &colour->specular,
                   &alpha->specular, &loss) ||
        (b->options.irradiance &&
         !take_cube(p, IBL_PROBES_IRRADIANCE, layer, &colour->irradiance,
                    &alpha->irradiance, &loss)))
        return false;
    snprintf(name, sizeof name, "%s: %s", p->opts->input, l->capture.place);
    ibl_warn_of_overflow(p->console, name, &b->texels, NULL, false,
                         &loss.beyond);
    ibl_warn_of_underflow(p->console, name, ibl_pixel_name(b->texels.pixel),
                          loss.dark);
    l->note = ibl_probes_note(made, &loss);
    return l->note || ibl_probes_no_memory(p);
}

static bool bake_layer(ibl_probes_bake *p, int layer)
{
    ibl_bake_result made[IBL_CAPTURE_PARTS] = {0};

    const bool ok =
        ibl_capture_bake(p, layer, made) && take_capture(p, layer, made);
    for (int part = 0; part < IBL_CAPTURE_PARTS; part++)
        ibl_bake_result_free(&made[part]);
    return ok;
}

bool ibl_probes_copy_layer(ibl_probes_bake *p, int kind, int layer, int source,
                           const ibl_texture *array)
{
    ibl_texture tex = {0};

    return !ibl_texture_layer(p->ctx, array, source, &tex) &&
           take_texture(p, kind, layer, &tex);
}

/* Copies the layers that the old array has. */
static bool copy_old(ibl_probes_bake *p, int kind)
{
    ibl_texture array = {0};
    bool ok = true;

    for (int i = 0; i < p->set.layers && ok; i++)
        if (p->set.entry[i].from == IBL_FROM_OLD)
            ok = (array.data ||
                  !ibl_texture_read(p->ctx, p->file[kind].old, &array, NULL)) &&
                 ibl_probes_copy_layer(p, kind, i, p->set.entry[i].source,
                                       &array);
    ibl_texture_free(&array);
    return ok;
}

static bool copy_twin(ibl_probes_bake *p, int layer)
{
    ibl_set_entry *l = &p->set.entry[layer];
    bool ok = true;

    l->note = json_incref(p->set.entry[l->source].note);
    l->alpha = p->set.entry[l->source].alpha;
    for (int kind = 0; kind < IBL_PROBES_ARRAYS && ok; kind++)
        ok = !p->array[kind].data ||
             ibl_probes_copy_layer(p, kind, layer, l->source, &p->array[kind]);
    return ok;
}

/* Logs where a layer came from, for -v. */
static void log_layer(const ibl_probes_bake *p, int layer)
{
    const ibl_set_entry *l = &p->set.entry[layer];
    const char *name = layer < p->set.count ? l->name : "(global)";

    if (l->from == IBL_FROM_TWIN)
        ibl_console_info(p->console, "layer %d: %s: as layer %d", layer, name,
                         l->source);
    else
        ibl_console_info(p->console, "layer %d: %s: %s", layer, name,
                         l->from != IBL_FROM_BAKE ? "kept"
                         : l->alpha               ? "baked, with alpha"
                                                  : "baked");
}

/* Bytes that a cube of so many levels has as texels. */
static double texture_bytes(const ibl_probes_bake *p, int size, int levels)
{
    const ibl_pixel pixel = p->set.bake.texels.pixel;
    const int block = ibl_pixel_block(pixel);

    return (double)ibl_cube_texels(size, levels) *
           (double)ibl_pixel_bytes(pixel) / (block * block);
}

/* The most that a layer takes while it is baked: its map, which faces and parts
 * with alpha have twice, the bake, and what is spread of level 0. */
static bool layer_bytes(ibl_probes_bake *p, double *most)
{
    const int size = p->layout.size;
    const double texels = 16 * (double)ibl_cube_texels(size, 1) +
                          12 * (double)ibl_cube_texels(size, p->layout.levels);
    bool ok = true;

    *most = 0;
    for (int i = 0; i < p->set.layers && ok; i++) {
        uint64_t pixels;
        size_t bake;
        if (p->set.entry[i].from != IBL_FROM_BAKE)
            continue;
        ok = ibl_capture_pixels(p, i, &pixels);
        const int height = ok ? (int)ceil(sqrt((double)pixels / 2)) : 1;
        ok = ok && !ibl_bake_memory(p->ctx, 2 * height, height,
                                    &p->set.bake.options, &bake);
        if (ok)
            *most = fmax(*most, 28 * (double)pixels + (double)bake + texels);
    }
    return ok;
}

/* Whether the arrays of all layers, those of the old set that are copied, and
 * the bake of a layer fit in --max-memory. */
static bool fits(ibl_probes_bake *p)
{
    const size_t most = ibl_memory_most(&p->opts->common);
    const double each =
        texture_bytes(p, p->layout.size, p->layout.levels) +
        texture_bytes(p, p->set.bake.options.irradiance_options.size, 1);
    double old = 0, layer = 0;

    for (int i = 0; i < p->set.layers; i++)
        if (p->set.entry[i].from == IBL_FROM_OLD)
            old = each * p->set.layers;
    if (!layer_bytes(p, &layer))
        return false;
    const double need =
        IBL_PROGRAM_BYTES +
        1.1 * (each * p->set.layers * (p->set.bake.zstd ? 2 : 1) +
               fmax(old, layer));
    ibl_console_info(p->console, "plans %.0f MiB of memory", need / (1 << 20));
    return !most || need <= (double)most ||
           ibl_console_fail(p->console,
                            "%s: takes %.0f MiB of memory, more than the %.0f "
                            "of --max-memory: ask for a smaller --size, or "
                            "bake a part by --shard",
                            p->opts->input, ceil(need / (1 << 20)),
                            floor((double)most / (1 << 20)));
}

static bool make_layers(ibl_probes_bake *p)
{
    bool ok = fits(p);

    for (int kind = 0; kind < IBL_PROBES_ARRAYS && ok; kind++)
        ok = !p->file[kind].path || p->file[kind].same || copy_old(p, kind);
    for (int i = 0; i < p->set.layers && ok; i++) {
        const ibl_probes_origin from = p->set.entry[i].from;
        ok = from == IBL_FROM_BAKE   ? bake_layer(p, i)
             : from == IBL_FROM_TWIN ? copy_twin(p, i)
                                     : true;
        if (ok)
            log_layer(p, i);
    }
    return ok;
}

/* ---- files -------------------------------------------------------------- */

static bool set_keys(const ibl_probes_bake *p, ibl_probes_kind kind,
                     ibl_texture *tex)
{
    static const ibl_content contents[IBL_PROBES_ARRAYS + 1] = {
        [IBL_PROBES_SPECULAR] = IBL_CONTENT_SPECULAR,
        [IBL_PROBES_IRRADIANCE] = IBL_CONTENT_IRRADIANCE,
        [IBL_PROBES_LUT] = IBL_CONTENT_LUT};
    ibl_sidecar_options facts = ibl_sidecar_options_default();
    const ibl_sidecar_output output = {.content = contents[kind]};

    facts.specular = &p->set.bake.options.specular_options;
    return !ibl_texture_describe(p->ctx, tex, &facts, &output);
}

/* Hashes and writes a texture that is compressed: once, not for each. */
static bool put_packed(ibl_probes_bake *p, ibl_probes_file *f,
                       const ibl_texture *tex)
{
    void *bytes = NULL;
    size_t size;

    const bool ok =
        !ibl_texture_encode(p->ctx, tex, IBL_CONTAINER_KTX2, &bytes, &size);
    if (ok)
        ibl_hash_bytes(bytes, size, f->hash);
    const bool added = ok && !ibl_outputs_add(p->outputs, f->path, bytes, size);
    ibl_bytes_free(bytes);
    return added;
}

/* Copied layers brought the flag of their whole old array. */
static bool set_alpha(const ibl_probes_bake *p, ibl_texture *tex)
{
    tex->premultiplied = 0;
    for (int i = 0; i < p->set.layers; i++)
        tex->premultiplied |= p->set.entry[i].alpha;
    return !ibl_texture_set(p->ctx, tex, "iblbake.alpha",
                            tex->premultiplied ? "premultiplied" : "opaque");
}

bool ibl_probes_put_texture(ibl_probes_bake *p, ibl_probes_kind kind,
                            ibl_texture *tex)
{
    const ibl_container container = p->set.bake.container;
    ibl_probes_file *f = &p->file[kind];

    ibl_console_progress(p->console, "hash", 0);
    tex->zstd = p->set.bake.zstd;
    if (kind != IBL_PROBES_LUT && !set_alpha(p, tex))
        return false;
    if (tex->zstd)
        return put_packed(p, f, tex);
    if (ibl_hash_texture(p->ctx, tex, container, f->hash))
        return false;
    ibl_console_progress(p->console, "write", 0);
    return !ibl_outputs_take_texture(p->outputs, f->path, tex, container, NULL);
}

static bool put_array(ibl_probes_bake *p, ibl_probes_kind kind)
{
    ibl_texture *array = &p->array[kind];

    return set_keys(p, kind, array) && ibl_probes_put_texture(p, kind, array);
}

static bool put_lut(ibl_probes_bake *p)
{
    ibl_lut_options options = ibl_lut_options_default();
    ibl_lut lut = {0};
    ibl_texture tex = {0};

    options.size = p->set.bake.lut_size;
    ibl_console_progress(p->console, "lut", 0);
    const bool ok =
        !ibl_bake_lut(p->ctx, &options, &lut) &&
        !ibl_texture_from_lut(p->ctx, &lut, p->lut_pixel, &tex, NULL) &&
        set_keys(p, IBL_PROBES_LUT, &tex) &&
        ibl_probes_put_texture(p, IBL_PROBES_LUT, &tex);
    ibl_texture_free(&tex);
    ibl_lut_free(&lut);
    return ok;
}

/* Writes the index unless the old one has the same bytes. */
static bool put_index(ibl_probes_bake *p)
{
    ibl_probes_file *f = &p->file[IBL_PROBES_INDEX];
    char *text = ibl_probes_index_text(p), hash[IBL_HASH_SIZE];

    if (!text)
        return ibl_probes_no_memory(p);
    ibl_hash_bytes(text, strlen(text), hash);
    f->same = !p->opts->force && !strcmp(hash, f->hash);
    const bool ok =
        f->same || !ibl_outputs_add(p->outputs, f->path, text, strlen(text));
    free(text);
    return ok;
}

static bool put_files(ibl_probes_bake *p)
{
    bool ok = true;

    for (int kind = 0; kind < IBL_PROBES_TEXTURES && ok; kind++)
        if (p->file[kind].path && !p->file[kind].same)
            ok = kind == IBL_PROBES_LUT ? put_lut(p)
                                        : put_array(p, (ibl_probes_kind)kind);
    return ok && put_index(p);
}

/* ---- the command ------------------------------------------------------- */

static bool prepare(ibl_probes_bake *p)
{
    const ibl_isa isa = p->opts->common.isa;

    p->isa = isa == IBL_ISA_AUTO ? ibl_isa_best() : isa;
    if (!ibl_probe_set_read(p->opts->input, p->console, &p->set) ||
        !find_options(p) || !ibl_probes_check_walls(p) || !name_files(p) ||
        !ibl_probes_check_input(p, p->opts->input))
        return false;
    ibl_console_progress(p->console, "look", 0);
    return (!p->opts->shard.count || ibl_probes_take_shard(p)) &&
           ibl_probes_hash_inputs(p) && ibl_probes_plan(p);
}

bool ibl_probes_start(ibl_probes_bake *p)
{
    const ibl_probes_opts *opts = p->opts;

    p->held = -1;
    ibl_signals_catch();
    if (ibl_start(&opts->common, p->console, &p->ctx) ||
        ibl_start_outputs(p->ctx, opts->sync, &p->outputs) ||
        ibl_outputs_mkdir(p->outputs, opts->output))
        return false;
    p->held = ibl_probes_hold(p->console, opts->output, LOCK_EX);
    ibl_outputs_hold(p->outputs, p->held);
    return true;
}

/* Logs counts, files and times, for -v. */
static void log_summary(const ibl_probes_bake *p)
{
    int baked = 0;

    for (int i = 0; i < p->set.layers; i++)
        baked += p->set.entry[i].from == IBL_FROM_BAKE;
    ibl_console_info(p->console, "baked %d of %d layers", baked, p->set.layers);
    for (int i = 0; i < IBL_PROBES_FILES; i++)
        if (p->file[i].path)
            ibl_console_info(p->console, "%s %s",
                             p->file[i].same ? "kept" : "wrote",
                             p->file[i].path);
    ibl_console_print_times(p->console);
}

void ibl_probes_free(ibl_probes_bake *p)
{
    ibl_end_outputs(p->outputs);
    if (p->held >= 0)
        close(p->held);
    for (int kind = 0; kind < IBL_PROBES_ARRAYS; kind++)
        ibl_texture_free(&p->array[kind]);
    for (int i = 0; i < IBL_PROBES_FILES; i++) {
        free(p->file[i].path);
        free(p->file[i].old);
    }
    ibl_probe_set_free(&p->set);
    ibl_ctx_free(p->ctx);
}

int ibl_probes_run(const void *settings)
{
    const ibl_probes_opts *opts = settings;
    ibl_console console;
    ibl_probes_bake p = {.opts = opts, .console = &console};

    if (opts->grid)
        return ibl_probes_grid(opts);
    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    const bool ok = ibl_probes_start(&p) && prepare(&p) && make_layers(&p) &&
                    put_files(&p) && ibl_console_commit(&console, p.outputs);
    const int status = ibl_console_end(&console, ok);
    if (ok && p.dropped && !opts->shard.count)
        ibl_console_warn(&console,
                         "%s: %d of the %d probes that were there are not in "
                         "%s and are gone",
                         opts->output, p.dropped, p.old_probes, opts->input);
    if (ok && opts->common.verbose)
        log_summary(&p);
    ibl_probes_free(&p);
    return status;
}
