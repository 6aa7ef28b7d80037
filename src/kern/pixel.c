/* SPDX-License-Identifier: MIT */
/*
 * The plain encoders. Sources: EXT_texture_shared_exponent (RGB9E5),
 * EXT_packed_float (R11G11B10F), IEEE 754-2008 (halves).
 */
#include "kern/pixel.h"

#include <float.h>
#include <string.h>

#include "core/half.h"

/* Limits f to [-max, max], with NaN as 0; counts it in *beyond if outside. */
static float clamp_signed(float f, float max, size_t *beyond)
{
    if (f != f)
        return 0;
    if (f > max || f < -max) {
        ++*beyond;
        return f > 0 ? max : -max;
    }
    return f;
}

/* Limits f to [0, max], with NaN as 0; counts it in *beyond if above. */
static float clamp_unsigned(float f, float max, size_t *beyond)
{
    if (!(f > 0))
        return 0;
    if (f > max) {
        ++*beyond;
        return max;
    }
    return f;
}

/* Encodes two channels, or three with an alpha of 1. */
static size_t encode_halves(const float *src, size_t count, size_t channels,
                            unsigned char *out)
{
    const size_t bytes = channels == 3 ? 8 : 4;
    size_t beyond = 0;
    for (size_t i = 0; i < count; i++, src += channels, out += bytes) {
        uint16_t texel[4] = {[3] = 0x3C00 /* alpha 1 */};
        for (size_t c = 0; c < channels; c++)
            texel[c] = ibl_half_from_float(
                clamp_signed(src[c], IBL_HALF_MAX, &beyond));
        memcpy(out, texel, bytes);
    }
    return beyond;
}

static size_t encode_floats(const float *src, size_t count, size_t channels,
                            unsigned char *out)
{
    const size_t bytes = channels == 3 ? 16 : 8;
    size_t beyond = 0;
    for (size_t i = 0; i < count; i++, src += channels, out += bytes) {
        float texel[4] = {[3] = 1};
        for (size_t c = 0; c < channels; c++)
            texel[c] = clamp_signed(src[c], FLT_MAX, &beyond);
        memcpy(out, texel, bytes);
    }
    return beyond;
}

size_t ibl_encode_rgba16f_c(const float *src, size_t count, void *dst)
{
    return encode_halves(src, count, 3, dst);
}

size_t ibl_encode_rg16f_c(const float *src, size_t count, void *dst)
{
    return encode_halves(src, count, 2, dst);
}

static size_t encode_rgba32f(const float *src, size_t count, void *dst)
{
    return encode_floats(src, count, 3, dst);
}

static size_t encode_rg32f(const float *src, size_t count, void *dst)
{
    return encode_floats(src, count, 2, dst);
}

/*
 * The shared exponent of EXT_texture_shared_exponent, N = 9, B = 15. It uses
 * floor(log2(max)) from the float's exponent, plus one if the largest mantissa
 * would round up to 2^9. Mantissas are floor(x + 1/2). The sum is exact in
 * double; in float 0.49999997 would become 1.
 */
static uint32_t shared_exponent(const float rgb[3], size_t *beyond)
{
    enum {
        N = 9,
        B = 15
    };
    float c[3], max = 0;
    for (int i = 0; i < 3; i++) {
        c[i] = clamp_unsigned(rgb[i], IBL_RGB9E5_MAX, beyond);
        max = c[i] > max ? c[i] : max;
    }
    const int floor_log2 = (int)(ibl_bits_of(max) >> 23) - 127;
    int exponent = (floor_log2 > -B - 1 ? floor_log2 : -B - 1) + 1 + B;
    double scale =
        (double)ibl_float_of((uint32_t)(127 + B + N - exponent) << 23);
    if ((uint32_t)(max * scale + 0.5) == 1u << N) {
        exponent++;
        scale /= 2;
    }
    uint32_t texel = (uint32_t)exponent << 27;
    for (int i = 0; i < 3; i++)
        texel |= (uint32_t)(c[i] * scale + 0.5) << (N * i);
    return texel;
}

static uint32_t small_floats(const float rgb[3], size_t *beyond)
{
    const float r = clamp_unsigned(rgb[0], IBL_SMALL11_MAX, beyond);
    const float g = clamp_unsigned(rgb[1], IBL_SMALL11_MAX, beyond);
    const float b = clamp_unsigned(rgb[2], IBL_SMALL10_MAX, beyond);
    return ibl_small_float(r, 6) | ibl_small_float(g, 6) << 11 |
           ibl_small_float(b, 5) << 22;
}

/* Encodes texels of one 32-bit word. */
static inline size_t encode_words(uint32_t encode(const float rgb[3],
                                                  size_t *beyond),
                                  const float *src, size_t count, void *dst)
{
    unsigned char *out = dst;
    size_t beyond = 0;
    for (size_t i = 0; i < count; i++, src += 3, out += 4) {
        const uint32_t texel = encode(src, &beyond);
        memcpy(out, &texel, sizeof texel);
    }
    return beyond;
}

static size_t encode_rgb9e5(const float *src, size_t count, void *dst)
{
    return encode_words(shared_exponent, src, count, dst);
}

static size_t encode_r11g11b10f(const float *src, size_t count, void *dst)
{
    return encode_words(small_floats, src, count, dst);
}

void ibl_decode_rgba16f_c(const void *src, size_t count, float *dst)
{
    const unsigned char *in = src;

    for (size_t i = 0; i < count; i++, in += 8) {
        uint16_t texel[3];
        memcpy(texel, in, sizeof texel);
        for (int c = 0; c < 3; c++)
            *dst++ = ibl_half_to_float(texel[c]);
    }
}

_Static_assert(IBL_PIXEL_COUNT == 9, "each has a row below");

IBL_KERNEL(ibl_pixel,
           {[IBL_PIXEL_RGBA16F] = ibl_encode_rgba16f_c,
            [IBL_PIXEL_RGBA32F] = encode_rgba32f,
            [IBL_PIXEL_RGB9E5] = encode_rgb9e5,
            [IBL_PIXEL_R11G11B10F] = encode_r11g11b10f,
            [IBL_PIXEL_RG16F] = ibl_encode_rg16f_c,
            [IBL_PIXEL_RG32F] = encode_rg32f},
           ibl_decode_rgba16f_c)
