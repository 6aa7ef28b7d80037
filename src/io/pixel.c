/* SPDX-License-Identifier: MIT */
#include <assert.h>
#include <float.h>
#include <pthread.h>
#include <string.h>

#include "core/half.h"
#include "kern/pixel.h"

static const struct {
    const char *name;
    size_t bytes;
    int channels;
    float max;
} formats[IBL_PIXEL_COUNT] = {
    [IBL_PIXEL_RGBA16F] = {"rgba16f", 8, 3, IBL_HALF_MAX},
    [IBL_PIXEL_RGBA32F] = {"rgba32f", 16, 3, FLT_MAX},
    [IBL_PIXEL_RGB9E5] = {"rgb9e5", 4, 3, IBL_RGB9E5_MAX},
    [IBL_PIXEL_R11G11B10F] = {"r11g11b10f", 4, 3, IBL_SMALL11_MAX},
    [IBL_PIXEL_RG16F] = {"rg16f", 4, 2, IBL_HALF_MAX},
    [IBL_PIXEL_RG32F] = {"rg32f", 8, 2, FLT_MAX},
};

const char *ibl_pixel_name(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return formats[pixel].name;
}

size_t ibl_pixel_bytes(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return formats[pixel].bytes;
}

int ibl_pixel_channels(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return formats[pixel].channels;
}

int ibl_pixel_has_alpha(ibl_pixel pixel)
{
    return pixel == IBL_PIXEL_RGBA16F || pixel == IBL_PIXEL_RGBA32F;
}

float ibl_pixel_max(ibl_pixel pixel)
{
    assert(pixel < IBL_PIXEL_COUNT);
    return formats[pixel].max;
}

static ibl_pixel_dsp best;
static pthread_once_t best_once = PTHREAD_ONCE_INIT;

static void find_best(void)
{
    ibl_pixel_dsp_init(&best, IBL_ISA_AUTO);
}

size_t ibl_pixel_encode(ibl_pixel pixel, const float *src, size_t count,
                        void *dst)
{
    assert(pixel < IBL_PIXEL_COUNT);
    pthread_once(&best_once, find_best);
    return best.encode[pixel](src, count, dst);
}

static void decode_halves(const unsigned char *src, int channels, int stride,
                          size_t count, float *dst)
{
    for (size_t i = 0; i < count; i++, src += 2 * stride) {
        for (int c = 0; c < channels; c++) {
            uint16_t half;
            memcpy(&half, src + 2 * c, sizeof half);
            *dst++ = ibl_half_to_float(half);
        }
    }
}

static void decode_rgb9e5(const unsigned char *src, size_t count, float *dst)
{
    for (size_t i = 0; i < count; i++, src += 4) {
        uint32_t texel;
        memcpy(&texel, src, sizeof texel);
        /* 2^(E - B - N), at least 2^-24. */
        const uint32_t scale_bits = (127 - 24 + (texel >> 27)) << 23;
        float scale;
        memcpy(&scale, &scale_bits, sizeof scale);
        for (int c = 0; c < 3; c++)
            *dst++ = (float)(texel >> (9 * c) & 511) * scale;
    }
}

/* The small floats are halves whose last mantissa bits are left out. */
static void decode_r11g11b10f(const unsigned char *src, size_t count,
                              float *dst)
{
    for (size_t i = 0; i < count; i++, src += 4) {
        uint32_t texel;
        memcpy(&texel, src, sizeof texel);
        *dst++ = ibl_half_to_float((uint16_t)((texel & 0x7FF) << 4));
        *dst++ = ibl_half_to_float((uint16_t)((texel >> 11 & 0x7FF) << 4));
        *dst++ = ibl_half_to_float((uint16_t)((texel >> 22) << 5));
    }
}

static void decode_floats(const unsigned char *src, size_t count, float *dst)
{
    for (size_t i = 0; i < count; i++)
        memcpy(dst + 3 * i, src + 16 * i, 3 * sizeof *dst);
}

void ibl_pixel_decode(ibl_pixel pixel, const void *src, size_t count,
                      float *dst)
{
    switch (pixel) {
    case IBL_PIXEL_RGBA16F:
        decode_halves(src, 3, 4, count, dst);
        break;
    case IBL_PIXEL_RG16F:
        decode_halves(src, 2, 2, count, dst);
        break;
    case IBL_PIXEL_RGBA32F:
        decode_floats(src, count, dst);
        break;
    case IBL_PIXEL_RG32F:
        if (count) /* src and dst may be NULL with nothing to copy */
            memcpy(dst, src, count * 2 * sizeof *dst);
        break;
    case IBL_PIXEL_RGB9E5:
        decode_rgb9e5(src, count, dst);
        break;
    case IBL_PIXEL_R11G11B10F:
        decode_r11g11b10f(src, count, dst);
        break;
    case IBL_PIXEL_COUNT:
        assert(!"a pixel format");
    }
}
