/* SPDX-License-Identifier: MIT */
/*
 * Radiance pixels in plain C; the vector versions must agree.
 *
 * A pixel is three mantissas and an exponent, value = m * 2^(e - 136) (Ward
 * 1991, "Real Pixels", Graphics Gems II). Ward's own tools decode m + 0.5. The
 * readers that most programs use decode m, and so does this one.
 */
#include "kern/rgbe.h"

#include <stdint.h>
#include <string.h>

static const unsigned char *expand(const unsigned char *src, int count,
                                   unsigned char *dst)
{
    while (count > 0) {
        int n = *src++;
        if (n > 128) {
            n -= 128;
            memset(dst, *src++, (size_t)n);
        } else {
            memcpy(dst, src, (size_t)n);
            src += n;
        }
        dst += n;
        count -= n;
    }
    return src;
}

/* 2^(e - 128), a float for every e: denormal for 1, 0 for 0. */
static float unit_of(uint32_t e)
{
    const uint32_t bits = e > 1 ? (e - 1) << 23 : e << 22;
    float unit;
    memcpy(&unit, &bits, sizeof unit);
    return unit;
}

void ibl_rgbe_to_rgb_c(const unsigned char *src, size_t plane_bytes, int count,
                       const float scale[3], float *dst)
{
    for (int i = 0; i < count; i++) {
        const float unit = unit_of(src[3 * plane_bytes + i]);
        for (int c = 0; c < 3; c++) {
            const float m = (float)src[c * plane_bytes + i] / 256;
            dst[3 * i + c] = m * unit * scale[c];
        }
    }
}

IBL_KERNEL(ibl_rgbe, expand, ibl_rgbe_to_rgb_c)
