/* SPDX-License-Identifier: MIT */
/* Decodes images of a level in strips of rows, each a job. */
#include "io/container.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"
#include "io/blocks.h"
#include "kern/texel_error.h"

enum {
    STRIP = 16 /* rows, of whole blocks */
};

/* A level of a texture, and what its texels become, or NULL. */
typedef struct level {
    const ibl_texture *tex;
    const unsigned char *data;
    size_t width, height, image_bytes, image_strips, strips;
    float *rgb;
    unsigned char *halves; /* RGBA16F */
    atomic_bool invalid;   /* a block is not */
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

static void decode_job(void *arg, int job, int worker)
{
    level *l = arg;
    const strip s = strip_of(l, (size_t)job);
    const size_t to = s.texel * ibl_pixel_bytes(IBL_PIXEL_RGBA16F);

    (void)worker;
    if (!(l->halves ? ibl_blocks_to_halves(l->tex->pixel, s.data, l->width,
                                           s.rows, l->halves + to)
                    : decode_strip(l, &s, l->rgb + 3 * s.texel)))
        l->invalid = true;
}

/* A block of BC6H that is not valid is black; one of ASTC may be of the part of
 * it that is not read. */
static ibl_status decode_level(ibl_ctx *ctx, level *l)
{
    const ibl_status status = ibl_run(ctx, NULL, (int)l->strips, decode_job, l);

    if (status || !l->invalid || l->tex->pixel == IBL_PIXEL_BC6H)
        return status;
    return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                    "blocks of ASTC beyond UASTC HDR 4x4, which alone is "
                    "read: give the texels that they were made of");
}

ibl_status ibl_texels_decode(ibl_ctx *ctx, const ibl_texture *tex, int l,
                             float *rgb)
{
    level of = level_of(tex, l);

    of.rgb = rgb;
    return decode_level(ctx, &of);
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
        level of = level_of(tex, l);
        of.halves = out.data + ibl_texture_offset(&out, l, 0);
        status = decode_level(ctx, &of);
    }
    ibl_free(status ? out.data : tex->data);
    if (!status)
        *tex = out;
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

static ibl_status compare(ibl_ctx *ctx, const ibl_texture *tex, int l,
                          const ibl_cube *cube, ibl_pixel_error *error)
{
    comparing c = {.level = level_of(tex, l),
                   .truth = ibl_cube_face(cube, l, 0)};
    const size_t workers = (size_t)ibl_ctx_threads(ctx);
    double wrong = 0, truth = 0, relative = 0, count = 0, light = 0, lost = 0;
    ibl_status status = IBL_OK;

    ibl_texel_error_dsp_init(&c.dsp, ibl_ctx_isa(ctx));
    c.scratch =
        ibl_alloc_array(workers * c.level.width, 3 * STRIP * sizeof *c.scratch);
    c.sums = ibl_alloc_zeroed(c.level.strips, sizeof *c.sums);
    if (c.scratch && c.sums)
        status = ibl_run(ctx, NULL, (int)c.level.strips, compare_job, &c);
    else
        status = ibl_no_memory(ctx, "the errors of a texture");
    for (size_t i = 0; i < c.level.strips * IBL_ERROR_LANES && !status; i++) {
        const ibl_error_sums *one = &c.sums[i / IBL_ERROR_LANES];
        const size_t lane = i % IBL_ERROR_LANES;
        wrong += one->wrong[lane];
        truth += one->truth[lane];
        relative += one->relative[lane];
        count += one->count[lane];
        light += one->light[lane];
        lost += one->lost[lane];
    }
    error->nrmse = truth > 0 ? sqrt(wrong / truth) : wrong > 0;
    error->relative = count > 0 ? relative / count : 0;
    error->lost = light > 0 ? lost / light : 0;
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
