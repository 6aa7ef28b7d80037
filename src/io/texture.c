/* SPDX-License-Identifier: MIT */
#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "core/alloc.h"
#include "image/cube.h"
#include "image/overflow.h"
#include "io/blocks.h"
#include "io/container.h"
#include "io/input.h"
#include "kern/pixel.h"

void ibl_texture_free(ibl_texture *tex)
{
    if (!tex)
        return;
    for (int i = 0; i < tex->key_count; i++) {
        ibl_free(tex->keys[i].key);
        ibl_free(tex->keys[i].value);
    }
    ibl_free(tex->keys);
    ibl_free(tex->data);
    *tex = (ibl_texture){0};
}

size_t ibl_texture_face_bytes(const ibl_texture *tex, int level)
{
    const ibl_layout *layout = &ibl_layouts[tex->pixel];

    return ibl_layout_blocks(layout, ibl_texture_width(tex, level)) *
           ibl_layout_blocks(layout, ibl_texture_height(tex, level)) *
           (size_t)layout->block_bytes;
}

size_t ibl_texture_level_bytes(const ibl_texture *tex, int level)
{
    return (size_t)tex->layers * (size_t)tex->faces *
           ibl_texture_face_bytes(tex, level);
}

size_t ibl_texture_layer_offset(const ibl_texture *tex, int level, int layer,
                                int face)
{
    const size_t image = (size_t)layer * (size_t)tex->faces + (size_t)face;
    size_t offset = 0;
    for (int l = 0; l < level; l++)
        offset += ibl_texture_level_bytes(tex, l);
    return offset + image * ibl_texture_face_bytes(tex, level);
}

size_t ibl_texture_offset(const ibl_texture *tex, int level, int face)
{
    return ibl_texture_layer_offset(tex, level, 0, face);
}

/* ---- in the three containers ------------------------------------------ */

uint32_t ibl_input_u32(const ibl_input *in, uint64_t at)
{
    uint32_t value;
    memcpy(&value, in->bytes + at, sizeof value);
    return value;
}

ibl_status ibl_input_short(const ibl_input *in, const char *what)
{
    return ibl_bad_file(in,
                        "damaged or cut short: its %zu bytes do not hold %s: "
                        "copy or make it again",
                        in->size, what);
}

size_t ibl_texture_width(const ibl_texture *tex, int level)
{
    return (size_t)ibl_cube_edge(tex->width, level);
}

size_t ibl_texture_height(const ibl_texture *tex, int level)
{
    return (size_t)ibl_cube_edge(tex->height, level);
}

ibl_extent ibl_extent_of(const ibl_texture *tex)
{
    return (ibl_extent){.width = (uint32_t)tex->width,
                        .height = (uint32_t)tex->height,
                        .layers = tex->layers > 1 ? (uint32_t)tex->layers : 0,
                        .faces = (uint32_t)tex->faces,
                        .levels = (uint32_t)tex->levels};
}

/* Bytes of a row of blocks. */
static uint64_t row_bytes(const ibl_layout *layout, size_t width,
                          uint32_t row_align)
{
    const uint64_t bytes = (uint64_t)ibl_layout_blocks(layout, width) *
                           (uint64_t)layout->block_bytes;
    return (bytes + row_align - 1) / row_align * row_align;
}

uint64_t ibl_place_bytes(const ibl_place *place, const ibl_texture *tex,
                         int level)
{
    return row_bytes(place->layout, ibl_texture_width(tex, level),
                     place->row_align) *
           ibl_layout_blocks(place->layout, ibl_texture_height(tex, level));
}

ibl_status ibl_texture_shape(const ibl_input *in, const ibl_extent *s,
                             const ibl_place *place, ibl_texture *tex)
{
    uint32_t most = 1;

    if (s->depth > 1 || (s->width && !s->height))
        return ibl_unsupported(in,
                               "a %s texture: only 2D textures, cubes and "
                               "arrays of them are read",
                               s->depth > 1 ? "3D" : "1D");
    if (s->width < 1 || s->height < 1)
        return ibl_bad_file(in, "%ux%u texels: a texture has at least 1x1",
                            s->width, s->height);
    if (s->width > IBL_MAX_EDGE || s->height > IBL_MAX_EDGE)
        return ibl_unsupported(in, "%ux%u texels: the limit is %d", s->width,
                               s->height, IBL_MAX_EDGE);
    if (s->layers > IBL_MAX_LAYERS)
        return ibl_unsupported(in, "an array of %u layers: the limit is %d",
                               s->layers, IBL_MAX_LAYERS);
    if (s->faces != 1 && s->faces != IBL_FACES)
        return ibl_bad_file(in, "%u faces: must be 6 or 1", s->faces);
    if (s->faces == IBL_FACES && s->width != s->height)
        return ibl_bad_file(in, "cube faces of %ux%u texels: must be square",
                            s->width, s->height);
    while (s->width >> most || s->height >> most)
        most++;
    if (s->levels > most)
        return ibl_bad_file(in, "%u levels of %ux%u texels: the limit is %u",
                            s->levels, s->width, s->height, most);
    *tex = (ibl_texture){.pixel = place->layout->pixel,
                         .width = (int)s->width,
                         .height = (int)s->height,
                         .levels = s->levels ? (int)s->levels : 1,
                         .layers = s->layers ? (int)s->layers : 1,
                         .faces = (int)s->faces};
    return IBL_OK;
}

/* The texels take at most 4/3 of the file's size, or 8 times that if it has
 * signed blocks; of compressed levels what ibl_allow allows. */
ibl_status ibl_texture_alloc(const ibl_input *in, ibl_texture *tex)
{
    tex->bytes = ibl_texture_offset(tex, tex->levels, 0);
    if (in->head)
        return IBL_OK;
    const ibl_status status =
        ibl_allow(in, tex->bytes + (in->bytes ? in->size : 0));
    return status ? status : ibl_texture_room(in->ctx, tex);
}

uint64_t ibl_place_all_bytes(const ibl_place *place, const ibl_texture *tex,
                             uint64_t images)
{
    uint64_t bytes = 0;
    for (int l = 0; l < tex->levels; l++) /* below 2^51, by the limits */
        bytes += images * ibl_place_bytes(place, tex, l);
    return bytes;
}

ibl_status ibl_check_stored(const ibl_input *in, const ibl_place *place,
                            const ibl_texture *tex)
{
    const uint64_t bytes = ibl_place_all_bytes(
        place, tex, (uint64_t)tex->layers * (uint64_t)tex->faces);
    return bytes <= in->size
               ? IBL_OK
               : ibl_bad_file(in,
                              "damaged or cut short: its texels take %llu "
                              "bytes, the file has %zu: copy or make it again",
                              (unsigned long long)bytes, in->size);
}

ibl_status ibl_check_level_bytes(const ibl_input *in, int level, uint64_t bytes,
                                 uint64_t must)
{
    return bytes == must
               ? IBL_OK
               : ibl_bad_file(
                     in, "damaged: level %d of %llu bytes, must be %llu", level,
                     (unsigned long long)bytes, (unsigned long long)must);
}

ibl_status ibl_place_read(const ibl_input *in, ibl_place *place,
                          ibl_texture *tex, int level, int image)
{
    const ibl_layout *layout = place->layout;
    const size_t width = ibl_texture_width(tex, level);
    const size_t columns = ibl_layout_blocks(layout, width);
    const size_t rows =
        ibl_layout_blocks(layout, ibl_texture_height(tex, level));
    const uint64_t bytes = ibl_place_bytes(place, tex, level);
    const unsigned char *from = in->bytes + place->at;
    const size_t texel = ibl_pixel_bytes(tex->pixel);
    const size_t stored = (size_t)layout->block_bytes; /* less for RGB */
    unsigned char *to =
        tex->data + ibl_texture_layer_offset(tex, level, image / tex->faces,
                                             image % tex->faces);

    if (!ibl_input_has(in, place->at, bytes))
        return ibl_bad_file(
            in,
            "damaged or cut short: image %d of level %d is at %llu, beyond the "
            "file's %zu bytes: copy or make it again",
            image, level, (unsigned long long)place->at, in->size);
    place->at += bytes;
    if (place->bottom_up && layout->block_edge > 1)
        return ibl_unsupported(in, "blocks of texels whose rows begin at the "
                                   "bottom: only those from the top are read");
    if (layout == &ibl_layouts[IBL_LAYOUT_BC6H_SIGNED]) {
        ibl_signed_blocks_to_halves(from, width, ibl_texture_height(tex, level),
                                    to);
        return IBL_OK;
    }
    for (size_t y = 0; y < rows; y++) {
        const unsigned char *row =
            from + (place->bottom_up ? rows - 1 - y : y) *
                       row_bytes(layout, width, place->row_align);
        if (stored == texel)
            memcpy(to, row, columns * texel);
        for (size_t x = 0; x < columns && stored < texel; x++) {
            memcpy(to + x * texel, row + x * stored, stored);
            ibl_pixel_set_alpha(tex->pixel, to, x, 1);
        }
        to += columns * texel;
    }
    return IBL_OK;
}

ibl_status ibl_place_read_level(const ibl_input *in, ibl_place *place,
                                ibl_texture *tex, int level)
{
    ibl_status status = IBL_OK;
    for (int i = 0; i < tex->layers * tex->faces && !status; i++)
        status = ibl_place_read(in, place, tex, level, i);
    return status;
}

/* ---- cubes and LUTs ------------------------------------------------- */

enum {
    JOB_TEXELS = 1 << 14 /* take well under a millisecond */
};

typedef struct encoding {
    ibl_encode_fn *encode;
    const float *src;
    unsigned char *dst;
    size_t texels, texel_bytes;
    int channels;
    atomic_size_t beyond;
} encoding;

static void encode_job(void *arg, int job, int worker)
{
    encoding *e = arg;
    const size_t first = (size_t)job * JOB_TEXELS;
    const size_t left = e->texels - first;
    (void)worker;
    e->beyond += e->encode(e->src + first * (size_t)e->channels,
                           left < JOB_TEXELS ? left : JOB_TEXELS,
                           e->dst + first * e->texel_bytes);
}

/* Encodes texels to dst on the pool. Adds to *beyond the components over the
 * maximum. */
static ibl_status encode_texels(ibl_ctx *ctx, ibl_pixel pixel, const float *src,
                                size_t texels, unsigned char *dst,
                                size_t *beyond)
{
    const size_t jobs = (texels + JOB_TEXELS - 1) / JOB_TEXELS;
    ibl_pixel_dsp dsp;

    ibl_pixel_dsp_init(&dsp, ibl_ctx_isa(ctx));
    encoding e = {.encode = dsp.encode[pixel],
                  .src = src,
                  .dst = dst,
                  .texels = texels,
                  .texel_bytes = ibl_pixel_bytes(pixel),
                  .channels = ibl_pixel_channels(pixel)};
    const ibl_status status = ibl_run(ctx, NULL, (int)jobs, encode_job, &e);
    *beyond += e.beyond;
    return status;
}

ibl_status ibl_texture_room(ibl_ctx *ctx, ibl_texture *tex)
{
    tex->bytes = ibl_texture_offset(tex, tex->levels, 0);
    tex->data = ibl_alloc_array(tex->bytes, 1);
    return tex->data ? IBL_OK : ibl_no_memory(ctx, "a texture");
}

static ibl_status check_pixel(ibl_ctx *ctx, ibl_pixel pixel, int channels,
                              const char *what)
{
    if (pixel >= IBL_PIXEL_COUNT)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "pixel format %d: must be below %d", (int)pixel,
                        IBL_PIXEL_COUNT);
    if (ibl_pixel_channels(pixel) != channels)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%s as %s: a pixel format of %d channels is needed",
                        what, ibl_pixel_name(pixel), channels);
    return IBL_OK;
}

/* Encodes a level of a cube from its texels. Adds to *beyond. */
static ibl_status encode_level(ibl_ctx *ctx, const ibl_texel_options *opts,
                               const float *texels, ibl_texture *tex, int level,
                               size_t *beyond)
{
    const size_t width = ibl_texture_width(tex, level);
    const size_t height = ibl_texture_height(tex, level);
    const size_t images = (size_t)tex->faces;
    unsigned char *dst = tex->data + ibl_texture_offset(tex, level, 0);
    const ibl_block_images blocks = {
        tex->pixel,  opts->quality, opts->alike != 0, (int)width,
        (int)height, images,        texels,           dst};

    return ibl_pixel_block(tex->pixel) > 1
               ? ibl_blocks_encode_images(ctx, &blocks, beyond)
               : encode_texels(ctx, tex->pixel, texels, images * width * height,
                               dst, beyond);
}

/* Reports the light of a level beyond the largest value, where the encoder may
 * have clamped it. If there is any, encodes the level again. */
static ibl_status settle_level(ibl_ctx *ctx, const ibl_cube *cube, int level,
                               const ibl_texel_options *opts, ibl_texture *tex,
                               ibl_overflow_level *report)
{
    const float own = ibl_pixel_max(tex->pixel);
    const float blue = ibl_pixel_max_blue(tex->pixel);
    const float most = opts->largest > 0 ? (float)opts->largest : own;
    const float max[3] = {fminf(own, most), fminf(own, most),
                          fminf(blue, most)};
    const ibl_level_shape shape = ibl_map_shape(cube, level);
    float *settled = NULL;
    size_t beyond = 0;

    ibl_status status =
        ibl_overflow_settle(ctx, opts->overflow, max, &shape,
                            ibl_cube_face(cube, level, 0), &settled, report);
    if (!status && settled)
        status = encode_level(ctx, opts, settled, tex, level, &beyond);
    ibl_free(settled);
    return status;
}

static const char table_key[] = "iblbake.table";
static const char layout_key[] = "iblbake.layout";

ibl_texel_options ibl_texel_options_default(void)
{
    return (ibl_texel_options){.pixel = IBL_PIXEL_RGBA16F,
                               .overflow = IBL_OVERFLOW_SPREAD,
                               .quality = IBL_QUALITY_NORMAL};
}

ibl_status ibl_texture_from_cube(ibl_ctx *ctx, const ibl_cube *cube,
                                 const ibl_texel_options *opts,
                                 ibl_texture *tex, ibl_overflow_report *report)
{
    const ibl_texel_options o = opts ? *opts : ibl_texel_options_default();
    ibl_overflow_report r = {0};
    ibl_status status = ibl_check_map(ctx, cube);
    if (!status)
        status = check_pixel(ctx, o.pixel, 3, "a cube");
    if (status)
        return status;
    if (o.quality > IBL_QUALITY_BEST)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "quality %d: must be 0 to %d",
                        (int)o.quality, IBL_QUALITY_BEST);
    if (!tex)
        return ibl_missing(ctx, "ibl_texture_from_cube: tex");
    const ibl_level_shape shape = ibl_map_shape(cube, 0);
    *tex = (ibl_texture){.pixel = o.pixel,
                         .width = shape.width,
                         .height = shape.height,
                         .levels = cube->levels,
                         .layers = 1,
                         .faces = shape.faces};
    status = ibl_texture_room(ctx, tex);
    for (int l = 0; l < cube->levels && !status; l++)
        status =
            encode_level(ctx, &o, ibl_cube_face(cube, l, 0), tex, l, &r.values);
    const bool some = r.values || o.largest > 0;
    for (int l = 0; l < cube->levels && some && !status; l++)
        status = settle_level(ctx, cube, l, &o, tex, &r.level[l]);
    if (!status && tex->faces == 1)
        status = ibl_texture_set(ctx, tex, layout_key,
                                 ibl_projection_name(cube->projection));
    if (status)
        ibl_texture_free(tex);
    else if (report)
        *report = r;
    return status;
}

/* The encoder of two halves, twice for each texel: RGBA16F's has no alpha. */
ibl_status ibl_texture_from_lobe_table(ibl_ctx *ctx,
                                       const ibl_lobe_table *table,
                                       ibl_texture *tex)
{
    if (!ctx || !table || !tex)
        return ibl_missing(ctx, "ibl_texture_from_lobe_table: table or tex");
    if (table->size < 1 || !table->data)
        return ibl_missing(ctx, "ibl_texture_from_lobe_table: table's data");
    if (table->layers != IBL_LOBE_LAYERS &&
        table->layers != IBL_LOBE_LAYERS / 2)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a lobe table of %d layers: must be %d or %d",
                        table->layers, IBL_LOBE_LAYERS, IBL_LOBE_LAYERS / 2);
    size_t beyond = 0;
    *tex = (ibl_texture){.pixel = IBL_PIXEL_RGBA16F,
                         .width = table->size,
                         .height = table->size,
                         .levels = 1,
                         .layers = table->layers,
                         .faces = 1};
    ibl_status status = ibl_texture_room(ctx, tex);
    if (!status)
        status = encode_texels(ctx, IBL_PIXEL_RG16F, table->data,
                               tex->bytes / ibl_pixel_bytes(IBL_PIXEL_RG16F),
                               tex->data, &beyond);
    if (status)
        ibl_texture_free(tex);
    return status;
}

ibl_status ibl_texture_from_lut(ibl_ctx *ctx, const ibl_lut *lut,
                                ibl_pixel pixel, ibl_texture *tex,
                                size_t *saturated)
{
    size_t beyond = 0;
    if (!ctx || !lut || !lut->data || !tex)
        return ibl_missing(ctx, "ibl_texture_from_lut: lut, its data or tex");
    ibl_status status =
        check_pixel(ctx, pixel, ibl_lut_channels(lut->kind), "a LUT");
    if (status)
        return status;
    if (ibl_pixel_block(pixel) > 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "a LUT of blocks (%s)",
                        ibl_pixel_name(pixel));
    *tex = (ibl_texture){.pixel = pixel,
                         .width = lut->size,
                         .height = lut->size,
                         .levels = 1,
                         .layers = 1,
                         .faces = 1};
    status = ibl_texture_room(ctx, tex);
    if (!status)
        status = encode_texels(ctx, pixel, lut->data,
                               (size_t)lut->size * (size_t)lut->size, tex->data,
                               &beyond);
    if (!status && lut->kind)
        status = ibl_texture_set(ctx, tex, table_key, ibl_lut_name(lut->kind));
    if (status)
        ibl_texture_free(tex);
    else if (saturated)
        *saturated = beyond;
    return status;
}

static ibl_status check_single(ibl_ctx *ctx, const ibl_texture *tex)
{
    return tex->layers == 1
               ? IBL_OK
               : ibl_fail(ctx, IBL_ERR_ARGUMENT,
                          "a texture of %d layers: 1 is needed; "
                          "ibl_texture_layer takes one out of an array",
                          tex->layers);
}

ibl_projection ibl_texture_projection(const ibl_texture *tex)
{
    const char *word = ibl_texture_get(tex, layout_key);

    if (tex->faces == IBL_FACES)
        return IBL_PROJECTION_CUBE;
    if (word && !strcmp(word, ibl_projection_name(IBL_PROJECTION_EQUIRECT)))
        return IBL_PROJECTION_EQUIRECT;
    if (word && !strcmp(word, ibl_projection_name(IBL_PROJECTION_OCTAHEDRAL)))
        return IBL_PROJECTION_OCTAHEDRAL;
    return tex->width == tex->height ? IBL_PROJECTION_OCTAHEDRAL
                                     : IBL_PROJECTION_EQUIRECT;
}

ibl_status ibl_texture_to_cube(ibl_ctx *ctx, const ibl_texture *tex,
                               ibl_cube *cube)
{
    ibl_status status = ibl_texture_check(ctx, tex);
    if (status)
        return status;
    const ibl_projection projection = ibl_texture_projection(tex);
    const ibl_level_shape one = ibl_level_shape_of(projection, 1);
    if (tex->faces != one.faces || ibl_pixel_channels(tex->pixel) != 3 ||
        tex->width % one.width ||
        tex->width / one.width * one.height != tex->height)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a texture of %dx%d texels, %d %s and %d channels is "
                        "no cube: 6 faces and 3 channels are needed, or a flat "
                        "texture of the shape of an equirectangular (4:2) or "
                        "octahedral (2:2) map",
                        tex->width, tex->height, tex->faces,
                        tex->faces == 1 ? "face" : "faces",
                        ibl_pixel_channels(tex->pixel));
    status = check_single(ctx, tex);
    if (!status)
        status = ibl_cube_alloc_as(ctx, projection, tex->width / one.width,
                                   tex->levels, cube);
    if (status)
        return status;
    for (int l = 0; l < tex->levels && !status; l++)
        status = ibl_texels_decode(ctx, tex, l, ibl_cube_face(cube, l, 0));
    if (status)
        ibl_cube_free(cube);
    return status;
}

/* By the key; without one, or with one of no kind, split. */
static ibl_lut_kind kind_of(const ibl_texture *tex)
{
    const char *word = ibl_texture_get(tex, table_key);
    ibl_lut_kind kind = IBL_LUT_CHARLIE;

    while (word && kind && strcmp(word, ibl_lut_name(kind)))
        kind--;
    return word ? kind : IBL_LUT_SPLIT;
}

ibl_status ibl_texture_to_lut(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_lut *lut)
{
    ibl_status status = ibl_texture_check(ctx, tex);
    if (status)
        return status;
    if (!lut)
        return ibl_missing(ctx, "ibl_texture_to_lut: lut");
    const ibl_lut_kind kind = kind_of(tex);
    const size_t channels = (size_t)ibl_lut_channels(kind);
    if (tex->faces != 1 || ibl_pixel_channels(tex->pixel) != (int)channels ||
        ibl_pixel_block(tex->pixel) > 1 || tex->width != tex->height)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a texture of %dx%d texels, %d faces and %d channels "
                        "is no LUT: 1 square face and %zu channels are needed",
                        tex->width, tex->height, tex->faces,
                        ibl_pixel_channels(tex->pixel), channels);
    status = check_single(ctx, tex);
    if (status)
        return status;
    const size_t texels = (size_t)tex->width * (size_t)tex->height;
    float *data = ibl_alloc_array(texels, channels * sizeof *data);
    if (!data)
        return ibl_no_memory(ctx, "a LUT");
    ibl_pixel_decode(tex->pixel, tex->data, texels, data);
    *lut = (ibl_lut){tex->width, data, kind};
    return IBL_OK;
}

/* ---- the alpha of cubes ---------------------------------------------- */

ibl_status ibl_texture_set_alpha(ibl_ctx *ctx, ibl_texture *tex,
                                 const ibl_cube *alpha)
{
    ibl_status status = ibl_texture_check(ctx, tex);

    if (!status)
        status = ibl_check_cube(ctx, alpha);
    if (status)
        return status;
    if (!ibl_pixel_has_alpha(tex->pixel))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "alpha of %s texels: rgba16f and rgba32f alone have it",
                        ibl_pixel_name(tex->pixel));
    if (tex->faces != IBL_FACES || tex->layers != 1 ||
        tex->width != alpha->size || tex->levels != alpha->levels)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "alpha of size %d with %d levels for a texture of size "
                        "%d with %d levels, %d layers and %d faces: a cube of "
                        "one layer and the same shape is needed",
                        alpha->size, alpha->levels, tex->width, tex->levels,
                        tex->layers, tex->faces);
    const size_t texels = ibl_cube_texels(alpha->size, alpha->levels);
    for (size_t i = 0; i < texels; i++) {
        const float a = alpha->data[3 * i];
        const float clamped = !(a > 0) ? 0 : a < 1 ? a : 1; /* NaN: 0 */
        ibl_pixel_set_alpha(tex->pixel, tex->data, i, clamped);
    }
    tex->premultiplied = 1;
    return IBL_OK;
}

ibl_status ibl_texture_get_alpha(ibl_ctx *ctx, const ibl_texture *tex,
                                 ibl_cube *alpha)
{
    if (!alpha)
        return ibl_missing(ctx, "ibl_texture_get_alpha: alpha");
    ibl_cube cube = {0};
    const ibl_status status = ibl_texture_to_cube(ctx, tex, &cube);

    if (status)
        return status;
    const size_t texels =
        ibl_map_texels(cube.projection, cube.size, cube.levels);
    for (size_t i = 0; i < texels; i++) {
        const float a = ibl_pixel_get_alpha(tex->pixel, tex->data, i);
        for (int k = 0; k < 3; k++)
            cube.data[3 * i + k] = a;
    }
    *alpha = cube;
    return IBL_OK;
}

/* ---- containers ----------------------------------------------------- */

static const struct {
    const char *name, *extension, *magic;
    ibl_status (*encode)(ibl_ctx *ctx, const ibl_texture *tex,
                         ibl_pieces *file);
    ibl_status (*decode)(const ibl_input *in, ibl_texture *tex);
} containers[IBL_CONTAINER_COUNT] = {
    [IBL_CONTAINER_KTX2] = {"ktx2", "ktx2", IBL_KTX2_MAGIC, ibl_ktx2_encode,
                            ibl_ktx2_decode},
    [IBL_CONTAINER_KTX] = {"ktx", "ktx", IBL_KTX_MAGIC, ibl_ktx_encode,
                           ibl_ktx_decode},
    [IBL_CONTAINER_DDS] = {"dds", "dds", IBL_DDS_MAGIC, ibl_dds_encode,
                           ibl_dds_decode},
    [IBL_CONTAINER_DDS_LEGACY] = {"dds-legacy", "dds", IBL_DDS_MAGIC,
                                  ibl_dds_legacy_encode, ibl_dds_decode},
};

_Static_assert(IBL_CONTAINER_COUNT == 4, "each has a row above");

const char *ibl_container_name(ibl_container container)
{
    return containers[container].name;
}

const char *ibl_container_extension(ibl_container container)
{
    return containers[container].extension;
}

int ibl_container_holds(ibl_container container, ibl_pixel pixel)
{
    const ibl_layout *layout = &ibl_layouts[pixel];

    switch (container) {
    case IBL_CONTAINER_KTX:
        return layout->gl_internal > 0;
    case IBL_CONTAINER_DDS:
        return layout->dxgi > 0;
    case IBL_CONTAINER_DDS_LEGACY:
        return layout->d3d > 0;
    default:
        return true;
    }
}

ibl_container ibl_container_of(const unsigned char *bytes, size_t size)
{
    ibl_container c = 0;

    while (c < IBL_CONTAINER_COUNT &&
           (size < strlen(containers[c].magic) ||
            memcmp(bytes, containers[c].magic, strlen(containers[c].magic))))
        c++;
    return c == IBL_CONTAINER_DDS && ibl_dds_is_legacy(bytes, size)
               ? IBL_CONTAINER_DDS_LEGACY
               : c;
}

static bool is_valid(const ibl_texture *tex)
{
    const ibl_place place = {.layout = &ibl_layouts[IBL_PIXEL_RGBA16F]};
    const ibl_input silent = {.ctx = NULL};
    const ibl_extent shape = ibl_extent_of(tex);
    ibl_texture same;

    return tex->pixel < IBL_PIXEL_COUNT && tex->data && tex->levels > 0 &&
           tex->layers > 0 &&
           !ibl_texture_shape(&silent, &shape, &place, &same) &&
           tex->bytes == ibl_texture_offset(tex, tex->levels, 0);
}

ibl_status ibl_texture_check(ibl_ctx *ctx, const ibl_texture *tex)
{
    if (!ctx || !tex)
        return ibl_missing(ctx, "a texture");
    if (tex->zstd < 0 || tex->zstd > IBL_MAX_ZSTD)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "Zstandard's level %d: must be 1 to %d, or 0",
                        tex->zstd, IBL_MAX_ZSTD);
    if (is_valid(tex))
        return IBL_OK;
    return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                    "a texture of %dx%d texels, %d levels, %d layers and %d "
                    "faces in %zu bytes: not a whole texture",
                    tex->width, tex->height, tex->levels, tex->layers,
                    tex->faces, tex->bytes);
}

bool ibl_pieces_alloc(ibl_pieces *file, size_t head_bytes, int room)
{
    file->head = ibl_alloc_zeroed(head_bytes, 1);
    file->piece = ibl_alloc_array((size_t)room, sizeof *file->piece);
    file->room = room;
    return file->head && file->piece;
}

void ibl_pieces_free(ibl_pieces *file)
{
    ibl_free(file->head);
    ibl_free(file->packed);
    ibl_free(file->piece);
    *file = (ibl_pieces){0};
}

void ibl_pieces_add(ibl_pieces *file, const void *bytes, size_t size)
{
    assert(file->count < file->room);
    file->piece[file->count++] = (ibl_piece){bytes, size};
    file->size += size;
}

ibl_status ibl_texture_pieces(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_container container, ibl_pieces *file)
{
    const ibl_status status = ibl_texture_check(ctx, tex);
    if (status)
        return status;
    if (container >= IBL_CONTAINER_COUNT)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "container %d: must be below %d",
                        (int)container, IBL_CONTAINER_COUNT);
    if (tex->zstd && container != IBL_CONTAINER_KTX2)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%s files hold no Zstandard frames: KTX2 files do",
                        ibl_container_name(container));
    if (!ibl_container_holds(container, tex->pixel))
        return ibl_fail(
            ctx, IBL_ERR_UNSUPPORTED, "%s files cannot hold %s: KTX2 files can",
            ibl_container_name(container), ibl_pixel_name(tex->pixel));
    return containers[container].encode(ctx, tex, file);
}

ibl_status ibl_texture_encode(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_container container, void **bytes,
                              size_t *size)
{
    if (!bytes || !size)
        return ibl_missing(ctx, "ibl_texture_encode: bytes or size");
    ibl_pieces file = {0};
    ibl_status status = ibl_texture_pieces(ctx, tex, container, &file);
    unsigned char *to = status ? NULL : ibl_alloc_array(file.size, 1);

    if (to) {
        *bytes = to;
        *size = file.size;
    } else if (!status) {
        status = ibl_no_memory(ctx, "a texture's file");
    }
    for (int i = 0; to && i < file.count; i++) {
        memcpy(to, file.piece[i].bytes, file.piece[i].size);
        to += file.piece[i].size;
    }
    ibl_pieces_free(&file);
    return status;
}

void ibl_bytes_free(void *bytes)
{
    ibl_free(bytes);
}

ibl_status ibl_texture_decode(ibl_ctx *ctx, const char *name, const void *bytes,
                              size_t size, ibl_texture *tex,
                              ibl_container *container)
{
    ibl_input in = ibl_input_of(ctx, name, bytes, size);

    if (!ctx || !name || (!bytes && size) || !tex)
        return ibl_missing(ctx, "ibl_texture_decode: name, bytes or tex");
    return ibl_texture_take(&in, tex, container);
}

ibl_status ibl_texture_take(const ibl_input *in, ibl_texture *tex,
                            ibl_container *container)
{
    *tex = (ibl_texture){0};
    const ibl_container found =
        ibl_container_of(in->bytes, in->head ? in->head : in->size);
    if (found == IBL_CONTAINER_COUNT)
        return ibl_bad_file(
            in, "not a texture: no KTX2, KTX or DDS file begins like that");
    const ibl_status status = containers[found].decode(in, tex);
    if (status)
        ibl_texture_free(tex);
    else if (container)
        *container = found;
    return status;
}

ibl_status ibl_texture_read(ibl_ctx *ctx, const char *path, ibl_texture *tex,
                            ibl_container *container)
{
    ibl_input in;

    if (!ctx || !path || !tex)
        return ibl_missing(ctx, "ibl_texture_read: path or tex");
    *tex = (ibl_texture){0};
    ibl_status status = ibl_input_open(ctx, path, &in);
    if (status)
        return status;
    status = ibl_input_load(&in);
    if (!status)
        status =
            ibl_texture_decode(ctx, in.name, in.bytes, in.size, tex, container);
    ibl_input_close(&in);
    return status;
}
