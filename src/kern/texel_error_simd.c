/* SPDX-License-Identifier: MIT */
/* VF texels at a time. */
#include "kern/texel_error.h"

#include <math.h>

#include "kern/lanes.h"

/* The components of VF texels. Reads one float beyond them. */
static inline void load(const float *texels, vf rgb[4])
{
#ifdef IBL_NEON
    const float32x4x3_t three = vld3q_f32(texels);
    rgb[0] = three.val[0];
    rgb[1] = three.val[1];
    rgb[2] = three.val[2];
#else
#pragma GCC unroll 4
    for (size_t k = 0; k < 4; k++) {
        const float *const at[] = {texels + 3 * k, texels + 3 * (k + 4)};
        rgb[k] = vf_load_quads(at);
    }
    vf_transpose(rgb);
#endif
}

static inline vf square(const vf v[3])
{
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

/* Adds a float for each of VF lanes. */
static inline void add_lanes(double *sums, vf values)
{
    vd half[2];

    vf_widen(values, half);
#pragma GCC unroll 2
    for (size_t k = 0; k < 2; k++)
        vd_store(sums + k * VD, vd_load(sums + k * VD) + half[k]);
}

static inline void add_texels(const float *t, const float *d, size_t lane,
                              ibl_error_sums *sums)
{
    const vf zero = vf_all(0), one = vf_all(1);
    vf a[4], b[4];

    load(t, a);
    load(d, b);
    const vf off[] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const vf wrong = square(off), truth = square(a);
    const vi finite = truth < vf_all(INFINITY), black = truth <= zero;
    const vf ratio = vf_sqrt(wrong) / vf_sqrt(vf_either(black, one, truth));
    const vf of_black = vf_either(wrong > zero, one, zero);
    add_lanes(sums->wrong + lane, vf_either(finite, wrong, zero));
    add_lanes(sums->truth + lane, vf_either(finite, truth, zero));
    add_lanes(sums->relative + lane,
              vf_either(finite, vf_either(black, of_black, ratio), zero));
    add_lanes(sums->count + lane, vf_either(finite, one, zero));
    vf light = zero, lost = zero;
#pragma GCC unroll 3
    for (int c = 0; c < 3; c++) {
        const vf own = vf_either(finite, vf_max(a[c], zero), zero);
        light += own;
        lost += vf_either(b[c] > zero, zero, own);
    }
    add_lanes(sums->light + lane, light);
    add_lanes(sums->lost + lane, lost);
}

static float square_of(const float v[3])
{
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

/* Adds the texels from first on, fewer than a block, one by one. */
static void add_rest(const float *t, const float *d, size_t first, size_t count,
                     ibl_error_sums *sums)
{
    for (size_t i = first; i < count; i++) {
        const float *a = t + 3 * i, *b = d + 3 * i;
        const float off[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        const float wrong = square_of(off), truth = square_of(a);
        const size_t lane = i % IBL_ERROR_LANES;
        if (!(truth < INFINITY))
            continue;
        sums->wrong[lane] += (double)wrong;
        sums->truth[lane] += (double)truth;
        sums->relative[lane] +=
            truth > 0 ? (double)(sqrtf(wrong) / sqrtf(truth)) : wrong > 0;
        sums->count[lane]++;
        float light = 0, lost = 0;
        for (int c = 0; c < 3; c++) {
            const float own = a[c] > 0 ? a[c] : 0;
            light += own;
            lost += b[c] > 0 ? 0 : own;
        }
        sums->light[lane] += (double)light;
        sums->lost[lane] += (double)lost;
    }
}

static void add(const float *t, const float *d, size_t count,
                ibl_error_sums *sums)
{
    size_t i = 0;

    for (; i + IBL_ERROR_LANES < count; i += IBL_ERROR_LANES)
#pragma GCC unroll 2
        for (size_t lane = 0; lane < IBL_ERROR_LANES; lane += VF)
            add_texels(t + 3 * (i + lane), d + 3 * (i + lane), lane, sums);
    add_rest(t, d, i, count, sums);
}

IBL_VECTOR_KERNEL(ibl_texel_error, add)
