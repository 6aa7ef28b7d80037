/* SPDX-License-Identifier: MIT */
/* iblbake convert: a texture in another container, pixel format or layout, or
 * as pictures. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/job.h"
#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "engine/engine.h"
#include "engine/picture.h"
#include "json/text.h"

typedef struct convert_opts {
    ibl_common common;
    const char *path[2]; /* IN and OUT */
    int count;
    int file;            /* in format_names; -1: as OUT's suffix says */
    ibl_picture picture; /* what that is, else NONE */
    int layout;          /* in ibl_layout_names; -1: IN's */
    int pixel;           /* an ibl_pixel; -1: IN's */
    int zstd;
    ibl_tone tone;
    ibl_texel_options texels;
    ibl_given given;
} convert_opts;

/* ---- options --------------------------------------------------------- */

static const char *const format_names[] = {
    [IBL_CONTAINER_KTX2] = "ktx2",
    [IBL_CONTAINER_KTX] = "ktx",
    [IBL_CONTAINER_DDS] = "dds",
    [IBL_CONTAINER_DDS_LEGACY] = "dds-legacy",
    "exr", /* and the others of ibl_picture */
    "hdr",
    "png",
    NULL};

#define IBL_SETTINGS convert_opts

/* clang-format off */
static const ibl_option outputs[] = {
    {"format", 0, IBL_CHOICE(file, format_names),
     .standard = "what OUT's suffix says",
     .help = "the kind of file; exr, hdr and png: a picture for each level and "
             "face"},
    {"tone", 0, IBL_CHOICE(tone, ibl_tone_names),
     .help = "what png files make of light before sRGB's curve: film, or clip "
             "it at 1"},
    {"pixel", 0, IBL_CHOICE(pixel, ibl_pixel_names),
     .standard = "IN's",
     .help = "texels of maps; tables keep theirs"},
    {"layout", 0, IBL_CHOICE(layout, ibl_layout_names),
     .standard = "IN's",
     .help = "a cube, or one flat image a level; cross: a cube's faces in one "
             "picture"},
    {"zstd", 0, IBL_INT(zstd, 0, IBL_MAX_ZSTD),
     .help = "compress ktx2 files with Zstandard of level N; 0: do not"},
    IBL_TEXEL_OPTIONS
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
        return ibl_misuse("%s: what kind of file? End its name in .ktx2, .ktx, "
                          ".dds, .exr, .hdr or .png, or add --format NAME",
                          o->path[1]);
    if (o->file >= IBL_CONTAINER_COUNT)
        o->picture =
            (ibl_picture)(o->file - IBL_CONTAINER_COUNT + IBL_PICTURE_EXR);
    if (!o->picture && o->layout == IBL_LAYOUT_CROSS)
        return ibl_misuse("--layout cross: is for pictures: exr, hdr or png");
    o->texels.alike = o->zstd > 0;
    const bool encoded = o->picture || o->pixel >= 0 || o->layout >= 0;
    const ibl_rule rules[] = {
        {"zstd", o->file == IBL_CONTAINER_KTX2,
         "only ktx2 files can hold it: leave it out"},
        {"pixel", o->picture < IBL_PICTURE_HDR,
         "hdr and png files have their own: leave it out"},
        {"tone", o->picture == IBL_PICTURE_PNG,
         "is for --format png: leave it out"},
        {"quality", o->pixel >= 0 && ibl_pixel_block((ibl_pixel)o->pixel) > 1,
         "is for --pixel bc6h, uastc-hdr and astc4x4hdr: leave it out"},
        {"overflow largest", encoded,
         "texels stay as they are: add --pixel or --layout, or leave it out"},
        {.options = NULL}};
    return ibl_common_validate(&o->common) &&
           ibl_check_rules(&o->given, rules, true);
}

/* ---- texels ---------------------------------------------------------- */

typedef struct conversion {
    const convert_opts *o;
    ibl_console console;
    ibl_ctx *ctx;
    ibl_texture in, out;
    ibl_texel_options texels; /* of OUT */
    ibl_projection layout;
    bool table; /* IN is one, not a map */
} conversion;

/* A map in another layout: each texel of a level is an average over the solid
 * angle that it has there. */
static bool lay_out(ibl_ctx *ctx, ibl_projection to, ibl_cube *map)
{
    ibl_cube out = {0};
    bool ok = !ibl_cube_alloc_as(ctx, to, map->size, map->levels, &out);

    for (int l = 0; l < map->levels && ok; l++) {
        const int n = ibl_cube_edge(map->size, l);
        ibl_cube from = {n, 1, ibl_cube_face(map, l, 0), map->projection};
        ibl_cube into = {n, 1, ibl_cube_face(&out, l, 0), to}, cube = {0};
        ibl_image image = {4 * n, 2 * n, from.data}, made = {0};

        if (from.projection == IBL_PROJECTION_OCTAHEDRAL) {
            ok = !ibl_cube_from_flat(ctx, &from, &cube);
            from = cube;
        }
        if (map->projection != IBL_PROJECTION_EQUIRECT) {
            const int width = ibl_latlong_width(n);
            ok = ok && !ibl_image_alloc(ctx, width, width / 2, &made) &&
                 !ibl_latlong_from_cube(ctx, &from, &made);
            image = made;
        }
        ok = ok && !(to == IBL_PROJECTION_CUBE
                         ? ibl_cube_from_latlong(ctx, &image, 0, &into)
                         : ibl_flat_from_latlong(ctx, &image, 0, &into));
        ibl_image_free(&made);
        ibl_cube_free(&cube);
    }
    ibl_cube_free(map);
    *map = out;
    return ok;
}

/* Counts components that the pixel format makes 0: NaN, and of those without a
 * sign what is negative. */
static size_t count_bad(const ibl_cube *map, ibl_pixel pixel)
{
    size_t bad = 0;

    for (int l = 0; l < map->levels; l++) {
        const ibl_level_shape s =
            ibl_level_shape_of(map->projection, ibl_cube_edge(map->size, l));
        const float *texel = ibl_cube_face(map, l, 0);
        const size_t count = 3 * (size_t)(s.faces * s.height) * (size_t)s.width;
        for (size_t i = 0; i < count; i++)
            bad +=
                isnan(texel[i]) || (pixel > IBL_PIXEL_RGBA32F && texel[i] < 0);
    }
    return bad;
}

/* Encodes a layer of a map. */
static bool encode_layer(conversion *c, int layer)
{
    const bool other = c->layout != ibl_texture_projection(&c->in);
    ibl_texture one = {0}, made = {0};
    ibl_cube map = {0}, alpha = {0};
    char *name = (char *)c->o->path[1];
    ibl_output file = {.paths = &name};

    bool ok =
        !ibl_texture_layer(c->ctx, &c->in, layer, &one) &&
        !ibl_texture_to_cube(c->ctx, &one, &map) &&
        (!one.premultiplied || !ibl_texture_get_alpha(c->ctx, &one, &alpha)) &&
        (!other || (lay_out(c->ctx, c->layout, &map) &&
                    (!alpha.data || lay_out(c->ctx, c->layout, &alpha)))) &&
        !ibl_texture_from_cube(c->ctx, &map, &c->texels, &made,
                               &file.overflow) &&
        !ibl_texture_errors(c->ctx, &made, &map, file.error);
    if (ok) {
        const size_t bad = count_bad(&map, c->texels.pixel);
        if (bad)
            ibl_console_warn(
                &c->console, "%s: %zu components that are NaN%s are 0 in it",
                name, bad,
                c->texels.pixel > IBL_PIXEL_RGBA32F ? " or negative" : "");
        file.shape.levels = map.levels;
        ibl_output_warn(&file, &c->console, &c->texels, NULL, false);
    }
    ok = ok && (!alpha.data || !ibl_texture_set_alpha(c->ctx, &made, &alpha)) &&
         (layer ||
          !ibl_texture_array_begin(c->ctx, &made, c->in.layers, &c->out)) &&
         !ibl_texture_array_put(c->ctx, &c->out, layer, &made);
    c->out.premultiplied = c->in.premultiplied;
    ibl_texture_free(&one);
    ibl_texture_free(&made);
    ibl_cube_free(&map);
    ibl_cube_free(&alpha);
    return ok;
}

/* Sets the keys of OUT: those of IN, but for what they say of its texels. */
static bool set_keys(conversion *c, bool encoded)
{
    static const char *const names[] = {"KTXwriterScParams", "iblbake.layout",
                                        "iblbake.pixel", "iblbake.quality",
                                        NULL};
    const bool blocks = ibl_pixel_block(c->out.pixel) > 1;
    char writer[32];
    bool ok = true;

    snprintf(writer, sizeof writer, "--zstd %d", c->o->zstd);
    const char *const values[] = {
        c->o->zstd ? writer : NULL,
        c->out.faces == 1 ? ibl_projection_name(c->layout) : NULL,
        blocks ? ibl_pixel_name(c->out.pixel) : NULL,
        blocks ? ibl_quality_names[c->texels.quality] : NULL};
    for (int i = 0; i < c->in.key_count && ok; i++) {
        const ibl_key_value *pair = &c->in.keys[i];
        const int own = ibl_names_find(names, pair->key);
        if (own < 0 || (own > 0 && !encoded))
            ok = !ibl_texture_set(c->ctx, &c->out, pair->key, pair->value);
    }
    for (int i = 0; i < (encoded ? 4 : 1) && ok; i++)
        ok = !values[i] ||
             !ibl_texture_set(c->ctx, &c->out, names[i], values[i]);
    return ok;
}

/* Makes OUT's texture of IN's. */
static bool change(conversion *c)
{
    const convert_opts *o = c->o;
    const char *content = ibl_texture_get(&c->in, "iblbake.content");
    const ibl_projection was = ibl_texture_projection(&c->in);
    const ibl_pixel pixel = c->in.pixel;
    bool ok = true;

    c->table =
        ibl_pixel_channels(pixel) == 2 || (content && strstr(content, "_lut"));
    c->texels = o->texels;
    c->texels.pixel = o->pixel >= 0 ? (ibl_pixel)o->pixel : pixel;
    if (o->picture > IBL_PICTURE_EXR)
        c->texels.pixel = IBL_PIXEL_RGBA32F;
    else if (o->picture && o->pixel < 0 && pixel != IBL_PIXEL_RGBA32F)
        c->texels.pixel = IBL_PIXEL_RGBA16F;
    if (c->table)
        c->texels.pixel = pixel;
    c->layout = o->layout < 0                   ? was
                : o->layout == IBL_LAYOUT_CROSS ? IBL_PROJECTION_CUBE
                                                : (ibl_projection)o->layout;
    const char *up = ibl_texture_get(&c->in, "iblbake.up"), *why = NULL;
    if (c->table && (o->layout >= 0 || o->pixel >= 0))
        why = "is a table, no map: leave out --layout and --pixel";
    else if (o->picture && (c->in.layers > 1 || c->in.premultiplied))
        why = "has layers or alpha, which pictures have not: take a texture";
    else if (o->picture ? !c->table && c->texels.pixel > IBL_PIXEL_RGBA32F
                        : !ibl_container_holds((ibl_container)o->file,
                                               c->texels.pixel))
        why = "such a file cannot hold these texels: take --pixel rgba16f";
    else if (c->layout != was && up && !strcmp(up, "z"))
        why = "has its z up (iblbake.up), and flat maps y: leave out --layout";
    if (why)
        return ibl_console_fail(&c->console, "%s: %s", o->path[0], why);
    const bool encoded =
        c->layout != was || o->pixel >= 0 || c->texels.pixel != pixel;
    if (!encoded) {
        c->out = c->in;
        c->out.keys = NULL;
        c->out.key_count = 0;
        c->in.data = NULL;
    }
    for (int i = 0; i < c->in.layers && encoded && ok; i++)
        ok = encode_layer(c, i);
    c->out.primaries = c->in.primaries;
    c->out.zstd = o->zstd;
    return ok && set_keys(c, encoded);
}

/* ---- files ------------------------------------------------------------ */

static bool write_pictures(conversion *c, ibl_outputs *to)
{
    const convert_opts *o = c->o;
    const char *out = o->path[1], *suffix = strrchr(out, '.');
    const bool ends = suffix && !strcmp(suffix + 1, format_names[o->file]);
    const size_t length = ends ? (size_t)(suffix - out) : strlen(out);
    const ibl_picture_options options = {
        .kind = o->picture,
        .tone = c->table ? IBL_TONE_RAW : o->tone,
        .cross = o->layout == IBL_LAYOUT_CROSS,
        .equirect = !c->table && c->layout == IBL_PROJECTION_EQUIRECT};
    const int each = options.cross ? 1 : c->out.faces;
    ibl_output file = {.count = each * c->out.levels};
    char *stem = ibl_need(ibl_format("%.*s", (int)length, out));
    bool ok = true;

    file.paths = ibl_need(calloc((size_t)file.count, sizeof *file.paths));
    for (int i = 0; i < file.count; i++) {
        file.paths[i] = ibl_need(
            ibl_picture_name(stem, o->picture, c->out.levels, each, i));
        ok = ok &&
             ibl_console_differ(&c->console, o->path[0], file.paths[i], "OUT");
    }
    ok = ok && ibl_output_pictures(&file, c->ctx, to, &c->out, options);
    for (int i = 0; i < file.count; i++) {
        if (ok)
            ibl_console_info(&c->console, "wrote %s", file.paths[i]);
        free(file.paths[i]);
    }
    free(file.paths);
    free(stem);
    return ok;
}

static bool write_files(conversion *c)
{
    const char *out = c->o->path[1];
    const ibl_texture made = c->out; /* its shape, when it is written */
    ibl_outputs *to = NULL;
    bool ok = !ibl_outputs_create(c->ctx, 0, &to);

    if (ok && c->o->picture)
        ok = write_pictures(c, to);
    else if (ok)
        ok = !ibl_outputs_take_texture(to, out, &c->out,
                                       (ibl_container)c->o->file, NULL);
    ok = ok && ibl_console_commit(&c->console, to);
    ibl_outputs_free(to);
    if (ok && !c->o->picture)
        ibl_console_info(&c->console, "wrote %s: %s, %s, %d x %d, levels: %d",
                         out, made.faces == 6 ? "cube" : "2D",
                         ibl_pixel_name(made.pixel), made.width, made.height,
                         made.levels);
    return ok;
}

static int run(const void *settings)
{
    const convert_opts *o = settings;
    const char *in = o->path[0];
    conversion c = {.o = o};
    int format;

    ibl_console_init(&c.console, o->common.quiet, o->common.verbose);
    const bool ok =
        !ibl_start(&o->common, &c.console, &c.ctx) &&
        ibl_console_differ(&c.console, in, o->path[1], "OUT") &&
        !ibl_engine_look(c.ctx, in, true, &c.in, &format) &&
        (format >= 0 ||
         ibl_console_fail(&c.console,
                          "%s: is no texture (KTX2, KTX or DDS), nor an "
                          "engine's: a map becomes one by iblbake %s -o DIR "
                          "--only skybox --skybox N",
                          in, in)) &&
        change(&c) && write_files(&c);
    const int status = ibl_console_end(&c.console, ok);
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
