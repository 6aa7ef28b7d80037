/* SPDX-License-Identifier: MIT */
#include "kern/radial.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

static void points(double v, int size, int first, int stride, float *point)
{
    for (int i = 0; i < stride; i++) {
        const double u = (2.0 * (first + i) + 1) / size - 1;
        const double scale = 1 / sqrt(1 + u * u + v * v);
        const double d[3] = {scale, u * scale, v * scale};
        for (int k = 0; k < 3; k++) {
            const float near = (float)d[k];
            point[k * stride + i] = near;
            point[(k + 3) * stride + i] = (float)(d[k] - (double)near);
        }
    }
}

static float tabulated(const ibl_radial *lobe, float q)
{
    const int side = q > 1, shift = 23 - lobe->bits;
    const float v = side ? 2 - q : q;
    const float t = (v > 0 ? v : 0) + lobe->start[side];
    uint32_t word;
    memcpy(&word, &t, sizeof word);
    const float *c =
        lobe->coef + 4 * ((ptrdiff_t)(word >> shift) - lobe->base[side]);
    const float x =
        (float)(word & ((1u << shift) - 1)) * (1 / (float)(1u << shift));
    return q < 2 ? ((c[3] * x + c[2]) * x + c[1]) * x + c[0] : 0;
}

static float rational(const ibl_radial *lobe, float q)
{
    const float level = 1 - 0.5f * q, t = 1 + lobe->slope * q;
    return level > 0 ? lobe->peak * level / (t * t) : 0;
}

static void add(const ibl_radial *lobe, const ibl_radial_light *lights,
                int count, const float *point, int stride, float *rgba)
{
    for (int i = 0; i < stride; i++) {
        float sum[3] = {0};
        for (int l = 0; l < count; l++) {
            const ibl_radial_light *s = &lights[l];
            float q = 0;
            for (int k = 0; k < 3; k++) {
                const float e = (point[k * stride + i] - s->at[k]) +
                                (point[(k + 3) * stride + i] - s->rest[k]);
                q += e * e;
            }
            const float value =
                lobe->coef ? tabulated(lobe, q) : rational(lobe, q);
            for (int c = 0; c < 3; c++)
                sum[c] += s->rgb[c] * value;
        }
        for (int c = 0; c < 3; c++)
            rgba[4 * i + c] += sum[c];
    }
}

IBL_KERNEL(ibl_radial, points, add)
