/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli/capture.h"
#include "cli/probes.h"
#include "cli/signals.h"
#include "cli/start.h"

/* Where a layer comes from. */
typedef enum origin {
    FROM_BAKE,
    FROM_OLD,  /* a layer of the old arrays */
    FROM_TWIN, /* an earlier layer with the same inputs */
} origin;

typedef struct source {
    origin from;
    int layer; /* of the old arrays, or the twin */
} source;

typedef struct probes {
    const ibl_probes_opts *opts;
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_outputs *outputs;
    ibl_isa isa;
    ibl_probe_set set;
    ibl_bake_options options;
    int layers;
    char *path[IBL_PROBES_TEXTURES + 1]; /* the last: the index */
    char *old_text;                      /* of the index */
    ibl_probes_index old, index;
    bool whole[IBL_PROBES_TEXTURES]; /* the old file is what its index says */
    bool same[IBL_PROBES_TEXTURES + 1]; /* and what we would write */
    source *source;
    ibl_texture *texture[2]; /* of each layer: specular, irradiance */
} probes;

enum {
    INDEX = IBL_PROBES_TEXTURES
};

static ibl_status no_memory(const probes *p)
{
    ibl_console_fail(p->console, "%s: no memory for the set", p->opts->input);
    return IBL_ERR_MEMORY;
}

/* ---- what is asked for -------------------------------------------------- */

/* The set's options and the command line's, into the library's. */
static ibl_status find_options(probes *p)
{
    const ibl_probes_opts *o = p->opts;
    ibl_set_bake *b = &p->set.bake;
    ibl_specular_options *s = &p->options.specular_options;
    ibl_specular_layout layout;

    if (o->size > 0)
        b->size = o->size;
    /* Those of the set go with its size. */
    if (o->levels > 0 || (o->size > 0 && b->levels))
        b->levels = o->levels > 0 ? o->levels : 0;
    if (o->pixel >= 0)
        b->pixel = o->pixel;
    if (o->container >= 0)
        b->container = o->container;
    if (o->irradiance >= 0)
        b->irradiance = o->irradiance;
    p->options = ibl_bake_options_default();
    s->size = b->size;
    s->levels = b->levels;
    s->mapping = (ibl_roughness_map)b->mapping;
    s->method = (ibl_method)b->method;
    s->tolerance = b->tolerance;
    if (b->samples)
        s->samples = b->samples;
    else if (b->tolerance > 0)
        s->samples = 65536;
    p->options.irradiance = b->irradiance > 0;
    if (b->irradiance)
        p->options.irradiance_options.size = b->irradiance;
    p->options.sh_degree = b->irradiance ? -1 : IBL_PROBES_SH_DEGREE;
    if (!ibl_specular_layout_of(s, &layout))
        return IBL_OK;
    ibl_console_fail(p->console, "--levels %d: a cube of size %d has fewer",
                     b->levels, b->size);
    return IBL_ERR_ARGUMENT;
}

static char *join(const char *directory, const char *name)
{
    const size_t size = strlen(directory) + strlen(name) + 2;
    char *path = malloc(size);

    if (path)
        snprintf(path, size, "%s%s%s", directory,
                 directory[strlen(directory) - 1] == '/' ? "" : "/", name);
    return path;
}

static ibl_status name_files(probes *p)
{
    static const char *const stems[] = {"probes_specular", "probes_irradiance",
                                        "brdf_lut"};
    const char *ext = ibl_container_name((ibl_container)p->set.bake.container);

    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++) {
        ibl_probes_texture *t = &p->index.file[kind];
        if (kind == IBL_PROBES_IRRADIANCE && !p->set.bake.irradiance)
            continue;
        snprintf(t->name, sizeof t->name, "%s.%s", stems[kind], ext);
        p->path[kind] = join(p->opts->output, t->name);
        if (!p->path[kind])
            return no_memory(p);
    }
    p->path[INDEX] = join(p->opts->output, "index.json");
    return p->path[INDEX] ? IBL_OK : no_memory(p);
}

static bool is_same_file(const char *a, const char *b)
{
    struct stat x, y;
    return !stat(a, &x) && !stat(b, &y) && x.st_dev == y.st_dev &&
           x.st_ino == y.st_ino;
}

/* Refuses outputs that would replace what they are made from. */
static ibl_status check_input(const probes *p, const char *input)
{
    for (int i = 0; i <= INDEX; i++)
        if (p->path[i] && is_same_file(p->path[i], input)) {
            ibl_console_fail(p->console,
                             "%s: is both input and output: choose another "
                             "directory",
                             p->path[i]);
            return IBL_ERR_ARGUMENT;
        }
    return IBL_OK;
}

/* ---- what has changed --------------------------------------------------- */

/* What the texels of a layer depend on besides the files. */
static void describe(const probes *p, char *text, size_t size)
{
    const ibl_set_bake *b = &p->set.bake;
    const ibl_specular_options *s = &p->options.specular_options;
    const ibl_read_options *r = &p->opts->common.read;

    snprintf(text, size,
             "iblbake %s %s %s\nsize %d levels %d mapping %d method %d "
             "samples %d tolerance %.17g pixel %d irradiance %d\n"
             "part %d strict %d any_aspect %d layer %s\n",
             IBL_VERSION, IBL_REVISION, ibl_isa_name(p->isa), s->size,
             s->levels, (int)s->mapping, (int)s->method, s->samples,
             s->tolerance, b->pixel, b->irradiance, r->part, r->strict,
             r->any_aspect, r->layer ? r->layer : "");
}

static ibl_status hash_capture(const probes *p, const ibl_capture *c,
                               const char *options, char hash[IBL_HASH_SIZE])
{
    char *text = NULL;
    size_t size;
    FILE *to = open_memstream(&text, &size);
    ibl_status status = IBL_OK;

    if (!to)
        return no_memory(p);
    fprintf(to, "%s%s", options, ibl_capture_name(c->kind));
    for (int i = 0; i < c->count && !status; i++) {
        char one[IBL_HASH_SIZE];
        status = check_input(p, c->file[i]);
        if (!status && !ibl_hash_file(c->file[i], one)) {
            char element[16] = "";
            if (c->count > 1)
                snprintf(element, sizeof element, "[%d]", i);
            ibl_console_fail(p->console,
                             "%s: %s.%s%s: expected a file that can be read, "
                             "found %s: %s",
                             p->opts->input, c->place,
                             ibl_capture_name(c->kind), element, c->file[i],
                             errno == EINVAL ? "no regular file"
                                             : strerror(errno));
            status = IBL_ERR_IO;
        }
        if (!status)
            fprintf(to, " %s", one);
    }
    if (fclose(to) && !status)
        status = no_memory(p);
    if (!status)
        ibl_hash_bytes(text, size, hash);
    free(text);
    return status;
}

static ibl_status hash_inputs(probes *p)
{
    char options[1024], lut[128];
    ibl_status status = IBL_OK;

    describe(p, options, sizeof options);
    for (int i = 0; i < p->layers && !status; i++)
        status = hash_capture(p, &p->set.entry[i].capture, options,
                              p->index.layer[i].hash);
    const int n =
        snprintf(lut, sizeof lut, "iblbake %s %s %s\nlut %d %d", IBL_VERSION,
                 IBL_REVISION, ibl_isa_name(p->isa), p->set.bake.lut_size,
                 p->set.bake.pixel == IBL_PIXEL_RGBA32F);
    ibl_hash_bytes(lut, (size_t)n, p->index.file[IBL_PROBES_LUT].inputs);
    return status;
}

/* Reads the old index and sees which of its files are still what it says. */
static ibl_status look_back(probes *p)
{
    ibl_probes_index_read(p->path[INDEX], &p->old_text, &p->old);
    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++) {
        const ibl_probes_texture *t = &p->old.file[kind];
        char *path = *t->name ? join(p->opts->output, t->name) : NULL;
        char hash[IBL_HASH_SIZE];
        if (!path && *t->name)
            return no_memory(p);
        p->whole[kind] =
            path && ibl_hash_file(path, hash) && !strcmp(hash, t->hash);
        free(path);
    }
    return IBL_OK;
}

/* The old layer with the same inputs, its own place first; -1: none. */
static int find_old(const probes *p, int layer)
{
    const char *hash = p->index.layer[layer].hash;

    if (layer < p->old.layers && !strcmp(p->old.layer[layer].hash, hash))
        return layer;
    for (int i = 0; i < p->old.layers; i++)
        if (!strcmp(p->old.layer[i].hash, hash))
            return i;
    return -1;
}

static int find_twin(const probes *p, int layer)
{
    for (int i = 0; i < layer; i++)
        if (!strcmp(p->index.layer[i].hash, p->index.layer[layer].hash))
            return i;
    return -1;
}

/* Where each layer comes from, and which files stay as they are. */
static void plan(probes *p)
{
    const bool usable =
        !p->opts->force && p->whole[IBL_PROBES_SPECULAR] &&
        (!p->set.bake.irradiance || p->whole[IBL_PROBES_IRRADIANCE]);
    bool moved = p->old.layers != p->layers;

    for (int i = 0; i < p->layers; i++) {
        const int old = usable ? find_old(p, i) : -1;
        const int twin = find_twin(p, i);
        p->source[i] = old >= 0    ? (source){FROM_OLD, old}
                       : twin >= 0 ? (source){FROM_TWIN, twin}
                                   : (source){FROM_BAKE, -1};
        moved |= old != i;
    }
    for (int kind = 0; kind < IBL_PROBES_TEXTURES; kind++)
        p->same[kind] =
            !p->opts->force && p->whole[kind] &&
            !strcmp(p->old.file[kind].name, p->index.file[kind].name) &&
            (kind == IBL_PROBES_LUT
                 ? !strcmp(p->old.file[kind].inputs, p->index.file[kind].inputs)
                 : !moved);
}

/* ---- layers -------------------------------------------------------------- */

static ibl_status take_cube(probes *p, int kind, int layer,
                            const ibl_cube *cube)
{
    size_t saturated;
    const ibl_status status =
        ibl_texture_from_cube(p->ctx, cube, (ibl_pixel)p->set.bake.pixel,
                              &p->texture[kind][layer], &saturated);

    if (!status)
        p->index.layer[layer].saturated += saturated;
    return status;
}

static void take_sh(ibl_probes_layer *layer, const double *sh)
{
    int i = 0;

    for (int l = 0; l <= IBL_PROBES_SH_DEGREE; l++)
        for (int k = 0; k < 3 * (2 * l + 1); k++, i++)
            layer->sh[i] = ibl_sh_cosine(l) * sh[i] + 0.0;
}

static ibl_status bake_layer(probes *p, int layer)
{
    const ibl_set_entry *e = &p->set.entry[layer];
    ibl_probes_layer *l = &p->index.layer[layer];
    ibl_bake_result made = {0};
    ibl_status status =
        ibl_capture_bake(p->ctx, p->console, p->opts->input, &e->capture,
                         &p->opts->common.read, &p->options, &made);

    if (!status)
        status = take_cube(p, IBL_PROBES_SPECULAR, layer, &made.specular);
    if (!status && p->set.bake.irradiance)
        status = take_cube(p, IBL_PROBES_IRRADIANCE, layer, &made.irradiance);
    if (!status && made.sh)
        take_sh(l, made.sh);
    ibl_bake_result_free(&made);
    if (!status && l->saturated)
        ibl_console_warn(
            p->console,
            "%s: %s: %zu values above %.9g became that, the largest of %s: "
            "use --pixel rgba32f to keep them",
            p->opts->input, e->capture.place, l->saturated,
            (double)ibl_pixel_max((ibl_pixel)p->set.bake.pixel),
            ibl_pixel_name((ibl_pixel)p->set.bake.pixel));
    return status;
}

/* Copies what does not have to be baked from the old array. */
static ibl_status take_old(probes *p, int kind)
{
    char *path = join(p->opts->output, p->old.file[kind].name);
    ibl_texture array = {0};
    ibl_status status =
        path ? ibl_texture_read(p->ctx, path, &array, NULL) : no_memory(p);

    for (int i = 0; i < p->layers && !status; i++)
        if (p->source[i].from == FROM_OLD)
            status = ibl_texture_layer(p->ctx, &array, p->source[i].layer,
                                       &p->texture[kind][i]);
    ibl_texture_free(&array);
    free(path);
    return status;
}

/* Where a layer came from, for -v. */
static void tell_layer(const probes *p, int layer)
{
    const source *s = &p->source[layer];
    const char *name =
        layer < p->set.count ? p->set.entry[layer].name : "(global)";

    if (s->from == FROM_TWIN)
        ibl_console_info(p->console, "layer %d: %s: as layer %d", layer, name,
                         s->layer);
    else
        ibl_console_info(p->console, "layer %d: %s: %s", layer, name,
                         s->from == FROM_BAKE ? "baked" : "kept");
}

static ibl_status make_layers(probes *p)
{
    ibl_status status = IBL_OK;
    bool old = false;

    for (int i = 0; i < p->layers; i++) {
        const source *s = &p->source[i];
        old |= s->from == FROM_OLD;
        if (s->from == FROM_OLD)
            p->index.layer[i] = p->old.layer[s->layer];
    }
    for (int kind = 0; kind < 2 && !status; kind++)
        if (old && p->path[kind] && !p->same[kind])
            status = take_old(p, kind);
    for (int i = 0; i < p->layers && !status; i++) {
        const source *s = &p->source[i];
        if (s->from == FROM_BAKE)
            status = bake_layer(p, i);
        else if (s->from == FROM_TWIN)
            p->index.layer[i] = p->index.layer[s->layer];
        if (!status)
            tell_layer(p, i);
    }
    return status;
}

/* ---- files --------------------------------------------------------------- */

/* Sets keys until the first failure, which it keeps. */
static void set_key(const probes *p, ibl_texture *tex, ibl_status *status,
                    const char *key, const char *fmt, ...)
    __attribute__((format(printf, 5, 6)));
static void set_key(const probes *p, ibl_texture *tex, ibl_status *status,
                    const char *key, const char *fmt, ...)
{
    char value[512];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(value, sizeof value, fmt, ap);
    va_end(ap);
    if (!*status)
        *status = ibl_texture_set(p->ctx, tex, key, value);
}

static ibl_status set_keys(const probes *p, ibl_probes_file kind,
                           ibl_texture *tex)
{
    const ibl_specular_options *o = &p->options.specular_options;
    ibl_specular_layout layout;
    char roughness[IBL_MAX_LEVELS * 24] = "";
    ibl_status status = IBL_OK;

    ibl_specular_layout_of(o, &layout);
    for (int l = 0; l < layout.levels; l++) {
        const size_t used = strlen(roughness);
        snprintf(roughness + used, sizeof roughness - used, "%s%.9g",
                 l ? "," : "", layout.roughness[l]);
    }
    if (kind == IBL_PROBES_LUT) {
        set_key(p, tex, &status, "iblbake.content", "brdf_lut");
        set_key(p, tex, &status, "iblbake.axes", "u=N.V,v=roughness");
        set_key(p, tex, &status, "iblbake.geometry", "smith");
    } else if (kind == IBL_PROBES_IRRADIANCE) {
        set_key(p, tex, &status, "iblbake.content", "irradiance");
        set_key(p, tex, &status, "iblbake.irradiance_scale", "E/pi");
    } else {
        set_key(p, tex, &status, "iblbake.content", "specular");
        set_key(p, tex, &status, "iblbake.lobe", "%s", ibl_lobe_name(o->lobe));
        set_key(p, tex, &status, "iblbake.mapping", "%s",
                ibl_roughness_map_name(o->mapping));
        set_key(p, tex, &status, "iblbake.roughness", "%s", roughness);
        set_key(p, tex, &status, "iblbake.lod_scale", "%.9g", layout.lod_scale);
        set_key(p, tex, &status, "iblbake.lod_offset", "%.9g",
                layout.lod_offset);
    }
    return status;
}

static ibl_status put_texture(probes *p, ibl_probes_file kind, ibl_texture *tex)
{
    void *bytes = NULL;
    size_t size;
    ibl_status status = set_keys(p, kind, tex);

    ibl_console_progress(p->console, "write", 0);
    if (!status)
        status = ibl_texture_encode(
            p->ctx, tex, (ibl_container)p->set.bake.container, &bytes, &size);
    if (!status) {
        ibl_hash_bytes(bytes, size, p->index.file[kind].hash);
        status = ibl_outputs_add(p->outputs, p->path[kind], bytes, size);
    }
    ibl_bytes_free(bytes);
    return status;
}

static ibl_status put_array(probes *p, ibl_probes_file kind)
{
    const ibl_texture **layer = calloc((size_t)p->layers, sizeof *layer);
    ibl_texture array = {0};
    ibl_status status = layer ? IBL_OK : no_memory(p);

    for (int i = 0; i < p->layers && !status; i++) {
        const source *s = &p->source[i];
        layer[i] = &p->texture[kind][s->from == FROM_TWIN ? s->layer : i];
    }
    if (!status)
        status = ibl_texture_array(p->ctx, layer, p->layers, &array);
    if (!status)
        status = put_texture(p, kind, &array);
    ibl_texture_free(&array);
    free(layer);
    return status;
}

static ibl_status put_lut(probes *p)
{
    ibl_lut_options options = ibl_lut_options_default();
    const ibl_pixel pixel = p->set.bake.pixel == IBL_PIXEL_RGBA32F
                                ? IBL_PIXEL_RG32F
                                : IBL_PIXEL_RG16F;
    ibl_lut lut = {0};
    ibl_texture tex = {0};

    options.size = p->set.bake.lut_size;
    ibl_console_progress(p->console, "lut", 0);
    ibl_status status = ibl_bake_lut(p->ctx, &options, &lut);
    if (!status)
        status = ibl_texture_from_lut(p->ctx, &lut, pixel, &tex, NULL);
    if (!status)
        status = put_texture(p, IBL_PROBES_LUT, &tex);
    ibl_texture_free(&tex);
    ibl_lut_free(&lut);
    return status;
}

/* Writes the index unless it is there, to the byte. */
static ibl_status put_index(probes *p)
{
    char *text = ibl_probes_index_text(&p->set, &p->index,
                                       &p->options.specular_options, p->isa);
    ibl_status status = text ? IBL_OK : no_memory(p);

    p->same[INDEX] =
        text && p->old_text && !p->opts->force && !strcmp(text, p->old_text);
    if (!status && !p->same[INDEX])
        status =
            ibl_outputs_add(p->outputs, p->path[INDEX], text, strlen(text));
    free(text);
    return status;
}

static ibl_status put_all(probes *p)
{
    ibl_status status = IBL_OK;

    for (int kind = 0; kind < IBL_PROBES_TEXTURES && !status; kind++) {
        if (!p->path[kind])
            continue;
        if (p->same[kind])
            p->index.file[kind] = p->old.file[kind];
        else if (kind == IBL_PROBES_LUT)
            status = put_lut(p);
        else
            status = put_array(p, (ibl_probes_file)kind);
    }
    return status ? status : put_index(p);
}

/* ---- the whole ------------------------------------------------------------
 */

static ibl_status prepare(probes *p)
{
    const ibl_isa isa = (ibl_isa)p->opts->common.isa;
    ibl_status status;

    p->isa = isa == IBL_ISA_AUTO ? ibl_isa_best() : isa;
    if (!ibl_probe_set_read(p->opts->input, p->console, &p->set))
        return IBL_ERR_FORMAT;
    p->layers = ibl_probe_set_layers(&p->set);
    status = find_options(p);
    if (!status)
        status = name_files(p);
    if (!status)
        status = check_input(p, p->opts->input);
    if (status)
        return status;
    const size_t n = (size_t)p->layers;
    p->index.layers = p->layers;
    p->index.layer = calloc(n, sizeof *p->index.layer);
    p->source = calloc(n, sizeof *p->source);
    for (int kind = 0; kind < 2; kind++)
        p->texture[kind] = calloc(n, sizeof *p->texture[kind]);
    if (!p->index.layer || !p->source || !p->texture[0] || !p->texture[1])
        return no_memory(p);
    ibl_console_progress(p->console, "look", 0);
    status = hash_inputs(p);
    return status ? status : look_back(p);
}

static ibl_status commit(probes *p)
{
    ibl_console_progress(p->console, "write", 1);
    ibl_status status = ibl_outputs_wait(p->outputs);

    if (status)
        return status;
    ibl_signals_hold();
    status = ibl_outputs_commit(p->outputs);
    ibl_signals_guard(NULL);
    ibl_signals_release();
    return status;
}

/* How much was done, for -v. */
static void tell(const probes *p)
{
    int baked = 0;

    for (int i = 0; i < p->layers; i++)
        baked += p->source[i].from == FROM_BAKE;
    ibl_console_info(p->console, "baked %d of %d layers", baked, p->layers);
    for (int i = 0; i <= INDEX; i++)
        if (p->path[i])
            ibl_console_info(p->console, "%s %s", p->same[i] ? "kept" : "wrote",
                             p->path[i]);
    ibl_console_print_times(p->console);
}

static void free_probes(probes *p)
{
    ibl_signals_guard(NULL);
    ibl_outputs_free(p->outputs);
    for (int kind = 0; kind < 2; kind++) {
        for (int i = 0; p->texture[kind] && i < p->layers; i++)
            ibl_texture_free(&p->texture[kind][i]);
        free(p->texture[kind]);
    }
    for (int i = 0; i <= INDEX; i++)
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
    probes p = {.opts = opts, .console = &console};
    ibl_status status;

    if (opts->grid)
        return ibl_probes_grid(opts);
    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    ibl_signals_catch();
    status = prepare(&p);
    if (!status)
        plan(&p);
    if (!status)
        status = ibl_start(&opts->common, &console, &p.ctx);
    if (!status)
        status = ibl_outputs_create(p.ctx, &p.outputs);
    if (!status) {
        ibl_outputs_sync(p.outputs, opts->sync);
        ibl_signals_guard(p.outputs);
        status = ibl_outputs_mkdir(p.outputs, opts->output);
    }
    if (!status)
        status = make_layers(&p);
    if (!status)
        status = put_all(&p);
    if (!status)
        status = commit(&p);
    ibl_console_finish(&console);
    if (status)
        ibl_console_fail(&console, "%s", ibl_status_text(status));
    else if (opts->common.verbose)
        tell(&p);
    free_probes(&p);
    return status ? 1 : 0;
}
