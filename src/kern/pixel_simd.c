/* SPDX-License-Identifier: MIT */
/* Halves, VF at a time. */
#include <stdbool.h>

#include "kern/lanes.h"
#include "kern/pixel.h"

/* Limits v to the range of halves, with NaN as 0. Subtracts 1 from the lanes of
 * *beyond where v was outside. */
static inline vf clamp(vf v, vi *beyond)
{
    const vf limit = vf_all(IBL_HALF_MAX);
    const vf number = (vf)((vi)v & (vi)(v == v));

    *beyond += (vi)((vf)((vi)number & ~(vi)vf_all(-0.0f)) > limit);
    return vf_max(vf_min(number, limit), -limit);
}

#ifndef HALVES
/* Uses the arithmetic of ibl_small_float. */
static inline void vf_store_halves(void *out, vf v)
{
    const vi bits = (vi)v & 0x7FFFFFFF, odd = bits >> 13 & 1;
    const vi normal = (bits + odd + (0xFFF - (112 << 23))) >> 13;
    /* The last bit of 0.5 is 2^-24, the unit of denormal halves. */
    const vf half = vf_all(0.5f);
    const vi denormal = (vi)((vf)bits + half) - (vi)half;
    const vi size = (vi)vf_either(bits < 0x38800000, (vf)denormal, (vf)normal);
    /* Extends the sign upwards, as the signed packing needs it. */
    const __m128i halves = (__m128i)(size | ((vi)v & ~0x7FFFFFFF) >> 16);
    _mm_storel_epi64(out, _mm_packs_epi32(halves, halves));
}
#endif

#ifdef IBL_NEON
enum {
    RGB_TEXELS = VF /* that are encoded at a time */
};

static inline void encode_rgb(const float *src, unsigned char *out, vi *beyond)
{
    const float32x4x3_t rgb = vld3q_f32(src);
    uint16x4x4_t texels = {.val[3] = vdup_n_u16(0x3C00)}; /* alpha: 1 */
#pragma GCC unroll 3
    for (int c = 0; c < 3; c++)
        vf_store_halves(&texels.val[c], clamp(rgb.val[c], beyond));
    vst4_u16((uint16_t *)(void *)out, texels);
}
#else
enum {
    RGB_TEXELS = VF / 4
};

/* With an alpha of 1. Reads one float beyond the texels. */
static inline void encode_rgb(const float *src, unsigned char *out, vi *beyond)
{
    const float *const at[] = {src, src + 3};
    const vi alpha = vf_all_quads((vq){0, 0, 0, 1}) != vf_all(0);
    const vf rgba = vf_either(alpha, vf_all(1), vf_load_quads(at));
    vf_store_halves(out, clamp(rgba, beyond));
}
#endif

enum {
    BLOCK = 1 << 24 /* texels without overflow of the lanes' counts */
};

/* Encodes the texels that fill whole vectors; *done is their number. Returns
 * how many components were beyond the range. */
static inline size_t encode(const float *src, size_t count, bool rgb,
                            unsigned char *out, size_t *done)
{
    const size_t step = rgb ? RGB_TEXELS : VF / 2, least = step + rgb;
    size_t sum = 0, i = 0;
    while (count - i >= least) {
        const size_t end = count - i < BLOCK ? count : i + BLOCK;
        vi beyond = {0};
        for (; i + least <= end; i += step) {
            if (rgb)
                encode_rgb(src + 3 * i, out + 8 * i, &beyond);
            else
                vf_store_halves(out + 4 * i,
                                clamp(vf_load(src + 2 * i), &beyond));
        }
        for (int k = 0; k < VF; k++)
            sum -= (size_t)beyond[k];
    }
    *done = i;
    return sum;
}

static size_t encode_rgba16f(const float *src, size_t count, void *dst)
{
    unsigned char *out = dst;
    size_t i;
    const size_t beyond = encode(src, count, true, out, &i);
    return beyond + ibl_encode_rgba16f_c(src + 3 * i, count - i, out + 8 * i);
}

static size_t encode_rg16f(const float *src, size_t count, void *dst)
{
    unsigned char *out = dst;
    size_t i;
    const size_t beyond = encode(src, count, false, out, &i);
    return beyond + ibl_encode_rg16f_c(src + 2 * i, count - i, out + 4 * i);
}

#ifdef IBL_NEON
static void decode_rgba16f(const void *src, size_t count, float *dst)
{
    const uint16_t *in = src;
    size_t i = 0;

    for (; i + VF <= count; i += VF) {
        const uint16x4x4_t rgba = vld4_u16(in + 4 * i);
        vf_store_rgb(dst + 3 * i, vf_load_halves(&rgba.val[0]),
                     vf_load_halves(&rgba.val[1]),
                     vf_load_halves(&rgba.val[2]));
    }
    ibl_decode_rgba16f_c(in + 4 * i, count - i, dst + 3 * i);
}
#elif defined HALVES
/* VF / 4 texels at a time; each store has one float more, which the next one
 * replaces. */
static void decode_rgba16f(const void *src, size_t count, float *dst)
{
    const unsigned char *in = src;
    size_t i = 0;

    for (; i + VF / 4 < count; i += VF / 4) {
        const vf texels = vf_load_halves(in + 8 * i);
        for (size_t k = 0; k < VF / 4; k++)
            vq_store(dst + 3 * (i + k), vf_quad(texels, k));
    }
    ibl_decode_rgba16f_c(in + 8 * i, count - i, dst + 3 * i);
}
#endif

void IBL_FOR_ISA(ibl_pixel_init)(ibl_pixel_dsp *dsp)
{
#ifdef HALVES
    dsp->decode_rgba16f = decode_rgba16f;
#endif
    dsp->encode[IBL_PIXEL_RGBA16F] = encode_rgba16f;
    dsp->encode[IBL_PIXEL_RG16F] = encode_rg16f;
}
