/* SPDX-License-Identifier: MIT */
/* iblbake probes: a set is baked anew unless nothing that it depends on has
 * changed. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli/probes.h"
#include "common/path.h"
#include "common/signals.h"
#include "ibl/sidecar.h"
#include "json/json_text.h"

/* The files of a set. */
typedef enum ibl_probes_kind {
    IBL_PROBES_SPECULAR,
    IBL_PROBES_IRRADIANCE,
    IBL_PROBES_LUT,
    IBL_PROBES_INDEX,
    IBL_PROBES_FILES
} ibl_probes_kind;

#define IBL_PROBES_SH_DEGREE 2

/* A set while it is baked. */
typedef struct ibl_probes_bake {
    const ibl_probes_opts *opts;
    const char *input; /* SET.json */
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_outputs *outputs;
    ibl_probe_set set;
    ibl_specular_layout layout;
    ibl_pixel lut_pixel;
    char hash[IBL_FILE_HASH];            /* of all that the files depend on */
    char *path[IBL_PROBES_FILES];        /* NULL: not wanted */
    ibl_texture array[IBL_PROBES_INDEX]; /* filled layer by layer; the table */
} ibl_probes_bake;

/* ---- options ------------------------------------------------------------ */

/* Completes the set's options by the command line's, and checks them together;
 * finds the layout. */
static bool find_options(ibl_probes_bake *p)
{
    ibl_set_bake *b = &p->set.bake;
    ibl_bake_options *o = &b->options;
    const ibl_texel_options *t = &b->texels;
    const ibl_given *given = &p->opts->given;

    ibl_probes_override(p->opts, b);
    o->irradiance = o->irradiance_options.size > 0;
    o->sh_degree = o->irradiance ? -1 : IBL_PROBES_SH_DEGREE;
    b->texels.alike = b->zstd > 0;
    p->lut_pixel = ibl_lut_pixel(t->pixel, IBL_LUT_SPLIT);
    if (ibl_specular_layout_of(&o->specular_options, &p->layout))
        return ibl_console_fail(
            p->console, "levels %d: a cube of size %d has 1 to %d levels",
            o->specular_options.levels, o->specular_options.size,
            ibl_most_levels(o->specular_options.size));
    const bool holds = ibl_container_holds(b->container, t->pixel);
    if (!holds || (b->zstd && b->container != IBL_CONTAINER_KTX2))
        return ibl_console_fail(
            p->console, "%s: %s files cannot hold it: take the container ktx2",
            holds ? "zstd" : "pixel", ibl_container_name(b->container));
    if (t->pixel == IBL_PIXEL_RGBA32F && ibl_is_given(given, "overflow"))
        return ibl_console_fail(
            p->console, "--overflow: rgba32f holds all light: leave it out");
    if (ibl_pixel_block(t->pixel) == 1 &&
        (t->quality != IBL_QUALITY_NORMAL || ibl_is_given(given, "quality")))
        return ibl_console_fail(p->console,
                                "quality: %s has none: it is for bc6h, "
                                "uastc-hdr and astc4x4hdr",
                                ibl_pixel_name(t->pixel));
    ibl_warn_of_small_faces(p->console, &p->layout);
    return true;
}

/* ---- files -------------------------------------------------------------- */

/* Fails if an output would replace this input. */
static bool check_input(const ibl_probes_bake *p, const char *input)
{
    bool ok = true;

    for (int i = 0; i < IBL_PROBES_FILES && ok; i++)
        ok = !p->path[i] ||
             ibl_console_differ(p->console, input, p->path[i], "directory");
    return ok;
}

/* Hashes all that the files depend on: the program, its options, the set, and
 * the contents of its captures. */
static bool hash_inputs(ibl_probes_bake *p)
{
    char *text = ibl_settings_text(ibl_ctx_isa(p->ctx), &ibl_probes_command,
                                   &p->opts->given);
    char *set = ibl_need(ibl_json_text(p->set.root)), hash[IBL_FILE_HASH];
    bool ok = check_input(p, p->input);

    ibl_append(&text, "%s", set);
    free(set);
    for (int i = 0; i < p->set.layers && ok; i++) {
        const ibl_set_entry *e = &p->set.entry[i];
        char *files[IBL_FACES] = {0};
        int count = 0;
        ok = !ibl_input_files(p->ctx, e->capture, files, &count);
        for (int k = 0; k < count && ok; k++) {
            ok = check_input(p, files[k]) &&
                 (!(errno = ibl_hash_file(files[k], hash)) ||
                  ibl_console_fail(p->console, "%s: %s: %s: cannot be read: %s",
                                   p->input, e->place, files[k],
                                   errno == EINVAL ? "no regular file"
                                                   : strerror(errno)));
            if (ok)
                ibl_append(&text, "%s\n", hash);
        }
        ibl_input_files_free(files);
    }
    ibl_hash_bytes(text, strlen(text), p->hash);
    free(text);
    return ok;
}

static bool is_later(struct timespec a, struct timespec b)
{
    return a.tv_sec > b.tv_sec ||
           (a.tv_sec == b.tv_sec && a.tv_nsec > b.tv_nsec);
}

/* Whether the files are there and those of the hash. One that is newer than the
 * index was edited, or a run was killed before it wrote the index. */
static bool is_kept(const ibl_probes_bake *p)
{
    struct stat index, file;
    ibl_json_why why;
    json_t *old = p->opts->force
                      ? NULL
                      : ibl_json_load(p->path[IBL_PROBES_INDEX], 0, &why);
    bool kept = !strcmp(text_of(old, "hash"), p->hash) &&
                !stat(p->path[IBL_PROBES_INDEX], &index);

    for (int i = 0; i < IBL_PROBES_INDEX && kept; i++)
        kept = !p->path[i] || (!stat(p->path[i], &file) &&
                               !is_later(file.st_mtim, index.st_mtim));
    json_decref(old);
    return kept;
}

/* ---- captures ----------------------------------------------------------- */

/* Alpha of at least this counts as 1, since renderers round it. */
#define OPAQUE 0.999f

/* The cookie of read_greys; alpha is the next row. */
typedef struct greys {
    const float *alpha;
    int width;
} greys;

static ibl_status read_greys(void *cookie, int rows, float *rgb)
{
    greys *g = cookie;
    const size_t count = (size_t)rows * (size_t)g->width;

    for (size_t i = 0; i < 3 * count; i++)
        rgb[i] = g->alpha[i / 3];
    g->alpha += count;
    return IBL_OK;
}

/* Bakes rows; level 0 is that of faces with its size, if there is one. */
static bool bake(const ibl_probes_bake *p, const ibl_environment *rows,
                 ibl_cube *faces, ibl_bake_result *made)
{
    ibl_bake_options options = p->set.bake.options;
    const int size = options.specular_options.size;
    ibl_cube level0 = {.size = size, .levels = 1};
    int level = 0;

    while (level + 1 < faces->levels && faces->size >> level > size)
        level++;
    if (faces->data && size << level == faces->size) {
        if (level && ibl_cube_build_mips(p->ctx, faces))
            return false;
        level0.data = ibl_cube_face(faces, level, 0);
        options.level0 = &level0;
    }
    return !ibl_bake_environment(p->ctx, rows, &options, made);
}

/* Bakes the alpha of a source that was read, if some of it is not 1. */
static bool bake_alpha(const ibl_probes_bake *p, const ibl_set_entry *e,
                       const ibl_source *source, ibl_cube *faces,
                       ibl_bake_result *made)
{
    const int width = ibl_source_width(source);
    const int height = ibl_source_height(source);
    greys grey = {ibl_source_alpha(source), width};
    const ibl_environment rows = {
        .width = width, .height = height, .read = read_greys, .cookie = &grey};
    const size_t pixels = (size_t)width * (size_t)height;
    float least = 1, most = 0;

    /* Of a cross only the faces: the report has all of the file. */
    for (size_t i = 0; i < pixels && grey.alpha; i++) {
        least = fminf(least, grey.alpha[i]);
        most = fmaxf(most, grey.alpha[i]);
    }
    if (least >= OPAQUE)
        return true;
    return most > 0
               ? bake(p, &rows, faces, made)
               : ibl_console_fail(
                     p->console,
                     "%s: %s: alpha is 0 everywhere, so nothing would be seen "
                     "of this probe: save it with alpha 1 where something is, "
                     "or take --alpha ignore",
                     p->input, e->place);
}

/* Whether the arrays of all layers, and the bake of a map of width x height
 * pixels, which is in memory with its alpha and its faces, fit in
 * --max-memory. */
static bool fits(const ibl_probes_bake *p, int width, int height)
{
    const ibl_set_bake *b = &p->set.bake;
    const ibl_pixel pixel = b->texels.pixel;
    const int size = p->layout.size, block = ibl_pixel_block(pixel);
    const double level0 = (double)ibl_cube_texels(size, 1);
    const double texels = (double)ibl_cube_texels(size, p->layout.levels);
    const int edge = b->options.irradiance_options.size;
    const double arrays = (texels + (double)ibl_cube_texels(edge, 1)) *
                          (double)ibl_pixel_bytes(pixel) / (block * block) *
                          p->set.layers * (b->zstd ? 2 : 1);
    size_t bake;

    if (ibl_bake_memory(p->ctx, width, height, &b->options, &bake))
        return false;
    const double need = IBL_PROGRAM_BYTES +
                        1.1 * (arrays + (double)bake + 28.0 * width * height +
                               16 * level0 + 12 * texels);
    return ibl_console_fits(p->console, &p->opts->common, p->input, need,
                            "ask for a smaller --size, or make two sets of it");
}

/*
 * Bakes the capture of a layer. If it has faces whose edge is 2^k times the
 * specular cube's, level 0 is the faces (k = 0) or means of their texels.
 *   colour, alpha  empty; to be freed with ibl_bake_result_free. alpha, in
 *                  greys, stays empty unless the layer's alpha is read and some
 *                  is below OPAQUE. Colours are multiplied by it
 * Alpha that is 0 everywhere is an error.
 */
static bool bake_capture(const ibl_probes_bake *p, int layer,
                         ibl_bake_result *colour, ibl_bake_result *alpha)
{
    const ibl_set_entry *e = &p->set.entry[layer];
    ibl_read_options read = p->opts->common.read;
    ibl_source *source = NULL;
    ibl_cube faces[2] = {0}; /* of colours and alpha */
    ibl_environment rows;

    read.alpha = ibl_probes_alpha(&p->set, layer);
    read.faces = faces;
    if (e->cube) {
        read.layout = IBL_INPUT_AUTO;
        read.any_aspect = 0; /* with which no cross is found */
    }
    ibl_console_progress(p->console, "decode", 0);
    bool ok = !ibl_source_open(p->ctx, e->capture, &read, &source);
    if (ok)
        rows = ibl_source_environment(source);
    ok = ok && fits(p, rows.width, rows.height) &&
         bake(p, &rows, &faces[0], colour) &&
         bake_alpha(p, e, source, &faces[1], alpha);
    ibl_cube_free(&faces[0]);
    ibl_cube_free(&faces[1]);
    ibl_source_close(source);
    return ok;
}

/* ---- layers -------------------------------------------------------------- */

/* What the pixel format changes of a layer. */
typedef struct loss {
    size_t values;             /* components above the largest value */
    ibl_overflow_level beyond; /* over all cubes and levels */
    double dark;               /* largest share of light that became 0 */
    json_t *errors;            /* of specular levels */
} loss;

/* Encodes a cube as a layer. Empty alpha means 1. */
static bool take_cube(ibl_probes_bake *p, ibl_probes_kind kind, int layer,
                      const ibl_cube *cube, const ibl_cube *alpha, loss *l)
{
    ibl_texture *array = &p->array[kind], tex = {0};
    ibl_overflow_report report = {0};
    ibl_pixel_error error[IBL_MAX_LEVELS] = {0};

    ibl_console_progress(p->console, "texels", 0);
    const bool ok =
        !ibl_texture_from_cube(p->ctx, cube, &p->set.bake.texels, &tex,
                               &report) &&
        !ibl_texture_errors(p->ctx, &tex, cube, error) &&
        (!alpha->data || !ibl_texture_set_alpha(p->ctx, &tex, alpha)) &&
        (array->data ||
         !ibl_texture_array_begin(p->ctx, &tex, p->set.layers, array)) &&
        !ibl_texture_array_put(p->ctx, array, layer, &tex);
    ibl_texture_free(&tex);
    l->values += report.values;
    for (int i = 0; i < cube->levels; i++) {
        ibl_overflow_add(&report.level[i], &l->beyond);
        l->dark = fmax(l->dark, error[i].lost);
        if (kind == IBL_PROBES_SPECULAR)
            json_array_append_new(l->errors, ibl_json_pixel_error(&error[i]));
    }
    return ok;
}

/* The coefficients of alpha, which all three components have. */
static json_t *alpha_harmonics(const double *sh)
{
    json_t *list = json_array();

    for (int l = 0; l <= IBL_PROBES_SH_DEGREE; l++)
        for (int i = l * l; i < (l + 1) * (l + 1); i++)
            json_array_append_new(
                list, json_real(ibl_sh_cosine(l) * sh[3 * i] + 0.0));
    return list;
}

static bool bake_layer(ibl_probes_bake *p, int layer)
{
    const ibl_texel_options *texels = &p->set.bake.texels;
    const char *pixel = ibl_pixel_name(texels->pixel);
    ibl_set_entry *e = &p->set.entry[layer];
    ibl_bake_result colour = {0}, alpha = {0};
    loss l = {.errors = json_array()};
    char name[512];

    bool ok = bake_capture(p, layer, &colour, &alpha);
    e->alpha = alpha.specular.data != NULL;
    if (e->alpha && !ibl_pixel_has_alpha(texels->pixel))
        ok = ibl_console_fail(
            p->console,
            "%s: %s: has alpha below 1, which %s has no room for: choose "
            "--pixel rgba16f or rgba32f, or --alpha ignore",
            p->input, e->place, pixel);
    ok = ok &&
         take_cube(p, IBL_PROBES_SPECULAR, layer, &colour.specular,
                   &alpha.specular, &l) &&
         (!colour.irradiance.data ||
          take_cube(p, IBL_PROBES_IRRADIANCE, layer, &colour.irradiance,
                    &alpha.irradiance, &l));
    snprintf(name, sizeof name, "%s: %s", p->input, e->place);
    ibl_warn_of_overflow(p->console, name, texels, NULL, false, &l.beyond);
    ibl_warn_of_underflow(p->console, name, pixel, l.dark);
    e->note = json_pack(
        "{sI so* sO* so* so*}", "saturated", (json_int_t)l.values, "beyond",
        l.beyond.texels ? ibl_json_overflow(&l.beyond) : NULL, "pixel_error",
        ibl_pixel_block(texels->pixel) > 1 ? l.errors : NULL, "sh",
        colour.sh ? ibl_json_harmonics(colour.sh, IBL_PROBES_SH_DEGREE, true)
                  : NULL,
        "alpha_sh", alpha.sh ? alpha_harmonics(alpha.sh) : NULL);
    json_decref(l.errors);
    ibl_bake_result_free(&colour);
    ibl_bake_result_free(&alpha);
    if (ok)
        ibl_console_info(p->console, "layer %d: %s: baked%s", layer,
                         *e->name ? e->name : "(global)",
                         e->alpha ? ", with alpha" : "");
    return ok;
}

/* ---- the index, as iblbake-probes(1) describes it ---------------------- */

enum {
    INDEX_VERSION = 1
};

static json_t *files_json(const ibl_probes_bake *p)
{
    static const char *const keys[] = {"specular", "irradiance", "brdf_lut"};
    const ibl_set_bake *bake = &p->set.bake;
    const int size[] = {p->layout.size, bake->options.irradiance_options.size,
                        bake->lut_size};
    json_t *j = json_object();

    for (int kind = 0; kind <= IBL_PROBES_LUT; kind++) {
        const bool lut = kind == IBL_PROBES_LUT;
        if (!p->path[kind])
            continue;
        json_t *file = json_pack(
            "{ss ss ss si si si}", "file", ibl_path_name(p->path[kind]),
            "container", ibl_container_name(bake->container), "pixel",
            ibl_pixel_name(lut ? p->lut_pixel : bake->texels.pixel), "size",
            size[kind], "levels",
            kind == IBL_PROBES_SPECULAR ? p->layout.levels : 1, "layers",
            lut ? 1 : p->set.layers);
        if (bake->zstd)
            json_object_set_new(file, "zstd", json_integer(bake->zstd));
        json_object_set_new(j, keys[kind], file);
    }
    return j;
}

static json_t *specular_json(const ibl_specular_options *options,
                             const ibl_specular_layout *layout)
{
    const bool linear = options->mapping == IBL_ROUGHNESS_LINEAR;
    json_t *roughness = json_array();

    for (int l = 0; l < layout->levels; l++)
        json_array_append_new(roughness, json_real(layout->roughness[l]));
    return json_pack(
        "{ss ss so ss sf sf}", "lobe", ibl_lobe_name(options->lobe), "mapping",
        ibl_roughness_map_name(options->mapping), "roughness", roughness, "lod",
        linear ? "roughness * lod_scale + lod_offset"
               : "roughness * (2 - roughness) * lod_scale + "
                 "lod_offset",
        "lod_scale", layout->lod_scale, "lod_offset", layout->lod_offset);
}

/* The entry of layer i: a probe, or the global environment, the last layer. */
static json_t *entry_json(const ibl_probes_bake *p, int i)
{
    const ibl_set_entry *e = &p->set.entry[i];
    json_t *j = json_pack("{ss* si}", "name", i < p->set.count ? e->name : NULL,
                          "layer", i);

    if (i < p->set.count) {
        json_object_update_new(j, ibl_json_probe_of(&p->set.probe[i]));
        json_object_set_new(j, "alpha", json_boolean(e->alpha));
    }
    json_object_update(j, e->note);
    return j;
}

/* The text of the index, which the caller must free. */
static char *index_text(const ibl_probes_bake *p)
{
    const ibl_bake_options *options = &p->set.bake.options;
    json_t *probes = json_array();
    json_t *irradiance =
        options->irradiance
            ? json_pack("{ss ss}", "kind", "cube", "scale", "E/pi")
            : json_pack("{ss ss si}", "kind", "sh", "scale", "E/pi", "degree",
                        IBL_PROBES_SH_DEGREE);

    for (int i = 0; i < p->set.count; i++)
        json_array_append_new(probes, entry_json(p, i));
    json_t *root = json_pack(
        "{si so ss so so so so so* ss}", "version", INDEX_VERSION, "generator",
        ibl_json_generator(ibl_ctx_isa(p->ctx), IBL_REVISION), "world",
        "right-handed, +Y up; faces +X -X +Y -Y +Z -Z, row 0 on top", "files",
        files_json(p), "specular",
        specular_json(&options->specular_options, &p->layout), "irradiance",
        irradiance, "probes", probes, "global",
        p->set.layers > p->set.count ? entry_json(p, p->set.count) : NULL,
        "hash", p->hash);
    char *text = ibl_need(ibl_json_text(root));
    json_decref(root);
    return text;
}

/* ---- outputs ------------------------------------------------------------ */

static bool put_texture(ibl_probes_bake *p, ibl_probes_kind kind)
{
    static const ibl_content contents[] = {
        [IBL_PROBES_SPECULAR] = IBL_CONTENT_SPECULAR,
        [IBL_PROBES_IRRADIANCE] = IBL_CONTENT_IRRADIANCE,
        [IBL_PROBES_LUT] = IBL_CONTENT_LUT};
    ibl_texture *tex = &p->array[kind];
    const ibl_sidecar_output output = {.content = contents[kind]};
    ibl_sidecar_options facts = ibl_sidecar_options_default();

    facts.specular = &p->set.bake.options.specular_options;
    tex->zstd = p->set.bake.zstd;
    ibl_console_progress(p->console, "write", 0);
    return !ibl_texture_describe(p->ctx, tex, &facts, &output) &&
           (kind == IBL_PROBES_LUT ||
            !ibl_texture_set(p->ctx, tex, "iblbake.alpha",
                             tex->premultiplied ? "premultiplied"
                                                : "opaque")) &&
           !ibl_outputs_take_texture(p->outputs, p->path[kind], tex,
                                     p->set.bake.container, NULL);
}

/* The index is written when all else is, so that nothing is newer. */
static bool put_files(ibl_probes_bake *p)
{
    ibl_lut_options options = ibl_lut_options_default();
    ibl_lut lut = {0};

    options.size = p->set.bake.lut_size;
    ibl_console_progress(p->console, "lut", 0);
    bool ok = !ibl_bake_lut(p->ctx, &options, &lut) &&
              !ibl_texture_from_lut(p->ctx, &lut, p->lut_pixel,
                                    &p->array[IBL_PROBES_LUT], NULL);
    ibl_lut_free(&lut);
    for (int kind = 0; kind < IBL_PROBES_INDEX && ok; kind++)
        ok = !p->path[kind] || put_texture(p, (ibl_probes_kind)kind);
    if (!ok || ibl_outputs_wait(p->outputs))
        return false;
    char *index = index_text(p);
    ok = !ibl_outputs_add(p->outputs, p->path[IBL_PROBES_INDEX], index,
                          strlen(index)) &&
         ibl_console_commit(p->console, p->outputs);
    free(index);
    return ok;
}

/* ---- walls that a set leaves to the light from outside ------------------ */

enum {
    SIDE = 13, /* points along an edge of a wall */
    POINTS = IBL_FACES * SIDE * SIDE
};

static const double told = 0.01; /* weight from outside that is told of */
/* A proxy so many times as large as the influence stands for infinity. */
static const double far = 1000;

/* A point of a box's wall, or the one in its direction on a sphere; a little
 * behind it, where an influence that ends there is over. */
static void wall_point(const ibl_volume *v, int n, double p[3])
{
    const int face = n / SIDE / SIDE, axis = face / 2;
    double at[3], scale = 1 + 1e-9;

    at[axis] = face % 2 ? 1 : -1;
    at[(axis + 1) % 3] = 2.0 * (n % SIDE) / (SIDE - 1) - 1;
    at[(axis + 2) % 3] = 2.0 * (n / SIDE % SIDE) / (SIDE - 1) - 1;
    if (v->shape == IBL_SHAPE_SPHERE)
        scale /= hypot(hypot(at[0], at[1]), at[2]);
    for (int k = 0; k < 3; k++)
        p[k] = v->centre[k] + scale * at[k] * v->half[k];
}

/* Warns of probes whose walls, those of their proxies, get light from outside,
 * and says which influence would do. With --strict fails. */
static bool check_walls(const ibl_probes_bake *p)
{
    const int count = p->set.count;
    const ibl_probe *probes = p->set.probe;
    int *order = ibl_need(calloc((size_t)count, sizeof *order));
    char line[IBL_LINE_BYTES];
    double most = told;
    int worst = -1;

    for (int i = 0; i < count; i++)
        order[i] = i; /* as they are */
    for (int i = 0; i < count; i++) {
        const ibl_volume *proxy = &probes[i].proxy;
        bool skip = !probes[i].has_proxy ||
                    ibl_volume_size(proxy) >=
                        far * ibl_volume_size(&probes[i].influence);
        for (int j = 0; j < i; j++) /* probes of a room have its walls */
            skip |= probes[j].has_proxy &&
                    !memcmp(&probes[j].proxy, proxy, sizeof *proxy);
        if (skip)
            continue;
        for (int n = 0; n < POINTS; n++) {
            ibl_probe_mix mix;
            double point[3];
            wall_point(proxy, n, point);
            ibl_probes_blend(probes, count, order, point, NULL, &mix);
            if (mix.rest > most) {
                most = mix.rest;
                worst = i;
            }
        }
    }
    free(order);
    if (worst < 0)
        return true;
    snprintf(line, sizeof line,
             "%s: probe \"%.60s\": up to %.0f %% of the light on the walls "
             "of its proxy comes from outside all probes: let its "
             "influence, or those of others, reach beyond them by the "
             "blend%s",
             p->input, p->set.entry[worst].name, 100 * most,
             probes[worst].blend > 0 ? "" : ", or by a little without one");
    if (p->opts->common.read.strict)
        return ibl_console_fail(p->console, "%s", line);
    ibl_console_warn(p->console, "%s", line);
    return true;
}

/* ---- the command ------------------------------------------------------- */

/* Bakes a set into a directory, unless it is there. */
static bool bake_set(const ibl_probes_opts *opts, const char *input,
                     const char *directory, ibl_console *console, ibl_ctx *ctx)
{
    static const char *const stems[] = {"probes_specular", "probes_irradiance",
                                        "brdf_lut", "index"};
    ibl_probes_bake p = {
        .opts = opts, .input = input, .console = console, .ctx = ctx};

    ibl_console_progress(console, "look", 0);
    bool ok = ibl_probe_set_read(input, console, &p.set) && find_options(&p) &&
              check_walls(&p);
    for (int i = 0; i < IBL_PROBES_FILES && ok; i++) {
        char name[64];
        snprintf(name, sizeof name, "%s.%s", stems[i],
                 i == IBL_PROBES_INDEX
                     ? "json"
                     : ibl_container_name(p.set.bake.container));
        if (i != IBL_PROBES_IRRADIANCE || p.set.bake.options.irradiance)
            p.path[i] = ibl_need(ibl_path_join(directory, name));
    }
    ok = ok && hash_inputs(&p);
    const bool kept = ok && is_kept(&p);
    if (ok && !kept)
        ok = !ibl_outputs_create(ctx, opts->sync, &p.outputs) &&
             !ibl_outputs_mkdir(p.outputs, directory);
    for (int i = 0; i < p.set.layers && ok && !kept; i++)
        ok = bake_layer(&p, i);
    ok = ok && (kept || put_files(&p));
    for (int i = 0; i < IBL_PROBES_FILES && ok; i++)
        if (p.path[i])
            ibl_console_info(console, "%s %s", kept ? "kept" : "wrote",
                             p.path[i]);
    ibl_outputs_free(p.outputs);
    for (int kind = 0; kind < IBL_PROBES_INDEX; kind++)
        ibl_texture_free(&p.array[kind]);
    for (int i = 0; i < IBL_PROBES_FILES; i++)
        free(p.path[i]);
    ibl_probe_set_free(&p.set);
    return ok;
}

/* Of several sets each has a directory of its own name. */
static bool check_names(const ibl_probes_opts *opts, ibl_console *console)
{
    json_t *seen = json_object(); /* indices by name */
    char name[256];
    bool ok = true;

    for (int i = 0; i < opts->count && ok && opts->count > 1; i++) {
        ok = ibl_stem(opts->input[i], name, sizeof name);
        console->failed |= !ok; /* that was said */
        const json_t *other = ok ? json_object_get(seen, name) : NULL;
        if (other)
            ok = ibl_console_fail(
                console,
                "%s and %s: both would be in %s/%s: bake one after the other, "
                "into two directories",
                opts->input[json_integer_value(other)], opts->input[i],
                opts->output, name);
        else if (ok)
            json_object_set_new_nocheck(seen, name, json_integer(i));
    }
    json_decref(seen);
    return ok;
}

int ibl_probes_run(const void *settings)
{
    const ibl_probes_opts *opts = settings;
    const ibl_shard *shard = &opts->shard;
    char stem[256] = "";
    ibl_console console;
    ibl_ctx *ctx = NULL;

    ibl_console_init(&console, opts->common.quiet, opts->common.verbose);
    bool ok = check_names(opts, &console) &&
              !ibl_start(&opts->common, &console, &ctx) &&
              (!opts->grid || ibl_probes_grid(opts, &console, ctx));
    for (int i = 0; i < opts->count && ok && !opts->grid; i++) {
        if (!ibl_shard_has(shard, i))
            continue;
        if (opts->count > 1)
            ibl_stem(opts->input[i], stem, sizeof stem);
        char *directory = ibl_need(ibl_path_join(opts->output, stem));
        ok = bake_set(opts, opts->input[i], directory, &console, ctx);
        free(directory);
    }
    const int status = ibl_console_end(&console, ok);
    ibl_ctx_free(ctx);
    return status;
}
