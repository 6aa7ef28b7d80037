/* SPDX-License-Identifier: MIT */
/* The pixel formats, without the encoders, which are in kern/pixel.c. */
#include "io/pixel_format.h"

#include <assert.h>
#include <float.h>
#include <string.h>

#include "core/half.h"
#include "io/blocks.h"
#include "kern/astc_hdr.h"
#include "kern/bc6h.h"
#include "kern/pixel.h"

_Static_assert(IBL_PIXEL_COUNT == 9, "each has a row in both tables");

static const struct {
    const char *name;
    int channels;
    int has_alpha;
    float max, max_blue;
} formats[IBL_PIXEL_COUNT] = {
    [IBL_PIXEL_RGBA16F] = {"rgba16f", 3, 1, IBL_HALF_MAX, IBL_HALF_MAX},
    [IBL_PIXEL_RGBA32F] = {"rgba32f", 3, 1, FLT_MAX, FLT_MAX},
    [IBL_PIXEL_RGB9E5] = {"rgb9e5", 3, 0, IBL_RGB9E5_MAX, IBL_RGB9E5_MAX},
    [IBL_PIXEL_R11G11B10F] = {"r11g11b10f", 3, 0, IBL_SMALL11_MAX,
                              IBL_SMALL10_MAX},
    [IBL_PIXEL_BC6H] = {"bc6h", 3, 0, IBL_BC6H_MAX, IBL_BC6H_MAX},
    [IBL_PIXEL_UASTC_HDR] = {"uastc-hdr", 3, 0, IBL_ASTC_HDR_MAX,
                             IBL_ASTC_HDR_MAX},
    [IBL_PIXEL_ASTC4X4HDR] = {"astc4x4hdr", 3, 0, IBL_ASTC_HDR_MAX,
                              IBL_ASTC_HDR_MAX},
    [IBL_PIXEL_RG16F] = {"rg16f", 2, 0, IBL_HALF_MAX, IBL_HALF_MAX},
    [IBL_PIXEL_RG32F] = {"rg32f", 2, 0, FLT_MAX, FLT_MAX},
};

/* Numbers: vulkan_core.h, dxgiformat.h, d3d9types.h, the OpenGL registry. */
const ibl_layout ibl_layouts[IBL_LAYOUT_COUNT] = {
    /* .pixel, .block_bytes, .word_bytes, .vk, .dxgi, .d3d,
     * .gl_type, .gl_format, .gl_internal, .block_edge */
    [IBL_PIXEL_RGBA16F] = {IBL_PIXEL_RGBA16F, 8, 2, 97, 10, 113, 0x140B, 0x1908,
                           0x881A, 1},
    [IBL_PIXEL_RGBA32F] = {IBL_PIXEL_RGBA32F, 16, 4, 109, 2, 116, 0x1406,
                           0x1908, 0x8814, 1},
    [IBL_PIXEL_RGB9E5] = {IBL_PIXEL_RGB9E5, 4, 4, 123, 67, 0, 0x8C3E, 0x1907,
                          0x8C3D, 1},
    [IBL_PIXEL_R11G11B10F] = {IBL_PIXEL_R11G11B10F, 4, 4, 122, 26, 0, 0x8C3B,
                              0x1907, 0x8C3A, 1},
    [IBL_PIXEL_BC6H] = {IBL_PIXEL_BC6H, 16, 1, 143, 95, 0, 0, 0x1907, 0x8E8F,
                        4},
    /* Before ASTC, which has the same number in Vulkan: KTX2 tells them apart
     * by the colour model. */
    [IBL_PIXEL_UASTC_HDR] = {IBL_PIXEL_UASTC_HDR, 16, 1, 1000066000, 0, 0, 0, 0,
                             0, 4},
    [IBL_PIXEL_ASTC4X4HDR] = {IBL_PIXEL_ASTC4X4HDR, 16, 1, 1000066000, 0, 0, 0,
                              0x1908, 0x93B0, 4},
    [IBL_PIXEL_RG16F] = {IBL_PIXEL_RG16F, 4, 2, 83, 34, 112, 0x140B, 0x8227,
                         0x822F, 1},
    [IBL_PIXEL_RG32F] = {IBL_PIXEL_RG32F, 8, 4, 103, 16, 115, 0x1406, 0x8227,
                         0x8230, 1},
    [IBL_LAYOUT_RGB16F] = {IBL_PIXEL_RGBA16F, 6, 2, 90, 0, 0, 0x140B, 0x1907,
                           0x881B, 1},
    [IBL_LAYOUT_RGB32F] = {IBL_PIXEL_RGBA32F, 12, 4, 106, 6, 0, 0x1406, 0x1907,
                           0x8815, 1},
    [IBL_LAYOUT_BC6H_SIGNED] = {IBL_PIXEL_RGBA16F, 16, 1, 144, 96, 0, 0, 0x1907,
                                0x8E8E, 4},
};

const ibl_layout *ibl_layout_find(size_t member, uint32_t number)
{
    for (int i = 0; number && i < IBL_LAYOUT_COUNT; i++) {
        uint32_t known;
        memcpy(&known, (const char *)&ibl_layouts[i] + member, sizeof known);
        if (known == number)
            return &ibl_layouts[i];
    }
    return NULL;
}

const char *ibl_pixel_name(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return formats[pixel].name;
}

size_t ibl_pixel_bytes(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return (size_t)ibl_layouts[pixel].block_bytes;
}

int ibl_pixel_block(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return ibl_layouts[pixel].block_edge;
}

ibl_pixel_numbers ibl_pixel_numbers_of(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    const ibl_layout *l = &ibl_layouts[pixel];
    return (ibl_pixel_numbers){.vk = l->vk,
                               .dxgi = l->dxgi,
                               .gl_internal = l->gl_internal,
                               .gl_format = l->gl_type ? l->gl_format : 0,
                               .gl_type = l->gl_type};
}

int ibl_pixel_channels(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return formats[pixel].channels;
}

int ibl_pixel_has_alpha(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return formats[pixel].has_alpha;
}

float ibl_pixel_max(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return formats[pixel].max;
}

float ibl_pixel_max_blue(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return formats[pixel].max_blue;
}

/* The last word of texel i. */
static size_t last_word(const ibl_layout *l, size_t i)
{
    return (i + 1) * (size_t)l->block_bytes - (size_t)l->word_bytes;
}

void ibl_pixel_set_alpha(ibl_pixel pixel, unsigned char *texels, size_t i,
                         float alpha)
{
    const ibl_layout *l = &ibl_layouts[pixel];
    const uint16_t half = ibl_half_from_float(alpha);
    const void *word = l->word_bytes == sizeof half ? (const void *)&half
                                                    : (const void *)&alpha;
    assert(formats[pixel].has_alpha);
    memcpy(texels + last_word(l, i), word, (size_t)l->word_bytes);
}

/* Converts a half or a float. */
static float load_word(const unsigned char *p, int word_bytes)
{
    uint16_t half;
    float f;
    memcpy(&half, p, sizeof half);
    if (word_bytes == sizeof half)
        return ibl_half_to_float(half);
    memcpy(&f, p, sizeof f);
    return f;
}

float ibl_pixel_get_alpha(ibl_pixel pixel, const unsigned char *texels,
                          size_t i)
{
    const ibl_layout *l = &ibl_layouts[pixel];
    return formats[pixel].has_alpha
               ? load_word(texels + last_word(l, i), l->word_bytes)
               : 1;
}

/* ---- data format descriptors ---------------------------------------- */

enum {
    CHANNEL_ALPHA = 15,
    EXPONENT = 0x20, /* qualifiers of a channel */
    SIGNED = 0x40,
    FLOAT = 0x80
};

static const uint32_t float_one = 0x3F800000, float_minus_one = 0xBF800000;

static ibl_sample float_sample(int offset, int bits, int channel)
{
    return (ibl_sample){.offset = (uint16_t)offset,
                        .last_bit = (uint8_t)(bits - 1),
                        .channel = (uint8_t)(channel | FLOAT),
                        .lower = channel & SIGNED ? float_minus_one : 0,
                        .upper = float_one};
}

int ibl_pixel_model(ibl_pixel pixel)
{
    return pixel == IBL_PIXEL_BC6H         ? IBL_MODEL_BC6H
           : pixel == IBL_PIXEL_UASTC_HDR  ? IBL_MODEL_UASTC_HDR
           : pixel == IBL_PIXEL_ASTC4X4HDR ? IBL_MODEL_ASTC
                                           : IBL_MODEL_RGBSDA;
}

int ibl_pixel_samples(ibl_pixel pixel, ibl_sample s[IBL_MAX_SAMPLES])
{
    const ibl_layout *l = &ibl_layouts[pixel];
    const int words = l->block_bytes / l->word_bytes;

    if (l->block_edge > 1) { /* a block is one sample */
        s[0] = float_sample(0, 128, pixel == IBL_PIXEL_ASTC4X4HDR ? SIGNED : 0);
        return 1;
    }
    if (pixel == IBL_PIXEL_R11G11B10F) {
        s[0] = float_sample(0, 11, 0);
        s[1] = float_sample(11, 11, 1);
        s[2] = float_sample(22, 10, 2);
        return 3;
    }
    /* Mantissa and exponent of each channel. A mantissa of 8448 (2^13 + 2^8)
     * with an exponent equal to the bias, 15, is 1. */
    for (int c = 0; c < 3 && pixel == IBL_PIXEL_RGB9E5; c++) {
        s[2 * c] = (ibl_sample){(uint16_t)(9 * c), 8, (uint8_t)c, 0, 0, 8448};
        s[2 * c + 1] = (ibl_sample){27, 4, (uint8_t)(c | EXPONENT), 0, 15, 31};
    }
    if (pixel == IBL_PIXEL_RGB9E5)
        return 6;
    for (int c = 0; c < words; c++)
        s[c] = float_sample(8 * c * l->word_bytes, 8 * l->word_bytes,
                            (c == 3 ? CHANNEL_ALPHA : c) | SIGNED);
    return words;
}

void ibl_pixel_decode(ibl_pixel pixel, const void *src, size_t count,
                      float *dst)
{
    const ibl_layout *l = &ibl_layouts[pixel];
    const unsigned char *from = src;
    ibl_pixel_dsp dsp;

    if (pixel == IBL_PIXEL_RGBA16F) {
        ibl_pixel_dsp_init(&dsp, ibl_isa_best());
        dsp.decode_rgba16f(src, count, dst);
        return;
    }
    if (l->block_edge > 1) {
        /* A block has as many bytes as texels. */
        for (size_t i = 0; i < count; i += IBL_BLOCK_TEXELS)
            ibl_blocks_to_floats(pixel, from + i, IBL_BLOCK_EDGE,
                                 IBL_BLOCK_EDGE, dst + 3 * i);
        return;
    }
    for (size_t i = 0; i < count; i++, from += l->block_bytes) {
        uint32_t texel;
        memcpy(&texel, from, sizeof texel);
        if (pixel == IBL_PIXEL_RGB9E5) {
            /* 2^(E - B - N), at least 2^-24. */
            const uint32_t bits = (127 - 24 + (texel >> 27)) << 23;
            float scale;
            memcpy(&scale, &bits, sizeof scale);
            for (int c = 0; c < 3; c++)
                *dst++ = (float)(texel >> (9 * c) & 511) * scale;
        } else if (pixel == IBL_PIXEL_R11G11B10F) {
            /* Halves without sign and last mantissa bits. */
            *dst++ = ibl_half_to_float((uint16_t)((texel & 0x7FF) << 4));
            *dst++ = ibl_half_to_float((uint16_t)((texel >> 11 & 0x7FF) << 4));
            *dst++ = ibl_half_to_float((uint16_t)((texel >> 22) << 5));
        } else {
            for (int c = 0; c < formats[pixel].channels; c++)
                *dst++ = load_word(from + c * l->word_bytes, l->word_bytes);
        }
    }
}
