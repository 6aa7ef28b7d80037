/* SPDX-License-Identifier: MIT */
/*
 * Pixel formats against tables of every value that a code stands for, built
 * here with ldexp in doubles, and against the text of
 * EXT_texture_shared_exponent written with log2 and pow.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "ibl/io.h"
#include "test.h"
#include "textures.h"

/* Value of a code of 5 exponent bits, bias 15, and `mantissa` bits. */
static double code_value(unsigned code, int mantissa)
{
    const int exponent = (int)(code >> mantissa);
    const unsigned fraction = code & ((1u << mantissa) - 1);
    if (!exponent)
        return ldexp(fraction, -14 - mantissa);
    return ldexp((1u << mantissa) + fraction, exponent - 15 - mantissa);
}

/* Each code alone, in the last of eight texels, both ways, the points halfway
 * to the next and their float neighbours, and what is negative. */
TEST(every_code)
{
    static const struct {
        ibl_pixel pixel;
        int channel, shift, mantissa;
    } codes[] = {
        {IBL_PIXEL_RG16F, 0, 0, 10},      {IBL_PIXEL_RG16F, 1, 16, 10},
        {IBL_PIXEL_RGBA16F, 0, 0, 10},    {IBL_PIXEL_RGBA16F, 1, 16, 10},
        {IBL_PIXEL_RGBA16F, 2, 32, 10},   {IBL_PIXEL_R11G11B10F, 0, 0, 6},
        {IBL_PIXEL_R11G11B10F, 1, 11, 6}, {IBL_PIXEL_R11G11B10F, 2, 22, 5}};
    for (size_t k = 0; k < sizeof codes / sizeof *codes; k++) {
        const ibl_pixel p = codes[k].pixel;
        const int mantissa = codes[k].mantissa, c = codes[k].channel;
        const unsigned end = 31u << mantissa; /* Inf */
        const uint64_t alpha = ibl_pixel_has_alpha(p) ? 0x3C00ull << 48 : 0;
        for (unsigned code = 0; code < end; code++) {
            const float value = (float)code_value(code, mantissa);
            const float middle = (float)((code_value(code, mantissa) +
                                          code_value(code + 1, mantissa)) /
                                         2);
            const struct {
                float in;
                unsigned code;
            } cases[] = {{value, code},
                         {middle, code + (code & 1)},
                         {nextafterf(middle, 0), code},
                         {nextafterf(middle, FLT_MAX), code + 1},
                         {-value, mantissa == 10 ? code | 0x8000 : 0}};
            for (int i = 0; i < 5; i++) {
                const int channels = ibl_pixel_channels(p);
                unsigned char texels[8 * 8];
                uint64_t out = 0;
                float rgb[3 * 8] = {0};
                if (code + 1 == end && i > 0 && i < 4)
                    continue;
                for (int t = c; t < 8 * channels; t += channels)
                    rgb[t] = cases[i].in;
                CHECK(!texels_encode(p, rgb, 8, texels));
                memcpy(&out, texels + 7 * ibl_pixel_bytes(p),
                       ibl_pixel_bytes(p));
                CHECK_MSG(
                    out == ((uint64_t)cases[i].code << codes[k].shift | alpha),
                    "%s %d: %a gives %#llx, not %#x", ibl_pixel_name(p), c,
                    (double)rgb[c], (unsigned long long)out, cases[i].code);
                ibl_pixel_decode(p, &out, 1, rgb);
                CHECK(i % 4 ||
                      rgb[c] == (mantissa < 10 && i ? 0 : cases[i].in));
            }
        }
    }
}

/* Section 3.8.1.4 of EXT_texture_shared_exponent, N = 9, B = 15, Emax = 31. */
static uint32_t shared_exponent(const float rgb[3])
{
    const double limit = (pow(2, 9) - 1) / pow(2, 9) * pow(2, 31 - 15);
    double c[3];
    for (int i = 0; i < 3; i++)
        c[i] = rgb[i] > 0 ? fmin(limit, rgb[i]) : 0;
    const double max = fmax(fmax(c[0], c[1]), c[2]);
    const double preliminary =
        max > 0 ? fmax(-15 - 1, floor(log2(max))) + 1 + 15 : 0;
    const double max_s = floor(max / pow(2, preliminary - 15 - 9) + 0.5);
    const double exponent = max_s == pow(2, 9) ? preliminary + 1 : preliminary;
    uint32_t texel = (uint32_t)exponent << 27;
    for (int i = 0; i < 3; i++)
        texel |= (uint32_t)floor(c[i] / pow(2, exponent - 15 - 9) + 0.5)
                 << (9 * i);
    return texel;
}

static void check_rgb9e5(const float rgb[3])
{
    uint32_t out;
    texels_encode(IBL_PIXEL_RGB9E5, rgb, 1, &out);
    CHECK_MSG(out == shared_exponent(rgb), "%a %a %a gives %#x, not %#x",
              (double)rgb[0], (double)rgb[1], (double)rgb[2], out,
              shared_exponent(rgb));
    float back[3];
    ibl_pixel_decode(IBL_PIXEL_RGB9E5, &out, 1, back);
    for (int c = 0; c < 3; c++)
        CHECK((double)back[c] ==
              ldexp(out >> 9 * c & 511, (int)(out >> 27) - 24));
}

TEST(rgb9e5)
{
    test_random r = {3};
    for (int i = 0; i < 300000; i++) {
        const int exponent = (int)(test_random_u64(&r) % 48) - 30;
        float rgb[3];
        for (int c = 0; c < 3; c++)
            rgb[c] = (float)ldexp(test_random_unit(&r),
                                  exponent - (int)(test_random_u64(&r) % 4));
        check_rgb9e5(rgb);
    }
    /* Just below half a unit: adding 0.5 in floats would round it up. */
    for (int e = -14; e <= 15; e++) {
        const float half = nextafterf(ldexpf(1, e - 9), 0);
        check_rgb9e5((float[]){ldexpf(1, e), half, half / 3});
    }
    /* Around every power of two and every change of the largest mantissa. */
    for (int e = -27; e <= 16; e++) {
        for (int m = 255; m <= 513; m++) {
            const float at = (float)ldexp(m - 0.5, e - 9);
            const float values[3] = {nextafterf(at, 0), at,
                                     nextafterf(at, FLT_MAX)};
            for (int i = 0; i < 3; i++) {
                check_rgb9e5((float[]){values[i], at / 3, 0});
                check_rgb9e5((float[]){0, values[i] / 2, values[i]});
            }
        }
    }
}

/* NaN, infinities, negatives and what lies beyond, counted. */
TEST(limits)
{
    for (ibl_pixel p = 0; p < IBL_PIXEL_COUNT; p++) {
        const int channels = ibl_pixel_channels(p);
        const bool sign = channels == 2 || ibl_pixel_has_alpha(p);
        const size_t texels = (size_t)(ibl_pixel_block(p) * ibl_pixel_block(p));
        const float max = ibl_pixel_max(p);
        const struct {
            float in, out;
            size_t beyond;
        } cases[] = {
            {FLT_TRUE_MIN,
             p == IBL_PIXEL_RGBA32F || p == IBL_PIXEL_RG32F ? FLT_TRUE_MIN : 0,
             0},
            {NAN, 0, 0},
            {-NAN, 0, 0},
            {INFINITY, max, 1},
            {max, max, 0},
            {nextafterf(max, INFINITY), max, 1},
            {-1, sign ? -1 : 0, 0},
            {-INFINITY, sign ? -max : 0, sign},
            {-0.0f, sign ? -0.0f : 0, 0},
            {0, 0, 0},
        };
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
            float in[3 * 16] = {0}, out[3 * 16];
            for (size_t k = 0; k < texels; k++)
                in[3 * k] = cases[i].in;
            unsigned char texel[16];
            const size_t beyond = texels_encode(p, in, texels, texel);
            ibl_pixel_decode(p, texel, texels, out);
            CHECK_MSG(beyond == texels * cases[i].beyond,
                      "%s of %g: %zu beyond", ibl_pixel_name(p), (double)in[0],
                      beyond);
            CHECK_MSG(out[0] == cases[i].out &&
                          !signbit(out[0]) == !signbit(cases[i].out),
                      "%s of %g is %g", ibl_pixel_name(p), (double)in[0],
                      (double)out[0]);
            CHECK(out[1] == 0 && (channels == 2 || out[2] == 0));
        }
    }
}
