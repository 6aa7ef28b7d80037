/* SPDX-License-Identifier: MIT */
/* kern/octant_sums.h in vectors of any width. */
#include <stddef.h>
#include <string.h>

#include "kern/lanes.h"
#include "kern/octant_sums.h"

typedef double four __attribute__((vector_size(32), may_alias));

static inline void widen(vq x, four *to)
{
#if VD == 4
    *to = (four)_mm256_cvtps_pd(x);
#elif defined IBL_NEON
    vd half[2];
    vf_widen(x, half);
    vd_store((double *)to, half[0]);
    vd_store((double *)to + VD, half[1]);
#else
    *to = __builtin_convertvector(x, four);
#endif
}

/* The RGB at p and a zero; reads nothing beyond. */
static inline vq load_rgb(const float *p)
{
#if VD == 4
    return _mm_maskload_ps(p, _mm_setr_epi32(-1, -1, -1, 0));
#else
    return (vq){p[0], p[1], p[2], 0};
#endif
}

/* One pixel of four images, one vector per channel. */
static inline void collect_four(const float *row, const int *offset, vq rgb[3])
{
#ifdef IBL_NEON
    float32x4x3_t v = vld3q_dup_f32(row + offset[0]);
    v = vld3q_lane_f32(row + offset[1], v, 1);
    v = vld3q_lane_f32(row + offset[2], v, 2);
    v = vld3q_lane_f32(row + offset[3], v, 3);
    rgb[0] = v.val[0];
    rgb[1] = v.val[1];
    rgb[2] = v.val[2];
#else
    const vq a = load_rgb(row + offset[0]), b = load_rgb(row + offset[1]);
    const vq c = load_rgb(row + offset[2]), d = load_rgb(row + offset[3]);
    const vq ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);
    const vq cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    rgb[0] = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
    rgb[1] = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
    rgb[2] = __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 6, 3, 7),
                                     __builtin_shufflevector(c, d, 2, 6, 3, 7),
                                     0, 1, 4, 5);
#endif
}

static void collect(const float *row, const int *offset, int count,
                    double *pixels)
{
    for (int i = 0; i < count; i++) {
        vq low[3], high[3];
        collect_four(row, offset, low);
        collect_four(row, offset + 4, high);
        for (int c = 0; c < 3; c++) {
            widen(low[c], (four *)(pixels + c * IBL_OCTANTS));
            widen(high[c], (four *)(pixels + c * IBL_OCTANTS + 4));
        }
        offset += IBL_OCTANTS;
        pixels += IBL_OCTANT_RGB;
    }
}

/* The RGB at p times a weight. */
static inline void weigh(const float *p, double weight, four *rgb)
{
    widen(load_rgb(p), rgb);
    *rgb *= weight;
}

/* One source row's contribution to a pixel. */
static inline void take_part(const ibl_octant_blend *row, int k, int column,
                             four *rgb)
{
    int x = column + row->turn[k];
    x -= x >= row->columns ? row->columns : 0;
    const ibl_octant_tap *tap = &row->taps[x];
    const double weight = row->weight[k] * tap->weight;
    four right;
    weigh(row->source[k] + tap->at[0], row->weight[k] - weight, rgb);
    weigh(row->source[k] + tap->at[1], weight, &right);
    *rgb += right;
}

static void blend(const ibl_octant_blend *row, const int *column, int count,
                  int lanes, double *pixels)
{
    for (int i = 0; i < count; i++) {
        for (int m = 0; m < lanes; m++) {
            four upper, lower;
            take_part(row, 0, column[m], &upper);
            take_part(row, 1, column[m], &lower);
            upper += lower;
            for (int c = 0; c < 3; c++)
                pixels[c * IBL_OCTANTS + m] = upper[c];
        }
        column += IBL_OCTANTS;
        pixels += IBL_OCTANT_RGB;
    }
}

/* Vectors of a pixel that are summed at a time: as many as registers hold. */
enum {
    OF_A_PIXEL = IBL_OCTANT_RGB / VD,
    CHAINS = REGISTERS / OF_A_PIXEL > 1 ? OF_A_PIXEL : 6
};

static inline void add_span(const ibl_octant_span *s, const double *p,
                            double *sum)
{
    vd v[CHAINS];
#pragma GCC unroll 12
    for (int k = 0; k < CHAINS; k++)
        v[k] = vd_load(p + k * VD);
    for (int i = 1; i < s->count; i++) {
        p += IBL_OCTANT_RGB;
#pragma GCC unroll 12
        for (int k = 0; k < CHAINS; k++)
            v[k] += vd_load(p + k * VD);
    }
    const vd w = vd_all((double)s->weight);
#pragma GCC unroll 12
    for (int k = 0; k < CHAINS; k++)
        vd_store(sum + k * VD, vd_load(sum + k * VD) + w * v[k]);
}

static void add_spans(const ibl_octant_span *spans, int count,
                      const double *pixels, double *sums, double *weights)
{
    for (const ibl_octant_span *s = spans; s < spans + count; s++) {
        weights[s->slot] += (double)s->weight * s->count;
        const double *p = pixels + IBL_OCTANT_RGB * (size_t)s->pixel;
        double *sum = sums + IBL_OCTANT_RGB * (size_t)s->slot;
#pragma GCC unroll 2
        for (int k = 0; k < OF_A_PIXEL; k += CHAINS)
            add_span(s, p + k * VD, sum + k * VD);
    }
}

/* Four lanes times scale, as floats. */
static inline vq four_floats(const double *p, double scale)
{
    return __builtin_convertvector(*(const four *)p * scale, vq);
}

/* A double stands for two floats. */
typedef double pair __attribute__((vector_size(16)));

static inline void write_rgb(float *to, double rg, float b)
{
    memcpy(to, &rg, sizeof rg);
    to[2] = b;
}

static inline void write_four(float *const out[4], const ptrdiff_t step[4],
                              int i, vq r, vq g, vq b)
{
    const pair low = (pair)__builtin_shufflevector(r, g, 0, 4, 1, 5);
    const pair high = (pair)__builtin_shufflevector(r, g, 2, 6, 3, 7);

    write_rgb(out[0] + i * step[0], low[0], b[0]);
    write_rgb(out[1] + i * step[1], low[1], b[1]);
    write_rgb(out[2] + i * step[2], high[0], b[2]);
    write_rgb(out[3] + i * step[3], high[1], b[3]);
}

static void write_sums(double *sums, double *weights, int count,
                       float *const out[IBL_OCTANTS],
                       const ptrdiff_t step[IBL_OCTANTS])
{
    for (int i = 0; i < count; i++) {
        const double scale = 1 / weights[i];
        for (int m = 0; m < IBL_OCTANTS; m += 4)
            write_four(out + m, step + m, i, four_floats(sums + m, scale),
                       four_floats(sums + IBL_OCTANTS + m, scale),
                       four_floats(sums + 2 * IBL_OCTANTS + m, scale));
        weights[i] = 0;
#pragma GCC unroll 12
        for (int k = 0; k < OF_A_PIXEL; k++)
            vd_store(sums + k * VD, vd_all(0));
        sums += IBL_OCTANT_RGB;
    }
}

IBL_VECTOR_KERNEL(ibl_octants, collect, blend, add_spans, write_sums)
