/* SPDX-License-Identifier: MIT */
/* iblbake convert: a texture in another container, pixel format or layout. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/console.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "engine/engine.h"

typedef struct convert_opts {
    ibl_common common;
    const char *path[2]; /* IN and OUT */
    int count;
    int file;   /* an ibl_container; -1: as OUT's suffix says */
    int layout; /* an ibl_projection; -1: IN's */
    int pixel;  /* an ibl_pixel; -1: IN's */
    int zstd;
    ibl_texel_options texels;
    ibl_given given;
} convert_opts;

/* ---- options --------------------------------------------------------- */

static const char *const format_names[] = {[IBL_CONTAINER_KTX2] = "ktx2",
                                           [IBL_CONTAINER_KTX] = "ktx",
                                           [IBL_CONTAINER_DDS] = "dds",
                                           [IBL_CONTAINER_DDS_LEGACY] =
                                               "dds-legacy",
                                           NULL};

#define IBL_SETTINGS convert_opts

/* clang-format off */
static const ibl_option outputs[] = {
    {"format", 0, IBL_CHOICE(file, format_names),
     .standard = "what OUT's suffix says",
     .help = "the kind of file"},
    {"pixel", 0, IBL_CHOICE(pixel, ibl_pixel_names),
     .standard = "IN's",
     .help = "texels of maps; a BRDF table is rg32f with rgba32f, else rg16f"},
    {"layout", 0, IBL_CHOICE(layout, ibl_projection_names),
     .standard = "IN's",
     .help = "a cube, or one flat image a level"},
    {"zstd", 0, IBL_INT(zstd, 0, IBL_MAX_ZSTD),
     .help = "compress ktx2 files with Zstandard of level N; 0: do not"},
    {"quality", 0, IBL_CHOICE(texels.quality, ibl_quality_names),
     .help = "of bc6h, uastc-hdr and astc4x4hdr: more time, less error"},
    {"overflow", 0, IBL_CHOICE(texels.overflow, ibl_overflow_names),
     .help = "light above the largest value of the pixel format: spread over "
             "the texels around it, or clip"},
    {"largest", 0, IBL_REAL(texels.largest, "MAX", 1e-6, 1e30),
     .standard = "what the pixel format holds",
     .help = "treat light above MAX in the same way"},
};
/* clang-format on */

static const ibl_section *const sections[] = {
    IBL_SECTION("Outputs", outputs),
    &ibl_running_section,
    NULL,
};

static void defaults(void *settings)
{
    *(convert_opts *)settings = (convert_opts){
        .common = ibl_common_default(),
        .file = -1,
        .layout = -1,
        .pixel = -1,
        .texels = ibl_texel_options_default(),
    };
}

static bool take(void *settings, const char *word)
{
    convert_opts *o = settings;

    if (o->count == 2 || !*word)
        return ibl_misuse("%s: convert takes two names, IN and OUT",
                          *word ? word : "an empty argument");
    o->path[o->count++] = word;
    return true;
}

enum {
    ZSTD = 1 << 0,
    ENCODED = 1 << 1, /* texels are, anew */
    BLOCKS = 1 << 2
};

static const ibl_rule rules[] = {
    {"zstd", ZSTD, "only ktx2 files can hold it: leave it out"},
    {"quality", BLOCKS,
     "is for --pixel bc6h, uastc-hdr and astc4x4hdr: leave it out"},
    {"overflow largest", ENCODED,
     "texels stay as they are: add --pixel or --layout, or leave it out"},
    {.options = NULL}};

static bool validate(void *settings)
{
    convert_opts *o = settings;

    if (o->count < 2)
        return ibl_misuse("no %s: iblbake convert [options] IN OUT, see "
                          "iblbake convert --help",
                          o->count ? "OUT" : "files");
    const char *out = ibl_path_name(o->path[1]), *dot = strrchr(out, '.');
    if (o->file < 0 && dot)
        o->file = ibl_names_find(format_names, dot + 1);
    if (o->file < 0)
        return ibl_misuse("%s: what kind of file? End its name in .ktx2, .ktx "
                          "or .dds, or add --format NAME",
                          o->path[1]);
    o->texels.alike = o->zstd > 0;
    const unsigned facts =
        (o->file == IBL_CONTAINER_KTX2 ? ZSTD : 0) |
        (o->pixel >= 0 || o->layout >= 0 ? ENCODED : 0) |
        (o->pixel >= 0 && ibl_pixel_block((ibl_pixel)o->pixel) > 1 ? BLOCKS
                                                                   : 0);
    return ibl_common_validate(&o->common) &&
           ibl_check_rules(&o->given, rules, facts);
}

/* ---- texels ---------------------------------------------------------- */

typedef struct conversion {
    const convert_opts *o;
    ibl_console console;
    ibl_ctx *ctx;
    ibl_texture in, out;
    ibl_texel_options texels; /* of OUT */
    ibl_projection layout;
} conversion;

/* A map in another layout: each texel of a level is an average over the solid
 * angle that it has there. */
static ibl_status lay_out(ibl_ctx *ctx, ibl_projection to, ibl_cube *map)
{
    ibl_cube out = {0};
    ibl_status status =
        ibl_cube_alloc_as(ctx, to, map->size, map->levels, &out);

    for (int l = 0; l < map->levels && !status; l++) {
        const int n = ibl_cube_edge(map->size, l);
        ibl_cube from = {n, 1, ibl_cube_face(map, l, 0), map->projection};
        ibl_cube into = {n, 1, ibl_cube_face(&out, l, 0), to}, cube = {0};
        ibl_image image = {4 * n, 2 * n, from.data}, made = {0};

        if (from.projection == IBL_PROJECTION_OCTAHEDRAL &&
            !(status = ibl_cube_from_flat(ctx, &from, &cube)))
            from = cube;
        if (from.projection == IBL_PROJECTION_CUBE && !status) {
            const int width = ibl_latlong_width(from.size);
            status = ibl_image_alloc(ctx, width, width / 2, &made);
            if (!status)
                status = ibl_latlong_from_cube(ctx, &from, &made);
            image = made;
        }
        if (!status)
            status = to == IBL_PROJECTION_CUBE
                         ? ibl_cube_from_latlong(ctx, &image, 0, &into)
                         : ibl_flat_from_latlong(ctx, &image, 0, &into);
        ibl_image_free(&made);
        ibl_cube_free(&cube);
    }
    ibl_cube_free(map);
    *map = out;
    return status;
}

/* Warns of what the pixel format cannot hold. */
static void warn_of_format(conversion *c, const ibl_cube *map,
                           const ibl_overflow_report *overflow,
                           const ibl_pixel_error *error)
{
    const char *name = c->o->path[1];
    const ibl_pixel pixel = c->texels.pixel;
    const bool below = pixel > IBL_PIXEL_RGBA32F;
    ibl_overflow_level sum = {0};
    size_t bad = 0;
    double dark = 0;

    for (int l = 0; l < map->levels; l++) {
        const ibl_level_shape s =
            ibl_level_shape_of(map->projection, ibl_cube_edge(map->size, l));
        const float *texel = ibl_cube_face(map, l, 0);
        for (int i = 0; i < 3 * s.faces * s.width * s.height; i++)
            bad += isnan(texel[i]) || (below && texel[i] < 0);
        ibl_overflow_add(&overflow->level[l], &sum);
        dark = fmax(dark, error[l].lost);
    }
    if (bad)
        ibl_console_warn(&c->console,
                         "%s: %zu components that are NaN%s are 0 in it", name,
                         bad, below ? " or negative" : "");
    ibl_warn_of_underflow(&c->console, name, ibl_pixel_name(pixel), dark);
    ibl_warn_of_overflow(&c->console, name, &c->texels, NULL, false, &sum);
}

/* Encodes a layer of a map. */
static ibl_status encode_layer(conversion *c, int layer)
{
    ibl_texture one = {0}, made = {0};
    ibl_cube map = {0}, alpha = {0};
    ibl_overflow_report overflow;
    ibl_pixel_error error[IBL_MAX_LEVELS];
    ibl_status status = ibl_texture_layer(c->ctx, &c->in, layer, &one);
    const bool other = c->layout != ibl_texture_projection(&c->in);

    if (!status)
        status = ibl_texture_to_cube(c->ctx, &one, &map);
    if (!status && one.premultiplied)
        status = ibl_texture_get_alpha(c->ctx, &one, &alpha);
    if (!status && other)
        status = lay_out(c->ctx, c->layout, &map);
    if (!status && other && alpha.data)
        status = lay_out(c->ctx, c->layout, &alpha);
    if (!status)
        status =
            ibl_texture_from_cube(c->ctx, &map, &c->texels, &made, &overflow);
    if (!status && !(status = ibl_texture_errors(c->ctx, &made, &map, error)))
        warn_of_format(c, &map, &overflow, error);
    if (!status && alpha.data)
        status = ibl_texture_set_alpha(c->ctx, &made, &alpha);
    if (!status && !layer)
        status = ibl_texture_array_begin(c->ctx, &made, c->in.layers, &c->out);
    if (!status)
        status = ibl_texture_array_put(c->ctx, &c->out, layer, &made);
    c->out.premultiplied = c->in.premultiplied;
    ibl_texture_free(&one);
    ibl_texture_free(&made);
    ibl_cube_free(&map);
    ibl_cube_free(&alpha);
    return status;
}

static ibl_status encode_lut(conversion *c)
{
    ibl_lut lut = {0};
    ibl_status status = ibl_texture_to_lut(c->ctx, &c->in, &lut);

    if (!status)
        status = ibl_texture_from_lut(c->ctx, &lut,
                                      ibl_lut_pixel(c->texels.pixel, lut.kind),
                                      &c->out, NULL);
    ibl_lut_free(&lut);
    return status;
}

/* Sets the keys of OUT: those of IN, but for what they say of its texels. */
static ibl_status set_keys(conversion *c, bool encoded, bool map)
{
    static const char *const names[] = {"KTXwriterScParams", "iblbake.layout",
                                        "iblbake.pixel", "iblbake.quality",
                                        NULL};
    const bool blocks = ibl_pixel_block(c->out.pixel) > 1;
    char writer[32];
    ibl_status status = IBL_OK;

    snprintf(writer, sizeof writer, "--zstd %d", c->o->zstd);
    const char *const values[] = {
        c->o->zstd ? writer : NULL,
        map && c->out.faces == 1 ? ibl_projection_name(c->layout) : NULL,
        blocks ? ibl_pixel_name(c->out.pixel) : NULL,
        blocks ? ibl_quality_name(c->texels.quality) : NULL};
    for (int i = 0; i < c->in.key_count && !status; i++) {
        const ibl_key_value *pair = &c->in.keys[i];
        const int own = ibl_names_find(names, pair->key);
        if (own < 0 || (own > 0 && !encoded))
            status = ibl_texture_set(c->ctx, &c->out, pair->key, pair->value);
    }
    for (int i = 0; i < (encoded ? 4 : 1) && !status; i++)
        if (values[i])
            status = ibl_texture_set(c->ctx, &c->out, names[i], values[i]);
    return status;
}

/* Makes OUT of IN. */
static bool change(conversion *c)
{
    const convert_opts *o = c->o;
    const char *word = ibl_texture_get(&c->in, "iblbake.content");
    const char *content = word ? word : "", *name = o->path[0];
    const ibl_container container = (ibl_container)o->file;
    const ibl_pixel was = c->in.pixel;
    const bool lobes = !strcmp(content, "lobe_lut");
    const bool lut =
        !strcmp(content, "brdf_lut") || ibl_pixel_channels(was) == 2;
    const char *up = ibl_texture_get(&c->in, "iblbake.up");
    ibl_status status = IBL_OK;

    c->texels = o->texels;
    c->texels.pixel = o->pixel < 0 ? was : (ibl_pixel)o->pixel;
    c->layout = ibl_texture_projection(&c->in);
    const bool turned = o->layout >= 0 && o->layout != (int)c->layout;
    if ((lut || lobes) && o->layout >= 0)
        return ibl_console_fail(
            &c->console, "%s: is a table, no map: leave out --layout", name);
    if (lobes && c->texels.pixel != was)
        return ibl_console_fail(&c->console,
                                "%s: is a lobe table, which is always %s: "
                                "leave out --pixel",
                                name, ibl_pixel_name(was));
    if (turned && up && !strcmp(up, "z"))
        return ibl_console_fail(&c->console,
                                "%s: is a cube whose up is z (iblbake.up), "
                                "flat maps have y: leave out --layout",
                                name);
    if (turned)
        c->layout = (ibl_projection)o->layout;
    if (!lut && !ibl_container_holds(container, c->texels.pixel))
        return ibl_console_fail(
            &c->console, "%s: %s files cannot hold %s: add --pixel rgba16f%s",
            o->path[1], ibl_container_name(container),
            ibl_pixel_name(c->texels.pixel),
            ibl_container_holds(IBL_CONTAINER_KTX2, c->texels.pixel)
                ? ", or take ktx2"
                : "");
    const bool encoded = turned || o->pixel >= 0;
    if (!encoded) {
        c->out = c->in;
        c->out.keys = NULL;
        c->out.key_count = 0;
        c->in.data = NULL;
    }
    if (encoded && lut)
        status = encode_lut(c);
    for (int i = 0; i < c->in.layers && encoded && !lut && !status; i++)
        status = encode_layer(c, i);
    if (!status)
        status = set_keys(c, encoded, !lut && !lobes);
    c->out.primaries = c->in.primaries;
    c->out.zstd = o->zstd;
    return !status;
}

/* ---- the command ------------------------------------------------------ */

static bool read_texture(conversion *c)
{
    const char *name = c->o->path[0];
    const ibl_engine engine = ibl_engine_of_name(name);
    ibl_container container = IBL_CONTAINER_COUNT;
    const ibl_status status =
        engine ? ibl_engine_read(c->ctx, name, -1, &c->in)
               : ibl_engine_look(c->ctx, name, true, &c->in, &container);

    return !status &&
           (c->in.data ||
            ibl_console_fail(&c->console,
                             "%s: is no texture (KTX2, KTX or DDS), nor an "
                             "engine's: a map becomes one by iblbake %s -o DIR "
                             "--only skybox --skybox N",
                             name, name));
}

static bool write_texture(conversion *c)
{
    ibl_outputs *files = NULL;
    const bool ok = !ibl_start_outputs(c->ctx, 0, &files) &&
                    !ibl_outputs_add_texture(files, c->o->path[1], &c->out,
                                             (ibl_container)c->o->file, NULL) &&
                    ibl_console_commit(&c->console, files);

    ibl_end_outputs(files);
    if (ok)
        ibl_console_info(&c->console, "wrote %s: %s, %s, %d x %d, levels: %d",
                         c->o->path[1], c->out.faces == 6 ? "cube" : "2D",
                         ibl_pixel_name(c->out.pixel), c->out.width,
                         c->out.height, c->out.levels);
    return ok;
}

static int run(const void *settings)
{
    const convert_opts *o = settings;
    conversion c = {.o = o};

    ibl_console_init(&c.console, o->common.quiet, o->common.verbose);
    ibl_signals_catch();
    const bool ok =
        !ibl_start(&o->common, &c.console, &c.ctx) &&
        ibl_console_differ(&c.console, o->path[0], o->path[1], "OUT") &&
        read_texture(&c) && change(&c) && write_texture(&c);
    const int status = ibl_console_end(&c.console, ok);
    if (ok && o->common.verbose)
        ibl_console_print_times(&c.console);
    ibl_texture_free(&c.in);
    ibl_texture_free(&c.out);
    ibl_ctx_free(c.ctx);
    return status;
}

const ibl_command ibl_convert_command = {
    .name = "convert",
    .usage = "[options] IN OUT",
    .brief = "write a texture in another container, format or layout",
    .intro = "Writes a baked texture (KTX2, KTX, DDS, or an engine's file) to "
             "OUT, whose\n"
             "suffix says in which container, and keeps its levels and keys. "
             "Nothing is baked.\n",
    .statuses = "0 done, 1 failed, 2 wrong usage",
    .sections = sections,
    .settings_size = sizeof(convert_opts),
    .given = offsetof(convert_opts, given),
    .defaults = defaults,
    .take = take,
    .validate = validate,
    .run = run,
};
