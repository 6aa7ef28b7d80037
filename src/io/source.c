/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "io/bridge.h"
#include "io/colour.h"
#include "io/colour_space.h"
#include "io/container.h"
#include "io/exr.h"
#include "io/input.h"
#include "io/layout.h"
#include "io/repair.h"
#include "io/rgbe.h"
#include "io/rows.h"
#include "io/ultra_hdr.h"

enum {
    BRIDGE_BYTES = 150 << 20, /* OpenImageIO and its libraries */
    SNIFF_BYTES = 64,         /* enough to identify the kind of a file */
    HEIF_BYTES = 1 << 16 /* where the boxes of a HEIF file are looked for */
};

struct ibl_source {
    ibl_ctx *ctx;
    ibl_input in;
    ibl_rows *rows;
    ibl_mender mender;
    ibl_colour colour;
    ibl_alpha_range alpha;
    bool strict;
    bool straight;     /* colours are not multiplied by alpha yet */
    bool mended;       /* the rows are, and what was mended was told */
    bool unwrapped;    /* the rows are of a map made of changed pixels */
    float peak;        /* of what was mended */
    int row;           /* the next row to read */
    ibl_status status; /* of the first read that failed */
    char name[];
};

ibl_read_options ibl_read_options_default(void)
{
    return (ibl_read_options){.part = -1};
}

const char *ibl_alpha_name(ibl_alpha alpha)
{
    static const char *const names[] = {"ignore", "file", "straight"};
    return names[alpha];
}

/* ---- the kind of a file --------------------------------------------- */

/* `size` bytes at `offset` in a file identify its kind. */
typedef struct signature {
    unsigned char offset, size;
    char bytes[14];
    const char *kind, *reader;
} signature;

static const signature signatures[] = {
    {0, 8, "\x89PNG\r\n\x1a\n", "PNG", "png"},
    {0, 3, "\xff\xd8\xff", "JPEG", "jpeg"},
    {0, 4, "II*\0", "TIFF", "tiff"},
    {0, 4, "MM\0*", "TIFF", "tiff"},
    {0, 4, "II+\0", "BigTIFF", "tiff"},
    {0, 4, "MM\0+", "BigTIFF", "tiff"},
    {0, 3, "PF\n", "PFM", "pnm"},
    {0, 3, "Pf\n", "PFM", "pnm"},
    {0, 3, "PF\r", "PFM", "pnm"},
    {0, 3, "PF ", "PFM", "pnm"},
    {0, 3, "Pf ", "PFM", "pnm"},
    {0, 4, "8BPS", "Photoshop", "psd"},
    {0, 6, "GIF87a", "GIF", "gif"},
    {0, 6, "GIF89a", "GIF", "gif"},
    {8, 4, "WEBP", "WebP", "webp"},
    {0, 4, "DDS ", "DDS", "dds"},
    {0, 12, "\0\0\0\x0cjP  \r\n\x87\n", "JPEG 2000", "jpeg2000"},
    {0, 4, "\xff\x4f\xff\x51", "JPEG 2000", "jpeg2000"},
    {4, 8, "ftypheic", "HEIF", "heif"},
    {4, 8, "ftypheix", "HEIF", "heif"},
    {4, 8, "ftypmif1", "HEIF", "heif"},
    {4, 8, "ftypavif", "AVIF", "heif"},
    {4, 8, "ftypavis", "AVIF", "heif"},
    {0, 12, "\0\0\0\x0cJXL \r\n\x87\n", "JPEG XL", "jpegxl"},
    {0, 2, "\xff\x0a", "JPEG XL", "jpegxl"},
    {0, 4, "SDPX", "DPX", "dpx"},
    {0, 4, "XPDS", "DPX", "dpx"},
    {0, 4, "\x80\x2a\x5f\xd7", "Cineon", "cineon"},
    {0, 9, "SIMPLE  =", "FITS", "fits"},
    {0, 2, "\x01\xda", "SGI", "sgi"},
    {0, 4, "\x53\x80\xf6\x34", "Softimage", "softimage"},
    {0, 4, "FOR4", "Maya IFF", "iff"},
    {0, 2, "BM", "BMP", "bmp"},
};

static bool is_pnm(const unsigned char *b, size_t size)
{
    return size > 2 && b[0] == 'P' && b[1] >= '1' && b[1] <= '6' &&
           (b[2] == ' ' || b[2] == '\n' || b[2] == '\r' || b[2] == '\t' ||
            b[2] == '#');
}

/* Finds the kind of an image that only the bridge reads; NULL: unknown. */
static const signature *sniff(const unsigned char *bytes, size_t size)
{
    static const signature pnm = {.kind = "PNM", .reader = "pnm"};

    for (size_t i = 0; i < sizeof signatures / sizeof signatures[0]; i++) {
        const signature *s = &signatures[i];
        if (size >= (size_t)s->offset + s->size &&
            !memcmp(bytes + s->offset, s->bytes, s->size))
            return s;
    }
    return is_pnm(bytes, size) ? &pnm : NULL;
}

/* ---- opening -------------------------------------------------------- */

static bool is_env(const unsigned char *bytes, size_t size)
{
    return size >= 8 && !memcmp(bytes, "\x86\x16\x87\x96\xF6\xD6\x96\x36", 8);
}

static uint64_t longest(const unsigned char *bytes, size_t size)
{
    if (ibl_rgbe_is(bytes, size))
        return ibl_rgbe_longest(bytes, size);
    return sniff(bytes, size) || ibl_exr_is(bytes, size) ||
                   is_env(bytes, size) ||
                   ibl_container_of(bytes, size) != IBL_CONTAINER_COUNT
               ? IBL_LONGEST
               : 0;
}

/* The curve of a HEIF or AVIF file, by a box "colr" in its first bytes
 * (transfer characteristics of ITU-T H.273), if the bridge would take its
 * values for sRGB's and be wrong. NULL: it is none. */
static const char *other_curve(const ibl_input *in)
{
    const size_t size = in->size < HEIF_BYTES ? in->size : HEIF_BYTES;

    for (size_t at = 0; at + 12 <= size; at++) {
        if (memcmp(in->bytes + at, "colrnclx", 8) != 0)
            continue;
        const int transfer = in->bytes[at + 10] << 8 | in->bytes[at + 11];
        if (transfer == 8 || transfer == 16 || transfer == 18)
            return transfer == 8 ? "linear" : transfer == 16 ? "PQ" : "HLG";
    }
    return NULL;
}

static ibl_status check_curve(const ibl_input *in, const char *kind)
{
    const char *curve = other_curve(in);

    return curve ? ibl_unsupported(in,
                                   "is %s with the curve %s, which the image "
                                   "bridge does not decode: convert it to EXR",
                                   kind, curve)
                 : IBL_OK;
}

/* Names what downloads often are in place of the file. */
static ibl_status check_text(const ibl_input *in)
{
    char first[256] = "";
    const char *text = first;

    memcpy(first, in->bytes,
           in->size < sizeof first ? in->size : sizeof first - 1);
    text += !strncmp(text, "\xef\xbb\xbf", 3) ? 3 : 0;
    text += strspn(text, " \t\r\n");
    if (!strncmp(text, "version https://git-lfs", 23))
        return ibl_bad_file(in, "is a pointer of Git LFS, not the file itself: "
                                "fetch it with git lfs pull");
    if (*text == '<')
        return ibl_bad_file(in, "is a web page (HTML or XML), not an image: "
                                "download the file itself");
    return IBL_OK;
}

static ibl_status open_bridged(ibl_source *s, const ibl_read_options *opts)
{
    const ibl_status status = ibl_input_load(&s->in);
    if (status)
        return status;
    ibl_bridge_source source = {.in = &s->in};
    const signature *known = sniff(s->in.bytes, s->in.size);
    if (!known) {
        const ibl_status text = check_text(&s->in);
        if (text)
            return text;
    }
    if (known && !strcmp(known->reader, "jpeg")) {
        const ibl_status hdr = ibl_ultra_hdr_open(&s->in, opts, &s->rows);
        if (hdr || s->rows)
            return hdr;
    }
    if (known && !strcmp(known->reader, "heif")) {
        const ibl_status curve = check_curve(&s->in, known->kind);
        if (curve)
            return curve;
    }
    if (known) {
        snprintf(source.kind, sizeof source.kind, "%s", known->kind);
        source.request.reader = known->reader;
    }
    return ibl_bridge_rows(&source, opts, &s->rows);
}

/* Alpha of level 0, if it is wanted. */
static ibl_status texture_alpha(const ibl_texture *tex,
                                const ibl_read_options *opts, ibl_rows *rows)
{
    const size_t texels = (size_t)rows->width * (size_t)rows->height;

    if (!opts->alpha || !ibl_pixel_has_alpha(tex->pixel))
        return IBL_OK;
    const ibl_status status = ibl_rows_alloc_alpha(rows);
    for (size_t i = 0; i < texels && !status; i++)
        rows->alpha[i] = ibl_pixel_get_alpha(tex->pixel, tex->data, i);
    rows->straight = !tex->premultiplied;
    return status;
}

/* The index of a key's value in names; 0, the first, without the key; -1: it is
 * none of them. */
static int find_value(const ibl_texture *tex, const char *key,
                      const char *const *names, int count)
{
    const char *value = ibl_texture_get(tex, key);
    int i = 0;

    while (value && i < count && strcmp(value, names[i]))
        i++;
    return i < count ? i : -1;
}

/* Turns the faces of a cube that iblbake wrote in other axes back. */
static ibl_status turn_back(ibl_source *s, const ibl_texture *tex,
                            ibl_image *strip)
{
    static const char *const mirrors[] = {"none", "x", "z", "xz"};
    static const char *const ups[] = {"y", "z"};
    const int mirror = find_value(tex, "iblbake.mirror", mirrors, 4);
    const int up = find_value(tex, "iblbake.up", ups, 2);
    const ibl_cube from = {
        .size = strip->width, .levels = 1, .data = strip->data};
    ibl_cube turned = {0};

    if (tex->faces != IBL_FACES || (!mirror && !up))
        return IBL_OK;
    if (mirror < 0 || up < 0)
        return ibl_unsupported(&s->in, "is in axes that are not known, by its "
                                       "keys iblbake.mirror and iblbake.up");
    const ibl_axes axes = {.mirror = (ibl_mirror)mirror, .up = (ibl_up)up};
    const ibl_status status =
        ibl_cube_turn_axes(s->ctx, &from, axes, 1, &turned);
    if (!status)
        memcpy(strip->data, turned.data,
               3 * sizeof *turned.data * ibl_cube_texels(turned.size, 1));
    ibl_cube_free(&turned);
    return status;
}

/* The layout of a flat texture that iblbake wrote is in its keys. */
static ibl_read_options texture_options(const ibl_texture *tex,
                                        const ibl_read_options *opts)
{
    const char *layout = ibl_texture_get(tex, "iblbake.layout");
    ibl_read_options own = *opts;

    if (!opts->layout && layout && !strcmp(layout, "octahedral"))
        own.layout = IBL_INPUT_OCTAHEDRAL;
    return own;
}

/* What iblbake baked would be blurred once more. */
static void warn_if_baked(const ibl_source *s, const ibl_texture *tex)
{
    const char *content = ibl_texture_get(tex, "iblbake.content");

    if (!content || !strcmp(content, "skybox"))
        return;
    ibl_warn(
        s->ctx,
        !strcmp(content, "specular")
            ? "%s: is a baked map, of which level 0 is taken for the "
              "environment: bake the map that it was made of"
            : "%s: is a baked map (%s), not an environment, and is blurred "
              "already: bake the map that it was made of",
        s->in.name, content);
}

/* By our keys, since KTX and DDS say nothing else, or by KTX2's descriptor. */
static void take_primaries(const ibl_texture *tex, ibl_rows *rows)
{
    static const char *const names[] = {"", "rec709", "acescg", "rec2020"};
    const int key = find_value(tex, "iblbake.primaries", names, 4);
    const double *xy = key > 0 ? ibl_primaries_xy((ibl_primaries)key)
                               : ibl_khronos_xy(tex->primaries);

    rows->has_primaries = xy != NULL;
    if (xy)
        memcpy(rows->primaries, xy, sizeof rows->primaries);
}

/* Level 0 as an image; the faces of a cube are below one another. */
static ibl_status texture_rows(ibl_source *s, const ibl_texture *tex,
                               const ibl_read_options *opts)
{
    ibl_image img = {0};
    const int height = tex->height * tex->faces;

    if (tex->layers > 1 || ibl_pixel_channels(tex->pixel) != 3)
        return ibl_bad_file(&s->in,
                            "is a texture of %d layers and %d channels: an "
                            "environment has one layer of 3",
                            tex->layers, ibl_pixel_channels(tex->pixel));
    ibl_status status =
        tex->faces == 1
            ? ibl_map_check_size(&s->in, opts, tex->width, tex->height)
            : IBL_OK;
    if (!status)
        status = ibl_map_alloc(&s->in, tex->width, height, &img);
    if (!status)
        status = ibl_texels_decode(s->ctx, tex, 0, img.data);
    if (!status)
        status = turn_back(s, tex, &img);
    if (status)
        ibl_image_free(&img);
    else
        status = ibl_rows_of_image(s->ctx, &img, &s->rows);
    if (!status)
        take_primaries(tex, s->rows);
    return status ? status : texture_alpha(tex, opts, s->rows);
}

static ibl_status open_texture(ibl_source *s, ibl_container container,
                               const ibl_read_options *opts)
{
    ibl_texture tex = {0};
    ibl_status status = ibl_input_load(&s->in);

    const bool env = !status && is_env(s->in.bytes, s->in.size);
    if (env && !opts->env)
        return ibl_unsupported(&s->in,
                               "a Babylon .env, which is not read here");
    if (!status)
        status =
            env ? opts->env(s->ctx, s->in.name, s->in.bytes, s->in.size, &tex)
                : ibl_texture_decode(s->ctx, s->in.name, s->in.bytes,
                                     s->in.size, &tex, NULL);
    const ibl_read_options own = texture_options(&tex, opts);
    if (!status)
        status = texture_rows(s, &tex, &own);
    if (!status) {
        ibl_read_report *r = &s->rows->report;
        warn_if_baked(s, &tex);
        snprintf(r->format, sizeof r->format, "%s, %s",
                 env                               ? "Babylon .env"
                 : container == IBL_CONTAINER_KTX2 ? "KTX2"
                 : container == IBL_CONTAINER_KTX  ? "KTX"
                                                   : "DDS",
                 ibl_pixel_name(tex.pixel));
        r->layout = tex.faces == IBL_FACES
                        ? IBL_INPUT_CUBE
                        : ibl_input_layout_of(&own, tex.width, tex.height);
    }
    ibl_texture_free(&tex);
    return status;
}

/* Whether this library reads the pixels of a DDS file, and not the bridge. */
static ibl_status look_into_dds(ibl_source *s, bool *ours)
{
    const ibl_status status = ibl_input_load(&s->in);
    ibl_texture tex = {0};
    ibl_input silent = s->in;

    silent.ctx = NULL;
    *ours = !status && ibl_dds_decode(&silent, &tex) != IBL_ERR_UNSUPPORTED;
    ibl_texture_free(&tex);
    return status;
}

static ibl_status open_image(ibl_source *s, const unsigned char *first,
                             size_t size, const ibl_read_options *opts)
{
    if (opts->layout == IBL_INPUT_FACES)
        return ibl_bad_file(&s->in, "is one file; six of faces are named by a "
                                    "pattern with %%f or a list with commas");
    if (opts->layout == IBL_INPUT_CUBE && !ibl_exr_is(first, size) &&
        ibl_container_of(first, size) == IBL_CONTAINER_COUNT)
        return ibl_bad_file(
            &s->in, "is no texture that can be read, KTX2, KTX or DDS, where "
                    "the layout cube was asked for");
    if (ibl_exr_is(first, size))
        return ibl_exr_open(&s->in, opts, &s->rows);
    if (ibl_rgbe_is(first, size))
        return ibl_rgbe_open(&s->in, opts, &s->rows);
    return open_bridged(s, opts);
}

static ibl_status open_any(ibl_source *s, const ibl_read_options *opts)
{
    unsigned char first[SNIFF_BYTES];
    size_t size;

    if (!ibl_input_read(&s->in, 0, sizeof first, first, &size))
        return ibl_reject(&s->in, IBL_ERR_IO, "cannot be read");
    const ibl_container container = ibl_container_of(first, size);
    bool texture = container != IBL_CONTAINER_COUNT || is_env(first, size);
    ibl_status status =
        container == IBL_CONTAINER_DDS ? look_into_dds(s, &texture) : IBL_OK;
    if (!status && (opts->layer || opts->part > 0) && !ibl_exr_is(first, size))
        status = ibl_bad_file(
            &s->in, "has no %s: only OpenEXR files do, so do not ask for one",
            opts->layer ? "layers" : "parts");
    if (!status)
        status = texture ? open_texture(s, container, opts)
                         : open_image(s, first, size, opts);
    if (!status && s->rows->report.layout == IBL_INPUT_CUBE && opts->layout &&
        opts->layout != IBL_INPUT_CUBE)
        status = ibl_bad_file(&s->in, "is a cube, not in the layout %s",
                              ibl_input_layout_name(opts->layout));
    if (!status && opts->transfer && !s->rows->report.low_range)
        status = ibl_bad_file(&s->in, "holds floats, which are linear: leave "
                                      "out the option input-transfer");
    if (!status && s->rows->orientation > 1 && s->rows->orientation <= 8)
        status = ibl_rows_upright(&s->in, &s->rows);
    return status;
}

static ibl_status open_files(ibl_source *s, const ibl_read_options *opts)
{
    char *files[IBL_FACES];
    int count;
    ibl_status status = ibl_input_files(s->ctx, s->name, files, &count);

    if (status)
        return status;
    s->in.name = s->name;
    s->mended = count == IBL_FACES;
    if (s->mended)
        status = ibl_six_files_open(s->ctx, s->name, files, opts, &s->rows);
    else
        status = ibl_input_open(s->ctx, s->name, longest, &s->in);
    if (!status && !s->mended)
        status = open_any(s, opts);
    ibl_input_files_free(files);
    return status;
}

static bool is_ordered(const ibl_read_options *opts)
{
    return opts->face_order[0] + opts->face_order[1] > 0;
}

static ibl_status check_options(ibl_ctx *ctx, const ibl_read_options *opts)
{
    if (opts->part < -1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "part %d: must be -1 or the number of a part, from 0",
                        opts->part);
    if (opts->alpha > IBL_ALPHA_STRAIGHT)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "alpha option %d: must be at most %d", (int)opts->alpha,
                        IBL_ALPHA_STRAIGHT);
    if (opts->primaries > IBL_PRIMARIES_REC2020)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "primaries %d: must be at most %d",
                        (int)opts->primaries, IBL_PRIMARIES_REC2020);
    if (!(fabs(opts->exposure) <= IBL_MAX_EXPOSURE))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an exposure of %g: must be from -%d to %d",
                        opts->exposure, IBL_MAX_EXPOSURE, IBL_MAX_EXPOSURE);
    if (!(opts->clamp >= 0) || !isfinite(opts->clamp))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a clamp of %g: must be above 0, or 0 for none",
                        opts->clamp);
    if (opts->layout > IBL_INPUT_OCTAHEDRAL)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "input layout %d: must be at most %d",
                        (int)opts->layout, IBL_INPUT_OCTAHEDRAL);
    if (opts->transfer > IBL_TRANSFER_SRGB)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "transfer %d: must be at most %d", (int)opts->transfer,
                        IBL_TRANSFER_SRGB);
    if (is_ordered(opts)) {
        unsigned found = 0;
        for (int i = 0; i < IBL_FACES; i++)
            found |= opts->face_order[i] < 8 * IBL_FACES
                         ? 1u << opts->face_order[i] % IBL_FACES
                         : 0;
        if (found != (1u << IBL_FACES) - 1)
            return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                            "face order: must have each of six faces once");
    }
    return IBL_OK;
}

/* Prepares to change the colours of the rows. Those of six files are converted
 * already, but not clamped. */
static ibl_status begin_colour(ibl_source *s, const ibl_read_options *opts)
{
    ibl_read_options rest = ibl_read_options_default();
    const ibl_read_report report = s->rows->report;

    if (!s->mended)
        return ibl_colour_init(&s->colour, &s->in, s->rows, opts);
    rest.clamp = opts->clamp;
    const ibl_status status =
        ibl_colour_init(&s->colour, &s->in, s->rows, &rest);
    s->rows->report = report;
    memcpy(s->colour.luma, report.luma, sizeof report.luma);
    return status;
}

static ibl_status begin(ibl_source *s, const ibl_read_options *opts)
{
    ibl_status status = ibl_mender_init(&s->mender, s->rows);

    if (!status)
        status = begin_colour(s, opts);
    if (!status && opts->hash && !s->mended)
        status = ibl_file_hash(&s->in, s->rows->report.hash);
    if (s->rows->whole.data)
        ibl_input_close(&s->in);
    s->straight = s->rows->straight || opts->alpha == IBL_ALPHA_STRAIGHT;
    s->alpha = (ibl_alpha_range){INFINITY, -INFINITY};
    s->peak = s->rows->report.peak;
    if (!s->mended) {
        s->rows->report.has_alpha = s->rows->alpha != NULL;
        s->rows->report.alpha_least = s->rows->report.alpha_most = 1;
    }
    return status;
}

/* The image takes that of the rows if it is whole. */
ibl_status ibl_source_image(ibl_source *s, ibl_image *img)
{
    if (!s || !img)
        return ibl_missing(s ? s->ctx : NULL, "ibl_source_image: img");
    ibl_rows *rows = s->rows;
    ibl_image whole = rows->whole;
    ibl_status status = IBL_OK;

    rows->whole = (ibl_image){0};
    if (!whole.data)
        status = ibl_map_alloc(&s->in, rows->width, rows->height, &whole);
    if (!status)
        status = ibl_source_read(s, whole.height, whole.data);
    if (status)
        ibl_image_free(&whole);
    else
        *img = whole;
    return status;
}

/* Makes the map of alpha, in the memory of the file's colours. */
static ibl_status unwrap_alpha(const ibl_source *s,
                               const unsigned char order[IBL_FACES],
                               ibl_cube *faces, ibl_image *grey, float **alpha)
{
    const size_t pixels = (size_t)grey->width * (size_t)grey->height;
    ibl_image map = {0};

    for (size_t i = 0; i < 3 * pixels; i++)
        grey->data[i] = s->rows->alpha[i / 3];
    const ibl_status status = ibl_unwrap(s->ctx, NULL, s->rows->report.layout,
                                         order, grey, faces, &map);
    for (size_t i = 0; i < (size_t)map.width * (size_t)map.height; i++)
        map.data[i] = map.data[3 * i];
    *alpha = map.data;
    return status;
}

/* Replaces the rows of another layout by those of its map. */
static ibl_status unwrap(ibl_source *s, const ibl_read_options *opts)
{
    const ibl_input_layout layout = s->rows->report.layout;
    unsigned char order[IBL_FACES];
    ibl_image flat = {0}, map = {0};
    float *alpha = NULL;

    memcpy(order, is_ordered(opts) ? opts->face_order : s->rows->face_order,
           sizeof order);
    ibl_status status = ibl_source_image(s, &flat);
    if (!status)
        status =
            s->rows->to_edges ? ibl_faces_from_edges(s->ctx, &flat) : IBL_OK;
    if (!status)
        status = ibl_unwrap(s->ctx, s->in.name, layout, order, &flat,
                            opts->faces, &map);
    if (!status && s->rows->alpha)
        status = unwrap_alpha(s, order, opts->faces ? opts->faces + 1 : NULL,
                              &flat, &alpha);
    ibl_image_free(&flat);
    if (status) {
        ibl_image_free(&map);
        return status;
    }
    const ibl_read_report report = s->rows->report;
    ibl_mender_free(&s->mender);
    ibl_colour_free(&s->colour); /* so that it changes nothing more */
    ibl_rows_close(s->rows);
    ibl_input_close(&s->in);
    s->rows = NULL;
    s->row = 0;
    s->mended = s->unwrapped = true;
    s->peak = report.peak;
    status = ibl_rows_of_image(s->ctx, &map, &s->rows);
    if (status) {
        ibl_free(alpha);
        return status;
    }
    s->rows->report = report;
    s->rows->alpha = alpha;
    return ibl_mender_init(&s->mender, s->rows);
}

static ibl_status open_pixels(ibl_source *s, const ibl_pixels *pixels,
                              const ibl_read_options *opts)
{
    const ibl_status status =
        ibl_map_check_size(&s->in, opts, pixels->width, pixels->height);

    return status
               ? status
               : ibl_rows_of_pixels(s->ctx, pixels,
                                    opts->alpha != IBL_ALPHA_IGNORE, &s->rows);
}

/* What a source is made of: a file or, if bytes or pixels is set, memory that
 * must stay until all rows are read. */
typedef struct origin {
    const char *name;
    const void *bytes;
    size_t size;
    const ibl_pixels *pixels;
} origin;

static ibl_status open_source(ibl_ctx *ctx, const origin *from,
                              const ibl_read_options *given, ibl_source **out)
{
    const char *name = from->name;
    const ibl_read_options opts = given ? *given : ibl_read_options_default();
    const size_t name_bytes = strlen(name) + 1;
    ibl_status status = check_options(ctx, &opts);

    if (!status && from->pixels &&
        (opts.layer || opts.part > 0 || opts.hash || opts.transfer))
        status =
            ibl_fail(ctx, IBL_ERR_ARGUMENT,
                     "%s: pixels have no layer, part, hash or transfer", name);
    if (status)
        return status;
    ibl_source *s = ibl_alloc_zeroed(1, sizeof *s + name_bytes);
    if (!s)
        return ibl_no_memory(ctx, "a source");
    s->ctx = ctx;
    s->in.fd = -1;
    s->strict = opts.strict;
    memcpy(s->name, name, name_bytes);
    if (from->bytes || from->pixels)
        s->in = ibl_input_of(ctx, s->name, from->bytes, from->size);
    ibl_progress(ctx, "decode", 0);
    status = from->pixels  ? open_pixels(s, from->pixels, &opts)
             : from->bytes ? open_any(s, &opts)
                           : open_files(s, &opts);
    if (!status && !s->rows->report.layout)
        s->rows->report.layout =
            ibl_input_layout_of(&opts, s->rows->width, s->rows->height);
    if (!status)
        status = begin(s, &opts);
    const ibl_input_layout layout = status ? 0 : s->rows->report.layout;
    const bool flat =
        layout == IBL_INPUT_EQUIRECT || layout == IBL_INPUT_OCTAHEDRAL;
    if (!status && flat && is_ordered(&opts))
        status = ibl_bad_file(&s->in,
                              "is %s, which has no faces to order: leave out "
                              "the option face-order",
                              ibl_input_layout_name(layout));
    if (!status && layout != IBL_INPUT_EQUIRECT)
        status = unwrap(s, &opts);
    if (status)
        ibl_source_close(s);
    else
        *out = s;
    return status;
}

ibl_status ibl_source_open(ibl_ctx *ctx, const char *path,
                           const ibl_read_options *opts, ibl_source **out)
{
    if (!ctx || !path || !out)
        return ibl_missing(ctx, "ibl_source_open: path or out");
    *out = NULL;
    return open_source(ctx, &(origin){.name = path}, opts, out);
}

static ibl_status check_pixels(ibl_ctx *ctx, const char *name,
                               const ibl_pixels *p)
{
    const size_t bytes = p->half ? 2 : 4;
    const size_t row =
        p->row_bytes < 0 ? 0 - (size_t)p->row_bytes : (size_t)p->row_bytes;

    if (p->channels != 3 && p->channels != 4)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%s: %d channels: must be 3 or 4", name, p->channels);
    if ((unsigned)p->half > 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "%s: half %d: must be 0 or 1",
                        name, p->half);
    if (p->width < 1 || p->height < 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%s: %dx%d pixels: must be 1x1 or more", name, p->width,
                        p->height);
    const size_t least = (size_t)p->width * (size_t)p->channels * bytes;
    if (row && (row < least || row > PTRDIFF_MAX / (size_t)p->height))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%s: row_bytes %td: must be 0 or from %zu to %zu", name,
                        p->row_bytes, least, PTRDIFF_MAX / (size_t)p->height);
    return IBL_OK;
}

ibl_status ibl_source_of_pixels(ibl_ctx *ctx, const char *name,
                                const ibl_pixels *pixels,
                                const ibl_read_options *opts, ibl_source **out)
{
    if (!ctx || !name || !pixels || !pixels->data || !out)
        return ibl_missing(ctx, "ibl_source_of_pixels: name, pixels or out");
    *out = NULL;
    const ibl_status status = check_pixels(ctx, name, pixels);
    if (status)
        return status;
    return open_source(ctx, &(origin){.name = name, .pixels = pixels}, opts,
                       out);
}

void ibl_source_close(ibl_source *source)
{
    if (!source)
        return;
    ibl_mender_free(&source->mender);
    ibl_colour_free(&source->colour);
    ibl_rows_close(source->rows);
    ibl_input_close(&source->in);
    ibl_free(source);
}

/* ---- reading -------------------------------------------------------- */

/* Beside the reader's, the bytes of a file in memory, alpha, and 4 MiB of
 * buffers. */
size_t ibl_source_memory(const ibl_source *source)
{
    const ibl_rows *r = source->rows;
    const double pixels = (double)r->width * (double)r->height;
    const double each =
        r->held + (r->whole.data ? 12 : 0) + (r->alpha ? sizeof(float) : 0);

    return (size_t)(pixels * each) + (4 << 20) +
           (r->report.bridged ? BRIDGE_BYTES : 0) +
           (source->in.bytes ? source->in.size : 0);
}

int ibl_source_width(const ibl_source *source)
{
    return source->rows->width;
}

int ibl_source_height(const ibl_source *source)
{
    return source->rows->height;
}

const float *ibl_source_alpha(const ibl_source *source)
{
    return source->rows->alpha;
}

const ibl_read_report *ibl_source_report(const ibl_source *source)
{
    return &source->rows->report;
}

/* Like report_mended, for alpha. */
static ibl_status report_alpha(const ibl_source *s)
{
    const ibl_read_report *r = &s->rows->report;

    if (s->strict && (r->alpha_nonfinite || r->alpha_beyond))
        return ibl_bad_file(
            &s->in,
            "alpha is not finite in %zu pixels and not from 0 to 1 in %zu, "
            "which strict reading refuses and any other mends",
            r->alpha_nonfinite, r->alpha_beyond);
    if (r->alpha_nonfinite)
        ibl_warn(s->ctx,
                 "%s: alpha of %zu pixels was not finite and became 0: they "
                 "count as not seen",
                 s->in.name, r->alpha_nonfinite);
    if (r->alpha_beyond)
        ibl_warn(s->ctx,
                 "%s: alpha of %zu pixels was not from 0 to 1 but from %.9g to "
                 "%.9g, and became 0 or 1",
                 s->in.name, r->alpha_beyond, (double)s->alpha.lowest,
                 (double)s->alpha.highest);
    if (r->alpha_hidden)
        ibl_warn(s->ctx,
                 "%s: %zu pixels had a colour but alpha 0, and became black: "
                 "colours are taken as multiplied by alpha unless they are "
                 "said to be straight",
                 s->in.name, r->alpha_hidden);
    return IBL_OK;
}

static void report_colour(const ibl_source *s)
{
    const ibl_read_report *r = &s->rows->report;
    const double *xy = r->primaries;

    if (!s->mended && r->has_primaries &&
        s->colour.primaries == IBL_PRIMARIES_KEEP &&
        strcmp(r->primaries_name, "Rec.709"))
        ibl_warn(s->ctx,
                 *r->primaries_name
                     ? "%s: its primaries are %s, not Rec.709: its colours are "
                       "kept as they are"
                     : "%s: its primaries are %s(%.4g %.4g, %.4g %.4g, %.4g "
                       "%.4g, white %.4g %.4g), not Rec.709: its colours are "
                       "kept as they are",
                 s->in.name, r->primaries_name, xy[0], xy[1], xy[2], xy[3],
                 xy[4], xy[5], xy[6], xy[7]);
    if (!s->mended && r->outside)
        ibl_warn(s->ctx,
                 "%s: %zu pixels were outside the gamut of %s, and became "
                 "greyer of the same luminance",
                 s->in.name, r->outside,
                 ibl_primaries_name(s->colour.primaries));
    if (r->clamped)
        ibl_warn(s->ctx,
                 "%s: %zu pixels were above %g and were clamped, which took "
                 "%.3g %% of the map's luminance",
                 s->in.name, r->clamped, s->colour.clamp,
                 100 * r->clamp_removed);
}

/* The share of a map's light that is worth a word. */
static const double notable = 1e-4;

/* After the last row: warns of mended values or, if strict, refuses them. */
static ibl_status report_mended(const ibl_source *s)
{
    const ibl_read_report *r = &s->rows->report;

    if (s->strict && (r->nonfinite || r->negative))
        return ibl_bad_file(&s->in,
                            "%zu pixels are not finite and %zu negative, which "
                            "strict reading refuses and any other mends",
                            r->nonfinite, r->negative);
    if (r->nonfinite)
        ibl_warn(s->ctx,
                 "%s: %zu pixels were not finite; each became its brightest "
                 "neighbour that is, or black if NaN and 65504 if infinite",
                 s->in.name, r->nonfinite);
    if (s->mender.removed > notable * s->mender.light)
        ibl_warn(s->ctx,
                 "%s: %zu pixels were negative and became 0: %.2g %% of the "
                 "map's light",
                 s->in.name, r->negative,
                 100 * fmin(s->mender.removed / s->mender.light, 1));
    if (r->low_range)
        ibl_warn(s->ctx,
                 "%s: low dynamic range (integers, taken for %s): lamps and "
                 "the sun are clipped, so it cannot light well",
                 s->in.name, r->low_range == 1 ? "sRGB" : "linear");
    return report_alpha(s);
}

/* Mends alpha of the next rows and applies it to their colours. */
static void apply_alpha(ibl_source *s, int rows, float *rgb)
{
    const size_t width = (size_t)s->rows->width;
    ibl_read_report *report = &s->rows->report;

    if (!s->rows->alpha)
        return;
    if (!s->row)
        report->alpha_most = 0;
    ibl_alpha_mend(s->rows->alpha + width * (size_t)s->row, rgb,
                   width * (size_t)rows, s->straight, &s->alpha, report);
}

static ibl_status end_rows(ibl_source *s)
{
    if (!s->unwrapped)
        ibl_colour_end(&s->colour);
    /* A square may be a face, one of six; what alpha hides is black. */
    if ((s->unwrapped || s->rows->report.layout == IBL_INPUT_EQUIRECT) &&
        !(s->rows->report.peak > 0) && !s->rows->alpha &&
        s->rows->width != s->rows->height)
        ibl_warn(s->ctx, "%s: is black everywhere", s->in.name);
    const ibl_status status = s->mended ? IBL_OK : report_mended(s);
    if (!status && !s->unwrapped)
        report_colour(s);
    return status;
}

ibl_status ibl_source_read(ibl_source *source, int rows, float *rgb)
{
    ibl_source *s = source;

    if (!s || !rgb)
        return ibl_missing(s ? s->ctx : NULL, "ibl_source_read: rgb");
    if (s->status)
        return s->status;
    const int left = s->rows->height - s->row;
    if (rows < 1 || rows > left)
        return ibl_fail(s->ctx, IBL_ERR_ARGUMENT,
                        "%d rows: must be 1 to the %d that are left", rows,
                        left);
    s->status = ibl_mender_read(&s->mender, rows, rgb);
    if (s->mended)
        s->rows->report.peak = s->peak;
    if (!s->status)
        s->status = ibl_colour_apply(&s->colour, s->row, rows, rgb);
    if (!s->status && !s->mended)
        apply_alpha(s, rows, rgb);
    s->row += rows;
    if (!s->status && rows == left)
        s->status = end_rows(s);
    if (!s->status && rows == left && s->rows->silent)
        ibl_progress(s->ctx, "decode", 1);
    return s->status;
}

static ibl_status read_source(void *cookie, int rows, float *rgb)
{
    return ibl_source_read(cookie, rows, rgb);
}

ibl_environment ibl_source_environment(ibl_source *source)
{
    return (ibl_environment){.width = source->rows->width,
                             .height = source->rows->height,
                             .read = read_source,
                             .cookie = source};
}

/* ---- whole images --------------------------------------------------- */

/* Reads all rows of a source and closes it. */
static ibl_status read_all(ibl_source *source, ibl_image *img,
                           ibl_read_report *report)
{
    const ibl_status status = ibl_source_image(source, img);

    if (report)
        *report = source->rows->report;
    ibl_source_close(source);
    return status;
}

ibl_status ibl_image_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                            size_t size, const ibl_read_options *opts,
                            ibl_image *img, ibl_read_report *report)
{
    ibl_source *source;
    if (!ctx || !name || (!bytes && size) || !img)
        return ibl_missing(ctx, "ibl_image_decode: name, bytes or img");
    if (!size)
        return ibl_fail(ctx, IBL_ERR_FORMAT, "%s: is empty", name);
    const ibl_status status =
        open_source(ctx, &(origin){.name = name, .bytes = bytes, .size = size},
                    opts, &source);
    return status ? status : read_all(source, img, report);
}

ibl_status ibl_image_read(ibl_ctx *ctx, const char *path,
                          const ibl_read_options *opts, ibl_image *img,
                          ibl_read_report *report)
{
    ibl_source *source;
    if (!ctx || !img)
        return ibl_missing(ctx, "ibl_image_read: img");
    const ibl_status status = ibl_source_open(ctx, path, opts, &source);
    return status ? status : read_all(source, img, report);
}
