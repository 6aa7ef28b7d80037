/* SPDX-License-Identifier: MIT */
#include "io/blocks.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

#include "core/half.h"
#include "kern/astc_hdr.h"
#include "kern/bc6h.h"

enum {
    JOB_BLOCKS = 256, /* take some milliseconds */
    JOB_ALIKE = 1024, /* with more of them, more are alike */
    LEAST_ALIKE = 64, /* smaller images are few of a file's bytes */
    GROUP = 128,      /* blocks whose texels are on the stack: 24 KiB */
    ALPHA_ONE = 0x3C00
};

static ibl_encode_blocks_fn *encoder_of(ibl_pixel pixel, ibl_isa isa)
{
    ibl_bc6h_dsp bc6h;
    ibl_astc_hdr_dsp astc;

    if (pixel == IBL_PIXEL_BC6H) {
        ibl_bc6h_dsp_init(&bc6h, isa);
        return bc6h.encode;
    }
    ibl_astc_hdr_dsp_init(&astc, isa);
    return astc.encode;
}

static ibl_decode_block_fn *decoder_of(ibl_pixel pixel)
{
    assert(ibl_pixel_block(pixel) == IBL_BLOCK_EDGE);
    return pixel == IBL_PIXEL_BC6H ? ibl_bc6h_decode_block
                                   : ibl_astc_hdr_decode_block;
}

/* ---- encoding images ------------------------------------------------- */

typedef struct encoding {
    const ibl_block_images *of;
    ibl_encode_blocks_fn *encode;
    ibl_astc_hdr_dsp astc;
    bool alike;
    float max;
    size_t row_blocks, image_blocks, blocks, job_blocks;
    atomic_size_t beyond;
} encoding;

/* Copies the texels of a block, limited to [0, max], with NaN as 0. Returns how
 * many components were above. */
static size_t gather(const encoding *e, size_t block, float *texels)
{
    const size_t w = (size_t)e->of->width, h = (size_t)e->of->height;
    const size_t at = block % e->image_blocks;
    const size_t left = at % e->row_blocks * IBL_BLOCK_EDGE;
    const size_t top = at / e->row_blocks * IBL_BLOCK_EDGE;
    const float *image = e->of->src + block / e->image_blocks * w * h * 3;
    size_t beyond = 0;

    for (size_t i = 0; i < IBL_BLOCK_TEXELS; i++) {
        const size_t x = left + i % IBL_BLOCK_EDGE,
                     y = top + i / IBL_BLOCK_EDGE;
        const size_t column = x < w ? x : w - 1, row = y < h ? y : h - 1;
        for (int c = 0; c < 3; c++) {
            const float from = image[(row * w + column) * 3 + c];
            beyond += from > e->max && x < w && y < h;
            *texels++ = !(from > 0) ? 0 : from < e->max ? from : e->max;
        }
    }
    return beyond;
}

static void encode_job(void *arg, int job, int worker)
{
    encoding *e = arg;
    float texels[GROUP * IBL_BLOCK_TEXELS * 3];
    ibl_astc_past past = {0};
    size_t block = (size_t)job * e->job_blocks, beyond = 0;
    const size_t last = block + e->job_blocks;
    const size_t end = last < e->blocks ? last : e->blocks;

    (void)worker;
    while (block < end) {
        const size_t count = end - block < GROUP ? end - block : GROUP;
        for (size_t i = 0; i < count; i++)
            beyond += gather(e, block + i, texels + i * 3 * IBL_BLOCK_TEXELS);
        unsigned char *dst = e->of->dst + block * IBL_BLOCK_BYTES;
        if (e->alike)
            e->astc.encode_alike(texels, count, e->of->quality, &past, dst);
        else
            e->encode(texels, count, e->of->quality, dst);
        block += count;
    }
    e->beyond += beyond;
}

ibl_status ibl_blocks_encode_images(ibl_ctx *ctx, const ibl_block_images *of,
                                    size_t *beyond)
{
    const bool alike = of->alike && of->pixel != IBL_PIXEL_BC6H &&
                       of->quality != IBL_QUALITY_BEST &&
                       of->height >= LEAST_ALIKE;
    const size_t row =
        ((size_t)of->width + IBL_BLOCK_EDGE - 1) / IBL_BLOCK_EDGE;
    const size_t rows =
        ((size_t)of->height + IBL_BLOCK_EDGE - 1) / IBL_BLOCK_EDGE;
    encoding e = {.of = of,
                  .encode = encoder_of(of->pixel, ibl_ctx_isa(ctx)),
                  .alike = alike,
                  .max = ibl_pixel_max(of->pixel),
                  .row_blocks = row,
                  .image_blocks = row * rows,
                  .blocks = row * rows * of->images,
                  .job_blocks = alike ? JOB_ALIKE : JOB_BLOCKS};
    const size_t jobs = (e.blocks + e.job_blocks - 1) / e.job_blocks;

    ibl_astc_hdr_dsp_init(&e.astc, ibl_ctx_isa(ctx));
    const ibl_status status = ibl_run(ctx, NULL, (int)jobs, encode_job, &e);

    *beyond += e.beyond;
    return status;
}

/* ---- decoding images ------------------------------------------------- */

/* Decodes to rgb, or if that is NULL to rgba. */
static int decode_image(ibl_decode_block_fn *decode,
                        const unsigned char *blocks, size_t width,
                        size_t height, float *rgb, unsigned char *rgba)
{
    uint16_t texels[IBL_BLOCK_TEXELS][3];
    int valid = 1;

    for (size_t top = 0; top < height; top += IBL_BLOCK_EDGE)
        for (size_t left = 0; left < width; left += IBL_BLOCK_EDGE) {
            valid &= decode(blocks, texels);
            blocks += IBL_BLOCK_BYTES;
            for (size_t i = 0; i < IBL_BLOCK_TEXELS; i++) {
                const size_t x = left + i % IBL_BLOCK_EDGE;
                const size_t y = top + i / IBL_BLOCK_EDGE;
                const uint16_t *t = texels[i];
                const uint16_t texel[] = {t[0], t[1], t[2], ALPHA_ONE};
                if (x >= width || y >= height)
                    continue;
                if (!rgb)
                    memcpy(rgba + (y * width + x) * sizeof texel, texel,
                           sizeof texel);
                for (size_t c = 0; c < 3 && rgb; c++)
                    rgb[3 * (y * width + x) + c] = ibl_half_to_float(t[c]);
            }
        }
    return valid;
}

int ibl_blocks_to_floats(ibl_pixel pixel, const unsigned char *blocks,
                         size_t width, size_t height, float *rgb)
{
    return decode_image(decoder_of(pixel), blocks, width, height, rgb, NULL);
}

int ibl_blocks_to_halves(ibl_pixel pixel, const unsigned char *blocks,
                         size_t width, size_t height, unsigned char *rgba)
{
    return decode_image(decoder_of(pixel), blocks, width, height, NULL, rgba);
}

void ibl_signed_blocks_to_halves(const unsigned char *blocks, size_t width,
                                 size_t height, unsigned char *rgba)
{
    decode_image(ibl_bc6h_decode_signed_block, blocks, width, height, NULL,
                 rgba);
}
