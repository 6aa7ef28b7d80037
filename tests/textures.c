/* SPDX-License-Identifier: MIT */
#include "textures.h"

#include <stdlib.h>
#include <string.h>

#include "test.h"

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
