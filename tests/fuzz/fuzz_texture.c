/* SPDX-License-Identifier: MIT */
/* Textures of every container and pixel format: what is decoded is encoded
 * again, and turned into cubes and tables. */
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "io/container.h"

enum {
    LARGE = 1 << 20 /* bytes; larger ones are only decoded */
};

void fuzz_begin(void)
{
}

/* The bytes of all levels, by their shapes. */
static size_t count_bytes(const ibl_texture *tex)
{
    const int block = ibl_pixel_block(tex->pixel);
    size_t blocks = 0;

    for (int l = 0; l < tex->levels; l++) {
        const int w = tex->width >> l, h = tex->height >> l;
        blocks += (size_t)(((w ? w : 1) + block - 1) / block) *
                  (size_t)(((h ? h : 1) + block - 1) / block);
    }
    return blocks * ibl_pixel_bytes(tex->pixel) * (size_t)tex->faces *
           (size_t)tex->layers;
}

static void check_same(const ibl_texture *a, const ibl_texture *b)
{
    FUZZ_NEED(a->pixel == b->pixel && a->width == b->width &&
              a->height == b->height && a->levels == b->levels &&
              a->layers == b->layers && a->faces == b->faces);
    FUZZ_NEED(a->bytes == b->bytes && !memcmp(a->data, b->data, a->bytes));
}

static void encode_again(ibl_texture *tex, ibl_container container, int zstd)
{
    ibl_texture back = {0};
    void *bytes;
    size_t size;

    tex->zstd = container == IBL_CONTAINER_KTX2 ? zstd : 0;
    const ibl_status status =
        ibl_texture_encode(fuzz_ctx, tex, container, &bytes, &size);
    fuzz_said(status);
    if (status)
        return;
    FUZZ_NEED(!ibl_texture_decode(fuzz_ctx, "again", bytes, size, &back, NULL));
    fuzz_said(false);
    check_same(tex, &back);
    ibl_texture_free(&back);
    ibl_bytes_free(bytes);
}

static void use_cube(const ibl_texture *tex)
{
    ibl_cube cube = {0}, alpha = {0};
    ibl_lut lut = {0};

    fuzz_said(ibl_texture_to_cube(fuzz_ctx, tex, &cube));
    fuzz_said(ibl_texture_get_alpha(fuzz_ctx, tex, &alpha));
    fuzz_said(ibl_texture_to_lut(fuzz_ctx, tex, &lut));
    ibl_cube_free(&cube);
    ibl_cube_free(&alpha);
    ibl_lut_free(&lut);
}

static void use(ibl_texture *tex, int layer)
{
    ibl_texture one = {0};

    const ibl_status status = ibl_texture_layer(fuzz_ctx, tex, layer, &one);
    fuzz_said(status);
    if (!status) {
        use_cube(&one);
        fuzz_said(ibl_texture_unblock(fuzz_ctx, &one));
    }
    ibl_texture_free(&one);
}

/* Reads nothing behind the first half of a file, and finds no other texture. */
static void look(const fuzz_input *in, const ibl_texture *whole)
{
    unsigned char *half = malloc(in->size / 2 + 1);
    ibl_input head = ibl_input_of(NULL, "head", half, in->size);
    ibl_texture tex = {0};

    FUZZ_NEED(half);
    head.head = in->size / 2 + 1;
    memcpy(half, in->bytes, head.head);
    if (!ibl_texture_take(&head, &tex, NULL) && whole->data)
        FUZZ_NEED(!tex.data && tex.bytes == whole->bytes &&
                  tex.pixel == whole->pixel && tex.width == whole->width &&
                  tex.levels == whole->levels && tex.faces == whole->faces &&
                  tex.primaries == whole->primaries &&
                  tex.key_count == whole->key_count);
    ibl_texture_free(&tex);
    free(half);
}

void fuzz_one(fuzz_input in)
{
    const int container = fuzz_choice(&in, IBL_CONTAINER_COUNT);
    const int zstd = fuzz_choice(&in, 4), layer = fuzz_choice(&in, 3);
    ibl_container found = IBL_CONTAINER_COUNT;
    ibl_texture tex = {0};

    const ibl_status status =
        ibl_texture_decode(fuzz_ctx, "file", in.bytes, in.size, &tex, &found);
    fuzz_said(status);
    if (in.size > 1)
        look(&in, &tex);
    if (!status) {
        FUZZ_NEED(found < IBL_CONTAINER_COUNT);
        FUZZ_NEED(tex.pixel < IBL_PIXEL_COUNT && tex.width >= 1 &&
                  tex.height >= 1 && tex.levels >= 1 && tex.layers >= 1 &&
                  tex.layers <= IBL_MAX_LAYERS &&
                  (tex.faces == 1 || tex.faces == IBL_FACES));
        FUZZ_NEED(tex.bytes == count_bytes(&tex));
        if (tex.bytes <= LARGE) {
            encode_again(&tex, (ibl_container)container, zstd);
            use(&tex, layer);
        }
    }
    ibl_texture_free(&tex);
}
