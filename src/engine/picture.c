/* SPDX-License-Identifier: MIT */
#include "engine/picture.h"

#include <OpenEXR/openexr.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/context.h"
#include "io/colour_space.h"
#include "json/text.h"

enum {
    RGB = 3
};

/* ---- PNG -------------------------------------------------------------- */

const char *const ibl_tone_names[] = {"film", "clip", NULL};

/* FILM: Narkowicz 2016, "ACES Filmic Tone Mapping Curve". */
double ibl_tone_value(ibl_tone tone, double x)
{
    if (tone == IBL_TONE_FILM)
        x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    if (tone != IBL_TONE_RAW)
        x = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
    return fmin(fmax(x, 0), 1);
}

static bool encode_png(const ibl_picture_options *o, int width, int height,
                       const float *rgb, ibl_blob *out)
{
    const size_t values = (size_t)width * (size_t)height * RGB;
    unsigned char *bytes = malloc(values);

    for (size_t i = 0; i < values && bytes; i++)
        bytes[i] =
            (unsigned char)(255 * ibl_tone_value(o->tone, (double)rgb[i]) +
                            0.5);
    const bool ok =
        bytes && ibl_png_encode(bytes, RGB, width, height, NULL, out);
    free(bytes);
    return ok;
}

/* ---- Radiance --------------------------------------------------------- */

/* The nearest R, G, B and common exponent; Ward 1991, "Real Pixels". */
static void rgbe_of(const float *rgb, unsigned char rgbe[4])
{
    const float most = fmaxf(fmaxf(rgb[0], rgb[1]), rgb[2]);
    int e;

    memset(rgbe, 0, 4);
    if (!(most > 0) || (frexpf(most, &e), e < -127))
        return;
    if (ldexpf(most, 8 - e) >= 255.5F)
        e++;
    e = e > 127 ? 127 : e;
    for (int c = 0; c < RGB; c++)
        rgbe[c] =
            (unsigned char)fminf(ldexpf(fmaxf(rgb[c], 0), 8 - e) + 0.5F, 255);
    rgbe[3] = (unsigned char)(e + 128);
}

void ibl_picture_round(ibl_picture kind, ibl_texture *tex)
{
    const size_t texels = tex->bytes / (4 * sizeof(float));
    float *texel = (float *)(void *)tex->data;
    unsigned char rgbe[4];

    if (kind != IBL_PICTURE_HDR || tex->pixel != IBL_PIXEL_RGBA32F)
        return;
    for (size_t i = 0; i < texels; i++, texel += 4) {
        rgbe_of(texel, rgbe);
        for (int c = 0; c < RGB; c++)
            texel[c] = ldexpf(rgbe[c], rgbe[3] - 136);
    }
}

/* Whether three components of a row are alike from x on. */
static bool begins_run(const unsigned char *row, int width, int x)
{
    const unsigned char *p = row + 4 * x;

    return x + 2 < width && p[0] == p[4] && p[0] == p[8];
}

/* One component of a row: runs, and what lies between them. */
static bool put_runs(const unsigned char *row, int width, ibl_blob *out)
{
    bool ok = true;

    for (int x = 0, n = 0; x < width && ok; x += n, n = 0) {
        unsigned char code[129];
        const bool run = begins_run(row, width, x);
        if (run) {
            while (n < 127 && x + n < width && row[4 * (x + n)] == row[4 * x])
                n++;
            code[0] = (unsigned char)(128 + n);
            code[1] = row[4 * x];
        } else {
            do
                code[1 + n] = row[4 * (x + n)];
            while (++n < 128 && x + n < width &&
                   !begins_run(row, width, x + n));
            code[0] = (unsigned char)n;
        }
        ok = ibl_blob_add(out, code, run ? 2 : 1 + (size_t)n);
    }
    return ok;
}

static bool encode_hdr(int width, int height, const float *rgb,
                       const double *xy, ibl_blob *out)
{
    unsigned char *row = malloc(4 * (size_t)width);
    char head[320], primaries[200] = "";

    if (xy)
        snprintf(primaries, sizeof primaries,
                 "PRIMARIES=%.4f %.4f %.4f %.4f %.4f %.4f %.4f %.4f\n", xy[0],
                 xy[1], xy[2], xy[3], xy[4], xy[5], xy[6], xy[7]);
    snprintf(head, sizeof head,
             "#?RADIANCE\nSOFTWARE=iblbake " IBL_VERSION
             "\n%sFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n",
             primaries, height, width);
    bool ok = row && ibl_blob_add(out, head, strlen(head));
    for (int y = 0; y < height && ok; y++) {
        const unsigned char start[] = {2, 2, (unsigned char)(width >> 8),
                                       (unsigned char)width};
        for (int x = 0; x < width; x++, rgb += RGB)
            rgbe_of(rgb, row + 4 * x);
        if (width < 8 || width > 32767) { /* run lengths are not defined */
            ok = ibl_blob_add(out, row, 4 * (size_t)width);
            continue;
        }
        ok = ibl_blob_add(out, start, sizeof start);
        for (int c = 0; c < 4 && ok; c++)
            ok = put_runs(row + c, width, out);
    }
    free(row);
    return ok;
}

/* ---- OpenEXR ---------------------------------------------------------- */

static int64_t write_fn(exr_const_context_t exr, void *user, const void *from,
                        uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t error)
{
    ibl_blob *blob = user;
    const size_t end = (size_t)(offset + size);

    (void)exr;
    (void)error;
    if (end > blob->room)
        return -1;
    memcpy(blob->bytes + offset, from, (size_t)size);
    blob->size = end > blob->size ? end : blob->size;
    return (int64_t)size;
}

/* Without a handler OpenEXR prints errors, which are returned as well. */
static void ignore_error(exr_const_context_t exr, exr_result_t code,
                         const char *text)
{
    (void)exr;
    (void)code;
    (void)text;
}

/* Writes a block of lines with its own pipeline. */
static exr_result_t write_block(exr_context_t exr, const float *rgb, int width,
                                int y)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    const float *row = rgb + (size_t)y * (size_t)width * RGB;
    exr_chunk_info_t chunk;
    exr_result_t rv = exr_write_scanline_chunk_info(exr, 0, y, &chunk);

    if (rv)
        return rv;
    rv = exr_encoding_initialize(exr, 0, &chunk, &pipe);
    if (rv)
        return rv;
    for (int i = 0; i < RGB; i++) {
        exr_coding_channel_info_t *c = &pipe.channels[i];
        c->encode_from_ptr = (const uint8_t *)(row + RGB - 1 - i);
        c->user_bytes_per_element = sizeof *rgb;
        c->user_data_type = EXR_PIXEL_FLOAT;
        c->user_pixel_stride = RGB * sizeof *rgb;
        c->user_line_stride = RGB * (int)sizeof *rgb * width;
    }
    rv = exr_encoding_choose_default_routines(exr, 0, &pipe);
    if (!rv)
        rv = exr_encoding_run(exr, 0, &pipe);
    exr_encoding_destroy(exr, &pipe);
    return rv;
}

/* Names are in the alphabetical order of files, which is not that of a pixel.
 */
static exr_result_t write_picture(exr_context_t exr,
                                  const ibl_picture_options *o, int width,
                                  int height, const float *rgb,
                                  const double *xy)
{
    static const char *const names[] = {"B", "G", "R"};
    const ibl_texture *about = o->about;
    int part;
    int32_t lines = 0;
    exr_result_t rv = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);

    if (!rv)
        rv = exr_initialize_required_attr_simple(exr, part, width, height,
                                                 EXR_COMPRESSION_ZIP);
    for (int i = 0; i < RGB && !rv; i++)
        rv = exr_add_channel(exr, part, names[i],
                             o->halves ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                             EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (!rv && xy) {
        float c[8];
        for (int i = 0; i < 8; i++)
            c[i] = (float)xy[i];
        const exr_attr_chromaticities_t primaries = {c[0], c[1], c[2], c[3],
                                                     c[4], c[5], c[6], c[7]};
        rv = exr_attr_set_chromaticities(exr, part, "chromaticities",
                                         &primaries);
    }
    if (!rv && o->equirect)
        rv = exr_attr_set_envmap(exr, part, "envmap", EXR_ENVMAP_LATLONG);
    for (int i = 0; about && i < about->key_count && !rv; i++)
        if (strlen(about->keys[i].key) < 32) /* those of iblbake are */
            rv = exr_attr_set_string(exr, part, about->keys[i].key,
                                     about->keys[i].value);
    if (!rv)
        rv = exr_write_header(exr);
    if (!rv)
        rv = exr_get_scanlines_per_chunk(exr, part, &lines);
    for (int y = 0; y < height && !rv; y += lines)
        rv = write_block(exr, rgb, width, y);
    return rv;
}

static ibl_status encode_exr(ibl_ctx *ctx, const char *name,
                             const ibl_picture_options *o, int width,
                             int height, const float *rgb, const double *xy,
                             ibl_blob *out)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t exr = NULL;

    /* Headers and the table of blocks take less; ZIP never enlarges a block. */
    out->room = 4096 + (size_t)height * (16 + 12 * (size_t)width);
    for (int i = 0; o->about && i < o->about->key_count; i++)
        out->room += 64 + strlen(o->about->keys[i].value);
    out->bytes = calloc(out->room, 1);
    init.error_handler_fn = ignore_error;
    init.user_data = out;
    init.write_fn = write_fn;
    exr_result_t rv =
        out->bytes ? exr_start_write(&exr, name, EXR_WRITE_FILE_DIRECTLY, &init)
                   : EXR_ERR_OUT_OF_MEMORY;
    if (!rv)
        rv = write_picture(exr, o, width, height, rgb, xy);
    /* Writes the table of blocks. */
    const exr_result_t end = exr_finish(&exr);
    if (!rv)
        rv = end;
    /* Whatever it calls that: nothing else can fail. */
    return !rv ? IBL_OK
               : ibl_fail(ctx, IBL_ERR_MEMORY,
                          "%s: no memory for an EXR of %d x %d pixels", name,
                          width, height);
}

/* ---- pictures ---------------------------------------------------------- */

static const struct {
    const char *extension, *pixel;
} kinds[] = {[IBL_PICTURE_EXR] = {"exr", NULL},
             [IBL_PICTURE_HDR] = {"hdr", "rgbe"},
             [IBL_PICTURE_PNG] = {"png", "rgb8"}};

const char *ibl_picture_extension(ibl_picture kind)
{
    return kinds[kind].extension;
}

const char *ibl_picture_pixel(ibl_picture kind)
{
    return kinds[kind].pixel;
}

ibl_status ibl_picture_encode(ibl_ctx *ctx, const char *name,
                              const ibl_picture_options *o, int width,
                              int height, const float *rgb, ibl_blob *out)
{
    const int named = o->about ? o->about->primaries : 0;
    const double *xy =
        named ? ibl_khronos_xy(named) : ibl_primaries_xy(IBL_PRIMARIES_REC709);

    *out = (ibl_blob){0};
    if (o->kind == IBL_PICTURE_EXR)
        return encode_exr(ctx, name, o, width, height, rgb, xy, out);
    return (o->kind == IBL_PICTURE_PNG
                ? encode_png(o, width, height, rgb, out)
                : encode_hdr(width, height, rgb, xy, out))
               ? IBL_OK
               : ibl_no_memory(ctx, "a picture");
}

char *ibl_picture_name(const char *stem, ibl_picture kind, int levels, int each,
                       int index)
{
    static const char *const sides[] = {"_px", "_nx", "_py",
                                        "_ny", "_pz", "_nz"};
    char level[16] = "";

    if (levels > 1)
        snprintf(level, sizeof level, "_%d", index / each);
    return ibl_format("%s%s%s.%s", stem, level,
                      each == 1 ? "" : sides[index % each],
                      kinds[kind].extension);
}

ibl_status ibl_picture_of_texture(ibl_ctx *ctx, const char *name,
                                  const ibl_texture *tex,
                                  const ibl_picture_options *o, int index,
                                  ibl_blob *out)
{
    static const int place[IBL_FACES][2] = {{2, 1}, {0, 1}, {1, 0},
                                            {1, 2}, {1, 1}, {3, 1}};
    const int channels = ibl_pixel_channels(tex->pixel);
    const int each = o->cross ? 1 : tex->faces, level = index / each;
    const int w = ibl_cube_edge(tex->width, level);
    const int h = ibl_cube_edge(tex->height, level);
    const int width = w * (o->cross ? 4 : 1), height = h * (o->cross ? 3 : 1);
    float *rgb = calloc((size_t)width * (size_t)height, RGB * sizeof *rgb);
    float *row = malloc((size_t)w * RGB * sizeof *row);

    for (int i = 0; rgb && row && i < (o->cross ? IBL_FACES : 1) * h; i++) {
        const int face = o->cross ? i / h : index % each, y = i % h;
        const int left = o->cross ? place[face][0] * w : 0;
        const int top = o->cross ? place[face][1] * h : 0;
        float *to = rgb + RGB * ((size_t)(top + y) * (size_t)width + left);
        ibl_pixel_decode(tex->pixel,
                         tex->data + ibl_texture_offset(tex, level, face) +
                             (size_t)y * (size_t)w *
                                 ibl_pixel_bytes(tex->pixel),
                         (size_t)w, row);
        for (int x = 0; x < w; x++)
            memcpy(to + RGB * x, row + channels * x,
                   (size_t)channels * sizeof *row);
    }
    *out = (ibl_blob){0};
    const ibl_status status =
        rgb && row ? ibl_picture_encode(ctx, name, o, width, height, rgb, out)
                   : ibl_no_memory(ctx, "a picture");
    free(rgb);
    free(row);
    return status;
}
