/* SPDX-License-Identifier: MIT */
#include "textures.h"

#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "io/blocks.h"
#include "kern/pixel.h"
#include "test.h"

static void free_texture(void *texture)
{
    ibl_texture_free(texture);
}

ibl_texture texture_owned(ibl_texture texture)
{
    test_defer_copy(free_texture, &texture, sizeof texture);
    return texture;
}

ibl_texture texture_random(ibl_ctx *ctx, ibl_pixel pixel, const int shape[4],
                           int layers)
{
    ibl_texture tex = {.pixel = pixel,
                       .width = shape[0],
                       .height = shape[1],
                       .levels = shape[2],
                       .layers = layers,
                       .faces = shape[3]};
    test_random r = {(uint64_t)(tex.width * 1000 + tex.height + layers)};

    for (int l = 0; l < tex.levels; l++)
        tex.bytes +=
            ibl_texture_face_bytes(&tex, l) * (size_t)(layers * tex.faces);
    tex.data = malloc(tex.bytes);
    if (!tex.data || ibl_texture_set(ctx, &tex, "zeta", "last"))
        exit(1);
    for (size_t i = 0; i < tex.bytes; i++)
        tex.data[i] = (unsigned char)test_random_u64(&r);
    return tex;
}

static void free_bytes(void *bytes)
{
    ibl_bytes_free(bytes);
}

unsigned char *texture_encode(ibl_ctx *ctx, const ibl_texture *tex,
                              ibl_container container, size_t *size)
{
    void *bytes;

    if (ibl_texture_encode(ctx, tex, container, &bytes, size))
        exit(1);
    test_defer(free_bytes, bytes);
    return bytes;
}

ibl_texture texture_decode(ibl_ctx *ctx, const void *bytes, size_t size)
{
    ibl_texture tex;

    if (ibl_texture_decode(ctx, "x", bytes, size, &tex, NULL))
        exit(1);
    return texture_owned(tex);
}

ibl_texture texture_layer(ibl_ctx *ctx, const ibl_texture *tex, int layer)
{
    ibl_texture one;

    if (ibl_texture_layer(ctx, tex, layer, &one))
        exit(1);
    return texture_owned(one);
}

ibl_texture texture_array(ibl_ctx *ctx, const ibl_texture *const *list,
                          int count)
{
    ibl_texture array;

    if (ibl_texture_array_begin(ctx, list[0], count, &array))
        exit(1);
    for (int i = 0; i < count; i++)
        if (ibl_texture_array_put(ctx, &array, i, list[i]))
            exit(1);
    return texture_owned(array);
}

size_t texels_encode(ibl_pixel pixel, const float *src, size_t count, void *dst)
{
    const ibl_block_images blocks = {.pixel = pixel,
                                     .quality = IBL_QUALITY_NORMAL,
                                     .width = IBL_BLOCK_EDGE,
                                     .height = IBL_BLOCK_EDGE,
                                     .images = count / IBL_BLOCK_TEXELS,
                                     .src = src,
                                     .dst = dst};
    ibl_pixel_dsp dsp;
    size_t beyond = 0;

    ibl_pixel_dsp_init(&dsp, ibl_isa_best());
    if (ibl_pixel_block(pixel) == 1)
        return dsp.encode[pixel](src, count, dst);
    NEED(
        !ibl_blocks_encode_images(test_ctx(1, IBL_ISA_AUTO), &blocks, &beyond));
    return beyond;
}

bool texture_same(const ibl_texture *a, const ibl_texture *b)
{
    return a->pixel == b->pixel && a->width == b->width &&
           a->height == b->height && a->levels == b->levels &&
           a->layers == b->layers && a->faces == b->faces &&
           a->bytes == b->bytes && !memcmp(a->data, b->data, a->bytes);
}

bool texture_has(const ibl_texture *tex, const char *key, const char *value)
{
    const char *got = ibl_texture_get(tex, key);
    return value ? got && !strcmp(got, value) : !got;
}

/* In memory that ends where they end. */
static ibl_status decode_copy(ibl_ctx *quiet, const unsigned char *bytes,
                              size_t size)
{
    unsigned char *copy = malloc(size ? size : 1);
    ibl_texture back;

    if (!copy)
        exit(1);
    memcpy(copy, bytes, size);
    const ibl_status status =
        ibl_texture_decode(quiet, "fuzz", copy, size, &back, NULL);
    CHECK(status != IBL_ERR_MEMORY);
    /* Zstandard's least block takes 4 bytes and holds 128 KiB. */
    const bool packed = size > 48 && file_u32(bytes + 44) == 2;
    /* Signed blocks become halves. */
    const bool grows = !status && back.pixel == IBL_PIXEL_RGBA16F;
    if (!status)
        CHECK(back.bytes <= (packed  ? size << 15
                             : grows ? 8 * size
                                     : size * 4 / 3 + 16) &&
              back.key_count < 99 && back.layers >= 1 &&
              back.layers <= IBL_MAX_LAYERS);
    else
        CHECK(!back.data && !back.keys);
    ibl_texture_free(&back);
    free(copy);
    return status;
}

void texture_damage(ibl_ctx *quiet, unsigned char *bytes, size_t size)
{
    for (size_t n = 0; n < size; n++) {
        const ibl_status status = decode_copy(quiet, bytes, n);
        CHECK(status == IBL_ERR_FORMAT || status == IBL_ERR_UNSUPPORTED);
    }
    for (size_t i = 0; i < size; i++) {
        const unsigned char old = bytes[i];
        for (int way = 0; way < 10; way++) {
            const int value = way < 8 ? old ^ 1 << way : way == 8 ? 0 : 255;
            bytes[i] = (unsigned char)value;
            decode_copy(quiet, bytes, size);
        }
        bytes[i] = old;
    }
}
