/* SPDX-License-Identifier: MIT */
#include "kern/rgbe.h"

#include <string.h>

#include "kern/lanes.h"

enum {
    BLOCK = 32 /* bytes expanded at once */
};

/* An unaligned vector of bytes. */
typedef int bytes
    __attribute__((vector_size(sizeof(vi)), aligned(1), may_alias));

/*
 * Runs and literals alternate without a pattern that a branch predictor could
 * learn, and most are short. So both are computed for a block of bytes and a
 * mask selects one; only longer ones branch.
 */
static const unsigned char *expand(const unsigned char *src, int count,
                                   unsigned char *dst)
{
    while (count > 0) {
        const int code = src[0];
        const int is_run = -(code > 128);
        const int n = code - (is_run & 128);
        const vi run = (vi){0} + ((int)(src[1] * 0x01010101u) & is_run);
        for (size_t k = 0; k < BLOCK; k += sizeof(vi))
            *(bytes *)(dst + k) =
                run | (*(const bytes *)(src + 1 + k) & ~is_run);
        if (n > BLOCK) {
            if (is_run)
                memset(dst + BLOCK, src[1], (size_t)(n - BLOCK));
            else
                memcpy(dst + BLOCK, src + 1 + BLOCK, (size_t)(n - BLOCK));
        }
        dst += n;
        count -= n;
        src += is_run ? 2 : n + 1;
    }
    return src;
}

/* Loads VF bytes as integers. */
#if VF == 8
static vi widen(const unsigned char *src)
{
    return (vi)_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)src));
}
#elif defined(IBL_NEON)
static vi widen(const unsigned char *src)
{
    int four;

    memcpy(&four, src, sizeof four);
    const uint16x8_t wide = vmovl_u8(vreinterpret_u8_s32(vdup_n_s32(four)));
    return (vi)vmovl_u16(vget_low_u16(wide));
}
#else
static vi widen(const unsigned char *src)
{
    const __m128i zero = _mm_setzero_si128();
    int four;

    memcpy(&four, src, sizeof four);
    return (vi)_mm_unpacklo_epi16(
        _mm_unpacklo_epi8(_mm_cvtsi32_si128(four), zero), zero);
}
#endif

/*
 * m / 256 without a conversion: m combined with the bits of 2^15 is the float
 * 2^15 + m / 256. Then times unit, which is 2^(e - 128).
 */
static vf scale_by(vi m, vf unit, vf scale)
{
    const vf base = vf_all(32768);
    return ((vf)(m | (vi)base) - base) * unit * scale;
}

/* 2^(e - 128): the larger of the bits as a normal float, negative for e = 0,
 * and those of the denormal for e = 1. */
static vf unit_of(vi e)
{
    const vi normal = (e << 23) - (1 << 23), denormal = e << 22;
    return (vf)vi_max(normal, denormal);
}

static void to_rgb(const unsigned char *src, size_t plane_bytes, int count,
                   const float scale[3], float *dst)
{
    const vf r = vf_all(scale[0]), g = vf_all(scale[1]), b = vf_all(scale[2]);
    int i = 0;

    for (; i + VF < count; i += VF) {
        const unsigned char *p = src + i;
        const vf unit = unit_of(widen(p + 3 * plane_bytes));
        vf_store_rgb(dst + 3 * i, scale_by(widen(p), unit, r),
                     scale_by(widen(p + plane_bytes), unit, g),
                     scale_by(widen(p + 2 * plane_bytes), unit, b));
    }
    ibl_rgbe_to_rgb_c(src + i, plane_bytes, count - i, scale, dst + 3 * i);
}

IBL_VECTOR_KERNEL(ibl_rgbe, expand, to_rgb)
