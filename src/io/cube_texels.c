/* SPDX-License-Identifier: MIT */
/* Decodes images of a level in strips of rows, each a job. */
#include "io/container.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/axes.h"
#include "image/cube.h"
#include "io/blocks.h"
#include "kern/texel_error.h"

enum {
    STRIP = 16 /* rows, of whole blocks */
};

/* A level of a texture. */
typedef struct level {
    const ibl_texture *tex;
    const unsigned char *data;
    size_t width, height, image_bytes, image_strips, strips;
} level;

static level level_of(const ibl_texture *tex, int l)
{
    const size_t height = ibl_texture_height(tex, l);
    const size_t strips = (height + STRIP - 1) / STRIP;

    return (level){.tex = tex,
                   .data = tex->data + ibl_texture_offset(tex, l, 0),
                   .width = ibl_texture_width(tex, l),
                   .height = height,
                   .image_bytes = ibl_texture_face_bytes(tex, l),
                   .image_strips = strips,
                   .strips = (size_t)(tex->layers * tex->faces) * strips};
}

/* Some rows of an image. */
typedef struct strip {
    const unsigned char *data; /* their texels or blocks */
    size_t texel, rows;        /* the first texel, counted in the level */
} strip;

static strip strip_of(const level *l, size_t i)
{
    const size_t image = i / l->image_strips;
    const size_t top = i % l->image_strips * STRIP, left = l->height - top;
    const ibl_layout *layout = &ibl_layouts[l->tex->pixel];
    const size_t row_bytes =
        ibl_layout_blocks(layout, l->width) * (size_t)layout->block_bytes;

    return (strip){
        .data = l->data + image * l->image_bytes +
                top / (size_t)layout->block_edge * row_bytes,
        .texel = (image * l->height + top) * l->width,
        .rows = left < STRIP ? left : STRIP,
    };
}

static int decode_strip(const level *l, const strip *s, float *rgb)
{
    if (ibl_pixel_block(l->tex->pixel) > 1)
        return ibl_blocks_to_floats(l->tex->pixel, s->data, l->width, s->rows,
                                    rgb);
    ibl_pixel_decode(l->tex->pixel, s->data, s->rows * l->width, rgb);
    return 1;
}

/* A block of BC6H that is not valid is black; one of ASTC may be of the part of
 * it that is not read. */
static ibl_status check_blocks(ibl_ctx *ctx, const ibl_texture *tex, bool all)
{
    if (all || tex->pixel == IBL_PIXEL_BC6H)
        return IBL_OK;
    return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                    "blocks of ASTC beyond UASTC HDR 4x4, which alone is "
                    "read: give the texels that they were made of");
}

/* ---- to cubes -------------------------------------------------------- */

typedef struct decoding {
    level level;
    float *rgb;
    atomic_bool invalid;
} decoding;

static void decode_job(void *arg, int job, int worker)
{
    decoding *d = arg;
    const strip s = strip_of(&d->level, (size_t)job);

    (void)worker;
    if (!decode_strip(&d->level, &s, d->rgb + 3 * s.texel))
        d->invalid = true;
}

ibl_status ibl_texels_decode(ibl_ctx *ctx, const ibl_texture *tex, int l,
                             float *rgb)
{
    decoding d = {level_of(tex, l), rgb, false};
    const ibl_status status =
        ibl_run(ctx, NULL, (int)d.level.strips, decode_job, &d);

    return status ? status : check_blocks(ctx, tex, !d.invalid);
}

ibl_status ibl_cube_texels_decode(ibl_ctx *ctx, const ibl_texture *tex,
                                  const ibl_cube *cube)
{
    ibl_status status = IBL_OK;

    for (int l = 0; l < tex->levels && !status; l++)
        status = ibl_texels_decode(ctx, tex, l, ibl_cube_face(cube, l, 0));
    return status;
}

/* ---- to halves ------------------------------------------------------- */

typedef struct unblocking {
    level level;
    unsigned char *to;
    atomic_bool invalid;
} unblocking;

static void unblock_job(void *arg, int job, int worker)
{
    unblocking *u = arg;
    const strip s = strip_of(&u->level, (size_t)job);

    (void)worker;
    if (!ibl_blocks_to_halves(
            u->level.tex->pixel, s.data, u->level.width, s.rows,
            u->to + s.texel * ibl_pixel_bytes(IBL_PIXEL_RGBA16F)))
        u->invalid = true;
}

ibl_status ibl_texture_unblock(ibl_ctx *ctx, ibl_texture *tex)
{
    ibl_status status = ibl_texture_check(ctx, tex);

    if (status || ibl_pixel_block(tex->pixel) == 1)
        return status;
    ibl_texture out = *tex;
    out.pixel = IBL_PIXEL_RGBA16F;
    out.bytes = ibl_texture_offset(&out, out.levels, 0);
    out.data = ibl_alloc_array(out.bytes, 1);
    if (!out.data)
        return ibl_no_memory(ctx, "the texels of a texture");
    for (int l = 0; l < tex->levels && !status; l++) {
        unblocking u = {level_of(tex, l),
                        out.data + ibl_texture_offset(&out, l, 0), false};
        status = ibl_run(ctx, NULL, (int)u.level.strips, unblock_job, &u);
        if (!status)
            status = check_blocks(ctx, tex, !u.invalid);
    }
    ibl_free(status ? out.data : tex->data);
    if (!status)
        *tex = out;
    return status;
}

/* ---- other axes ------------------------------------------------------- */

ibl_status ibl_texture_turn_axes(ibl_ctx *ctx, ibl_texture *tex, ibl_axes axes,
                                 int back)
{
    ibl_status status = ibl_texture_check(ctx, tex);

    if (!status)
        status = ibl_check_axes(ctx, axes);
    if (status)
        return status;
    if (tex->faces != IBL_FACES || ibl_pixel_block(tex->pixel) > 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "other axes for %d face(s) of %s: must be a cube of "
                        "single texels",
                        tex->faces, ibl_pixel_name(tex->pixel));
    unsigned char *to = ibl_alloc_array(tex->bytes, 1);
    if (!to)
        return ibl_no_memory(ctx, "the texels of a texture");
    const int words = (int)ibl_pixel_bytes(tex->pixel) / 4;
    for (int i = 0; i < tex->levels * tex->layers && !status; i++) {
        const int l = i / tex->layers;
        const size_t at = ibl_texture_layer_offset(tex, l, i % tex->layers, 0);
        const ibl_level_shape s = ibl_level_shape_of(
            IBL_PROJECTION_CUBE, ibl_cube_edge(tex->width, l));
        status = ibl_level_turn_axes(ctx, s, words, axes, back, tex->data + at,
                                     to + at);
    }
    ibl_free(status ? to : tex->data);
    if (!status)
        tex->data = to;
    return status;
}

/* ---- errors ----------------------------------------------------------- */

typedef struct comparing {
    level level;
    ibl_texel_error_dsp dsp;
    const float *truth;
    float *scratch;       /* of a strip for each worker */
    ibl_error_sums *sums; /* of each job */
} comparing;

static void compare_job(void *arg, int job, int worker)
{
    const comparing *c = arg;
    const strip s = strip_of(&c->level, (size_t)job);
    float *rgb = c->scratch + (size_t)worker * 3 * STRIP * c->level.width;

    decode_strip(&c->level, &s, rgb);
    const float *truth = c->truth + 3 * s.texel;
    const size_t texels = s.rows * c->level.width;
    c->dsp.add(truth, rgb, texels, &c->sums[job]);
}

/* Adds the sums of the strips, in order. */
static ibl_pixel_error error_of(const comparing *c)
{
    double wrong = 0, truth = 0, relative = 0, count = 0, light = 0, lost = 0;

    for (size_t i = 0; i < c->level.strips * IBL_ERROR_LANES; i++) {
        const ibl_error_sums *one = &c->sums[i / IBL_ERROR_LANES];
        const size_t lane = i % IBL_ERROR_LANES;
        wrong += one->wrong[lane];
        truth += one->truth[lane];
        relative += one->relative[lane];
        count += one->count[lane];
        light += one->light[lane];
        lost += one->lost[lane];
    }
    return (ibl_pixel_error){.nrmse =
                                 truth > 0 ? sqrt(wrong / truth) : wrong > 0,
                             .relative = count > 0 ? relative / count : 0,
                             .lost = light > 0 ? lost / light : 0};
}

static ibl_status compare(ibl_ctx *ctx, const ibl_texture *tex, int l,
                          const ibl_cube *cube, ibl_pixel_error *error)
{
    comparing c = {.level = level_of(tex, l),
                   .truth = ibl_cube_face(cube, l, 0)};
    const size_t workers = (size_t)ibl_ctx_threads(ctx);
    ibl_status status = IBL_OK;

    ibl_texel_error_dsp_init(&c.dsp, ibl_ctx_isa(ctx));
    c.scratch =
        ibl_alloc_array(workers * c.level.width, 3 * STRIP * sizeof *c.scratch);
    c.sums = ibl_alloc_zeroed(c.level.strips, sizeof *c.sums);
    if (c.scratch && c.sums)
        status = ibl_run(ctx, NULL, (int)c.level.strips, compare_job, &c);
    else
        status = ibl_no_memory(ctx, "the errors of a texture");
    if (!status)
        *error = error_of(&c);
    ibl_free(c.scratch);
    ibl_free(c.sums);
    return status;
}

ibl_status ibl_texture_errors(ibl_ctx *ctx, const ibl_texture *tex,
                              const ibl_cube *cube,
                              ibl_pixel_error error[IBL_MAX_LEVELS])
{
    ibl_status status = ibl_texture_check(ctx, tex);

    if (!status)
        status = ibl_check_map(ctx, cube);
    if (status)
        return status;
    if (!error)
        return ibl_missing(ctx, "ibl_texture_errors: error");
    const ibl_level_shape shape = ibl_map_shape(cube, 0);
    if (tex->faces != shape.faces || tex->layers != 1 ||
        ibl_pixel_channels(tex->pixel) != 3 || tex->width != shape.width ||
        tex->height != shape.height || tex->levels != cube->levels)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "errors of a texture of size %d with %d levels, %d "
                        "layers and %d faces against a cube of size %d with "
                        "%d levels: must be a cube of that shape",
                        tex->width, tex->levels, tex->layers, tex->faces,
                        cube->size, cube->levels);
    for (int l = 0; l < tex->levels && !status; l++)
        status = compare(ctx, tex, l, cube, &error[l]);
    return status;
}
